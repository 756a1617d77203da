"""equaltime: an unbiased Monte Carlo renderer that shows what accuracy costs in time.

::

    import equaltime as et

    scene = et.load("scenes/cornell-box.toml")
    result = et.render(scene, time=10)          # or spp=256; Ctrl-C keeps what is finished
    print(result.error)                         # 2.31 % [2.28, 2.34]
    print(result.stats.rays_per_second)
    result.image                                # (H, W, 3) float32, linear
    result.standard_error                       # (H, W, 3) float32
    result.save("cornell.exr")                  # and cornell.png
    other = et.render(scene, spp=256, strategy="best,technique=bsdf", seed=1)
    print(et.cost(scene, "report", quick=True).verdict)
"""

from __future__ import annotations

from importlib.metadata import version

from equaltime import startup as startup  # first: it is what Ctrl-C meets during the others
from equaltime.compare import compare
from equaltime.cost import cost
from equaltime.effects import PriceList, effects
from equaltime.error_estimate import Estimate
from equaltime.errors import (
    BrightImage,
    EffectError,
    EqualtimeError,
    EqualtimeWarning,
    ExperimentError,
    FaultySample,
    ImageError,
    NonFiniteSample,
    PeerError,
    Problem,
    RenderError,
    SampleError,
    SceneError,
    StrategyError,
)
from equaltime.merge import merge
from equaltime.pilot import Quote
from equaltime.progress import Progress
from equaltime.progressive import Progressive, progressive
from equaltime.quote import quote
from equaltime.render import render
from equaltime.replay import Replay, replay
from equaltime.result import Result, Stats
from equaltime.scene import Scene, load, load_dict
from equaltime.selftest import SelfTest, selftest
from equaltime.strategy import Strategy
from equaltime.tev import Viewer

__all__ = [
    "BrightImage",
    "EffectError",
    "EqualtimeError",
    "EqualtimeWarning",
    "Estimate",
    "ExperimentError",
    "FaultySample",
    "ImageError",
    "NonFiniteSample",
    "PeerError",
    "PriceList",
    "Problem",
    "Progress",
    "Progressive",
    "Quote",
    "RenderError",
    "Replay",
    "Result",
    "SampleError",
    "Scene",
    "SceneError",
    "SelfTest",
    "Stats",
    "Strategy",
    "StrategyError",
    "Viewer",
    "__version__",
    "compare",
    "cost",
    "effects",
    "load",
    "load_dict",
    "merge",
    "progressive",
    "quote",
    "render",
    "replay",
    "selftest",
]

__version__ = version("equaltime")
