"""A second renderer, written to be read: it says what the right image is, and the core is tested against it.

A path tracer in NumPy, all in float64, that shares the scene description with the core and nothing else: triangles are
found by embreex (Embree 4; the core has Embree 3), points on them are computed anew in float64, spheres and disks are
intersected by their formulas. What it does is the textbook's choice wherever there is one, and another than the
core's: random numbers from NumPy's Philox, lights sampled uniformly by area, microfacets by D, multiple importance
sampling with the balance heuristic, no Russian roulette. Slow, and noisier at equal samples: meant for small images.

Read it in this order: `tracer` (the estimator), `scattering`, `lights`, `environment`, `world` (what a ray meets),
`camera`.
"""

from __future__ import annotations

from importlib.util import find_spec

if find_spec("embreex") is None:
    raise ImportError("the cross-check needs embreex: pip install equaltime[crosscheck]", name="embreex")

from equaltime.crosscheck.camera import Camera
from equaltime.crosscheck.primary import PrimaryHits, primary_hits
from equaltime.crosscheck.tracer import render

__all__ = ["Camera", "PrimaryHits", "primary_hits", "render"]
