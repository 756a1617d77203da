"""A worker that makes a scene with many of something, by its name, and tells what that takes."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import workers
from core_worker import peak_bytes, resident_bytes, use_core
from numpy.typing import NDArray

Array = NDArray[np.float64]


def bottle(triangles: int) -> tuple[Array, NDArray[np.uint32]]:
    """Return vertices and faces of a closed surface round an axis, with a neck; normals point outwards."""
    around = max(8, round((triangles / 2) ** 0.5))
    rings = max(3, triangles // (2 * around))
    height = np.linspace(0.0, 1.0, rings)
    radius = 0.3 + 0.1 * np.cos(5.0 * height)
    turn = 2.0 * np.pi * np.arange(around) / around
    side = np.stack([radius[:, None] * np.cos(turn), radius[:, None] * np.sin(turn)], axis=-1)
    wall = np.concatenate([side, np.broadcast_to(height[:, None, None], (rings, around, 1))], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([wall, [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    i = np.arange(around)
    after = (i + 1) % around
    faces = [np.stack([np.full(around, len(wall)), after, i], axis=1)]
    faces += [
        np.stack([np.full(around, len(wall) + 1), i + (rings - 1) * around, after + (rings - 1) * around], axis=1)
    ]
    for ring in range(rings - 1):
        a, b = i + ring * around, after + ring * around
        faces += [np.stack([a, b, b + around], axis=1), np.stack([a, b + around, a + around], axis=1)]
    return vertices, np.concatenate(faces).astype(np.uint32)


def placed(x: float, y: float, z: float) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def add_bottle(b: Any, triangles: int, medium: bool) -> int:
    glass = b.add_null() if medium else b.add_bsdf("diffuse", [0.5] * 3)
    shape = int(b.add_mesh(*bottle(triangles), front=glass, back=glass, radiance=None))
    if medium:
        b.set_media(shape, exterior=None, interior=b.add_medium([0.1] * 3, [0.0] * 3))
    return shape


def instances(b: Any, count: int, medium: bool) -> None:
    group = b.add_group(add_bottle(b, 20_000, medium))
    side = int(np.ceil(count**0.5))
    for i in range(count):
        b.add_instance(group, placed(i % side, i // side, 2.0))


def groups(b: Any, count: int, _: bool) -> None:
    for i in range(count):
        shape = b.add_sphere((0, 0, 0), 0.25, flip_normals=False, front=None, back=None, radiance=None)
        b.add_instance(b.add_group(shape), placed(i % 64, i // 64, 2.0))


def beads(b: Any, count: int, _: bool) -> None:
    glass = b.add_null()
    for i in range(count):
        place = (i % 64, i // 64 % 64, 2.0 + i // 4096)
        shape = b.add_sphere(place, 0.25, flip_normals=False, front=glass, back=glass, radiance=None)
        b.set_priority(shape, i % 7)


def sky(b: Any, count: int, _: bool) -> None:
    random = np.random.default_rng(0)
    b.add_image_environment(random.random((count // 2, count, 3), np.float32), 1.0, np.eye(4))


def moving(b: Any, count: int, medium: bool) -> None:
    """Round the camera, which it leaves while the shutter is open."""
    b.add_moving_instance(
        b.add_group(add_bottle(b, count, medium)), [0, 1], np.array([placed(0, 0, -0.5), placed(2, 0, -0.5)])
    )


def keys(b: Any, count: int, _: bool) -> None:
    group = b.add_group(b.add_mesh(*bottle(100), front=None, back=None, radiance=None))
    angles = np.linspace(0.0, 6.0, count)
    matrices = np.tile(placed(0, 0, 2), (count, 1, 1))
    matrices[:, 0, 0], matrices[:, 0, 1] = np.cos(angles), -np.sin(angles)
    matrices[:, 1, 0], matrices[:, 1, 1] = np.sin(angles), np.cos(angles)
    b.add_moving_instance(group, np.linspace(0, 1, count), matrices)


def mesh(b: Any, count: int, _: bool) -> None:
    """With all that a vertex can have."""
    vertices, faces = bottle(count)
    checks = b.add_checkerboard((0.2, 0.2, 0.2), (0.8, 0.8, 0.8))
    b.bind(grey := b.add_bsdf("diffuse", [0.5] * 3), "reflectance", checks)
    b.add_mesh(vertices, faces, normals=vertices, uvs=vertices[:, :2], front=grey, back=grey, radiance=None)


def fog(b: Any, count: int, _: bool) -> None:
    """One mesh in fog, where nothing lets light pass."""
    grey = b.add_bsdf("diffuse", [0.5] * 3)
    vertices, faces = bottle(count)
    b.add_mesh(vertices + np.array([0.0, 0.0, 1.0]), faces, front=grey, back=grey, radiance=None)
    b.set_camera_medium(b.add_medium([0.1] * 3, [0.5] * 3))
    b.add_point_light((2.0, 1.0, 0.0), (1.0, 1.0, 1.0))


KINDS: dict[str, Callable[[Any, int, bool], None]] = {
    f.__name__: f for f in (instances, groups, beads, sky, moving, keys, mesh, fog)
}


def write_obj(path: Path, faces: int, materials: int) -> None:
    """Write as many squares of vertices of their own, in turn of each material."""
    lines: list[str] = []
    for material in range(materials):
        lines.append(f"usemtl m{material}")
        for i in range(faces // materials):
            lines += [f"v {i}.{k:03d} {material}.5 {k // 2}.25" for k in range(4)] + ["f -4 -3 -2 -1"]
    path.write_text("\n".join(lines) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--core", metavar="FILE")
    options = parser.parse_args()
    if options.core:
        use_core(options.core)

    import equaltime as et  # only now: the core is chosen above
    from equaltime import _core

    def from_here(build: Callable[[], Any]) -> tuple[Any, dict[str, Any]]:
        """Build, and tell seconds and memory of that alone."""
        Path("/proc/self/clear_refs").write_text("5")  # the peak is that of what follows
        before, begin = resident_bytes(), process_time()
        scene = build()
        peak = peak_bytes()
        return scene, {"build": process_time() - begin, "peak": peak, "more": peak - before}

    def materials(count: int) -> tuple[Any, dict[str, Any]]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "many.obj"
            write_obj(path, 100_000, count)
            parts: dict[str, Any] = {
                f"part{k}": {"type": "obj", "filename": str(path), "material": f"m{k}"} for k in range(count)
            }
            return from_here(lambda: et.load_dict({"type": "scene", "sensor": {"type": "perspective"}} | parts).core)

    def built(question: Mapping[str, Any]) -> tuple[Any, dict[str, Any]]:
        builder = _core.SceneBuilder()
        builder.add_constant_environment((1.0, 1.0, 1.0))
        KINDS[question["kind"]](builder, question["count"], question.get("medium", False))
        builder.set_perspective(np.eye(4), 40.0)
        builder.set_film(64, 64, (0, 0, 64, 64), "box", 0.5)
        return from_here(builder.build)

    def answer(question: Mapping[str, Any]) -> dict[str, Any]:
        scene, told = materials(question["count"]) if question["kind"] == "materials" else built(question)
        told["account"] = scene.memory_bytes
        if "spp" in question:
            renderer = _core.Renderer(scene, _core.Settings(max_depth=4), threads=1)
            begin = process_time()
            renderer.advance(question["spp"])
            told["render"] = process_time() - begin
            told["mean"] = float(renderer.moments["mean"].mean())
        return told

    workers.serve(answer)


if __name__ == "__main__":
    main()
