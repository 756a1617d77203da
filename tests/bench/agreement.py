"""Whether every scene of Mitsuba's in a folder has the same expected image here and there, from the same file.

Both read a copy of the file with a box filter, independent samples and a small film, and render it with 64 seeds; block
means are compared by `equaltime.statistics.agreement`. All scenes together have a false-alarm rate of 0.1 %, fixed
before the first is looked at. A file that Mitsuba 3 cannot read is given to it as equaltime writes it, and the line
says so. Ends with status 1 if a scene disagrees of which `KNOWN` does not say why.

Samples are independent because the images of Mitsuba's `ldsampler` have a mean of their own. In lajolla's Cornell box
they are two percent darker where light has been reflected twice.

An image by Mitsuba is worth no more than 0.2 % where gaps or edges are small against the scene's extent from the
origin, because Mitsuba moves the origin of each ray by 8.9e-5 (1 + its largest coordinate) along the normal. We
measured 0.18 % on Sponza. In such a scene a disagreement of that size is to be expected.

Needs the extra `peers`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from measuring import defines
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene.export import convert
from equaltime.statistics.agreement import LEVEL, Agreement, BlockMeans, compare, share

QUANTILES = (1, 10, 50, 90, 99)
KNOWN = {
    "simple_sphere.xml": "of a small distant sphere Mitsuba's light is 2e-4 too bright (the cone's cosine in float32); "
    "equaltime's is that of the closed form, pi L (R/d)^2, to 1e-5"
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--side", type=int, default=96, help="longest side of the film")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=64)
    parser.add_argument("--block", type=int, default=8)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    found = [loaded for path in sorted(options.folder.rglob("*.xml")) if (loaded := readable(path)) is not None]
    level = share(LEVEL, len(found))
    print(f"{len(found)} scenes, level {level:.2g} each; {options.seeds} seeds of {options.spp} samples a pixel")
    print(f"  z at {QUANTILES} %: a normal deviate has -2.33 -1.28 +0.00 +1.28 +2.33")
    wrong = 0
    for path, scene in found:
        agreement, note = agree(path, scene, options)
        agrees, why = agreement.p > level, KNOWN.get(path.name, "")
        wrong += not agrees and not why
        at = " ".join(f"{q:+.2f}" for q in np.nanpercentile(agreement.z, QUANTILES))
        verdict = "agrees" if agrees else f"known to disagree: {why}" if why else "DISAGREES"
        print(f"{path.relative_to(options.folder)}{note}: {verdict}, {agreement}; z {at}", flush=True)
    return 1 if wrong else 0


def readable(path: Path) -> tuple[Path, et.Scene] | None:
    """Return a scene that can be rendered here; another is named with the reason, and left out."""
    try:
        scene = et.load(path, substitute=True, **defines(path))
        _ = scene.core
    except et.SceneError as error:
        print(f"left out: {path}: {str(error).splitlines()[0]}")
        return None
    for warning in scene.warnings:
        print(f"{path.name}: {warning}")
    return path, scene


def agree(path: Path, scene: et.Scene, options: argparse.Namespace) -> tuple[Agreement, str]:
    scale = options.side / max(scene.size)
    size = (round(scene.size[0] * scale), round(scene.size[1] * scale))
    with tempfile.TemporaryDirectory() as name:
        folder, note = Path(name), ""
        copy = small(path, folder, size)
        try:
            theirs = mi.load_file(str(copy), **defines(path))
        except RuntimeError:
            exported = folder / "exported.xml"
            convert(scene.model, scene.assets, exported)
            theirs, note = mi.load_file(str(small(exported, folder, size))), " (as exported)"
        ours = et.load(copy, substitute=True, **defines(path))
        sides = (
            (et.render(ours, spp=options.spp, seed=seed).image for seed in range(options.seeds)),
            images(theirs, options),
        )
        return compare(*(BlockMeans.of_seeds(side, options.block) for side in sides)), note


def images(scene: Any, options: argparse.Namespace) -> Iterator[NDArray[np.float32]]:
    for seed in range(options.seeds):
        yield np.array(mi.render(scene, seed=seed, spp=options.spp))[..., :3]


def small(path: Path, folder: Path, size: tuple[int, int]) -> Path:
    """Write a scene with a box filter, independent samples and another size into a folder where it finds its files."""
    for file in path.parent.iterdir():
        if not (folder / file.name).exists():
            (folder / file.name).symlink_to(file.resolve())
    tree = ET.parse(path)
    film = next(tree.iter("film"))
    for child in list(film):
        if child.tag == "rfilter" or child.get("name", "") in ("width", "height") or "crop" in child.get("name", ""):
            film.remove(child)
    film.append(ET.Element("rfilter", type="box"))
    for what, value in zip(("width", "height"), size, strict=True):
        film.append(ET.Element("integer", name=what, value=str(value)))
    for sampler in tree.iter("sampler"):
        sampler.set("type", "independent")
        sampler[:] = [child for child in sampler if child.get("name") in ("sampleCount", "sample_count")]
    copy = folder / f"small-{path.name}"
    tree.write(copy)
    return copy


if __name__ == "__main__":
    sys.exit(main())
