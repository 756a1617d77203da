"""Summary of a saved render: its accuracy, how it was made, and the command that would repeat it."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from equaltime.cli.quote_details import single_pixels
from equaltime.cli.recorded import (
    CHANGED,
    copied_scene,
    error_limit,
    new_name,
    next_error,
    plain,
    recorded_command,
    recorded_exposure,
    recorded_scene,
    shown_path,
    shown_scene,
)
from equaltime.errors import EqualtimeError
from equaltime.film.parts_of_merge import statistics_of
from equaltime.quoting.noise_places import noise_places
from equaltime.rendering.origin import Origin
from equaltime.rendering.render_file import read_film
from equaltime.rendering.render_record import checked
from equaltime.rendering.stated import asked_samples, paths_up_to, samples_in_words, stated
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.words import duration_of_runs, percent

__all__ = ["bright_dots", "repeating", "saved_render", "seeds", "with_scene"]

Record = Mapping[str, Any]

_MOST_COMMANDS = 4
"""Largest number of commands that repeat a merged render without ``-v``, so that all fits into thirteen lines."""
_ENDS = {
    "spp": "it had its samples",
    "count": "it had the samples that a pilot chose",
    "time": "the time was up",
    "interrupt": "it was interrupted",
    "merge": "the parts were joined",
    "unfinished": "it is a checkpoint: the render was not finished",
    "nonfinite": "a sample was not a number",
    "faulty": "a sample raised a floating-point fault",
}


def saved_render(path: Path, record: Record, resumable: bool, verbose: bool = False) -> Iterator[str]:
    """Yield at most eleven lines (thirteen if merged) on the saved render at ``path``, whose file holds ``record``.

    ``record`` is JSON data on how the render was made, and ``resumable`` tells whether the render can be continued.
    ``verbose`` tells that all facts follow, so that the lines do not point to ``-v``.
    """
    record, changed = with_scene(checked(record, path), path)
    error = UNKNOWN if record["error"] is None else Interval.from_dict(record["error"])
    width, height = record["size"]
    more = "" if verbose else "; -v for more"
    number = stated(Origin.from_record(record))
    spp = samples_in_words(record["spp"], asked_samples(record["stopped_by"], record.get("position")))
    said = f"{number.noun} {error:%}{number.of_paths}"
    yield f"{path}: {said}, {spp} in {duration_of_runs(record['seconds'], record['runs'])}"
    yield f"shows     {shown_scene(record['scene'])} at {width}x{height}{_parts(record)}"
    yield f"ended     as {_end(record)}"
    yield f"strategy  {record['strategy']}{' (biased)' if record['biased'] else ''}, {seeds(record)}{more}"
    if error.doubt:
        yield f"in doubt  {error.doubt}"
    if number.missing:
        yield f"lacks     {number.missing}"
    yield from repeating(new_name(path), record, verbose, changed)
    picture = new_name(path).with_suffix(".png")
    convert = ["equaltime", "convert", str(path), str(picture), *recorded_exposure(record)]
    shown = str(picture) if picture.exists() else shlex.join(convert)
    yield f"picture   {shown}"
    yield f"goes on   {_how_on(path, record, error, changed) if resumable else 'no longer: it was saved small'}"


def bright_dots(path: Path, record: Record) -> Iterator[str]:
    """Yield lines on the single pixels that make much of the error of the saved render at ``path``, the largest first.

    The second line is the command that shows the path behind the first pixel, if the render can be replayed. There is
    no line without such pixels, without samples in the file, or if some pixels have too few to tell their noise.
    """
    moments, parts, second = read_film(path)
    if moments is None:
        return
    pixels = statistics_of(moments, parts, second)
    if not (np.isfinite(pixels.variance).all() and pixels.mean.any()):
        return
    places = noise_places(pixels, (record["crop"][0], record["crop"][1]))
    if dots := single_pixels(places):
        yield f"dots      {dots}"
        x, y = places.single_pixels[0]
        if record["scene"] is not None and record["backend"] == "core" and not record["sources"]:
            yield f"          {shlex.join(['equaltime', 'replay', str(path), '--pixel', f'{x},{y}'])}"


def _parts(record: Record) -> str:
    """Return what the picture has of its scene, if not all of it."""
    (width, height), crop, asked = record["size"], record["crop"], record.get("scene_max_depth")
    parts = [] if record["frame"] is None else [f"frame {record['frame']['number']}"]
    if crop != [0, 0, width, height]:
        parts.append(f"window {','.join(map(str, crop))}")
    if asked is not None and asked != record["max_depth"]:
        parts.append(paths_up_to(record["max_depth"]))
    if record.get("without"):
        parts.append(f"without {', '.join(record['without'])}")
    return "".join(f", {part}" for part in parts)


def _end(record: Record) -> str:
    stop = record.get("stop") or {}
    if record["stopped_by"] == "error":
        return f"the error was below {percent(stop['error'])}" if "error" in stop else "the error was small enough"
    return _ENDS[record["stopped_by"]]


def seeds(record: Record) -> str:
    """Return the seed of a render, or the seeds and samples a pixel of the parts of a merged one."""
    if not record.get("sources"):
        return f"seed {record['seed']}"
    return ", ".join(f"seed {source['seed']}: {_spp(source['samples'])} spp" for source in record["sources"])


def _how_on(path: Path, record: Record, error: Interval, changed: str) -> str:
    """Return how a saved render can go on, if possible as a command; ``changed`` tells why it cannot.

    A merged render has no position at which samples could go on. A kept copy is not written to, but copied first.
    """
    if record["sources"]:
        return "with merge"
    new = new_name(path)
    copied = "" if new == path else shlex.join(["cp", shown_path(path), shown_path(new)])
    if not changed and (command := _further(new, record, error)):
        return " && ".join(filter(None, [copied, command]))
    scene = "only with the scene as it was: " * bool(changed)
    return f"{scene}with --resume{f' after {copied},' * bool(copied)} or merge"


def _further(path: Path, record: Record, error: Interval) -> str | None:
    """Return the command that goes on with a render to the next smaller error; None without one.

    Merged renders and scenes made in memory have no such command. Nor has a render whose error is unknown or biased.
    """
    target = next_error(error.value)
    if target is None or record["scene"] is None or record["sources"] or record.get("bias"):
        return None
    return shlex.join(recorded_command(record, shown_path(path), ["--resume", "--error", f"{100.0 * target:g}%"]))


def _spp(samples: Mapping[str, int]) -> str:
    """Return the sample count of the pixels, or the range of counts."""
    return f"{samples['max']}" if samples["min"] == samples["max"] else f"{samples['min']} to {samples['max']}"


def repeating(path: Path, record: Record, verbose: bool, changed: str) -> Iterator[str]:
    """Yield the commands that would repeat the render, and what differs if it cannot be repeated exactly.

    The commands write ``path``, and ``changed`` tells why they give another picture (`with_scene`).
    """
    if record["scene"] is None:
        yield from _call(record, shown_path(path))
        return
    if not record["sources"]:
        words, why = _command(record, shown_path(path))
        yield f"{_title(not why)}{shlex.join(words)}"
        yield from _not_exactly(why)
    elif all(source["stopped_by"] for source in record["sources"]):
        yield from _repeat_parts(path, record, verbose)
    else:
        return  # merged by an earlier version, which did not record how the parts ended
    if changed:
        yield f"          but {changed}"


def _call(record: Record, name: str) -> Iterator[str]:
    """Yield the call that repeats a render of a scene made in Python, which no command can load."""
    if record["sources"] or record["frame"] is not None:
        yield "repeat    in Python: the scene was made there, and this file does not hold it"
        return
    option, why = _limit(record)
    limit, *rule = option[1::2]
    kind = option[0].removeprefix("--")
    words = [f"{kind}={float(limit.rstrip('%')) / 100.0:g}" if kind == "error" else f"{kind}={limit}"]
    words += [f"stop={name!r}" for name in rule] + [f"strategy={record['strategy']!r}", f"seed={record['seed']}"]
    words += [f"without={list(record['without'])!r}"] if record.get("without") else []
    saved = [] if record["exposure"] is None else [f"exposure={plain(record['exposure'])}"]
    words += [f"backend={record['backend']!r}"] if record["backend"] != "core" else []
    call = f"et.render(scene, {', '.join(words)}).save({', '.join([repr(name), *saved])})"
    yield f"{_title(not why)}in Python, with the same scene or dict, which no file holds: {call}"
    yield from _not_exactly(why)


def _repeat_parts(path: Path, record: Record, verbose: bool) -> Iterator[str]:
    """Yield the commands that would render the parts of a merged render, and merge them; not all unless ``verbose``."""
    commands = {}
    for source in record["sources"]:
        number = "" if record["frame"] is None else f"_{record['frame']['number']:04}"
        name = shown_path(path.with_name(f"part-{source['seed']}{number}.exr"))
        commands[name] = _command({**record, **source, "exposure": None}, name)
    why = next((why for _, why in commands.values() if why), "")
    title = _title(not why)
    lines = [words for words, _ in commands.values()] + [
        ["equaltime", "merge", *commands, "-o", shown_path(path), *recorded_exposure(record)]
    ]
    most = _MOST_COMMANDS - bool(why)
    shown = len(lines) if verbose or len(lines) <= most else most - 1
    for words in lines[:shown]:
        yield f"{title}{shlex.join(words)}"
        title = " " * len(title)
    if shown < len(lines):
        yield f"{title}and so on for {len(commands) - shown} more parts, then equaltime merge: -v shows all"
    yield from _not_exactly(why)


def _title(exact: bool) -> str:
    return f"{'repeat' if exact else 'similar':<10}"


def _not_exactly(why: str) -> Iterator[str]:
    """Yield the line that tells ``why`` a command does not repeat a render exactly; none if it does."""
    if why:
        yield f"          not exactly, since {why}"


def _command(record: Record, name: str) -> tuple[list[str], str]:
    """Return the command that renders the file ``name`` anew, and why the picture is not exactly the same, or empty."""
    limit, why = _limit(record)
    if record["frame"] is not None and record["seed"] < record["frame"]["number"]:  # Python may give any seed
        why = "the frame's seed is below its number"
    return recorded_command(record, name, limit), why


def _limit(record: Record) -> tuple[list[str], str]:
    """Return the options that end a render at the same samples, and why they do not do so exactly; else empty."""
    stop, by = record.get("stop") or {}, record["stopped_by"]
    if by in ("error", "count") and "error" in stop:
        bias = Interval.from_dict(record["bias"]) if record.get("bias") else None
        return error_limit(stop["error"], bias, fixed=by == "count"), ""
    if by == "spp" and (position := record.get("position")):
        return ["--spp", str(position[0])], ""
    why = "the file does not tell where it ended" if by in ("error", "count", "spp") else _ENDS[by]
    return ["--spp", str(max(1, round(record["spp"])))], f"{why}; only --spp and --error end at the same samples again"


def with_scene(record: Record, picture: Path) -> tuple[Record, str]:
    """Return the record with the scene's file as it is found now, and why that gives another picture, or empty.

    A copy of the scene beside the ``picture`` or in the working directory takes the place of the recorded file.
    """
    copied = copied_scene(record, picture)
    return (record, _changes(record)) if copied is None else (copied, "")


def _changes(record: Record) -> str:
    if record["scene"] is None:
        return ""
    if not Path(record["scene"]).exists():
        return "that file is not there"
    try:
        scene = recorded_scene(record)
    except EqualtimeError:
        return "that file cannot be read as it is"
    return "" if scene is not None else f"the scene {CHANGED}"
