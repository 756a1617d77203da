"""equaltime: an unbiased Monte Carlo renderer that shows what accuracy costs in time.

::

    import equaltime as et

    scene = et.load("scenes/cornell-box.toml")
    result = et.render(scene, time=10)          # or spp=256; Ctrl-C keeps what is finished
    print(result.error)                         # 2.31 % (2.28 to 2.34)
    print(result.stats.rays_per_second)
    result.image                                # (H, W, 3) float32, linear
    result.standard_error                       # (H, W, 3) float32
    result.save("cornell.exr")                  # and cornell.png
    other = et.render(scene, spp=256, strategy="best,technique=bsdf", seed=1)
    print(et.cost(scene, "report", quick=True).verdict)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from equaltime.api import render as render
    from equaltime.cluster import open_cluster as open_cluster
    from equaltime.errors import BrightImage as BrightImage
    from equaltime.errors import EffectError as EffectError
    from equaltime.errors import EqualtimeError as EqualtimeError
    from equaltime.errors import EqualtimeWarning as EqualtimeWarning
    from equaltime.errors import ExperimentError as ExperimentError
    from equaltime.errors import FaultySample as FaultySample
    from equaltime.errors import ImageError as ImageError
    from equaltime.errors import NonFiniteSample as NonFiniteSample
    from equaltime.errors import PeerError as PeerError
    from equaltime.errors import Problem as Problem
    from equaltime.errors import RenderError as RenderError
    from equaltime.errors import SampleError as SampleError
    from equaltime.errors import SceneError as SceneError
    from equaltime.errors import StrategyError as StrategyError
    from equaltime.experiments import cost as cost
    from equaltime.experiments.model.experiment import Experiment as Experiment
    from equaltime.experiments.model.summary import Summary as Summary
    from equaltime.hardcases import SelfTest as SelfTest
    from equaltime.hardcases import selftest as selftest
    from equaltime.pricing import PriceList as PriceList
    from equaltime.pricing import effects as effects
    from equaltime.quoting.observer import Observer as Observer
    from equaltime.quoting.pilot import Quote as Quote
    from equaltime.quoting.quote import quote as quote
    from equaltime.rendering.compare import Comparison as Comparison
    from equaltime.rendering.compare import compare as compare
    from equaltime.rendering.merge import merge as merge
    from equaltime.rendering.passes import Progress as Progress
    from equaltime.rendering.progressive import Progressive as Progressive
    from equaltime.rendering.progressive import progressive as progressive
    from equaltime.rendering.replay import Replay as Replay
    from equaltime.rendering.replay import replay as replay
    from equaltime.rendering.result import Result as Result
    from equaltime.rendering.result import Stats as Stats
    from equaltime.rendering.saved import read as read
    from equaltime.rendering.tev import Viewer as Viewer
    from equaltime.scene import Scene as Scene
    from equaltime.scene import load as load
    from equaltime.scene import load_dict as load_dict
    from equaltime.statistics.intervals import Estimate as Estimate
    from equaltime.statistics.intervals import Interval as Interval
    from equaltime.strategy import Strategy as Strategy

__all__ = [
    "BrightImage",
    "Comparison",
    "EffectError",
    "EqualtimeError",
    "EqualtimeWarning",
    "Estimate",
    "Experiment",
    "ExperimentError",
    "FaultySample",
    "ImageError",
    "Interval",
    "NonFiniteSample",
    "Observer",
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
    "Summary",
    "Viewer",
    "__version__",
    "compare",
    "cost",
    "effects",
    "load",
    "load_dict",
    "merge",
    "open_cluster",
    "progressive",
    "quote",
    "read",
    "render",
    "replay",
    "selftest",
]

_ROOMS = {
    "equaltime.api": ("render",),
    "equaltime.cluster": ("open_cluster",),
    "equaltime.errors": (
        "BrightImage",
        "EffectError",
        "EqualtimeError",
        "EqualtimeWarning",
        "ExperimentError",
        "FaultySample",
        "ImageError",
        "NonFiniteSample",
        "PeerError",
        "Problem",
        "RenderError",
        "SampleError",
        "SceneError",
        "StrategyError",
    ),
    "equaltime.experiments": ("cost",),
    "equaltime.experiments.model.experiment": ("Experiment",),
    "equaltime.experiments.model.summary": ("Summary",),
    "equaltime.hardcases": ("SelfTest", "selftest"),
    "equaltime.pricing": ("PriceList", "effects"),
    "equaltime.quoting.observer": ("Observer",),
    "equaltime.quoting.pilot": ("Quote",),
    "equaltime.quoting.quote": ("quote",),
    "equaltime.rendering.compare": ("Comparison", "compare"),
    "equaltime.rendering.merge": ("merge",),
    "equaltime.rendering.passes": ("Progress",),
    "equaltime.rendering.progressive": ("Progressive", "progressive"),
    "equaltime.rendering.replay": ("Replay", "replay"),
    "equaltime.rendering.result": ("Result", "Stats"),
    "equaltime.rendering.saved": ("read",),
    "equaltime.rendering.tev": ("Viewer",),
    "equaltime.scene": ("Scene", "load", "load_dict"),
    "equaltime.statistics.intervals": ("Estimate", "Interval"),
    "equaltime.strategy": ("Strategy",),
}
"""Public names by module. A module is imported when one of its names is first used, so that importing is quick."""
_HOMES = {name: room for room, names in _ROOMS.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # takes longer than all else here

        found: Any = version("equaltime")
    elif name in _HOMES:
        found = getattr(import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}", name=name, obj=None)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
