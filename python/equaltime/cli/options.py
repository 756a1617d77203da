"""Options that several commands share, and the parsers of their values."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, get_args

import typer

from equaltime.cluster import check_address, check_machines
from equaltime.extras import optional
from equaltime.images.exposure import AUTO, MOST_STOPS, Exposure
from equaltime.images.preview import JPEG_QUALITY
from equaltime.rendering.job import MOST_SECONDS, MOST_THREADS
from equaltime.rendering.output_files import AovPicture
from equaltime.scene.frames import parse_frames
from equaltime.scene.model.values import from_hex
from equaltime.words import seconds_of

__all__ = [
    "AovNames",
    "AsJson",
    "Crop",
    "Define",
    "ErrorTarget",
    "ExposureStops",
    "JpegQuality",
    "MaxDepth",
    "NoMetadata",
    "OnCluster",
    "OnMachines",
    "Overwrite",
    "SceneFile",
    "Seed",
    "Size",
    "Small",
    "StrategyWords",
    "Substitute",
    "Tev",
    "Threads",
    "Time",
    "Transparent",
    "Verbose",
    "Without",
    "parse_aov",
    "parse_background",
    "parse_cluster",
    "parse_crop",
    "parse_definitions",
    "parse_duration",
    "parse_exposure",
    "parse_frame_numbers",
    "parse_machines",
    "parse_number",
    "parse_percent",
    "parse_percents",
    "parse_pixel",
    "parse_size",
    "parse_whole",
]


def parse_duration(text: str) -> float:
    """Parse a duration such as ``10s``, ``500ms``, ``2.5m``, ``1h30m`` or ``2d``, and return it in seconds.

    A number without a unit is in seconds. Raises typer.BadParameter for any other text and for a duration of 0.
    """
    try:
        seconds = seconds_of(text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    if seconds <= 0.0:
        raise typer.BadParameter("a duration must be above 0")
    if seconds > MOST_SECONDS:
        raise typer.BadParameter(f"'{text}' is too long; a duration may have {MOST_SECONDS:g} seconds")
    return seconds


_LEAST_WITHOUT_SIGN = 0.5
"""Smallest number that needs a per cent sign: ``1`` for an error probably means 1 %, not 100 %."""


def parse_percent(text: str) -> float:
    """Parse an error such as ``2%`` or ``0.02``, and return it as a fraction in (0, 1).

    Raises typer.BadParameter for other texts, and for numbers of 0.5 or more without a per cent sign.
    """
    number, percent, rest = text.strip().partition("%")
    try:
        value = float(number) / (100.0 if percent else 1.0)
    except ValueError:
        value = math.nan
    if rest or not 0.0 < value < math.inf:
        raise typer.BadParameter(f"'{text}' is no error; write a positive percentage, such as 2%")
    if not percent and _LEAST_WITHOUT_SIGN <= value < 100.0:
        other = f", or {100.0 * value:g}%" if value < 1.0 else ""
        raise typer.BadParameter(f"'{text}' is {100.0 * value:g} %; did you mean {number.strip()}%{other}?")
    if value >= 1.0:
        raise typer.BadParameter(f"'{text}' is too large; an error to be reached is below 100 %, such as 2%")
    return value


def parse_percents(text: str) -> tuple[float, ...]:
    """Parse errors such as ``5%,2%``, and return them as fractions; raises typer.BadParameter as `parse_percent`."""
    return tuple(map(parse_percent, text.split(",")))


def parse_exposure(text: str) -> Exposure:
    """Parse an exposure: ``auto``, or a number of stops such as ``1.5`` or ``-2``.

    Raises typer.BadParameter for other texts, and for more than `MOST_STOPS` stops.
    """
    if text.strip() == AUTO:
        return AUTO
    try:
        stops = float(text)
    except ValueError:
        stops = math.nan
    if not abs(stops) <= MOST_STOPS:
        raise typer.BadParameter(f"'{text}' is no exposure; write auto, or stops such as 1.5 or -2")
    return stops


_COLORS = {"white": (1.0, 1.0, 1.0), "black": (0.0, 0.0, 0.0)}


def parse_background(text: str) -> tuple[float, ...]:
    """Parse ``white``, ``black``, ``#rrggbb`` (encoded sRGB) or ``R,G,B`` in [0, 1] (linear), and return linear sRGB.

    Raises typer.BadParameter for other texts.
    """
    try:
        hexadecimal = text.lstrip().startswith("#")
        color = _COLORS.get(text) or (from_hex(text) if hexadecimal else tuple(map(float, text.split(","))))
    except ValueError:
        color = ()
    if len(color) != 3 or not all(0.0 <= value <= 1.0 for value in color):
        kinds = "white, black, #rrggbb as on web pages, or linear R,G,B from 0 to 1: 0.2,0.2,0.2"
        raise typer.BadParameter(f"'{text}' is no colour; write {kinds}")
    return color


def parse_cluster(text: str) -> str:
    """Parse the place of a cluster, ``local:N`` or an address; raises typer.BadParameter for other texts.

    Raises EqualtimeError with the line that installs Dask if it is missing, before anything is begun.
    """
    return _with_dask(text, check_address)


def parse_machines(text: str) -> str:
    """Parse the place of a cluster whose machines take whole runs; raises typer.BadParameter for other texts.

    Raises EqualtimeError with the line that installs Dask if it is missing, before anything is begun.
    """
    return _with_dask(text, check_machines)


def _with_dask(text: str, check: Callable[[str], str]) -> str:
    try:
        where = check(text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    optional("distributed", "cluster")
    return where


def parse_aov(text: str) -> str:
    """Parse the name of a picture beside the image: ``variance``; raises typer.BadParameter for other names."""
    if text not in (known := get_args(AovPicture)):
        raise typer.BadParameter(
            f"'{text}' is not known here, only {', '.join(known)}; integrator 'aov' of the scene makes others"
        )
    return text


def parse_whole(least: int, most: int) -> Callable[[str | int], int]:
    """Return a parser of texts for integers in [least, most]; it raises typer.BadParameter for other texts.

    The parser also accepts an int, because typer passes an option's default through its parser.
    """

    def parse(value: str | int) -> int:
        text = str(value)
        if not (re.fullmatch(r"-?[0-9]{1,20}", text) and least <= int(text) <= most):
            raise typer.BadParameter(f"'{text}' is no whole number from {least} to {most}")
        return int(text)

    return parse


def parse_number(least: float, most: float) -> Callable[[str | float], float]:
    """Return a parser of texts for numbers in [least, most].

    The parser also accepts a number, because typer passes an option's default through its parser.
    """

    def parse(value: str | float) -> float:
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not least <= number <= most:
            raise typer.BadParameter(f"'{value}' is no number from {least:g} to {most:g}")
        return number

    return parse


def parse_frame_numbers(text: str | tuple[int, ...]) -> tuple[int, ...]:
    """Parse frame numbers such as ``0-47``, ``0-47:2`` (every second) or ``1,5,9``, and return them in a tuple.

    Raises typer.BadParameter for other texts.
    """
    try:
        return parse_frames(text) if isinstance(text, str) else text
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


def parse_size(text: str) -> tuple[int, int]:
    """Parse a size such as ``640x480``, and return width and height in pixels."""
    match = re.fullmatch(r"(\d+)[xX](\d+)", text.strip())
    if not match or 0 in (int(match[1]), int(match[2])):
        own = "; `equaltime info SCENE` tells the scene's own size" * ("%" in text)
        raise typer.BadParameter(f"'{text}' is no size; write WIDTHxHEIGHT, such as 640x480{own}")
    return int(match[1]), int(match[2])


def parse_pixel(text: str) -> tuple[int, int]:
    """Parse a pixel ``x,y``, and return its column and row, counted from 0 at the upper left."""
    if not (match := re.fullmatch(r"(\d+),(\d+)", text.replace(" ", ""))):
        raise typer.BadParameter(f"'{text}' is no pixel; write x,y, counted from the left and from the top")
    return int(match[1]), int(match[2])


def parse_crop(text: str) -> tuple[int, int, int, int]:
    """Parse a crop window ``x,y,w,h``, and return column and row of its upper left corner, width and height."""
    if not (match := re.fullmatch(r"(\d+),(\d+),(\d+),(\d+)", text.replace(" ", ""))):
        raise typer.BadParameter(f"'{text}' is no crop window; write x,y,width,height in pixels, such as 0,0,64,64")
    return int(match[1]), int(match[2]), int(match[3]), int(match[4])


def parse_definitions(pairs: Sequence[str]) -> dict[str, str]:
    """Parse texts ``name=value``, and return the values by name; the last text with a name wins."""
    definitions = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not (name and equals):
            raise typer.BadParameter(f"'{pair}' is no definition; write name=value", param_hint="-D")
        definitions[name] = value
    return definitions


SceneFile = Annotated[
    Path,
    typer.Argument(
        metavar="SCENE", help="Scene file: TOML, Mitsuba 3 XML, glTF; or a mesh, OBJ or PLY.", show_default=False
    ),
]

Time = Annotated[
    float | None,
    typer.Option(
        parser=parse_duration,
        metavar="DURATION",
        show_default=False,
        help="Render for this long: 10s, 500ms, 1h30m. Outputs beside the image take extra time.",
    ),
]

ErrorTarget = Annotated[
    float | None,
    typer.Option(
        parser=parse_percent,
        metavar="PERCENT",
        show_default=False,
        help="Render until the picture is this accurate: 2%. The upper limit of its error counts.",
    ),
]

Size = Annotated[
    Any,
    typer.Option(
        parser=parse_size, metavar="WxH", show_default=False, help="Size of the picture, instead of the scene's."
    ),
]

AsJson = Annotated[bool, typer.Option("--json", help="Print the numbers as JSON, and nothing else.")]

Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Print all details.")]

NoMetadata = Annotated[
    bool,
    typer.Option(
        "--no-metadata",
        help="Leave out of the picture all that tells of the render: the scene's path, the error, the program, and how "
        "to repeat it. `equaltime info` can then tell nothing of the picture.",
    ),
]

JpegQuality = Annotated[
    int | None,
    typer.Option(
        "--quality",
        parser=parse_whole(1, 100),
        metavar="N",
        help=f"Quality of a JPEG, from 1 (small file) to 100 (large file) [default: {JPEG_QUALITY}].",
        show_default=False,
    ),
]

Overwrite = Annotated[
    bool,
    typer.Option(
        "--overwrite",
        help="Replace FILE even if another program wrote or edited it, or it shows another scene file. A render of the "
        "same scene file is replaced without this option: an EXR is kept as FILE.exr~ if it took more than a minute or "
        "the scene was edited since, and a picture alone as FILE.png~.",
    ),
]

ExposureStops = Annotated[
    Any,
    typer.Option(
        "--exposure",
        parser=parse_exposure,
        metavar="auto|EV",
        show_default=False,
        help="Brightness of the preview in stops, such as 1.5 or -2, counted from the scene's own values (0), not from "
        "the automatic picture. auto: whole stops, if it would be too dark or too bright. The EXR is never scaled "
        "[default: auto]",
    ),
]

AovNames = Annotated[
    list[str] | None,
    typer.Option(
        parser=parse_aov,
        metavar="variance",
        show_default=False,
        help="Write FILE.variance.png too: the variance of one sample of each pixel, darker where it is higher, on a "
        "log scale that is printed.",
    ),
]

Small = Annotated[
    bool,
    typer.Option(
        "--small",
        help="Save a small file: the image in 11 bits, and its standard error. It cannot be resumed or merged.",
    ),
]

Crop = Annotated[
    Any,
    typer.Option(
        parser=parse_crop,
        metavar="X,Y,W,H",
        show_default=False,
        help="Render this window only: identical to that part of the full picture with adaptive=none.",
    ),
]

Transparent = Annotated[
    bool,
    typer.Option(
        "--transparent",
        help="Leave the sky out of the picture, and give it alpha. The sky still lights the scene; in a scene with a "
        "sky, lamps and glowing surfaces are hidden too. A ground stays, with its shadows.",
    ),
]

MaxDepth = Annotated[
    int | None,
    typer.Option(
        parser=parse_whole(-1, 2**31 - 1),
        metavar="N",
        show_default=False,
        help="Longest path: 1 shows lamps only, 2 direct light, 3 one bounce, -1 all.",
    ),
]

StrategyWords = Annotated[
    str,
    typer.Option(
        metavar="S",
        help="How paths are sampled: a preset, or preset,key=value,…, or a TOML file; see equaltime render -h.",
    ),
]

Seed = Annotated[
    int, typer.Option(parser=parse_whole(0, 2**64 - 1), metavar="N", help="Random seed: another one gives other noise.")
]

Threads = Annotated[
    int,
    typer.Option(parser=parse_whole(0, MOST_THREADS), metavar="N", help="Threads; 0 is one for each processor."),
]

OnCluster = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        parser=parse_cluster,
        metavar="WHERE",
        show_default=False,
        help="Let other processes take the samples: local:N for N processes here, or the address of Dask's scheduler "
        "such as tcp://node1:8786. The picture has the same bits. Needs Dask: pip install '.[cluster]' in a checkout.",
    ),
]

Define = Annotated[
    list[str] | None,
    typer.Option(
        "-D",
        "--define",
        metavar="NAME=VALUE",
        show_default=False,
        help="Set a parameter of the scene; of a model by itself (glTF, OBJ, PLY): view=back, up=z, sky=0.3, sun=2, "
        "sun_angle=15, ground=0.6, crease_angle=60 or face_normals=true.",
    ),
]

Substitute = Annotated[
    bool,
    typer.Option(
        "--substitute",
        help="Replace materials and the like that cannot be rendered, and images that are missing, and say so, instead "
        "of refusing the scene.",
    ),
]

Tev = Annotated[
    str | None,
    typer.Option(
        "--tev",
        metavar="HOST:PORT",
        show_default=False,
        help="Show the passes in the viewer tev, which listens at localhost:14158.",
    ),
]

Without = Annotated[
    list[str] | None,
    typer.Option(
        metavar="EFFECT",
        show_default=False,
        help="Leave an effect out, such as lens, textures or long_paths=4 (see equaltime effects). Faster, but no "
        "longer exact; the difference is measured and included in the error. May be given again.",
    ),
]

OnMachines = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        parser=parse_machines,
        metavar="WHERE",
        show_default=False,
        help="Let machines like this one take the runs, one at a time each: the address of Dask's scheduler such as "
        "tcp://node1:8786, or local:1. Needs Dask: pip install '.[cluster]' in a checkout.",
    ),
]
