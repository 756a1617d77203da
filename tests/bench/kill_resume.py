"""Renders that are killed (signal 9) again and again, and taken up: whether that works, what is lost, and the bits.

One render is killed at random moments, each time taken up from its checkpoint, and at last finished: its moments must
be those of a render that was never stopped. After every kill the checkpoint must be whole, and hold what was rendered
up to one interval (and the saving and the blocks that were going on) before, however long a pass of its film takes.
"""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measuring import SCENES, arguments, parsed

import equaltime as et
from equaltime.rendering.render_file import read_film, read_picture
from equaltime.statistics.intervals import median_interval

SCENE = SCENES / "cornell-box.toml"
MOST_SECONDS = 60.0
"""To wait for the first checkpoint."""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1, help="of the moments [%(default)s]")
    parser.add_argument("--interval", type=float, default=0.2, help="seconds between checkpoints [%(default)s]")
    parser.add_argument("--strategy", default="best")
    parser.add_argument("--size", type=int, nargs=2, default=[64, 64], help="of the film; large ones have long passes")
    options = parsed(parser, kills=8)
    moments = random.Random(options.seed)
    lost: list[float] = []
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        output = Path(folder) / "a.exr"
        before, empty = 0, 0
        for _ in range(options.kills):
            killed_after(command(output, options, 1_000_000), output, moments.uniform(0.0, 3.0 * options.interval))
            if not output.exists():
                empty += 1
                continue
            record = read_picture(output).record
            assert read_film(output).moments is not None
            done = int(record["samples"]["max"])
            assert done >= before, "the checkpoint went back"
            before = done
            lost.append(time.time() - output.stat().st_mtime)
        target = before + 64
        subprocess.run(command(output, options, target), check=True)
        whole = et.render(et.load(SCENE).with_(size=tuple(options.size)), spp=target, strategy=options.strategy)
        found = read_film(output).moments
        assert found is not None
        assert whole.moments is not None
        same = found.tobytes() == whole.moments.tobytes()
    print(f"{options.kills} kills, {empty} before the first checkpoint; {before} samples a pixel after the last")
    if lost:
        worst = median_interval(lost)
        print(f"age of the checkpoint at the kill: median {worst.value:.3g} s, at most {max(lost):.3g} s")
    print(f"the finished render has {'the bits' if same else 'NOT the bits'} of one that never stopped")
    sys.exit(0 if same else 1)


def command(output: Path, options: object, spp: int) -> list[str]:
    """Return the command that takes the render up, on as many threads as asked for."""
    values = vars(options)
    words = [
        "--spp",
        str(spp),
        "--size",
        "{}x{}".format(*values["size"]),
        "--strategy",
        values["strategy"],
        "--threads",
        str(values["threads"]),
    ]
    start = [sys.executable, "-m", "equaltime", "render", str(SCENE), "-o", str(output), "--resume", "-q"]
    return [*start, *words, "--checkpoint", f"{values['interval']}s"]


def killed_after(words: list[str], output: Path, seconds: float) -> None:
    """Run a command and kill it so many seconds after it first saved what it has done."""
    begin = time.time()
    process = subprocess.Popen(words, stderr=subprocess.DEVNULL)
    while not (output.exists() and output.stat().st_mtime > begin) and time.time() - begin < MOST_SECONDS:
        time.sleep(0.005)
    time.sleep(seconds)
    process.kill()
    process.wait()


if __name__ == "__main__":
    main()
