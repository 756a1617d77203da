"""Options that several commands share, so that their help is the same."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from equaltime.cli.arguments import parse_crop, parse_duration, parse_percent, parse_size, parse_whole
from equaltime.rendering.arguments import MOST_THREADS

__all__ = [
    "Crop",
    "Define",
    "ErrorTarget",
    "MaxDepth",
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
    "Without",
]

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
        help="Stop after this long, first sample to final film: 10s, 500ms, 1h30m. "
        "Outputs beside the image come on top.",
    ),
]
ErrorTarget = Annotated[
    float | None,
    typer.Option(
        parser=parse_percent,
        metavar="PERCENT",
        show_default=False,
        help="Stop when the upper limit of the image's error is here: 2%.",
    ),
]
Size = Annotated[
    Any, typer.Option(parser=parse_size, metavar="WxH", show_default=False, help="Film size, instead of the scene's.")
]
Overwrite = Annotated[
    bool,
    typer.Option("--overwrite", help="Replace FILE though another program wrote it, or it shows another scene."),
]
Small = Annotated[
    bool,
    typer.Option(
        "--small",
        help="Save a small file: the image rounded to 11 bits, and its standard error. It cannot be resumed or merged.",
    ),
]
Crop = Annotated[
    Any,
    typer.Option(
        parser=parse_crop,
        metavar="X,Y,W,H",
        show_default=False,
        help="Render this window of the film only: samples of the whole, in the same numbers with adaptive=none.",
    ),
]
MaxDepth = Annotated[
    int | None,
    typer.Option(
        parser=parse_whole(-1, 2**31 - 1),
        metavar="N",
        show_default=False,
        help="Longest path, as in Mitsuba: 1 emission only, 2 direct light, -1 unlimited.",
    ),
]
StrategyWords = Annotated[
    str, typer.Option(metavar="S", help="A preset, or preset,key=value,…, or a TOML file; see equaltime render -h.")
]
Seed = Annotated[int, typer.Option(parser=parse_whole(0, 2**64 - 1), metavar="N", help="Seed of all random numbers.")]
Threads = Annotated[
    int,
    typer.Option(parser=parse_whole(0, MOST_THREADS), metavar="N", help="Worker threads; 0 is one for each processor."),
]
Define = Annotated[
    list[str] | None,
    typer.Option("-D", "--define", metavar="NAME=VALUE", show_default=False, help="Set a parameter of the scene."),
]
Substitute = Annotated[
    bool,
    typer.Option(
        "--substitute",
        help="Replace what cannot be rendered by something that can, and say what, instead of refusing it.",
    ),
]
Tev = Annotated[
    str | None,
    typer.Option(
        "--tev",
        metavar="HOST:PORT",
        show_default=False,
        help="Show the passes in tev, the viewer, which listens at localhost:14158 unless told otherwise.",
    ),
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        metavar="EFFECT",
        show_default=False,
        help="Leave an effect out, such as lens, textures or long_paths=4 (see equaltime effects): biased, by an "
        "amount that is measured and in the error. May be given again.",
    ),
]
