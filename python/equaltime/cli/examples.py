"""The command ``equaltime examples``: lists the scenes and experiments that come with the package, or copies them."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Annotated

import typer

from equaltime.cli.messages import print_error, print_lines
from equaltime.examples import copy_to, experiment_names, scene_names

__all__ = ["examples"]


def examples(
    folder: Annotated[
        Path | None, typer.Argument(metavar="[DIR]", help="New folder for copies of all examples.", show_default=False)
    ] = None,
) -> int:
    """List the example scenes and experiments, or copy them.

    Every command takes their names in place of a file: `equaltime render cornell-box -o box.exr`,
    `equaltime cost x3-light -o DIR`.


    For instance: `equaltime examples my-scenes`
    """
    if folder is not None:
        return _copied(folder)
    print("Scenes, for equaltime render NAME -o OUT.exr:")
    print("\n".join(f"  {name}" for name in scene_names()))
    print_lines(["Experiments, for equaltime cost NAME -o DIR; the name experiments stands for all of them:"])
    print("\n".join(f"  {name}" for name in experiment_names()))
    return 0


def _copied(folder: Path) -> int:
    try:
        copy_to(folder)
    except OSError as error:
        exists = error.errno == errno.EEXIST
        print_error(f"{folder}: {'exists already; give a new folder' if exists else error.strerror or error}")
        return 2
    print(f"copied {len(scene_names())} scenes and {len(experiment_names())} experiments to {folder}")
    return 0
