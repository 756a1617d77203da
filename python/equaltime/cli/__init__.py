"""The command line: ``equaltime COMMAND …``.

A command is one function in one module, registered in `COMMANDS`. It returns its exit code: 0 done, 1 ran and failed
its purpose, 2 bad input or usage, 130 interrupted. Results go to stdout; progress and errors go to stderr.
"""

from __future__ import annotations

from equaltime.cli.signals import interruptible, ready  # first: handles Ctrl-C during the other imports

# isort: split
import equaltime.cli.level  # second: the commands load the core

# isort: split
import functools
import shlex
import sys
from collections.abc import Callable, Sequence
from io import TextIOWrapper
from typing import Annotated, Any

import typer

import equaltime
from equaltime.cli.bench import bench
from equaltime.cli.compare import compare
from equaltime.cli.convert import convert, schema
from equaltime.cli.cost import cost
from equaltime.cli.effects import effects
from equaltime.cli.examples import examples
from equaltime.cli.help import Command, Group
from equaltime.cli.info import info
from equaltime.cli.lint import lint
from equaltime.cli.merge import merge
from equaltime.cli.messages import print_error, worded_warnings
from equaltime.cli.open import open
from equaltime.cli.quote import quote
from equaltime.cli.render import render
from equaltime.cli.replay import replay
from equaltime.cli.selftest import selftest
from equaltime.cli.standard_output import named_output, tell_os_error
from equaltime.errors import EqualtimeError, RenderError

__all__ = ["COMMANDS", "app", "main"]

COMMANDS: tuple[Callable[..., int], ...] = (
    *(render, quote, cost, open, effects, compare, merge, info, examples),
    *(lint, replay, convert, schema, bench, selftest),
)

app = typer.Typer(
    name="equaltime",
    cls=Group,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _ending_in_words(command: Callable[..., int]) -> Callable[..., int]:
    """Return the command with messages for Ctrl-C and broken pipes, for which Typer prints nothing."""

    @functools.wraps(command)
    def run(*arguments: Any, **options: Any) -> int:
        try:
            return command(*arguments, **options)
        except KeyboardInterrupt:
            print_error("interrupted")
            return 130
        except OSError as error:
            return tell_os_error(error)

    return run


for _command in COMMANDS:
    app.command(cls=Command)(_ending_in_words(_command))


@app.callback(invoke_without_command=True)
def equaltime_command(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", "-V", help="Print the version.", is_eager=True)] = False,
) -> None:
    """Render pictures, and know how accurate they are and what they cost.

    Exit codes: 0 done, 1 failed, 2 bad input or usage, 130 interrupted (finished work is kept).
    """
    if version:
        typer.echo(f"equaltime {equaltime.__version__}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code, for the shell.

    ``arguments`` are the words after ``equaltime``; by default those in ``sys.argv``.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names that the terminal cannot show are escaped
    command = shlex.join(["equaltime", *(sys.argv[1:] if arguments is None else arguments)])
    try:
        ready()
        with named_output(), interruptible(), worded_warnings():
            code: int = app(arguments, prog_name="equaltime", standalone_mode=False, obj=command) or 0
        return code
    except KeyboardInterrupt:
        print_error("interrupted")
        return 130
    except typer.TyperException as error:
        print_error(error.format_message())
        return 2
    except RenderError as error:
        print_error(str(error))
        return 1
    except EqualtimeError as error:
        print_error(str(error))
        return 2
    except MemoryError:
        print_error("not enough memory")
        return 1
    except ImportError as error:
        if "failed to map segment" not in str(error):  # of a library that is loaded late
            raise
        print_error(f"not enough memory: {error}")
        return 1
    except OSError as error:
        return tell_os_error(error)
    finally:
        # If a KeyboardInterrupt once passed through an exec of text, as in a late import, Python exits as if killed by
        # Ctrl-C, even if it was caught. Another exec clears that state.
        exec("")
