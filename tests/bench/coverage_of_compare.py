"""How often the intervals of `equaltime compare` hold the true error of an image, and the true ratio of two.

Image A has 16 samples a pixel. Image B is compared with it, at 1 to 64 times the samples; both are rendered with the
default strategy and seeds of their own. Truths are realised errors against the long references of `trial_scenes`, whose
noise is subtracted. An interval that reaches down to 0 is printed as "unknown, at most ..."; its limits count as those
of any other. Nothing is timed: run it beside anything, nice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from measuring import arguments, parsed
from numpy.typing import NDArray
from trial_scenes import realised_square, reference, trial_scene, wilson

import equaltime as et
from equaltime.film.error import pixel_statistics, standard_error
from equaltime.images.image_files import Picture, Window
from equaltime.images.metrics import Reference, contributions
from equaltime.rendering.core import make_renderer
from equaltime.rendering.noisy_reference import Difference, Noise, log_ratio
from equaltime.statistics.intervals import signed_root

Floats = NDArray[np.float64]
SAMPLES = 16
TIMES = (1, 4, 16, 64)
REFERENCES = {"flat": 2**14, "cornell": 2**14, "caustic": 2**19, "mis": 2**17}
"""Samples a pixel of the reference that stands for the truth; the last two scenes have rare light."""


@dataclass(frozen=True, eq=False)
class Render:
    """What the file of a render holds."""

    image: Floats
    own: Noise
    """What a file with moments tells."""
    pooled: Noise
    """What a file tells that has standard errors alone."""

    @classmethod
    def of(cls, moments: NDArray[Any]) -> Render:
        pixels = pixel_statistics(moments)
        image, errors = pixels.mean.astype(np.float32), standard_error(pixels)
        layers = (("", image), ("stderr.", errors))
        planes = {prefix + channel: layer[..., i] for prefix, layer in layers for i, channel in enumerate("RGB")}
        height, width = image.shape[:2]
        picture = Picture(planes, Window(0, 0, width, height), {"seed": 0})
        own, pooled = Noise.of(picture, pixels), Noise.of(picture, None)
        assert own is not None
        assert pooled is not None
        return cls(image.astype(np.float64), own, pooled)


def main() -> None:
    parser = arguments(__doc__, threads=1)
    parser.add_argument("--seeds", type=int, default=200, help="pairs of images [%(default)s]")
    parser.add_argument("--first", type=int, default=0, help="the first seed [%(default)s]")
    parser.add_argument("--size", type=int, default=32, help="pixels along each side [%(default)s]")
    parser.add_argument("--scenes", nargs="*", default=list(REFERENCES), choices=list(REFERENCES))
    parser.add_argument("--spp", type=int, help="of the references that stand for the truth")
    options = parsed(parser, seeds=12, size=16, spp=1024)
    for name in options.scenes:
        truth = reference(name, options.size, options.spp or REFERENCES[name])
        seeds = range(options.first, options.first + options.seeds)
        images = [renders(name, options.size, 3 * seed, (1,), options.threads)[0] for seed in seeds]
        others = [renders(name, options.size, 3 * seed + 1, TIMES, options.threads) for seed in seeds]
        size = f"{options.size}x{options.size}"
        print(f"{name}, {size}, A {SAMPLES} spp, {options.seeds} pairs; error of the reference {error_of(truth):.2%}")
        report_errors(images, others, truth)
        report_ratios(images, [by_times[1] for by_times in others], others[1:] + others[:1], truth)


def renders(name: str, side: int, seed: int, times: tuple[int, ...], threads: int) -> list[Render]:
    """Return one render at each multiple of the samples: of one seed, so that the longer ones hold the shorter."""
    renderer = make_renderer(trial_scene(name, side), et.Strategy.parse("best,adaptive=none"), seed, threads)
    found = []
    for factor in times:
        renderer.advance(factor * SAMPLES)
        found.append(Render.of(renderer.moments.copy()))
    return found


def error_of(truth: Reference) -> float:
    return math.sqrt(max(truth.relmse, 0.0))


def report_errors(images: list[Render], others: list[list[Render]], truth: Reference) -> None:
    """Print how the error of A, measured against B, compares with the truth."""
    true = [realised_square(image.image, truth) for image in images]
    for place, factor in enumerate(TIMES):
        for label in ("own", "pooled"):
            found = [
                Difference.of(a.image, b[place].image, getattr(b[place], label))
                for a, b in zip(images, others, strict=True)
            ]
            limits = [difference.measured for difference in found]
            held = [number(m.low) <= t <= number(m.high) for m, t in zip(limits, true, strict=True)]
            known = [h for h, m in zip(held, limits, strict=True) if m.known]
            middle = signed_root(float(np.median([difference.value for difference in found])))
            widths = [0.5 * (number(m.high) - number(m.low)) / t for m, t in zip(limits, true, strict=True)]
            kept = "moments" if label == "own" else "stderr"
            print(
                f"  B {factor:2d} times, {kept:7s}: holds {share(held)}, of known ones {share(known)}; "
                f"unknown {1 - len(known) / len(held):.2f}; median error {middle:.4f} for "
                f"{signed_root(float(np.median(true))):.4f}, half width {np.median(widths):.2f} of error²",
                flush=True,
            )


def report_ratios(firsts: list[Render], seconds: list[Render], rest: list[list[Render]], truth: Reference) -> None:
    """Print how the ratio of A's error to that of B, measured against a third render, compares with this pair's."""
    true = np.array(
        [
            realised_square(a.image, truth) / realised_square(b.image, truth)
            for a, b in zip(firsts, seconds, strict=True)
        ]
    )
    for label, place in (("own", 3), ("own", 1), ("pooled", 1), ("none", 1)):
        held, stated = [], []
        for a, b, references, ratio in zip(firsts, seconds, rest, true, strict=True):
            third = references[place]
            if label == "none":
                plain = Reference(third.image, np.zeros_like(third.image))
                stated.append(contributions(a.image, plain).mean() / contributions(b.image, plain).mean())
                continue
            pair = [Difference.of(x.image, third.image, getattr(third, label)) for x in (a, b)]
            if all(difference.measured.known for difference in pair):
                log, half = log_ratio(*pair)
                stated.append(math.exp(log))
                held.append(ratio > 0.0 and abs(log - math.log(ratio)) <= half)
        kept = {"own": "moments", "pooled": "stderr", "none": "no errors"}[label]
        held_text = "states no interval" if label == "none" else f"holds {share(held)}"
        median = signed_root(float(np.median(stated))) if stated else math.nan
        expected = signed_root(float(np.median(true)))
        print(
            f"  ratio to B {TIMES[1]} times, REF {TIMES[place]} times, {kept}: {held_text}; no number "
            f"{1 - len(stated) / len(true):.2f}; median ratio {median:.3f} for {expected:.3f}",
            flush=True,
        )


def number(limit: float | None) -> float:
    assert limit is not None
    return limit


def share(held: list[bool]) -> str:
    """Write a rate with its 95 % interval."""
    low, high = wilson(sum(held), len(held))
    return f"{np.mean(held):.3f} [{low:.2f}, {high:.2f}]" if held else "none"


if __name__ == "__main__":
    main()
