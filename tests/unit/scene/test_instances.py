"""Groups of shapes and their instances: what rays meet, what they cost, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import SceneError, _core
from equaltime.scene import load_dict

Array = NDArray[np.float64]
GREY = {"type": "diffuse", "reflectance": 0.25}
CAMERA = {"type": "perspective", "to_world": [{"look_at": {"origin": [1, 2, 9], "target": [0, 0, 0]}}]}
SOLIDS: dict[str, dict[str, Any]] = {
    "cube": {"type": "cube", "to_world": [{"scale": 0.5}, {"translate": [0, -1, 0]}]},
    "ball": {"type": "sphere", "center": [0, 1, 0], "radius": 0.5, "bsdf": GREY},
    "disk": {"type": "disk", "to_world": [{"translate": [1, 0, 0]}]},
    "tube": {"type": "cylinder", "p0": [-1, -1, 0], "p1": [-1, 1, 0.5], "radius": 0.3},
}
STEPS: list[list[dict[str, Any]]] = [
    [{"rotate": {"axis": [1, 2, 3], "angle": 40}}, {"scale": 0.01}, {"translate": [1, 0.5, 0.25]}],
    [{"rotate": {"axis": [0, 1, 0], "angle": 70}}, {"scale": 2}, {"translate": [-2, 0, -1]}],
    [{"scale": -1}, {"translate": [3, 1, -2]}],
]


def scene(**parts: Any) -> dict[str, Any]:
    return {"type": "scene", "sensor": CAMERA} | parts


def instances(steps: list[list[dict[str, Any]]] = STEPS, **shapes: dict[str, Any]) -> dict[str, Any]:
    copies = {
        f"i{k}": {"type": "instance", "to_world": s, "g": {"type": "ref", "id": "g"}} for k, s in enumerate(steps)
    }
    return scene(g={"type": "shapegroup", **(shapes or SOLIDS)}, **copies)


def one_by_one() -> dict[str, Any]:
    """The same without instances."""
    shapes = {
        f"s{k}_{name}": shape | {"to_world": [*shape.get("to_world", []), *steps]}
        for k, steps in enumerate(STEPS)
        for name, shape in SOLIDS.items()
    }
    return scene(**shapes)


def rays(count: int) -> tuple[Array, Array]:
    """From all around, at the shapes."""
    rng = np.random.default_rng(5)
    centers = np.array([[1, 0.5, 0.25], [-2, 0, -1], [3, 1, -2]])[np.arange(count) % 3]
    aims = centers + rng.normal(size=(count, 3)) * np.array([0.01, 2.0, 1.0])[np.arange(count) % 3, None]
    origins = 12.0 * rng.normal(size=(count, 3))
    return origins, (aims - origins) / np.linalg.norm(aims - origins, axis=1, keepdims=True)


def test_an_instance_is_met_where_its_shapes_would_be() -> None:
    ours, theirs = (load_dict(d).core.intersect(*rays(20_000)) for d in (instances(), one_by_one()))
    hit = np.isfinite(theirs["t"])
    assert hit.sum() > 5000
    same = np.isfinite(ours["t"]) == hit
    assert (~same).sum() < 10, "silhouettes apart"
    both = hit & np.isfinite(ours["t"])
    assert np.quantile(np.abs(ours["p"] - theirs["p"])[both].max(axis=1), 0.99) < 2e-6
    assert np.quantile(np.abs(ours["n"] - theirs["n"])[both].max(axis=1), 0.99) < 1e-3, "of a ball of 0.005, at 1"
    moved = theirs["p"] + 1e-4
    assert np.quantile(np.abs(ours["p"] - moved)[both].max(axis=1), 0.999) > 5e-5, "the twin: a ten-thousandth off"


def test_the_shapes_of_a_group_come_after_all_others_and_are_counted_once() -> None:
    core = load_dict(instances() | {"floor": {"type": "rectangle"}}).core
    assert (core.shapes, core.instances, core.triangles) == (8, 3, 14)
    met = core.intersect(*rays(2000))["shape"]
    assert set(met[met >= 0].tolist()) == {3, 4, 5, 6, 7}
    assert core.effects()["instances"]
    assert not load_dict(one_by_one()).core.effects()["instances"]


def test_a_group_without_instances_is_not_seen() -> None:
    core = load_dict(instances([]) | {"floor": {"type": "rectangle"}}).core
    assert set(core.intersect(*rays(2000))["shape"].tolist()) <= {-1, 0}


def test_memory_hardly_grows_with_the_number_of_instances(tmp_path: Path) -> None:
    """A grid of 20000 triangles: 1.5 MB and more each if it were copied."""
    n = 100
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1))
    vertices = np.stack([x, y, 0.1 * np.sin(9 * x * y)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
    faces = (corner + np.array([0, 1, n + 1, 1, n + 2, n + 1])).reshape(-1, 3)

    def memory(count: int) -> int:
        builder = _core.SceneBuilder()
        group = builder.add_group(builder.add_mesh(vertices, faces, front=None, back=None, radiance=None))
        for k in range(count):
            builder.add_instance(group, np.diag([1.0, 1, 1, 1]) + np.eye(4, k=3) * k)
        builder.set_perspective(np.eye(4), 40.0)
        builder.set_film(4, 4, (0, 0, 4, 4), "box", 0.5)
        core = builder.build()
        assert core.triangles == 2 * n * n
        return core.memory_bytes

    assert memory(1000) - memory(1) < 2048 * 1000


def test_the_file_of_a_group_is_read_once_for_the_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    loaded = load_dict(instances(m={"type": "obj", "filename": str(tmp_path / "m.obj")}))
    opened: list[Path] = []
    whole = Path.open
    monkeypatch.setattr(Path, "open", lambda path, *how: (opened.append(path), whole(path, *how))[1])
    assert loaded.digest != load_dict(instances()).digest
    assert opened == [tmp_path / "m.obj"]


def test_shapes_of_a_group_do_not_emit() -> None:
    with pytest.raises(SceneError, match="the shapes of a group cannot emit"):
        load_dict(instances(lamp={"type": "sphere", "emitter": {"type": "area"}}))
    builder = _core.SceneBuilder()
    first = builder.add_sphere([0, 0, 0], 1, flip_normals=False, front=None, back=None, radiance=[1.0, 1.0, 1.0])
    builder.add_instance(builder.add_group(first), np.eye(4))
    builder.set_perspective(np.eye(4), 40.0)
    builder.set_film(4, 4, (0, 0, 4, 4), "box", 0.5)
    with pytest.raises(ValueError, match="shape 1: the shapes of a group cannot emit"):
        builder.build()


@pytest.mark.parametrize("matrix", [np.diag([1.0, 1, 0, 1]), np.full((4, 4), np.nan)])
def test_an_instance_needs_a_transform_with_an_inverse(matrix: Array) -> None:
    builder = _core.SceneBuilder()
    first = builder.add_sphere([0, 0, 0], 1, flip_normals=False, front=None, back=None, radiance=None)
    builder.add_instance(builder.add_group(first), matrix)
    with pytest.raises(ValueError, match="shape 0: to_world of an instance must be finite and have an inverse"):
        builder.build()
