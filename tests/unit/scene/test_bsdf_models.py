"""BSDFs of the core by the tables of their models, and the Python classes that fill them."""

from __future__ import annotations

from typing import Any

import pytest

from equaltime import _core
from equaltime.scene.model.bsdfs import LEAVES, BsdfPlugin, Null

MODELS = _core.bsdf_models()


def test_every_model_of_the_core_has_a_class() -> None:
    assert {leaf.model_fields["type"].default for leaf in LEAVES} == {*MODELS, "null"}


@pytest.mark.parametrize("leaf", [leaf for leaf in LEAVES if leaf is not Null], ids=lambda leaf: leaf.__name__)
def test_a_class_gives_what_the_model_takes(leaf: type[BsdfPlugin]) -> None:
    bsdf = leaf()
    assert {*bsdf.parameters()} == {*MODELS[bsdf.title]["parameters"]}
    assert {*MODELS[bsdf.title]["textured"]} - {*bsdf.textures()} <= {"alpha_u", "alpha_v"}, "alpha gives both"


@pytest.mark.parametrize(
    ("type", "values", "named", "message"),
    [
        ("plastik", (), {}, 'no BSDF "plastik"'),
        ("diffuse", (), {"reflectanse": 0.5}, "diffuse: the parameters are reflectance"),
        ("diffuse", (0.5, 0.5), {}, "diffuse: the parameters are reflectance"),
        ("diffuse", (0.5,), {"reflectance": 0.5}, "diffuse: reflectance is given twice"),
        ("dielectric", ("glass",), {}, "dielectric: cannot use ior = 'glass'"),
        ("plastic", (1.5, (0.1, 0.2)), {}, r"plastic: cannot use diffuse_reflectance = \(0.1, 0.2\)"),
        ("roughconductor", ("phong",), {}, '"ggx" or "beckmann", not "phong"'),
    ],
)
def test_what_a_model_does_not_take_is_refused(
    type: str, values: tuple[Any, ...], named: dict[str, Any], message: str
) -> None:
    builder = _core.SceneBuilder()
    with pytest.raises((TypeError, ValueError), match=message):
        builder.add_bsdf(type, *values, **named)
    assert builder.add_bsdf("diffuse", 0.5) == 0, "nothing was added"
