"""Messages of the command line: errors, warnings, quotes (predictions of a render), and lines about an image."""

from __future__ import annotations

import math
import re
import shlex
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

from rich.console import Console

from equaltime.cli.lines import fitted
from equaltime.cluster import CONNECT_SECONDS
from equaltime.errors import EqualtimeWarning, ImageError
from equaltime.film.unseen import FAR_APART
from equaltime.images.exposure import beside_automatic, exposure_in_words
from equaltime.quoting.observer import ENDED_FIRST
from equaltime.quoting.pilot import Quote
from equaltime.rendering.outputs import asked_for
from equaltime.rendering.result import Result
from equaltime.rendering.stated import asked_samples, not_as_asked, stated
from equaltime.scene import Scene
from equaltime.scene.bare_mesh import MESHES
from equaltime.scene.lint import Finding
from equaltime.statistics.in_words import count
from equaltime.strict_json import json_text, to_json
from equaltime.words import without_numbers

__all__ = [
    "ANY_WIDTH",
    "MOST_LINES",
    "WAYS",
    "Written",
    "bias",
    "doubts",
    "ended_by_interrupt",
    "headline",
    "kept_elsewhere",
    "left_by_interrupt",
    "lint_command",
    "once_each",
    "plain_console",
    "print_aside",
    "print_connecting",
    "print_error",
    "print_json",
    "print_line",
    "print_lines",
    "print_no_quote",
    "print_quote",
    "print_remarks",
    "print_warning",
    "print_warnings",
    "selects_images",
    "softer_sun",
    "while_heard",
    "worded_warnings",
]

MOST_LINES: Final = 12
"""Largest number of lines of an output without ``-v``: two with the answer, and ten more."""
ANY_WIDTH: Final = 1000
"""Width of a file or a pipe, in characters: more than any table has."""


def headline(result: Result) -> str:
    """Return a line on a render: size, samples per pixel, error or noise, and bias.

    The line also names errors that the printed number does not include, such as the error by paths left out.
    """
    height, width = result.samples.shape
    origin, number = result.origin, stated(result.origin)
    seeds = f" of {len(origin.sources)} seeds" if origin.sources else ""
    said = ", ".join([f"{number.noun} {result.error:%}{number.of_paths}", *bias(result)])
    missing = f"; {number.missing}" if number.missing else ""
    why = not_as_asked(result.spp, asked_samples(result.stopped_by, result.position))
    return f"{width}x{height}, {result.spp:.4g} spp{why}{seeds}, {said}{missing}"


def bias(result: Result) -> list[str]:
    """Return a list with one text: the cause of a bias, or "unbiased".

    The list is empty if other paths than the scene's were rendered. It is empty too if the scene has caustics and the
    error ended the render or a merged part. Such renders are a little too dark on average, even if all samples together
    have met the light often.
    """
    origin, number = result.origin, stated(result.origin)
    by = []
    if result.bias is not None:
        by.append(f"without {', '.join(origin.without)}, which makes {result.bias:%} of it")
    if number.by_strategy or (origin.biased and not by):
        by.append(origin.strategy)
    if by:
        return [f"biased: {', and '.join(by)}"]
    looked = result.stop is not None and result.stop.selects and result.stopped_by in ("error", "merge")
    selected = looked and result.focus.possible
    return [] if number.paths or selected else ["unbiased"]


def selects_images(result: Result) -> bool:
    """Tell whether the rule that ended the render favours images that missed rare light, so that their mean is biased.

    True if the rule compares the image's own error with a target, and pixels may have missed rare light.
    """
    return result.stop is not None and result.stop.selects and result.focus.rare(result.spp)


_LARGER_SUN: Final = "-D sun_angle=15"
_SOFTER = f"a larger sun ({_LARGER_SUN}) or rougher glass and metal are met sooner; both change the picture"


