"""What an effect costs a scene that does not call for it: instructions and time, against a core without that effect.

Each field of `Effects` in turn is taken out of a copy of the source: no row of kernels has it, and code that asks for
it is answered no when it is compiled, whatever the kernel. Instructions are those of `instructions.py`, in its room
that calls for nothing; what differs is told by symbol. Times are the processors', of the Cornell box, which calls for
nothing either; each build takes turns with this source, built the same way.
"""

from __future__ import annotations

import argparse
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from builds import REPOSITORY, Variant, build, rebuild
from instructions import PATHS, Profile, count
from measuring import SHIPPED, arguments, print_conditions, ratio, rounds, text
from workers import Worker

Edit = tuple[str, str, str]
EFFECTS, KERNELS = "cpp/transport/effects.h", "cpp/transport/kernels.cpp"
TWO_ROWS: Edit = (KERNELS, r"\n *row<(?!kAllEffects>|Effects\{\}>).*>\(\),", "")
"""Only the kernel of the scenes here, and the one for all: minutes of compiling less."""
UNCOUNTED: tuple[Edit, ...] = (
    ("CMakeLists.txt", r"\n *cpp/\w+/(bind_)?(bench|limit|replay|sampling|split|unseen)\.cpp", ""),
    ("cpp/bindings/module.cpp", r"\n *equaltime::bind_(bench|replay|sampling|split)\(m\);", ""),
)
"""What renders have no use for, but the package has: minutes less, where there is nothing to time."""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("fields", nargs="*", metavar="FIELD", help="of Effects [all]")
    options = parser.parse_args()
    print_conditions(options)
    less = (TWO_ROWS,) if options.repeats else (TWO_ROWS, *UNCOUNTED)
    known = re.findall(r"\n    \{&Effects::(\w+), ", (REPOSITORY / EFFECTS).read_text())
    with tempfile.TemporaryDirectory() as folder:
        here = kept("this", build(Variant({}, less), Path(folder)))
        room = count(here, "")
        print(f"{room.total / PATHS:.1f} instructions a path", flush=True)
        for field in options.fields or known:
            without = rebuild(Variant({}, (*removal(field), *less)), Path(folder), KERNELS)
            compare(field, here, kept(field, without), room, options)


def kept(name: str, module: str) -> str:
    """Return a copy of a module that the next build does not replace."""
    return str(shutil.copy(module, Path(module).with_name(f"{name}.so")))


def compare(field: str, here: str, without: str, room: Profile, options: argparse.Namespace) -> None:
    """Print what the field costs, and the functions in which it does."""
    other = count(without, "")
    line = f"  {field:18} {room.total / other.total - 1:+.4%} instructions"
    if options.repeats:
        line += f", {text(times(here, without, options), 4)} x the time"
    print(line, flush=True)
    for name in sorted({*room.functions, *other.functions}):
        more = room.functions.get(name, 0) - other.functions.get(name, 0)
        if more:
            print(f"    {more / PATHS:+.3f} a path in {name}")


def times(here: str, without: str, options: argparse.Namespace) -> object:
    """Return the ratio of processor times, this build over the one without the field."""
    with ExitStack() as stack:
        cores = {file: stack.enter_context(Worker("core_worker.py", ["--core", file])) for file in (here, without)}
        question = {"scene": str(SHIPPED[0]), "threads": options.threads, "size": [256, 256]}
        pilot = cores[here].ask(**question, spp=4)
        spp = max(4, round(1.0 / pilot["seconds"]) * 4)
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
        if re.search(pattern, (REPOSITORY / KERNELS).read_text()):
            yield KERNELS, pattern, ""


if __name__ == "__main__":
    main()
