"""Commit of equaltime's sources that this process runs, for the records of renders and experiments."""

from __future__ import annotations

import os
import subprocess
from functools import cache
from pathlib import Path
from typing import Final

__all__ = ["UNKNOWN_REVISION", "revision"]

UNKNOWN_REVISION: Final = "unknown"
"""Text that takes the place of a commit that is not known."""
_DESCRIBE: Final = ("git", "describe", "--always", "--abbrev=40", "--exclude=*", "--dirty= with uncommitted changes")
"""Command that prints HEAD, and whether tracked files differ from it; CMakeLists.txt has the same one for wheels."""
_LONGEST_WAIT: Final = 5.0
"""Seconds that git may take; it takes 0.05. A render should not wait for a file system that does not answer."""
_PACKAGE: Final = Path(__file__).parent


@cache
def revision(package: Path = _PACKAGE) -> str:
    """Return the commit of equaltime's sources: 40 hexadecimal digits, and whether tracked files were changed.

    In a checkout git tells it. A wheel has a file with the commit that it was built from. The answer is ``unknown``
    without either. It is found once, so that it belongs to the files that this process began with. In a checkout it is
    the commit of the Python files; the compiled core may be older, and ``core_sha256`` of experiments identifies it.

    ``package`` is the folder of the package.
    """
    root = package.parents[1]
    if _is_checkout(root):
        return _described(root) or UNKNOWN_REVISION
    try:
        return (package / "revision.txt").read_text("utf-8").strip() or UNKNOWN_REVISION
    except OSError:
        return UNKNOWN_REVISION


def _is_checkout(root: Path) -> bool:
    """Tell whether a folder is the top of a checkout of equaltime, and not of another repository with a copy of it."""
    try:
        return (root / ".git").exists() and 'name = "equaltime"' in (root / "pyproject.toml").read_text("utf-8")
    except OSError:
        return False


def _described(root: Path) -> str:
    """Return what git says of the checkout at ``root``; empty if there is no git, or if it fails."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    try:
        done = subprocess.run(
            _DESCRIBE,
            cwd=root,
            env={**environment, "GIT_OPTIONAL_LOCKS": "0"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=True,
            timeout=_LONGEST_WAIT,
        )
    except (OSError, subprocess.SubprocessError, UnicodeError):
        return ""
    return done.stdout.strip()
