"""The commands ``equaltime convert`` (scene to another format) and ``equaltime schema`` (JSON schema of scenes)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from equaltime.cli.messages import print_warnings
from equaltime.cli.options import Define, Substitute, parse_definitions
from equaltime.scene import load_file
from equaltime.scene.schema import scene_schema
from equaltime.strict_json import json_text

__all__ = ["convert", "schema"]


def schema() -> int:
    """Print a JSON schema of scene files, for editors.

    The schema describes every plugin and its parameters, so that an editor completes and checks scene files.

    For instance: `equaltime schema > scene.schema.json`, and on the first line of a scene `#:schema scene.schema.json`
    """
    print(json_text(scene_schema(), indent=1))
    return 0


def convert(
    scene: Annotated[
        Path, typer.Argument(metavar="IN", help="Scene file: TOML, Mitsuba XML, or glTF.", show_default=False)
    ],
    output: Annotated[
        Path, typer.Argument(metavar="OUT", help="A new file: .toml, or .xml for Mitsuba 3.", show_default=False)
    ],
    define: Define = None,
    substitute: Substitute = False,
    copy: Annotated[
        bool,
        typer.Option("--copy", help="Copy meshes and images into a folder beside OUT, instead of referring to them."),
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> int:
    """Write a scene to a file of another format.

    Renders of the new file equal renders of the old one bit by bit. No file is overwritten. Variables are replaced by
    their values, spectra by colours in linear sRGB, and outdated parameter names by current ones.
    """
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    if not quiet:
        print_warnings(loaded)
    written = loaded.write(output, copy=copy)
    if not quiet:
        print(f"wrote {', '.join(map(str, written))}")
    return 0
