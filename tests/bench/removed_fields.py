"""What an effect costs a scene that does not call for it: instructions and time, against a core without that effect.

Each field of `Effects` in turn is taken out of a copy of the source: out of the structure, the derivation and the rows
of kernels. Code that asks for it is answered no, whatever the kernel. Instructions are those of `instructions.py`, in
its room that calls for nothing; what differs is told by symbol. Times are the processors', of the Cornell box, which
calls for nothing either; each build takes turns with this source, built the same way.
"""

from __future__ import annotations

import argparse
import re
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

from builds import REPOSITORY, Variant, build
from instructions import PATHS, Profile, count
from measuring import SHIPPED, arguments, print_conditions, ratio, rounds, text
from workers import Worker

Edit = tuple[str, str, str]
EFFECTS, DERIVATION, KERNELS, RENDERER, BOUND = (
    *(f"cpp/transport/{name}" for name in ("effects.h", "effects.cpp", "kernels.cpp", "renderer.cpp")),
    "cpp/bindings/bind_scene.cpp",
)
OTHERS = (*(f"cpp/transport/{name}.cpp" for name in ("checked", "efficiency", "split", "unseen")), BOUND)
LESS: tuple[Edit, ...] = (
    (KERNELS, r"\n *row<(?!kAllEffects>|Effects\{\}>).*>\(\),", ""),
    *((file, "<kAllEffects>", "<Effects{}>") for file in OTHERS),
)
"""Only the kernel of the scenes here, and the one for all: minutes of compiling less for each build."""
UNCOUNTED: tuple[Edit, ...] = (
    ("CMakeLists.txt", r"\n *cpp/\w+/(bind_)?(bench|limit|replay|sampling|split|unseen)\.cpp", ""),
    ("cpp/bindings/module.cpp", r"\n *equaltime::bind_(bench|replay|sampling|split)\(m\);", ""),
)
"""What renders have no use for, but the package has: a minute less, where there is nothing to time."""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("fields", nargs="*", metavar="FIELD", help="of Effects [all]")
    options = parser.parse_args()
    print_conditions(options)
    less = LESS if options.repeats else (*LESS, *UNCOUNTED)
    known = re.findall(r"\n    \{&Effects::(\w+), ", (REPOSITORY / EFFECTS).read_text())
    with tempfile.TemporaryDirectory() as folder:
        here = built("this", less, Path(folder))
        room = count(here, "")
        print(f"{room.total / PATHS:.1f} instructions a path", flush=True)
        for field in options.fields or known:
            without = built(field, (*removal(field), *less), Path(folder))
            compare(field, here, without, room, options)


def built(name: str, edits: Sequence[Edit], folder: Path) -> str:
    """Build a core in the folder of all, where most is built already, and return its file."""
    file = folder / f"{name}.so"
    shutil.copy(build(Variant({}, edits), folder), file)
    return str(file)


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
    """Yield the edits that take a field out of the source; what asks for it finds a constant in its place."""
    yield EFFECTS, rf"\n  bool {field} = false;", rf"\n  static constexpr bool {field} = false;"
    yield EFFECTS, rf'\n    \{{&Effects::{field}, "{field}"\}},', ""
    asked = (
        (KERNELS, rf"&Effects::{field}(,\s*)?", ""),
        (KERNELS, rf"\.{field} = true(, )?", ""),
        (DERIVATION, rf"\be\.{field} = [^;]*;", ";"),
        (RENDERER, rf"\.{field} = [^,}}]*", ""),
        (BOUND, rf"if \(used != &Effects::{field}\) ", ""),
    )
    for file, pattern, replacement in asked:
        if re.search(pattern, (REPOSITORY / file).read_text()):
            yield file, pattern, replacement


if __name__ == "__main__":
    main()
