"""What kernels cost before anything is rendered: seconds to build the core and bytes of its module, with all its rows.

Beside it, the kernels alone, with all rows and with two, the one for no effect and the one for all: what a row adds.
Seconds are the processors', of compiler and linker.
"""

from __future__ import annotations

import resource
import tempfile
from collections.abc import Callable
from pathlib import Path

from builds import KERNELS, ROWS, TWO_ROWS, Variant, build, rebuild
from measuring import arguments, print_conditions


def main() -> None:
    options = arguments(__doc__, repeats=1).parse_args()
    print_conditions(options)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "core"
        whole, size = cost(lambda: build(Variant({}), folder))
        print(f"  {whole:.0f} s and {size / 1e6:.2f} MB: the whole core, of {ROWS} rows", flush=True)
        for _ in range(options.repeats):
            few, least = cost(lambda: rebuild(Variant(TWO_ROWS), folder, KERNELS))
            many, _ = cost(lambda: rebuild(Variant({}), folder, KERNELS))
            print(f"  {many:.1f} s: all rows by themselves; {few:.1f} s and {(size - least) / 1e6:.2f} MB less: two")
            print(
                f"  {(many - few) / (ROWS - 2):.2f} s and {(size - least) / (ROWS - 2) / 1e3:.0f} kB: a row", flush=True
            )


def cost(make: Callable[[], str]) -> tuple[float, int]:
    """Return the processor seconds of what builds a module, and the module's bytes."""
    begin = _spent()
    module = Path(make())
    return _spent() - begin, module.stat().st_size


def _spent() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
