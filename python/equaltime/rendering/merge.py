"""Merging of renders of one image with different seeds, from several machines or days, into one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.film.focus import Focus
from equaltime.film.parts_of_merge import MergedFilm
from equaltime.film.unseen import Unseen
from equaltime.images.image_files import extension
from equaltime.images.preview import EXTENSIONS
from equaltime.rendering.budget import Stop
from equaltime.rendering.film_picture import ALPHA
from equaltime.rendering.origin import Origin
from equaltime.rendering.result import Result, Stats, make_result
from equaltime.rendering.saved import Render, SavedRender, as_checkpoint, differences
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["merge"]


_OF_SOURCE: Final = ("seed", "samples", "spp", "stopped_by", "stop", "position", "seconds", "build")
"""Keys of a render's record that tell of a part of a merged render what its own command was, and what it took."""


def merge(renders: Sequence[Render]) -> Result:
    """Return one render that joins several renders of the same scene by the same strategy with different seeds.

    Moments (counts, means and deviations of each pixel's samples) are joined, not images. So the image is the image of
    one render with all the samples, up to the last bits of float64. Its standard error and its error come from the
    scatter of the merged renders, and of the halves of each (`equaltime.film.parts_of_merge`). The result can be merged
    again. The order of merging changes the image and its standard error by one float32 ulp at most. Alpha is the only
    output beside the image that is joined.

    Parameters
    ----------
    renders
        Two or more results, or files that `Result.save` wrote.

    Raises
    ------
    ImageError
        If a file cannot be read or holds no moments, if two belong to different images or have samples in common, if
        the sample counts of pixels follow from their own samples (``adaptive`` is neither ``none`` nor ``error``), or
        if a render ended at a sample that was not a number.

    Examples
    --------
    >>> parts = [et.render("scene.toml", spp=8, seed=seed) for seed in (1, 2)]
    >>> et.merge(parts).spp
    16.0
    """
    if len(renders) < 2:
        raise ImageError("merging takes two renders or more")
    for render in renders:
        _check_kind(render)
    parts = [as_checkpoint(render) for render in renders]
    first = parts[0]
    for part in parts:
        _check_counts(part)
        _check_whole(part)
    for part in parts[1:]:
        _check_alike(first, part)
    _check_disjoint(parts)
    film = reduce(MergedFilm.joined, (part.film for part in parts))
    result = make_result(
        replace(film.statistics(), common_doubt=max(part.record["common_doubt"] for part in parts)),
        _stats(parts),
        "merge",
        _origin(first, parts),
        film.moments,
        bias=_bias(parts),
        hidden=Unseen.together([part.missed for part in parts], _focus(parts)),
        parts=film.parts,
        stop=_stop(parts),
    )
    return replace(result, aovs=_alpha(parts))


def _alpha(parts: Sequence[SavedRender]) -> dict[str, NDArray[np.float32]]:
    """Return the mean alpha, weighted by the parts' samples, if all have it; other outputs cannot be joined."""
    planes = [(part.alpha, part.moments["count"].sum(axis=0)) for part in parts if part.alpha is not None]
    if len(planes) < len(parts):
        return {}
    samples = np.maximum(1, sum(counts for _, counts in planes))
    return {ALPHA: np.asarray(sum(alpha * counts for alpha, counts in planes) / samples, np.float32)}


def _check_kind(render: Render) -> None:
    """Refuse a picture: its samples are in the EXR file of the render."""
    if not isinstance(render, Result) and extension(path := Path(render)) in EXTENSIONS:
        exr = path.with_suffix(".exr")
        what = f"give {exr}" if exr.exists() else "render it with -o FILE.exr, and give that file"
        raise ImageError(f"{path}: a picture has no samples to merge; {what} instead")


