"""What an effect costs a scene that does not call for it: instructions and time, against a core without that effect.

Each field of `Effects` in turn is taken out of a copy of the source: out of the structure, the derivation and the rows
of kernels, and with it all code that asks for it. Instructions are those of `instructions.py`, in its room that calls
for nothing; what differs is told by symbol. Times are the processors', of the Cornell box, which calls for nothing
either; each build takes turns with this source, built the same way.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from builds import REPOSITORY, Variant, build
from instructions import PATHS, Profile, count
from measuring import SHIPPED, arguments, print_conditions, ratio, rounds, text
from workers import Worker

from equaltime import _core

Edit = tuple[str, str, str]
TWO_ROWS: Edit = ("cpp/transport/kernels.cpp", r"\n *row<(?!kAllEffects|Effects\{\}).*>\(\),", "")
"""Only the kernel of the scenes here, and the one for all: minutes of compiling less for each build."""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("fields", nargs="*", metavar="FIELD", help="of Effects [all]")
    options = parser.parse_args()
    print_conditions(options)
    fields = options.fields or list(_core.SceneBuilder().build().effects())
    with tempfile.TemporaryDirectory() as folder:
        here = build(Variant({}, [TWO_ROWS]), Path(folder) / "this")
        room = count(here, "")
        print(f"{room.total / PATHS:.1f} instructions a path")
        for field in fields:
            without = build(Variant({}, [*removal(field), TWO_ROWS]), Path(folder) / field)
            compare(field, here, without, room, options)


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
    """Yield the edits that take a field out of the source."""
    code = [*(REPOSITORY / "cpp").rglob("*.h"), *(REPOSITORY / "cpp").rglob("*.cpp")]
    asked = rf"\bE\.{field}\b"
    for file in code:
        if "tests" not in file.parts and re.search(asked, file.read_text()):
            yield str(file.relative_to(REPOSITORY)), asked, "false"
    effects, derivation, kernels = (f"cpp/transport/{name}" for name in ("effects.h", "effects.cpp", "kernels.cpp"))
    yield effects, rf"\n  bool {field} = false;[^\n]*", ""
    yield effects, rf'\n    \{{&Effects::{field}, "{field}"\}},', ""
    yield derivation, rf"\be\.{field} = [^;]*;", ";"
    rows = (REPOSITORY / kernels).read_text()
    chained, alone = (rf"\be\.{field} = (?=e\.)", rf"(?<== )e\.{field} = "), rf"\be\.{field} = (true|false);"
    for pattern in (*chained, alone, rf"\.{field} = true(, )?"):
        rows, found = re.subn(pattern, "", rows)
        if found:
            yield kernels, pattern, ""


if __name__ == "__main__":
    main()
