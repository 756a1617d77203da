"""The command ``equaltime replay``: shows the path of one sample of a render, by default a pixel's brightest."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import typer

from equaltime.cli.messages import print_json, print_lines, print_remarks
from equaltime.cli.options import (
    AsJson,
    Define,
    MaxDepth,
    Seed,
    Size,
    StrategyWords,
    Substitute,
    Transparent,
    Verbose,
    Without,
    parse_definitions,
    parse_pixel,
    parse_whole,
)
from equaltime.cli.replay_source import ReplaySource
from equaltime.cli.replay_summary import path_in_short
from equaltime.cli.replay_vertices import PathInLines, numbers
from equaltime.errors import ImageError
from equaltime.images.image_files import extension
from equaltime.images.preview import EXTENSIONS
from equaltime.rendering.replay import Replay
from equaltime.rendering.replay import replay as replay_sample
from equaltime.scene import load_file
from equaltime.scene.model import MOST_SAMPLES
from equaltime.strategy import Strategy

__all__ = ["replay"]

ENDS: Final = {
    "escapes": "the ray meets nothing",
    "depth": "the longest path is reached",
    "absorbed": "this side of the surface absorbs everything",
    "no_direction": "the BSDF gives no direction",
    "black": "nothing is scattered, as the BSDF weight is 0",
    "not_finite": "its throughput is not a finite number",
    "roulette": "by Russian roulette",
}
_UNDERFLOW: Final = "its throughput becomes 0 by underflow: throughput times BSDF weight is below the smallest float32"
_OF_RECORD: Final = ("size", "max_depth", "strategy", "define", "substitute", "transparent", "without")
"""Parameters of the command that the record of a saved render tells."""
_DOTS: Final = "what bright dots mean and what to do about them: scenes/render/README.md, When the error is in doubt"


def replay(
    context: typer.Context,
    scene: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE|OUT.exr",
            help="Scene file; or a saved render, whose record tells the scene, the strategy, the seed and the options.",
            show_default=False,
        ),
    ],
    pixel: Annotated[
        Any,
        typer.Option(
            parser=parse_pixel,
            metavar="X,Y",
            show_default=False,
            help="Column and row of the pixel, from 0 at the upper left.",
        ),
    ],
    sample: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(0, MOST_SAMPLES - 1),
            metavar="I",
            show_default=False,
            help="Number of the sample in the pixel, from 0 [default: the brightest of the first --spp].",
        ),
    ] = None,
    spp: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(1, MOST_SAMPLES),
            metavar="N",
            show_default=False,
            help="Number of samples of the pixel among which the brightest is looked for [default: all that OUT.exr "
            "has of the pixel; or the scene's, or 64]. A render may have taken more in a noisy pixel.",
        ),
    ] = None,
    seed: Seed = 0,
    strategy: StrategyWords = "best",
    size: Size = None,
    max_depth: MaxDepth = None,
    define: Define = None,
    substitute: Substitute = False,
    transparent: Transparent = False,
    without: Without = None,
    as_json: AsJson = False,
    verbose: Verbose = False,
) -> int:
    """Show the path of one sample of a render, vertex by vertex, with every factor of its radiance.

    Without `--sample`, the pixel's brightest sample is shown: the one that made a bright dot in the picture. Of a long
    path, the first 10 and the last 5 vertices are shown; `-v` shows all, and every digit of their numbers.

    With the same scene, size, depth, strategy and seed, path and radiance equal the render's bit by bit. Give OUT.exr
    for the samples of a saved render; of a merged one, `--seed` chooses the part.

    For instance:

    * `equaltime replay out.exr --pixel 120,80`, of a picture that `equaltime render` saved

    * `equaltime replay scene.toml --pixel 120,80 --sample 7 --seed 3`
    """
    if sample is not None and spp is not None:
        raise typer.BadParameter("give --sample for one sample, or --spp for the brightest of N", param_hint="--spp")
    if extension(scene) in EXTENSIONS:
        raise ImageError(f"{scene}: a picture has no samples to replay; give the EXR file of its render, or the scene")
    if extension(scene) == ".exr":
        _check_alone(context, scene)
        source = ReplaySource.read(scene, pixel, seed if _is_given(context, "seed") else None)
        loaded, chosen, seed, left_out = source.scene, source.strategy, source.seed, source.without
        spp = _looked_at(source, pixel, sample, spp)
    else:
        chosen, left_out = Strategy.parse(strategy), without or ()
        loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute).with_(transparent=transparent)
        print_remarks(loaded)
        loaded = loaded.with_(size=size, max_depth=max_depth)
    try:
        path = replay_sample(loaded, pixel=pixel, sample=sample, spp=spp, strategy=chosen, seed=seed, without=left_out)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--pixel") from error
    if as_json:
        print_json(path)
    else:
        print_lines([*_told(path, chosen, verbose)])
    return 0


def _is_given(context: typer.Context, name: str) -> bool:
    """Tell whether the command line has the option, whatever its value."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def _check_alone(context: typer.Context, path: Path) -> None:
    """Refuse options that the record of the saved render at ``path`` tells already."""
    if name := next((name for name in _OF_RECORD if _is_given(context, name)), None):
        raise typer.BadParameter(
            f"{path} tells this option itself: leave it out, or give the scene file instead",
            param_hint=f"--{name.replace('_', '-')}",
        )


def _looked_at(source: ReplaySource, pixel: tuple[int, int], sample: int | None, spp: int | None) -> int | None:
    """Return the number of samples among which the brightest is looked for; refuse a sample that was not rendered."""
    taken, (x, y) = source.samples, pixel
    if taken is None:  # `replay_sample` tells that the pixel is not in the picture
        return spp
    if taken == 0:
        raise typer.BadParameter(f"the render has no sample of pixel {x},{y}", param_hint="--pixel")
    if sample is not None and sample >= taken:
        raise typer.BadParameter(f"the render has samples 0 to {taken - 1} of pixel {x},{y}", param_hint="--sample")
    return taken if sample is None and spp is None else spp


def _told(path: Replay, strategy: Strategy, verbose: bool) -> Iterator[str]:
    if path.brightest is not None:
        yield str(path.brightest)
    x, y = path.pixel
    yield f"pixel {x},{y}, sample {path.sample}, seed {path.seed}, strategy {path.strategy}"
    if (short := path_in_short(path)) is not None:
        yield short
    vertices = PathInLines(path, strategy, verbose)
    yield ""
    yield from vertices.legend()
    yield from vertices.lines()
    yield f"   ends: {_end(path)}"
    yield ""
    agrees = "the sample" if path.sum == path.radiance else f"{numbers(path.sum)}, which is not the sample"
    yield f"radiance {vertices.all(path.radiance)}"
    yield f"the sum of what is added, times the filter weight {path.filter_weight:.9g}, is {agrees}"
    if path.brightest is not None and path.brightest.stands_out:
        yield _DOTS
    if (found := path.first_nonfinite) is not None:
        yield f"the first number that is not finite: at vertex {found[0] + 1}, {found[1].replace('_', ' ')}"


def _end(path: Replay) -> str:
    """Return why the path ends, in words."""
    if path.end != "black":
        return ENDS[path.end]
    last = path.vertices[-1]
    throughput, weight = (np.array(factor, np.float32) for factor in (last["left"], last["scattering"]["weight"]))
    if (throughput * weight).any():  # scattered by a surface with holes, which may end no path that goes through them
        return ENDS["depth"]
    return _UNDERFLOW if ((throughput > 0.0) & (weight > 0.0)).any() else ENDS["black"]