_PLACE = re.compile(r"^\S+\.\w+(?::\d+)?: ")
_FILE_NAME = re.compile(r"'[^']*\.\w+'")
"""Parts of a warning by which warnings of one kind differ: its place, such as ``a.mtl:3: ``, and names of files."""


_MUCH_WHITE: Final = 0.05
"""Least share of white pixels that is told of a picture whose exposure was asked for."""


@dataclass(frozen=True)
class Written:
    """Files that `Result.save` wrote, and how to read its pictures, for the lines that a command prints."""

    files: Sequence[Path]
    stops: float = 0.0
    """Exposure of the preview in stops: 1 is twice as bright."""
    automatic: float | None = None
    """Automatic exposure of the preview in stops; None if it is not to be compared with ``stops``."""
    scale: str = ""
    """Scale of the picture of the variance, in words; empty if there is no such picture."""
    opaque: bool = False
    """Whether the exposure was chosen from the opaque parts of the preview alone."""
    replaced: str = ""
    """Sentence on an earlier render at the same path that was replaced and not kept; empty if there is none."""
    white: float = 0.0
    """Share of the preview's pixels that are white, in [0, 1]."""
    again: bool = False
    """Whether the exposure was asked for by the earlier run of a resumed render."""

    def __str__(self) -> str:
        """Return the names of the files, with the exposure of the preview if it is not 0 or not the automatic one.

        Only an automatic exposure is told as brighter or darker: users compare another one with the automatic picture.
        """
        asked = self.automatic not in (None, self.stops)
        shown = f"exposure {self.stops:g}" if asked else exposure_in_words(self.stops)
        if shown and self.opaque:
            shown += " for what is not transparent"
        names = [str(file) for file in self.files if not file.name.endswith("~")]
        preview = next((i for i, name in enumerate(names) if not name.lower().endswith(".exr")), None)
        if shown and preview is not None:
            names[preview] += f" ({shown})"
        return ", ".join(names)

    @property
    def counted(self) -> str:
        """Sentence on an exposure that is not the automatic one; empty if it is."""
        told = "" if self.automatic is None else beside_automatic(self.stops, self.automatic)
        if told and self.again:
            return (
                f"--exposure {self.stops:g} is kept from the earlier run; --exposure auto chooses one for this picture"
            )
        if not told or self.white < _MUCH_WHITE:
            return told
        return f"{told}; {round(100.0 * self.white)} % of the picture is white: larger values are cut, not tone mapped"

    @property
    def kept(self) -> str:
        """Sentence that names the copy of an earlier render at the same path; empty if there is none."""
        kept = [file for file in self.files if file.name.endswith("~")]
        return f"the render that was there is kept as {', '.join(map(str, kept))}" if kept else ""


def doubts(result: Result, findings: Sequence[Finding] = (), forecast: str = "") -> list[str]:
    """Return one line for each reason not to trust the image or its error.

    ``findings`` are the results of `lint`, which searches a scene for likely mistakes. ``forecast`` is the doubt that
    the render's quote has told already.
    """
    lines = []
    if not result.error.trusted:
        known = without_numbers(forecast) == without_numbers(result.error.doubt)
        why = "for the reason told with the forecast" if known else result.error.doubt
        lines.append(f"the error's upper limit cannot be trusted{', ' if known else ': '}{why}")
        if result.focus.possible and _has_soft_sun(result):
            lines.append(_SOFTER)
    elif result.error.known and math.isinf(result.error.high):
        lines.append(
            "the error has no upper limit yet, since few very bright samples make it: take more samples, or a strategy "
            "that finds their light"
        )
    if empty := int((result.samples == 0).sum()):
        lines.append(f"{empty} of {result.samples.size} pixels have no sample")
    apart = result.radiance_range
    if apart > FAR_APART and any(finding.check == "radiance-range" for finding in findings):
        lines.append(
            f"the image has radiances {apart:.2g} times apart, more than {FAR_APART:.0e}: "
            "light of dim emitters may be missing where only they shine; "
            "render them separately, or choose all lights equally often (--strategy best,lights=uniform)"
        )
    return lines


