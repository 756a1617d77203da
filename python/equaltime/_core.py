"""The compiled core, for the best level of x86-64 that this machine has.

The package has a compiled file for one level or several. This module puts the core of the best one in its own place.
The environment variable ``EQUALTIME_ISA`` (v2, v3 or v4) chooses another level, and holds Embree to it.
"""

from __future__ import annotations

import os
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from types import ModuleType

from equaltime.instruction_sets import EMBREE, VARIABLE, core_file


def _load() -> ModuleType:
    """Return the chosen level's core, under the name of this module."""
    level, file = core_file()
    loader = ExtensionFileLoader(__name__, str(file))
    spec = spec_from_loader(__name__, loader)
    assert spec is not None
    core = module_from_spec(spec)
    loader.exec_module(core)
    if os.environ.get(VARIABLE) and level in EMBREE:
        core.hold_embree(EMBREE[level])
    return core


sys.modules[__name__] = _load()
