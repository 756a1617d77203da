"""Scenes with very many of something cost as much as there is of it, not its square: by ratios of processor time.

Each ratio is held against what work in proportion would give, with room for a busy machine: the least of three.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.rendering.outputs import first_hits
from equaltime.scene import assets

from ...statistical.worlds import affine, build, octahedron

EYE = np.eye(4)


def seconds(act: Callable[[], object]) -> float:
    def once() -> float:
        begin = process_time()
        act()
        return process_time() - begin

    return min(once() for _ in range(3))


def bottles(count: int, levels: int, medium: bool) -> Callable[[_core.SceneBuilder], None]:
    def add(b: _core.SceneBuilder) -> None:
        nothing = b.add_null()
        shape = b.add_mesh(*octahedron(levels, 0.4), front=nothing, back=nothing, radiance=None)
        if medium:
            b.set_media(shape, exterior=None, interior=b.add_medium([1.0] * 3, [0.0] * 3))
        group = b.add_group(shape)
        for i in range(count):
            b.add_instance(group, affine(*EYE[:3, :3], (i % 40, i // 40, 3.0)))

    return add


def test_instances_of_what_has_an_interior_do_not_look_at_all_its_triangles_each() -> None:
    """2000 of 8192 triangles: looked at one by one they took thirty times as long as all the rest."""
    without = seconds(lambda: build(bottles(2000, 5, False)))
    assert seconds(lambda: build(bottles(2000, 5, True))) < 4 * without


@pytest.mark.parametrize("lamp", [False, True])
def test_instances_far_from_lamps_do_not_look_at_all_their_triangles_each(lamp: bool) -> None:
    """2000 of 8192 triangles: compared with lamps one by one they took ninety times as long as 2000 of 32."""

    def scene(levels: int) -> Callable[[_core.SceneBuilder], None]:
        def add(b: _core.SceneBuilder) -> None:
            bottles(2000, levels, False)(b)
            if lamp:
                to_world = affine(*EYE[:3, :3], (20.0, 20.0, 9.0))
                b.add_rectangle(to_world, front=None, back=None, radiance=[1.0] * 3, flip_normals=False)

        return add

    assert seconds(lambda: build(scene(5))) < 8 * seconds(lambda: build(scene(1)))


def beads(count: int) -> Callable[[_core.SceneBuilder], None]:
    def add(b: _core.SceneBuilder) -> None:
        glass = b.add_null()
        for i in range(count):
            place = (i % 20, i // 20 % 20, 3.0 + i // 400)
            b.set_priority(b.add_sphere(place, 0.25, flip_normals=False, front=glass, back=glass, radiance=None), i % 5)

    return add


def test_bodies_that_do_not_touch_are_found_without_trying_all_pairs() -> None:
    few, many = seconds(lambda: build(beads(4000))), seconds(lambda: build(beads(16_000)))
    assert many < 9 * few


def glass(levels: int) -> Any:
    """A ball round the camera that goes away."""

    def add(b: _core.SceneBuilder) -> None:
        nothing = b.add_null()
        shape = b.add_mesh(*octahedron(levels, 1.0), front=nothing, back=nothing, radiance=None)
        b.set_media(shape, exterior=None, interior=b.add_medium([1.0] * 3, [0.0] * 3))
        b.add_moving_instance(
            b.add_group(shape), [0, 1], np.array([affine(*EYE[:3, :3], (x, 0, 0)) for x in (0.0, 4.0)])
        )
        b.add_constant_environment((1.0, 1.0, 1.0))

    return build(add, size=(16, 16))


def test_a_path_beside_a_moving_glass_does_not_look_at_all_its_triangles() -> None:
    """128 and 32768 triangles: 256 times as long, if each path looked at all."""

    def render(scene: Any) -> float:
        return seconds(lambda: _core.Renderer(scene, _core.Settings(), threads=1).advance(8))

    assert render(glass(6)) < 16 * render(glass(2))


def written(folder: Path, materials: int) -> Path:
    lines = []
    for k in range(materials):
        corners = [f"v {x} {y} {k}" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        lines += [*corners, f"usemtl m{k}", f"f {4 * k + 1} {4 * k + 2} {4 * k + 3}", "f -1 -2 -4"]
    (folder / "many.obj").write_text("\n".join(lines))
    return folder / "many.obj"


def test_an_obj_of_many_materials_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = str(written(tmp_path, 20))
    reads: list[str] = []

    def counted(name: str) -> None:
        read = getattr(assets, name)

        def reader(*arguments: Any) -> Any:
            reads.append(name)
            return read(*arguments)

        monkeypatch.setattr(assets, name, reader)

    counted("read_obj")
    counted("read_obj_by_material")
    parts: dict[str, Any] = {f"part{k}": {"type": "obj", "filename": path, "material": f"m{k}"} for k in range(20)}
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}} | parts)
    assert scene.core.triangles == 40
    assert reads == ["read_obj_by_material"]


def test_each_material_of_an_obj_is_what_it_is_when_read_alone(tmp_path: Path) -> None:
    path = written(tmp_path, 5)
    together = _core.read_obj_by_material(path)
    assert list(together) == [f"m{k}".encode() for k in range(5)]
    for name, mesh in together.items():
        alone = _core.read_obj(path, name.decode())
        np.testing.assert_array_equal(mesh.vertices, alone.vertices)
        np.testing.assert_array_equal(mesh.faces, alone.faces)
        assert mesh.warnings == alone.warnings


def test_a_bad_material_of_an_obj_does_not_spoil_the_others(tmp_path: Path) -> None:
    path = written(tmp_path, 2)
    path.write_text(path.read_text() + "\nusemtl bad\nf 1 2 99\n")
    with pytest.raises(_core.MeshError, match="vertex 99 does not exist"):
        _core.read_obj_by_material(path)
    obj = {"type": "obj", "filename": str(path), "material": "m1"}
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "it": obj})
    assert scene.core.triangles == 2


def test_the_account_of_memory_has_all_that_grows_with_the_scene() -> None:
    def balls(count: int) -> int:
        def add(b: _core.SceneBuilder) -> None:
            for i in range(count):
                place = (i % 10, i // 10, 3.0)
                b.add_sphere(place, 0.25, flip_normals=False, front=None, back=None, radiance=None)

        return int(build(add).memory_bytes)

    def mesh(alpha: tuple[float, float]) -> int:
        def add(b: _core.SceneBuilder) -> None:
            metal = b.add_bsdf("roughconductor", "ggx", *alpha, [1.0] * 3, [1.0] * 3, [1.0] * 3)
            b.add_mesh(*octahedron(5), front=metal, back=metal, radiance=None)

        return int(build(add).memory_bytes)

    assert balls(1000) - balls(500) > 500 * (224 + 32 + 4), "a surface, a sphere and its number"
    assert mesh((0.1, 0.2)) - mesh((0.1, 0.1)) >= 8192 * 12, "a tangent a triangle"


def test_first_hits_take_only_what_is_asked_for_on_as_many_threads() -> None:
    scene = build(lambda b: b.add_sphere((0, 0, 5), 1.0, flip_normals=False, front=None, back=None, radiance=None))
    directions = np.random.default_rng(1).normal(size=(5000, 3)) * 0.1 + [0, 0, 1]
    whole = scene.intersect(np.zeros((5000, 3)), directions)
    part = scene.intersect(np.zeros((5000, 3)), directions, only={"t", "uv", "front", "shape", "dp_du"}, threads=3)
    assert set(part) == {"t", "uv", "front", "shape", "dp_du"}
    for name, values in part.items():
        np.testing.assert_array_equal(values, whole[name])


def test_channels_are_the_same_however_many_are_asked_for() -> None:
    kinds = ("albedo", "depth", "sh_normal", "duv_dx", "prim_index")
    aov = {"type": "aov", "aovs": ",".join(f"{kind}:{kind}" for kind in kinds)}
    camera = {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 8}}
    parts: dict[str, Any] = {"sensor": camera, "ball": {"type": "sphere", "center": [0, 0, 5]}}
    scene = et.load_dict({"type": "scene", "integrator": aov} | parts)
    together = first_hits(scene, threads=2)
    for kind in kinds:
        for name, plane in first_hits(scene, ((kind, kind),), threads=1).items():
            np.testing.assert_array_equal(plane, together[name])


def test_an_image_by_the_lengths_of_paths_alone_is_the_same_as_among_all_parts() -> None:
    scene = glass(2)
    names, parts = _core.split_light(scene, _core.Settings(), samples=4)
    lengths, by_length = _core.split_light(scene, _core.Settings(), samples=4, only_lengths=True)
    assert lengths == [name for name in names if name[0] == "length"]
    assert parts.dtype == by_length.dtype == np.float32, "there are many"
    np.testing.assert_array_equal(by_length, parts[:, :, : len(lengths)])
    assert by_length.any()


SKY = """
import numpy as np
from pathlib import Path
from equaltime import _core

def status(key):
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith(key))

b = _core.SceneBuilder()
b.add_image_environment(np.random.default_rng(0).random((1024, 2048, 3), np.float32), 1.0, np.eye(4))
b.set_perspective(np.eye(4), 40.0)
b.set_film(8, 8, (0, 0, 8, 8), "box", 0.5)
Path("/proc/self/clear_refs").write_text("5")
before = status("VmRSS")
scene = b.build()
print((status("VmHWM") - before) / (1024 * 2048))
"""


def test_a_sky_is_not_copied_while_it_is_built() -> None:
    """Its table takes 12 bytes a pixel; there were 20 more, of a copy and of all weights at once."""
    command = [sys.executable, "-c", SKY]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert float(done.stdout) < 20
