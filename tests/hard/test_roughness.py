"""A lit ball whose roughness vanishes (S14): its highlight is one picture, however small, with no step on the way.

Lamp and picture shrink with the roughness. As far as that is small, the picture is always the same: what follows from
the ball's curvature is less than the roughness itself. So what a renderer does at some roughness, be it to call the
ball a mirror or to take the roughness for a larger one, would be seen as a step.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime.film.moments import squared_deviations

from ..statistical.worlds import build, looking, render

Array = NDArray[np.float64]
Facets = Literal["ggx", "beckmann"]
SIDE, SPP = 12, 2048
STEPS = [1.001e-3, 0.999e-3, 3e-4, 1.001e-4, 0.999e-4, 1.42e-5, 1.41e-5, 1e-5]
"""On both sides of where others call it a mirror (1e-3, the root of 2e-10) or stop (1e-4)."""


def highlight(size: float, alpha: float | None, facets: Facets) -> tuple[Array, Array]:
    """Return mean and variance of the pixels of a ball's highlight, its lamp and picture made for a roughness."""
    towards = np.array([0.6, 0.0, 0.8])

    def add(b: _core.SceneBuilder) -> None:
        metal = [0.0] * 3, [1.0] * 3, [1.0] * 3
        bsdf = (
            b.add_bsdf("conductor", *metal)
            if alpha is None
            else b.add_bsdf("roughconductor", facets, alpha, alpha, *metal)
        )
        b.add_sphere([0, 0, -1], 1.0, flip_normals=False, front=bsdf, back=None, radiance=None)
        b.add_sphere(2 * towards, 4 * size, flip_normals=False, front=None, back=None, radiance=[1] * 3)

    camera = looking(towards * [-2, 2, 2], [0, 0, 0])
    scene = build(add, camera=camera, fov=np.degrees(3 * size), size=(SIDE, SIDE))
    film = render(scene, SPP, sampler="independent", max_depth=2)[0]
    return film["mean"][..., 0], squared_deviations(film)[..., 0] / film["count"] / (film["count"] - 1)


def most_sigmas(first: tuple[Array, Array], second: tuple[Array, Array]) -> float:
    """Return by how many of their standard errors two pictures differ, as a whole or in the pixel that does most."""
    differ, variance = first[0] - second[0], first[1] + second[1]
    lit = variance > 0
    assert (differ[~lit] == 0).all()
    whole = abs(differ.sum()) / np.sqrt(variance.sum())
    return float(max(whole, (np.abs(differ[lit]) / np.sqrt(variance[lit])).max()))


@pytest.mark.parametrize("facets", ["ggx", "beckmann"])
def test_S14_the_highlight_of_a_ball_has_no_step_on_the_way_to_a_mirror(facets: Facets) -> None:  # noqa: N802
    """Within two sigmas, as a whole and in each pixel. All pictures are of the same random numbers."""
    pictures = {alpha: highlight(alpha, alpha, facets) for alpha in STEPS}
    first = pictures[STEPS[0]]
    assert first[0].max() > 0.3
    assert first[0].min() < 0.01
    for alpha, picture in pictures.items():
        assert most_sigmas(first, picture) < 2.0, alpha
    assert most_sigmas(first, highlight(0.999e-3, None, facets)) > 2.0, "the twin: a mirror below 1e-3"
    assert most_sigmas(first, highlight(0.8e-4, 1e-4, facets)) > 2.0, "the twin: no less than 1e-4"
    assert most_sigmas(first, highlight(1e-5, 1.41e-5, facets)) > 2.0, "the twin: no less than the root of 2e-10"
