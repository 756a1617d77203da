"""A worker that renders with Mitsuba 3 (--variant llvm_ad_rgb, scalar_rgb, …): its path integrator, roulette off."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from time import perf_counter
from typing import Any

import drjit
import mitsuba
import numpy as np
import workers


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--variant", required=True)
    mitsuba.set_variant(parser.parse_args().variant)
    scenes: dict[str, Any] = {}

    def answer(question: Mapping[str, Any]) -> dict[str, Any]:
        width, height = question["size"]
        key = repr((question["scene"], width, height, question["spp"]))
        if key not in scenes:
            defines = {"resx": width, "resy": height, "spp": question["spp"], "integrator": "path"}
            scenes[key] = mitsuba.load_file(question["scene"], **defines)
        if question["threads"]:
            drjit.set_thread_count(question["threads"])
        integrator = mitsuba.load_dict({"type": "path", "max_depth": question["max_depth"], "rr_depth": 10**6})
        begin = perf_counter()
        image = mitsuba.render(scenes[key], integrator=integrator, seed=question["seed"], spp=question["spp"])
        pixels = np.array(image)  # waits for what is still being computed
        seconds = perf_counter() - begin
        np.save(question["image"], pixels[..., :3])
        return {"seconds": seconds, "paths": width * height * question["spp"], "version": mitsuba.__version__}

    workers.serve(answer)


if __name__ == "__main__":
    main()
