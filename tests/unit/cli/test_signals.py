"""Ctrl-C while the command is importing what it needs."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest

from equaltime.cli.signals import ready, runs_the_command


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["/usr/bin/python3", "/venv/bin/equaltime", "cost"], True),
        (["python", "-m", "equaltime"], True),
        (["python", "-X", "importtime", "-m", "equaltime", "render"], False),  # not worth a parser
        (["python", "-I", "-m", "equaltime", "render"], True),
        (["python", "-m", "pytest", "equaltime"], False),
        (["python", "equaltime.py"], False),
        (["python", "-c", "import equaltime"], False),
        (["python"], False),
    ],
)
def test_the_command_is_known_by_how_it_was_started(arguments: list[str], expected: bool) -> None:
    assert runs_the_command(arguments) is expected


def test_who_imports_the_package_keeps_ctrl_c() -> None:
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ready()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


_TELLS = """
import signal, sys
class Tells:
    def find_spec(self, name, path=None, target=None):
        if name == "equaltime.scene":
            print("importing", flush=True)
            import time; time.sleep(30)
sys.meta_path.insert(0, Tells())
sys.orig_argv = ["python", "/venv/bin/equaltime"]
import equaltime.cli
"""


def test_ctrl_c_during_imports_ends_it_quietly() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", _TELLS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "importing\n"
    time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, complaints = process.communicate(timeout=30)
    assert (process.returncode, complaints) == (130, "")
