"""A small experiment that never ran: two scenes, three strategies, images of noise with a known error."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from equaltime.experiments.model.summary import Curve, SceneResult, StrategyResult, Summary
from equaltime.experiments.run.reference import KnownReference, write
from equaltime.images.metrics import Reference
from equaltime.statistics.intervals import UNKNOWN, Interval

TARGETS = (0.10, 0.05, 0.02, 0.01)
CONSTANTS = {"naive": 0.8, "cut": 0.2, "best": 0.1}
"""Label → error after a second of rendering."""
FEW = "only 2 repeats, and 3 are the least"
SHAPE = (24, 36, 3)
REPEATS = 5


def about(value: float, part: float = 0.1) -> Interval:
    return Interval(value, value * (1.0 - part), value * (1.0 + part))


def curve(constant: float) -> Curve:
    spp = (2, 4, 8, 16, 32)
    seconds = tuple(count / 16.0 for count in spp)
    errors = tuple(about(constant / math.sqrt(time)) for time in seconds)
    return Curve(spp, tuple(about(time) for time in seconds), errors, Interval(-0.5, -0.52, -0.48), errors)


def strategy(label: str, folder: Path, scene: str) -> StrategyResult:
    """Return a strategy's results, with an image of noise for each repeat in ``folder``."""
    constant = CONSTANTS[label]
    end = constant / math.sqrt(2.0)
    random = np.random.default_rng([len(scene), *map(ord, label)])
    images = tuple(folder / f"{scene}-{label}-{repeat}.npy" for repeat in range(REPEATS))
    for path in images:
        pixels = 0.5 * (1.0 + end * random.standard_normal(SHAPE))
        if label == "best":
            pixels[:8, :8] += 0.5 * random.standard_normal((8, 8, 3))  # where it loses
        np.save(path, pixels.astype(np.float32))
    variances = tuple(folder / f"{scene}-{label}-{repeat}-variance.npy" for repeat in range(REPEATS))
    for path in variances:
        np.save(path, np.full(SHAPE[:2], constant**2, np.float32))
    return StrategyResult(
        label=label,
        name=f"best,technique={label}",
        renderer="core",
        biased=label == "cut",
        repeats=REPEATS,
        curve=curve(constant),
        time_to={target: about((constant / target) ** 2) for target in TARGETS},
        ratio={target: about((CONSTANTS["naive"] / constant) ** 2) for target in TARGETS},
        efficiency=Interval(3.0, 2.5, 3.5),
        error_at_budget=about(end),
        fewer_samples=Interval(2.0, 1.5, 2.5),
        equality_p=None if label == "best" else 0.4,
        bias=Interval(0.001, -0.002, 0.003),
        notes=("its paths are cut",) if label == "cut" else (),
        image=images[0],
        image_error=1.05 * end,
        image_seconds=1.9,
        images=images,
        variances=variances,
    )


def scene_result(folder: Path, name: str = "box") -> SceneResult:
    reference = Reference(np.full(SHAPE, 0.5), np.full(SHAPE, 1e-6))
    write(folder / f"{name}-reference.npz", KnownReference(reference, {}))
    return SceneResult(
        name=name,
        digest="0123456789abcdef",
        size=(SHAPE[1], SHAPE[0]),
        max_depth=8,
        reference_error=0.002,
        baseline="naive",
        standard="best",
        budget_s=2.0,
        strategies=tuple(strategy(label, folder, name) for label in CONSTANTS),
        reference=folder / f"{name}-reference.npz",
        crops=((0, 0, 12, 12), (20, 6, 10, 10)),
    )


def summary(folder: Path, scenes: int = 1) -> Summary:
    """Return what an experiment found; its images are written into ``folder``."""
    return Summary(
        title="Three strategies",
        description="What is compared, what to see, why.",
        scenes=tuple(scene_result(folder, f"box{number}") for number in range(scenes)),
        targets=TARGETS,
        provenance={"machine": {"cpu": "a processor", "cores": 2}, "build": "a build", "seeds": [0, 1, 2]},
        verdict="On box0, best is about 64 times faster than naive (58 to 70): 1 % error in 100 s (90 to 110).",
    )


def doubted(result: SceneResult, label: str, reason: str = FEW) -> SceneResult:
    """Return the scene with a strategy whose times, speed-ups and gains cannot be trusted."""

    def doubt(one: StrategyResult) -> StrategyResult:
        if one.label != label:
            return one
        times = {target: interval.doubted(reason) for target, interval in one.time_to.items()}
        unknown = replace(UNKNOWN, note=reason)
        ratios = dict.fromkeys(one.ratio, unknown)
        return replace(one, time_to=times, ratio=ratios, efficiency=unknown, fewer_samples=unknown)

    return replace(result, strategies=tuple(doubt(one) for one in result.strategies))