def _has_soft_sun(result: Result) -> bool:
    """Tell whether the scene has a sun of this program whose size ``-D sun_angle=`` sets: a mesh by itself has one."""
    return _soft_sun(result.origin.scene or "", result.origin.record.get("defines") or {})


def softer_sun(scene: Scene) -> str:
    """Return the option that makes the scene's sun larger; empty unless this program added the sun."""
    told = any("-D sun_angle=" in warning for warning in scene.warnings)  # of a sun added to a glTF file
    return _LARGER_SUN if told or _soft_sun(str(scene.source or ""), scene.defines) else ""


def _soft_sun(source: str, defines: Mapping[str, object]) -> bool:
    return "sun_angle" in defines or (source.lower().endswith(MESHES) and defines.get("sun") not in ("0", "0.0"))


def ended_by_interrupt(result: Result, written: Written) -> list[str]:
    """Return one line if Ctrl-C ended a render whose files cannot be continued; otherwise an empty list."""
    if result.stopped_by != "interrupt":
        return []
    alone = not any(file.suffix.lower() == ".exr" for file in written.files)
    kind, way = ("a picture alone", "with -o FILE.exr") if alone else ("a small file", "without --small")
    return [f"{kind} cannot be continued; a render {way} can, by --resume"]


def left_by_interrupt(result: Result, scene: Scene) -> list[str]:
    """Return one line if Ctrl-C ended the render before the scene's other outputs (AOVs) were made.

    Otherwise return an empty list.
    """
    if result.stopped_by != "interrupt" or result.aovs or not asked_for(scene):
        return []
    return ["the outputs beside the image were not rendered; --resume renders them when the image is finished"]


def kept_elsewhere(result: Result) -> str:
    """Save a result to a temporary folder because its own file cannot be written.

    Returns a remark for the user with the path of the saved file; empty if this save fails, too.
    """
    with suppress(OSError):
        path = Path(tempfile.mkdtemp(prefix="equaltime-")) / "render.exr"
        with suppress(ImageError):  # also if only the preview fails
            result.save(path)
        if path.exists():
            return f"; the render is kept in {path}"
        path.parent.rmdir()
    return ""


T = TypeVar("T")

WAYS = {
    "seen": "seen by the camera",
    "met": "met by a scattered ray",
    "aimed": "aimed at",
    "none": "straight into the camera",
    "medium": "a medium",
}
"""Words for the techniques by which a path finds light, by their names in the core; for ``none``, light that no
surface scattered; and for ``medium``, light that a medium scattered."""


def plain_console() -> Console:
    """Return a console without markup, because rich would interpret brackets in names.

    A file or a pipe has no width: tables are not cut there.
    """
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = ANY_WIDTH
    return console


def print_line(console: Console, text: str, style: str = "") -> None:
    """Print a line to a console, broken to the width of a terminal; a file gets it in one piece."""
    console.print(fitted(text, console.file), style=style, soft_wrap=True)


def print_error(text: str) -> None:
    """Print each line of the text to stderr as ``error: …``."""
    for line in text.split("\n"):
        print(fitted(f"error: {_visible(line)}", sys.stderr), file=sys.stderr)


def print_json(value: object) -> None:
    """Print a value on stdout as JSON data."""
    print(json_text(to_json(value), indent=2))


def print_warnings(scene: Scene) -> None:
    """Print each kind of warning of the scene once to stderr, as ``warning: …``, with a count of those like it."""
    for warning in once_each(scene.warnings):
        print_warning(warning)


