"""What an effect costs a scene that does not call for it: instructions and time, against a core without that effect.

Each field of `Effects` in turn is taken out of a copy of the source: no row of kernels has it, and code that asks for
it is answered no when it is compiled, whatever the kernel. Instructions are those of `instructions.py`, in its room
that calls for nothing; what differs is told by symbol. Times are the processors', of the Cornell box, which calls for
nothing either; each build takes turns with this source, built the same way, in runs so short that what else the
machine does is the same for both.
"""

from __future__ import annotations

import argparse
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

from builds import KERNEL_TABLE, KERNELS, REPOSITORY, TWO_ROWS, Edit, Variant, build, rebuild, stamp_of
from instructions import PATHS, count
from measuring import SHIPPED, arguments, print_conditions, ratio, rounds, text
from workers import Worker

from equaltime.statistics.intervals import Interval

EFFECTS = "cpp/equaltime/base/effects.h"
RUN = 0.25
"""Seconds that a render takes, about."""
UNCOUNTED: tuple[Edit, ...] = (
    (
        "CMakeLists.txt",
        r"\n *cpp/equaltime/\w+/(bind_)?(bench|breakdown|light_breakdown|limit|replay|sampling)\.cpp",
        "",
    ),
    ("CMakeLists.txt", r"\n *cpp/equaltime/analysis/(unoccluded_light|visible_emitters)\.cpp", ""),
    ("cpp/equaltime/bindings/module.cpp", r"\n *equaltime::bind_(bench|breakdown|replay|sampling)\(m\);", ""),
)
"""What renders have no use for, but the package has: minutes less, where there is nothing to time."""


def main() -> None:
    parser = arguments(__doc__, repeats=80)
    parser.add_argument("fields", nargs="*", metavar="FIELD", help="of Effects [all]")
    parser.add_argument("--builds", type=Path, metavar="FOLDER", help="where builds are kept [a temporary folder]")
    parser.add_argument("--build-only", action="store_true", help="time and count nothing")
    options = parser.parse_args()
    print_conditions(options)
    known = re.findall(r"\n    \{&Effects::(\w+), ", (REPOSITORY / EFFECTS).read_text())
    less = () if options.repeats else UNCOUNTED
    with tempfile.TemporaryDirectory() as temporary:
        here, without = builds(options.builds or Path(temporary), options.fields or known, less)
        if options.build_only:
            return
        report_counts(here, without)
        for field, module in without.items() if options.repeats else ():
            print(f"  {field:18} {text(times(here, module, options), 4)} x the time", flush=True)


def builds(folder: Path, fields: list[str], less: tuple[Edit, ...]) -> tuple[str, dict[str, str]]:
    """Return the core of this source, and those without a field each; what is in the folder is not built again."""
    whole = Variant(TWO_ROWS, less)
    here = kept(folder / f"{stamp_of(whole)}.so", lambda: build(whole, folder / "whole"))
    variants = {field: Variant(TWO_ROWS, (*removal(field), *less)) for field in fields}
    return here, {
        field: kept(folder / f"{stamp_of(variant)}.so", lambda v=variant: rebuild(v, folder / "whole", KERNELS))
        for field, variant in variants.items()
    }


def kept(copy: Path, make: Callable[[], str]) -> str:
    """Return a copy of a module that the next build does not replace."""
    if not copy.is_file():
        shutil.copy(make(), copy)
    return str(copy)


def report_counts(here: str, without: dict[str, str]) -> None:
    """Print the instructions that each field costs, and the functions in which it does."""
    room = count(here, "")
    print(f"{room.total / PATHS:.1f} instructions a path", flush=True)
    for field, module in without.items():
        other = count(module, "")
        print(f"  {field:18} {room.total / other.total - 1:+.4%} instructions", flush=True)
        for name in sorted({*room.functions, *other.functions}):
            more = room.functions.get(name, 0) - other.functions.get(name, 0)
            if more:
                print(f"    {more / PATHS:+.3f} a path in {name}")


def times(here: str, without: str, options: argparse.Namespace) -> Interval:
    """Return the ratios of processor times, this build over one without a field, in short runs that take turns."""
    with ExitStack() as stack:
        cores = {file: stack.enter_context(Worker("core_worker.py", ["--core", file])) for file in (here, without)}
        question = {"scene": str(SHIPPED[0]), "threads": options.threads, "size": [256, 256]}
        pilot = cores[here].ask(**question, spp=4)
        spp = 2 * max(1, round(2 * RUN / pilot["seconds"]))
        found = rounds(
            cores, lambda file, seed: float(cores[file].ask(**question, spp=spp, seed=seed)["cpu"]), options.repeats
        )
    return ratio(found[here], found[without])


def removal(field: str) -> Iterator[Edit]:
    """Yield the edits that take a field out of the source.

    What asks for it finds a constant. Its place in the structure stays, so that all but the kernels may stay as it was
    built: what else knows of effects knows only which there are.
    """
    yield EFFECTS, rf"(bool {field} = false;)", r"bool nothing = false;\n  static constexpr \1"
    yield EFFECTS, rf"&Effects::{field}\b", "&Effects::nothing"
    for pattern in (rf"&Effects::{field}\b(,\s*)?", rf"\.{field} = true(, )?"):
        if re.search(pattern, (REPOSITORY / KERNEL_TABLE).read_text()):
            yield KERNEL_TABLE, pattern, ""


if __name__ == "__main__":
    main()
