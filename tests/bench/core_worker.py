"""A worker that renders with equaltime: with the installed core, or with another build of it (--core FILE.so)."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path
from time import process_time
from typing import Any

import workers


def use_core(file: str) -> None:
    """Let ``equaltime._core`` be this file; before equaltime is imported."""
    spec = importlib.util.spec_from_file_location("equaltime._core", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)


def peak_bytes() -> int:
    """Return the most memory that this process ever held; unlike getrusage's, without its parent's."""
    return _status("VmHWM")


def resident_bytes() -> int:
    return _status("VmRSS")


def _status(key: str) -> int:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith(f"{key}:"))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--core", metavar="FILE")
    options = parser.parse_args()
    if options.core:
        use_core(options.core)

    import numpy as np  # equaltime only now: the core is chosen above

    import equaltime as et

    scenes: dict[str, et.Scene] = {}

    def answer(question: Mapping[str, Any]) -> dict[str, Any]:
        """Load a scene, build it and render it as far as the question says; tell seconds and memory by then."""
        key = repr(sorted((name, question.get(name)) for name in ("scene", "define", "size", "max_depth")))
        if key not in scenes:
            loaded = et.load(question["scene"], **question.get("define", {}))
            size = question.get("size")
            scenes[key] = loaded.with_(size=size and tuple(size), max_depth=question.get("max_depth"))
        scene = scenes[key]
        told: dict[str, Any] = {"triangles": scene.core.triangles, "scene_bytes": scene.core.memory_bytes}
        told |= {**scene.timings, "built": resident_bytes()}
        limits = {name: question[name] for name in ("spp", "error") if name in question}
        if limits:
            strategy, seed, threads = (
                question.get(name, other) for name, other in (("strategy", "best"), ("seed", 0), ("threads", 0))
            )
            quotes: list[et.Quote] = []
            begin = process_time()
            result = et.render(
                scene,
                **limits,
                strategy=strategy,
                seed=seed,
                threads=threads,
                observer=et.Observer.of(quoted=quotes.append),
            )
            told["cpu"] = process_time() - begin
            told |= {"seconds": result.stats.seconds, "paths": result.stats.paths, "kernel": result.stats.kernel}
            if quotes:
                told["quoted"] = quotes[0].memory.as_dict()
            if "image" in question:
                np.save(question["image"], result.image)
            if "save" in question:
                result.save(question["save"])
        return told | {"peak": peak_bytes()}

    workers.serve(answer)


if __name__ == "__main__":
    main()
