"""Makes scenes/render/windmill.glb: a toy windmill on a table, with named materials, two cameras and an animation.

Usage: ``python scenes/render/model.py [FILE]``. The file has no lights, as most models. Lengths are metres, y is up.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib as gltf
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

HERE = Path(__file__).resolve().parent
SIDES = 48
"""Faces around a turned part: enough for its outline to look round in the pictures of the page."""
NO_AREA = 1e-9
"""Square metres below which a face at the end of an axis has no area."""
TURN = 4.0
"""Seconds in which the sails turn once."""
TILT = 15.0
"""Degrees by which the sails are turned at the beginning."""
MATERIALS = {
    "table": ((0.28, 0.27, 0.25), 0.0, 0.5),
    "wood": ((0.40, 0.20, 0.09), 0.0, 0.5),
    "plaster": ((0.80, 0.76, 0.68), 0.0, 0.9),
    "red lacquer": ((0.60, 0.03, 0.02), 0.0, 0.4),
    "brass": ((0.90, 0.62, 0.25), 1.0, 0.5),
    "sail": ((0.75, 0.70, 0.58), 0.0, 0.8),
    "ball": ((0.05, 0.20, 0.50), 0.0, 0.5),
}
"""Base colour, metallic and roughness of each material."""


@dataclass(frozen=True)
class Mesh:
    """Triangles: positions (N, 3), normals (N, 3), indices (M,)."""

    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    indices: NDArray[np.int64]


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path, default=HERE / "windmill.glb", help="[windmill.glb beside this]")
    Windmill().save(parser.parse_args().file)


class Windmill:
    """The glTF document, filled when it is made."""

    def __init__(self) -> None:
        self.document = gltf.GLTF2(asset=gltf.Asset(version="2.0"), scene=0, scenes=[gltf.Scene(nodes=[])])
        self.document.materials = [material(name) for name in MATERIALS]
        self.binary = b""
        self.add_tower()
        self.add_sails()
        self.add_camera("whole", (1.9, 2.0, 6.0), (0.1, 1.26, 0.0), yfov=math.radians(28))
        self.add_camera("sails", (1.5, 2.1, 3.4), (0.0, 1.62, 0.5), yfov=math.radians(42))

    def add_tower(self) -> None:
        """Add what stands still."""
        self.add_node("table", self.mesh("table", turned([(0.0, 0.0), (40.0, 0.0)])))
        plate = turned([(0.0, 0.12), (0.72, 0.12)], [(0.72, 0.12), (0.75, 0.09)], [(0.75, 0.09), (0.75, 0.0)])
        self.add_node("plate", self.mesh("wood", plate))
        self.add_node("tower", self.mesh("plaster", turned([(0.26, 1.55), (0.30, 1.1), (0.36, 0.6), (0.45, 0.12)])))
        dome = [(0.34 * math.sin(a), 1.55 + 0.36 * math.cos(a)) for a in np.linspace(0, math.pi / 2, SIDES // 4)]
        self.add_node("cap", self.mesh("red lacquer", turned(dome, [(0.34, 1.55), (0.25, 1.55)])))
        self.add_node("door", self.mesh("wood", box(0.2, 0.36, 0.1)), translation=[0.0, 0.3, 0.41])
        self.add_node("ball", self.mesh("ball", ball(0.28)), translation=[1.1, 0.28, 0.55])

    def add_sails(self) -> None:
        """Add the axle with its four sails, and the animation that turns them."""
        arm, cloth = self.mesh("wood", box(1.0, 0.05, 0.04)), self.mesh("sail", box(0.78, 0.24, 0.012))
        hub = self.mesh("brass", ball(0.09))
        blades = [node for angle in (0.0, 90.0, 180.0, 270.0) for node in self.blade(arm, cloth, angle)]
        tilt = about([0, 0, 1], TILT).as_quat().tolist()
        sails = self.add_node("sails", hub, children=blades, translation=[0.0, 1.62, 0.5], rotation=tilt)
        axle = self.mesh("brass", turned([(0.0, 0.34), (0.035, 0.34)], [(0.035, 0.34), (0.035, 0.0)]))
        forward = about([1, 0, 0], 90.0).as_quat().tolist()
        self.add_node("axle", axle, translation=[0.0, 1.62, 0.2], rotation=forward)
        self.add_turn(sails)

    def blade(self, arm: int, cloth: int, angle: float) -> tuple[int, int]:
        """Add an arm with its cloth, at an angle in degrees and pitched about its length; return their nodes."""
        pitched = about([math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0], 14.0)
        rotation = (pitched * about([0, 0, 1], angle)).as_quat()
        along, beside = rotated(rotation, (0.52, 0.0, 0.0)), rotated(rotation, (0.62, 0.14, 0.0))
        first = self.add_node("arm", arm, root=False, translation=along, rotation=rotation.tolist())
        return first, self.add_node("cloth", cloth, root=False, translation=beside, rotation=rotation.tolist())

    def add_turn(self, node: int) -> None:
        """Add the animation: one turn of a node about z, clockwise as seen from the front."""
        keys = np.linspace(0.0, 1.0, 9)
        rotations = [about([0, 0, 1], TILT - 360.0 * key).as_quat() for key in keys]
        sampler = gltf.AnimationSampler(
            input=self.accessor(TURN * keys, gltf.SCALAR, bounds=True), output=self.accessor(rotations, gltf.VEC4)
        )
        channel = gltf.AnimationChannel(sampler=0, target=gltf.AnimationChannelTarget(node=node, path="rotation"))
        self.document.animations = [gltf.Animation(name="turn", samplers=[sampler], channels=[channel])]

    def add_camera(self, name: str, origin: Sequence[float], target: Sequence[float], yfov: float) -> None:
        """Add a camera, three to two, that looks from ``origin`` to ``target``."""
        backward = np.subtract(origin, target) / np.linalg.norm(np.subtract(origin, target))
        right = np.cross([0.0, 1.0, 0.0], backward)
        right /= np.linalg.norm(right)
        rotation = Rotation.from_matrix(np.stack([right, np.cross(backward, right), backward], axis=1)).as_quat()
        view = gltf.Perspective(yfov=yfov, aspectRatio=1.5, znear=0.01)
        self.document.cameras.append(gltf.Camera(name=name, type="perspective", perspective=view))
        camera = len(self.document.cameras) - 1
        self.add_node(name, camera=camera, translation=list(origin), rotation=rotation.tolist())

    def add_node(self, name: str, mesh: int | None = None, *, root: bool = True, **placed: Any) -> int:
        """Add a node, to the scene if ``root``; return its index."""
        self.document.nodes.append(gltf.Node(name=name, mesh=mesh, **placed))
        index = len(self.document.nodes) - 1
        if root:
            self.document.scenes[0].nodes.append(index)
        return index

    def mesh(self, material_name: str, made: Mesh) -> int:
        """Add a mesh of one material; return its index."""
        positions = self.accessor(made.positions, gltf.VEC3, bounds=True)
        primitive = gltf.Primitive(
            attributes=gltf.Attributes(POSITION=positions, NORMAL=self.accessor(made.normals, gltf.VEC3)),
            indices=self.accessor(made.indices, gltf.SCALAR, "<u2"),
            material=list(MATERIALS).index(material_name),
        )
        self.document.meshes.append(gltf.Mesh(primitives=[primitive]))
        return len(self.document.meshes) - 1

    def accessor(self, values: ArrayLike, kind: str, dtype: str = "<f4", *, bounds: bool = False) -> int:
        """Add numbers to the binary part; return the index of their accessor."""
        array = np.ascontiguousarray(values, dtype=dtype)
        data = array.tobytes()
        self.document.bufferViews.append(gltf.BufferView(buffer=0, byteOffset=len(self.binary), byteLength=len(data)))
        self.binary += data + b"\0" * (-len(data) % 4)
        rows = array.reshape(len(array), -1)
        more: dict[str, Any] = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()} if bounds else {}
        more["componentType"] = gltf.FLOAT if dtype == "<f4" else gltf.UNSIGNED_SHORT
        view = len(self.document.bufferViews) - 1
        self.document.accessors.append(gltf.Accessor(bufferView=view, count=len(array), type=kind, **more))
        return len(self.document.accessors) - 1

    def save(self, file: Path) -> None:
        """Write the document as a binary glTF file."""
        self.document.buffers = [gltf.Buffer(byteLength=len(self.binary))]
        self.document.set_binary_blob(self.binary)
        self.document.save_binary(str(file))


def material(name: str) -> gltf.Material:
    """Return a material of `MATERIALS`."""
    color, metallic, roughness = MATERIALS[name]
    surface = gltf.PbrMetallicRoughness(
        baseColorFactor=[*color, 1.0], metallicFactor=metallic, roughnessFactor=roughness
    )
    return gltf.Material(name=name, pbrMetallicRoughness=surface, doubleSided=True, alphaCutoff=None)


def about(axis: Sequence[float], degrees: float) -> Rotation:
    """Return a rotation about an axis."""
    return Rotation.from_rotvec(math.radians(degrees) * np.asarray(axis, np.float64))


def rotated(quaternion: NDArray[np.float64], point: Sequence[float]) -> list[float]:
    """Return a point after a rotation."""
    return [float(x) for x in Rotation.from_quat(quaternion).apply(point)]


def turned(*curves: Sequence[tuple[float, float]]) -> Mesh:
    """Return the surface that curves sweep about the y axis.

    A curve is a list of (radius, height), from the top down. It is smooth; there is an edge between two curves.
    """
    parts = [swept(np.asarray(curve, np.float64)) for curve in curves]
    begins = np.cumsum([0, *(len(part.positions) for part in parts)])
    return Mesh(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.indices + begin for part, begin in zip(parts, begins[:-1], strict=True)]),
    )


def swept(points: NDArray[np.float64]) -> Mesh:
    """Return the surface that one smooth curve (N, 2) of radii and heights sweeps about the y axis."""
    along = np.gradient(points, axis=0)
    outward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    positions, normals = around(points), around(outward)
    corner = np.arange(len(points) - 1)[:, None] * (SIDES + 1) + np.arange(SIDES)
    below = corner + SIDES + 1
    faces = np.stack([corner, below, below + 1, corner, below + 1, corner + 1], axis=-1).reshape(-1, 3)
    a, b, c = (positions[faces[:, i]] for i in range(3))
    sized = np.linalg.norm(np.cross(b - a, c - a), axis=1) > NO_AREA
    return Mesh(positions, normals, faces[sized].reshape(-1))


def around(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N · (SIDES + 1), 3): points (N, 2) of radius and height, at equal steps around the y axis."""
    angles = np.linspace(0.0, 2.0 * math.pi, SIDES + 1)
    radii, heights = points[:, :1], np.broadcast_to(points[:, 1:], (len(points), SIDES + 1))
    return np.stack([radii * np.sin(angles), heights, radii * np.cos(angles)], axis=-1).reshape(-1, 3)


def ball(radius: float) -> Mesh:
    """Return a sphere about the origin."""
    angles = np.linspace(0.0, math.pi, SIDES // 2 + 1)
    return turned([(radius * math.sin(a), radius * math.cos(a)) for a in angles])


def box(width: float, height: float, depth: float) -> Mesh:
    """Return a box about the origin."""
    square = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], np.float64)
    turns = [about([0, 1, 0], 90.0 * i) for i in range(4)] + [about([1, 0, 0], angle) for angle in (90.0, -90.0)]
    positions = np.concatenate([turn.apply(square) for turn in turns]) * [width / 2, height / 2, depth / 2]
    normals = np.repeat([turn.apply([0.0, 0.0, 1.0]) for turn in turns], 4, axis=0)
    indices = np.array([4 * side + corner for side in range(6) for corner in (0, 1, 2, 0, 2, 3)])
    return Mesh(positions, normals, indices)


if __name__ == "__main__":
    main()
