"""Worst errors of the core's formulas, against more digits, over inputs that are uniform in their logarithm.

The marks are those of the table in README.md. Beside each stands what the usual form in single precision makes of the
same inputs, which the same mark rejects.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from ..statistical.worlds import build

Array = NDArray[np.float64]
F, LD = np.float32, np.longdouble
COUNT = 2000
ROW = re.compile(r"^\| ([^|]+?) \| [^|]+ \| ([0-9.e-]+) \|", re.MULTILINE)
MARKS = {m[1]: float(m[2]) for m in ROW.finditer((Path(__file__).parent / "README.md").read_text())}
Errors = tuple[Array, Array]
"""Of the core and of the usual form, relative."""


def logarithmic(low: float, high: float, shape: int | tuple[int, ...] = COUNT, seed: int = 1) -> Array:
    return np.asarray(10.0 ** np.random.default_rng(seed).uniform(np.log10(low), np.log10(high), shape)).astype(F)


def relative(found: Array, exact: Array) -> Array:
    with np.errstate(invalid="ignore", over="ignore"):
        off = np.abs(np.asarray(found, LD) / np.asarray(exact, LD) - 1)
    return np.where(np.isfinite(off), off, np.inf).astype(np.float64)


def mis_weights() -> Errors:
    a, b = logarithmic(1e-37, 1e38, (2, COUNT))
    exact = 1 / (1 + (b.astype(LD) / a) ** 2)
    kept = exact > 1e-30
    found = np.array([parts.mis_weight("power", x, y) for x, y in zip(a, b, strict=True)])
    with np.errstate(all="ignore"):
        usual = a * a / (a * a + b * b)
    return relative(found[kept], exact[kept]), relative(usual[kept], exact[kept])


def ball_solid_angles() -> Errors:
    ratio = logarithmic(1e-7, 0.7, 200)
    exact, found = [], []
    for r in ratio.astype(float):
        scene = build(
            lambda b, r=r: b.add_sphere([0, 0, 1], r, flip_normals=False, front=None, back=None, radiance=[1, 1, 1])
        )
        found.append(1 / parts.sample_lights(scene, "uniform", np.zeros((1, 3)), 1)["pdf"][0])
        exact.append(2 * np.pi * LD(r) ** 2 / (1 + np.sqrt(1 - LD(r) ** 2)))
    usual = F(2 * np.pi) * (F(1) - np.sqrt(F(1) - ratio * ratio))
    return relative(np.array(found), np.array(exact)), relative(usual, np.array(exact))


def microfacets() -> Errors:
    errors, usual = [], []
    rng = np.random.default_rng(3)
    for alpha in logarithmic(1e-5, 0.5, 40):
        builder = _core.SceneBuilder()
        builder.add_bsdf("roughconductor", "ggx", float(alpha), float(alpha), [0] * 3, [1] * 3, [1] * 3)
        builder.set_perspective(np.eye(4), 40.0)
        builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
        wo = np.tile([0.48, 0.36, 0.8], (100, 1))
        m = np.column_stack([rng.standard_normal((100, 2)) * alpha, np.ones(100)])
        m /= np.linalg.norm(m, axis=1, keepdims=True)
        wi = 2 * (wo * m).sum(axis=1, keepdims=True) * m - wo
        wo, wi = (v.astype(F).astype(float) for v in (wo[wi[:, 2] > 0.05], wi[wi[:, 2] > 0.05]))
        found = parts.eval_bsdf(builder.build(), 0, wo, wi)["f"][:, 0]
        errors.append(relative(found, _ggx(wo.astype(LD), wi.astype(LD), LD(alpha), components=True)))
        with np.errstate(all="ignore"):
            usual.append(relative(_ggx(wo.astype(F), wi.astype(F), F(alpha), components=False), found))
    return np.concatenate(errors), np.concatenate(usual)


def _ggx(wo: Array, wi: Array, alpha: Array, components: bool) -> Array:
    """D·G/(4 cosθo), D from the half-vector's components or in the usual form n²(α² - 1) + 1."""
    one = type(alpha)(1)
    m = wo + wi
    m = m / np.sqrt((m * m).sum(axis=1))[:, None]
    z2, a2 = m[:, 2] ** 2, alpha * alpha
    inner = ((m[:, 0] / alpha) ** 2 + (m[:, 1] / alpha) ** 2 + z2) if components else (z2 * (a2 - one) + one) / a2
    d = one / (type(alpha)(np.pi) * a2 * inner * inner)
    g = one
    for v in (wo, wi):
        t2 = a2 * (v[:, 0] ** 2 + v[:, 1] ** 2) / v[:, 2] ** 2
        g = g * 2 / (one + np.sqrt(one + t2))
    return np.asarray(d * g / (4 * wo[:, 2]))


def conductors() -> Errors:
    indices = logarithmic(1e-3, 1e4, (200, 2))
    builder = _core.SceneBuilder()
    for eta, k in indices.astype(float):
        builder.add_bsdf("conductor", [eta] * 3, [k] * 3, [1, 1, 1])
    builder.set_perspective(np.eye(4), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    scene = builder.build()
    wo = (
        np.array([[np.sqrt(1 - c * c), 0, c] for c in logarithmic(1e-4, 1.0, 20).astype(float)]).astype(F).astype(float)
    )
    found, exact, usual = [], [], []
    for number, (eta, k) in enumerate(indices.astype(float)):
        found.append(parts.sample_bsdf(scene, number, wo, np.zeros_like(wo))["weight"][:, 0])
        exact.append(_fresnel(wo[:, 2], np.clongdouble(complex(eta, k))))
        with np.errstate(all="ignore"):
            usual.append(_fresnel(wo[:, 2].astype(F), np.complex64(complex(eta, k))))
    return relative(np.concatenate(found), np.concatenate(exact)), relative(
        np.concatenate(usual), np.concatenate(exact)
    )


def _fresnel(cosine: Array, index: np.complexfloating) -> Array:
    transmitted = np.sqrt(1 - (1 - cosine * cosine) / (index * index))
    s = (cosine - index * transmitted) / (cosine + index * transmitted)
    p = (index * cosine - transmitted) / (index * cosine + transmitted)
    return np.asarray((np.abs(s) ** 2 + np.abs(p) ** 2) / 2)


FORMS: dict[str, Callable[[], Errors]] = {
    "power heuristic": mis_weights,
    "solid angle of a ball": ball_solid_angles,
    "GGX with masking": microfacets,
    "Fresnel of metals": conductors,
}


@pytest.mark.parametrize("form", FORMS)
def test_worst_errors_are_within_the_marks_that_usual_forms_miss(form: str) -> None:
    found, usual = FORMS[form]()
    print(f"{form}: worst {found.max():.2g}; the usual form: worst {usual.max():.2g}, median {np.median(usual):.2g}")
    assert found.max() <= MARKS[form]
    assert usual.max() > 2 * MARKS[form], "the twin"
