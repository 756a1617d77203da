"""A second, readable renderer, the cross-check: tests compare its images with the images of the C++ core.

The renderer is a path tracer in NumPy, in float64 throughout, and shares only the scene description with the core.
Triangles are found by embreex (Embree 4; the core has Embree 3), and points on them are recomputed in float64. Spheres
and disks are intersected by their formulas.

Where textbooks have a standard method, the cross-check uses it, and differs from the core: random numbers from NumPy's
Philox, lights sampled uniformly by area, microfacets by their distribution D, multiple importance sampling with the
balance heuristic, no Russian roulette. The cross-check is slow, and noisier at equal samples: use it for small images.

Read the modules in this order: `tracer` (the estimator), `scattering`, `lights`, `environment`, `world` (intersection),
`camera`.
"""

from __future__ import annotations

from importlib.util import find_spec

from equaltime.extras import install

if find_spec("embreex") is None:
    raise ImportError(f"the cross-check needs embreex: {install('crosscheck')}", name="embreex")

from equaltime.crosscheck.camera import Camera, PrimaryHits, primary_hits
from equaltime.crosscheck.tracer import render

__all__ = ["Camera", "PrimaryHits", "primary_hits", "render"]
