"""Throughput and variance per sample side by side with Mitsuba 3, on its own scene files.

Both render the same file, size, depth and number of samples on the same threads, with a box filter and without
roulette: Mitsuba with its `path` integrator and its multijitter sampler, equaltime with MIS and Owen-scrambled Sobol
points. Each has a process of its own and they take turns. Mitsuba needs LLVM for its llvm_ variants: if it does not
find the library, set DRJIT_LIBLLVM_PATH.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from measuring import SCENES, arguments, print_conditions, ratio, rounds, text
from numpy.typing import NDArray
from workers import Worker

from equaltime.bench import spread

STRATEGY = "best,roulette=none"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--scenes", nargs="+", default=["cornell-box"], help="folders of scenes/mitsuba [%(default)s]")
    parser.add_argument("--variants", nargs="+", default=["llvm_ad_rgb", "scalar_rgb"])
    parser.add_argument("--size", type=int, nargs=2, default=[256, 256])
    parser.add_argument("--max-depth", type=int, default=8)
    parser.add_argument("--spp", type=int, default=64, help="a square number, for multijitter [%(default)s]")
    parser.add_argument("--peer-python", default=sys.executable, help="a Python that has mitsuba [this one]")
    options = parser.parse_args()
    print_conditions(options)
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        peers = {
            variant: stack.enter_context(Worker("mitsuba_worker.py", ["--variant", variant], options.peer_python))
            for variant in options.variants
        }
        ours = stack.enter_context(Worker("core_worker.py"))
        for name in options.scenes:
            compare(name, ours, peers, options, Path(folder))


def compare(name: str, ours: Worker, peers: Mapping[str, Worker], options: Any, folder: Path) -> None:
    """Render one scene with everyone in turn, and print ratios."""
    scene = folder / f"{name}.xml"
    source = (SCENES / "mitsuba" / name / "scene.xml").read_text()
    source = source.replace('<rfilter type="tent"', '<rfilter type="box"')
    scene.write_text(source.replace('<sampler type="independent"', '<sampler type="multijitter"'))
    image = str(folder / "image.npy")
    images: dict[str, list[NDArray[np.float64]]] = {who: [] for who in ("equaltime", *peers)}
    question = {
        "scene": str(scene),
        "size": options.size,
        "max_depth": options.max_depth,
        "spp": options.spp,
        "threads": options.threads,
        "image": image,
    }

    def ask(who: str, seed: int) -> float:
        if who == "equaltime":
            own = {"strategy": STRATEGY, "define": {"integrator": "path"}}
            answer = ours.ask(**question, **own, seed=seed)
        else:
            answer = peers[who].ask(**question, seed=seed)
        if seed > 0:
            images[who].append(np.load(image).astype(np.float64))
        return float(answer["paths"] / answer["seconds"])

    rates = rounds(images, ask, options.repeats)
    width, height = options.size
    print(f"\n{name}, {width}x{height}, {options.spp} spp, depth {options.max_depth}")
    for who, values in rates.items():
        print(
            f"  {who:14} {text(spread([value / 1e6 for value in values]))} M paths/s, relMSE {noise(images[who]):.4g}"
        )
    for who in peers:
        faster = ratio(rates["equaltime"], rates[who])
        less = noise(images[who]) / noise(images["equaltime"])
        print(
            f"  equaltime over {who}: {text(faster)} x the paths/s; {who} has {less:.3g} x the relMSE at equal samples"
        )


def noise(images: Sequence[NDArray[np.float64]]) -> float:
    """RelMSE of one image, from the scatter of all over their seeds."""
    if len(images) < 2:
        return float("nan")
    mean = np.mean(images, axis=0)
    return float(np.mean(np.var(images, axis=0, ddof=1) / (mean**2 + (0.1 * mean.mean()) ** 2)))


if __name__ == "__main__":
    main()
