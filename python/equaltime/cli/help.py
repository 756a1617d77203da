"""Help of commands: options in groups, plain usage lines, and suggestions for options that do not exist."""

from __future__ import annotations

from typing import Any, Final

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption

from equaltime.words import nearest

__all__ = ["Command", "Group"]

PANELS: Final = {
    "How long": ("time", "error", "spp", "stop", "quick", "budget", "repeats"),
    "What": (
        *("size", "crop", "max_depth", "define", "substitute", "frames", "fps", "blur", "transparent"),
        *("without", "within", "pixel", "sample", "only"),
    ),
    "How": ("strategy", "strategies", "seed", "threads", "cluster"),
    "Output": (
        *("output", "exposure", "background", "quality", "no_metadata", "aov", "resume", "checkpoint", "small"),
        *("overwrite", "copy", "why", "as_json", "quiet", "verbose", "help"),
    ),
    "For experts": ("backend", "traps", "tev", "peer"),
}
"""Groups of options in the help of a command, in order: title, and names of parameters; others stand under
"Options"."""

_PANEL_OF: Final = {name: panel for panel, names in PANELS.items() for name in names}

MEANT: Final = {
    **dict.fromkeys(("--samples", "--sample-count", "--samples-per-pixel", "-n"), "--spp"),
    **dict.fromkeys(("--resolution", "--output-size", "--width", "--height", "-s"), "--size"),
    **dict.fromkeys(("--duration", "--seconds", "--timeout", "--budget", "-t"), "--time"),
    **dict.fromkeys(("--noise", "--accuracy", "-e"), "--error"),
    **dict.fromkeys(("--depth", "--bounces"), "--max-depth"),
    **dict.fromkeys(("--region", "--window"), "--crop"),
    **dict.fromkeys(("--jobs", "--cores", "-j"), "--threads"),
    **dict.fromkeys(("--force", "-f"), "--overwrite"),
    **dict.fromkeys(("--alpha", "--rgba", "--background", "--film-transparent"), "--transparent"),
    **dict.fromkeys(("--ev", "--brightness", "--gain", "--tonemap"), "--exposure"),
    **dict.fromkeys(("--integrator", "--sampler", "--method"), "--strategy"),
    **dict.fromkeys(("--denoise", "--denoiser"), "--error"),
}
"""Options of other programs, by name, and the option of equaltime with the same purpose, for a suggestion in the
error."""


_OF_CONVERT: Final = {"--quality": "a JPEG", "--no-metadata": "a PNG or JPEG of a saved render"}
"""Options of ``equaltime convert`` that are looked for in other commands, with their purposes."""


class Command(TyperCommand):
    """A command of equaltime whose help groups its options, and that suggests an option for one that does not exist."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        order = [None, *PANELS]
        self.params.sort(key=lambda parameter: order.index(_PANEL_OF.get(parameter.name)))

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the command's arguments and options for its help, each option in its group."""
        parameters = super().get_params(ctx)
        for option in _plain(parameters):
            option.rich_help_panel = _PANEL_OF.get(option.name)
        return parameters

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the command's usage line: arguments, required options, ``[options]``."""
        words = []
        for parameter in self.get_params(ctx):
            if not isinstance(parameter, TyperOption):
                word = parameter.metavar or parameter.name.upper()
                words.append(word if parameter.required or word.startswith("[") else f"[{word}]")
            elif parameter.required:
                words.append(f"{parameter.opts[0]} {parameter.metavar}")
        return [*words, "[options]"]

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words after the command; an option that does not exist raises an error with a suggestion."""
        try:
            return super().parse_args(ctx, args)
        except typer.TyperException as error:
            if not hasattr(error, "possibilities"):  # another error than an unknown option
                raise
            names = [name for option in _plain(self.get_params(ctx)) for name in option.opts]
            raise typer.TyperException(_unknown(str(getattr(error, "option_name", "")), names)) from None


class Group(TyperGroup):
    """Group of all commands: the program ``equaltime``, its own options and its help."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options of the program itself, for its help."""
        parameters = super().get_params(ctx)
        _plain(parameters)
        return parameters

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line of the program: ``COMMAND ...``."""
        return ["COMMAND", "..."]


def _plain(parameters: list[Any]) -> list[TyperOption]:
    """Return the options among the parameters; those that take no value show none in the help."""
    options = [parameter for parameter in parameters if isinstance(parameter, TyperOption)]
    for option in options:
        if option.is_flag:
            option.metavar = ""
    return options


def _unknown(name: str, names: list[str]) -> str:
    """Return an error message on an option that does not exist; ``names`` are those that do."""
    meant = MEANT.get(name)
    near = meant if meant in names else nearest(name, [known for known in names if known.startswith("--")])
    if name.startswith("--denois"):
        return (
            f"there is no option {name}, as nothing is denoised; integrator 'aov' of the scene writes albedo and "
            f"normals for a denoiser elsewhere, and {near or '--error'} renders until the noise is small"
        )
    if name == "--transparent":
        return f"there is no option {name} here; equaltime render has it, and a finished picture gets no alpha"
    if name in _OF_CONVERT:
        error = "--error 2% chooses the accuracy of a render, and " * (name == "--quality" and "--error" in names)
        return f"there is no option {name} here; {error}equaltime convert has {name} for {_OF_CONVERT[name]}"
    return f"there is no option {name}; {f'did you mean {near}?' if near else '--help lists all'}"
