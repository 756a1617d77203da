"""Check that this machine has a compiled core, before commands load it: if not, the command ends with one error.

Importing this module does the check.
"""

from __future__ import annotations

import sys

from equaltime.instruction_sets import LevelError, core_file

__all__: list[str] = []

try:
    core_file()
except LevelError as error:
    sys.stderr.write(f"error: {error}\n")
    sys.exit(2)