def print_remarks(scene: Scene) -> None:
    """Print one line to stderr on the warnings of the scene: the warning itself, or how many kinds `lint` lists.

    For commands that write no picture, and for resumed renders: `convert` and a new render print all of them.
    """
    kinds = once_each(scene.warnings)
    if len(kinds) > 1 and scene.source is not None:
        kinds = [f"{len(kinds)} kinds of remarks on how the file was read; see {lint_command(scene)}"]
    for line in kinds:
        print_warning(line)


def lint_command(scene: Scene) -> str:
    """Return the command that lists the hazards of the scene, read from its file with the same options."""
    source = [] if scene.source is None else [str(scene.source)]
    definitions = [word for name, value in scene.defines.items() for word in ("-D", f"{name}={value}")]
    return shlex.join(["equaltime", "lint", *source, *definitions, *["--substitute"] * bool(scene.substitutions)])


def once_each(warnings: Sequence[str]) -> list[str]:
    """Return the first warning of each kind, with the number of others that differ by place or file name alone."""
    kinds = [_FILE_NAME.sub("''", _PLACE.sub("", warning)) for warning in warnings]
    firsts = dict(zip(reversed(kinds), reversed(warnings), strict=True))
    counts = Counter(kinds)
    return [
        firsts[kind] + (f" (and {count - 1} more like it: lint -v)" if count > 1 else "")
        for kind, count in counts.items()
    ]


def print_warning(text: str) -> None:
    """Print the text to stderr as ``warning: …``."""
    print(fitted(f"warning: {_visible(text)}", sys.stderr), file=sys.stderr)


@contextmanager
def worded_warnings() -> Iterator[None]:
    """Print equaltime's own warnings inside the block as ``warning: …``, without a place in the code."""
    with warnings.catch_warnings():
        otherwise = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any) -> None:
            if issubclass(category, EqualtimeWarning):
                print_warning(str(message))
            else:
                otherwise(message, category, *place)

        warnings.showwarning = show  # type: ignore[assignment]  # it takes all places of a warning as one
        yield


def print_aside(text: str) -> None:
    """Print a line to stderr that is no warning, such as how long something will take."""
    print(fitted(_visible(text), sys.stderr), file=sys.stderr, flush=True)


def print_connecting(cluster: str | None) -> None:
    """Print to stderr how long a command may wait for the scheduler at an address; nothing for ``local:N`` or None."""
    if cluster is not None and not cluster.startswith("local:"):
        print_aside(f"connecting to {cluster}, which may take up to {CONNECT_SECONDS} s")


def print_lines(lines: Sequence[str]) -> None:
    """Print lines to stdout, broken to the width of a terminal, and flush after each."""
    for line in lines:
        print(fitted(_visible(line), sys.stdout), flush=True)


def print_quote(quote: Quote, resumed: bool = False) -> None:
    """Print the predicted error, time and samples of a render in one line.

    ``resumed`` tells whether the render is resumed, so that the time is only that of this run.
    """
    number = stated(quote.origin)
    spent = f"{quote.seconds:s}" + " of this run" * resumed
    said = f"{number.noun} {quote.error:%}{number.of_paths} after {spent}"
    doubt = f"; in doubt: {quote.error.doubt}" if quote.error.doubt else ""
    print_lines([f"Expect {said}, about {count(quote.spp.value)} samples a pixel{doubt}"])


def print_no_quote(why: str) -> None:
    """Print ``why``, the reason why time or error cannot be predicted.

    Print nothing if the render merely ended too soon.
    """
    if why != ENDED_FIRST:
        print_lines([f"No prediction: {why}"])


def while_heard(say: Callable[[T], object]) -> Callable[[T], None]:
    """Return a function that passes its argument to ``say``, but does nothing once ``say`` has raised an OSError.

    A closed pipe or a full disk therefore does not end a render.
    """
    heard = True

    def said(what: T) -> None:
        nonlocal heard
        if heard:
            try:
                say(what)
            except OSError:
                heard = False

    return said


def _visible(text: str) -> str:
    """Escape unprintable characters: a text from a file must not control the terminal."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)
