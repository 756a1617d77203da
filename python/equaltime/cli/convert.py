"""The commands ``equaltime convert`` (scene or render to another format) and ``equaltime schema`` (JSON schema)."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from equaltime.cli.messages import Written, print_lines, print_warnings
from equaltime.cli.options import (
    Define,
    ExposureStops,
    JpegQuality,
    NoMetadata,
    Substitute,
    parse_background,
    parse_definitions,
)
from equaltime.errors import ImageError
from equaltime.images import preview
from equaltime.images.exposure import AUTO, Exposure, white_share
from equaltime.images.image_files import PICTURES, extension
from equaltime.rendering.output_files import check_spares
from equaltime.rendering.saved import read
from equaltime.scene import load_file
from equaltime.scene.schema import scene_schema
from equaltime.strict_json import json_text

__all__ = ["convert", "schema"]

_BLACK: Final = "a JPEG has no alpha: it is black where the render is transparent; --background white changes that"


def schema() -> int:
    """Print a JSON schema of scene files, for editors.

    The schema describes every plugin and its parameters, so that an editor completes and checks scene files.

    For instance: `equaltime schema > scene.schema.json`, and on the first line of a scene `#:schema scene.schema.json`
    """
    print(json_text(scene_schema(), indent=1))
    return 0


def convert(
    scene: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            help="Scene file: TOML, Mitsuba XML, glTF, OBJ or PLY. Or a render: FILE.exr that equaltime saved.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="A file .toml, or .xml for Mitsuba 3. Of a render: .png or .jpg.",
            show_default=False,
        ),
    ],
    define: Define = None,
    substitute: Substitute = False,
    copy: Annotated[
        bool,
        typer.Option("--copy", help="Copy meshes and images into a folder beside OUT, instead of referring to them."),
    ] = False,
    exposure: ExposureStops = "auto",
    background: Annotated[
        Any,
        typer.Option(
            parser=parse_background,
            metavar="COLOUR",
            show_default=False,
            help="Colour behind a render with alpha, which the exposure does not change: white, black, '#ff8800' as on "
            "web pages, or linear 1,0.25,0. The picture then has no alpha. A JPEG never has: without this option it is "
            "black behind.",
        ),
    ] = None,
    quality: JpegQuality = None,
    no_metadata: NoMetadata = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUT if it is there.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> int:
    """Write one scene, or the picture of one saved render, to a file of another format.

    For many files: `for f in *.exr; do equaltime convert "$f" "${f%.exr}.png"; done`

    Renders of the new scene file equal renders of the old one bit by bit. Variables are replaced by their values,
    spectra by colours in linear sRGB, and outdated parameter names by current ones.

    `equaltime convert a.exr a.jpg` writes the picture of a saved render, in sRGB, as `render -o a.jpg` would.
    """
    if output.exists() and not overwrite:
        raise ImageError(f"{output}: is there already; choose another name, or --overwrite replaces it")
    if extension(scene) == ".exr":
        return _picture_of(scene, output, exposure, background, quality, not no_metadata, quiet)
    if extension(scene) in PICTURES:
        kinds = "a scene file, or of pictures a render that equaltime saved as FILE.exr"
        raise ImageError(f"{scene}: is a picture, and convert takes {kinds}; `equaltime compare` reads pictures")
    given = {"--background": background is not None, "--quality": quality is not None, "--no-metadata": no_metadata}
    if wrong := next((option for option, asked in given.items() if asked), None):
        raise typer.BadParameter("is for the picture of a render: FILE.exr that equaltime saved", param_hint=wrong)
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    check_spares([output], loaded.files, "the scene is made of this file")
    if not quiet:
        print_warnings(loaded)
    written = loaded.write(output, copy=copy, overwrite=overwrite)
    if not quiet:
        print(f"wrote {', '.join(map(str, written))}")
        if copy:
            command = shlex.join(["equaltime", "render", output.name, "-o", f"{output.stem}.exr"])
            print(f"in the folder {output.parent.absolute().name}, wherever it is: {command}")
    return 0


def _picture_of(
    saved: Path,
    output: Path,
    exposure: Exposure,
    background: Sequence[float] | None,
    quality: int | None,
    metadata: bool,
    quiet: bool,
) -> int:
    if quality is not None and output.suffix.lower() == ".png":
        raise typer.BadParameter("a PNG loses nothing: only a JPEG has a quality", param_hint="--quality")
    if output.suffix.lower() not in preview.EXTENSIONS:
        raise ImageError(f"{output}: the picture of a render is a file {' or '.join(preview.EXTENSIONS)}")
    result = read(saved)
    alpha = result.alpha if result.origin.picture.alpha else None
    if background is not None and alpha is None:
        raise typer.BadParameter(f"{saved} has no alpha: render it with --transparent", param_hint="--background")
    files = result.save(
        output,
        exposure=exposure,
        background=background,
        overwrite=True,
        metadata=metadata,
        quality=preview.JPEG_QUALITY if quality is None else quality,
    )
    if not quiet:
        opaque = exposure == AUTO and alpha is not None
        stops = result.exposure(exposure)
        white = white_share(result.image, stops)
        written = Written(files, stops, result.exposure(), opaque=opaque, white=white)
        print_lines([f"wrote {written}", *filter(None, [written.counted, written.kept])])
        if alpha is not None and (alpha < 1.0).any() and background is None and output.suffix.lower() != ".png":
            print_lines([_BLACK])
    return 0