def _check_counts(part: SavedRender) -> None:
    """Refuse sample counts that follow from a pixel's own samples: dark samples would weigh more in the mean.

    With adaptive=error the counts follow from other pixels, so a mean weighted by them is unbiased.
    """
    if (adaptive := Strategy.parse(part.record["strategy"]).adaptive) not in ("none", "error"):
        raise ImageError(
            f"{part.path}: renders with adaptive={adaptive} cannot be merged: each pixel chose its sample counts from "
            "its own samples. Render the parts with adaptive=error or adaptive=none."
        )


def _check_whole(part: SavedRender) -> None:
    """Refuse a render that lacks a sample because it was not finite: its image is no estimate."""
    if part.record["stopped_by"] == "nonfinite":
        raise ImageError(f"{part.path}: cannot be merged: it ended at a sample that was not a number, and lacks it")


def _check_alike(first: SavedRender, other: SavedRender) -> None:
    if different := differences(other.record, first.record):
        raise ImageError(
            f"{other.path}: cannot be merged with {first.path}: it has {'; '.join(different)}. Parts of one render "
            "differ only in --seed and in their numbers of samples; render one of the two anew."
        )


def _check_disjoint(parts: Sequence[SavedRender]) -> None:
    """Refuse the same random numbers twice: every render begins with sample 0, so one seed serves for one part."""
    owners: dict[int, Path] = {}
    for part in parts:
        for seed in _seeds(part):
            if seed in owners:
                raise ImageError(
                    f"{part.path}: cannot be merged with {owners[seed]}: both have the samples of seed {seed}; "
                    "render one of the two with another --seed"
                )
            owners[seed] = part.path


def _seeds(part: SavedRender) -> tuple[int, ...]:
    return tuple(source["seed"] for source in _sources(part))


def _sources(part: SavedRender) -> tuple[Mapping[str, Any], ...]:
    """Return the rendered sources, one for each seed."""
    record = part.record
    return tuple(record["sources"]) or ({key: record[key] for key in _OF_SOURCE if record[key] is not None},)


def _bias(parts: Sequence[SavedRender]) -> Interval | None:
    """Return the bias of the parts; it is the same in all, so the measurement with the largest upper limit is kept."""
    found = [Interval.from_dict(part.record["bias"]) for part in parts if part.record["bias"] is not None]
    return max(found, key=lambda bias: bias.high, default=None)


def _focus(parts: Sequence[SavedRender]) -> Focus:
    """Return the light that specular surfaces focus; all parts show one scene, so the first record with it decides."""
    told = (part.record["focus"] for part in parts if part.record["focus"] is not None)
    return Focus.from_dict(next(told, None))


def _stop(parts: Sequence[SavedRender]) -> Stop | None:
    """Return the rule of a part that stopped by its own error, if any: its selection affects the merged image too."""
    return next((part.stop for part in parts if part.stop is not None and part.stop.selects), None)


def _stats(parts: Sequence[SavedRender]) -> Stats:
    records = [part.record for part in parts]
    return Stats(
        phases={"render": sum(record["seconds"] for record in records)},
        paths=sum(record["paths"] for record in records),
        rays=sum(record["rays"] for record in records),
        shadow_rays=sum(record["shadow_rays"] for record in records),
        kernel=records[0]["kernel"],
        threads=records[0]["threads"],
        effects=tuple(records[0]["effects"]),
        revisions=tuple(dict.fromkeys(one for record in records for one in record["revisions"])),
        runs=sum(record["runs"] for record in records),
    )


def _origin(first: SavedRender, parts: Sequence[SavedRender]) -> Origin:
    sources = tuple(source for part in parts for source in _sources(part))
    origin = Origin.from_record(first.record)
    return replace(origin, second_net=0, sources=sources, scene_max_depth=_scene_max_depth(parts))


def _scene_max_depth(parts: Sequence[SavedRender]) -> int | None:
    """Return the depth that the parts' scene asks for; prefer one that differs from the image's depth."""
    said = [depth for part in parts if (depth := part.record["scene_max_depth"]) is not None]
    return max(said, key=lambda depth: depth != parts[0].record["max_depth"], default=None)
