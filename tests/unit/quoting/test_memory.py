"""The memory that a quote foretells, against the peak of a process that renders and saves."""

import subprocess
import sys
from pathlib import Path

import pytest

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"

_RENDERS = """
import sys
from pathlib import Path
import equaltime as et
scene, quotes = et.load(sys.argv[1]).with_(size=(480, 400), max_depth=3), []
et.render(scene, {}, observer=et.Observer.of(quoted=quotes.append)).save(sys.argv[2])
status = Path("/proc/self/status").read_text().splitlines()
print(next(1024 * int(line.split()[1]) for line in status if line.startswith("VmHWM:")))
memory = quotes[0].memory
print(memory.low, memory.value, memory.high, sep="\\n")
"""


@pytest.mark.parametrize("options", ["error=0.5", "error=0.5, strategy='best,adaptive=error'", "time=100.0, spp=10"])
def test_the_peak_of_the_process_is_in_the_interval(tmp_path: Path, options: str) -> None:
    command = [sys.executable, "-c", _RENDERS.format(options), str(SCENE), str(tmp_path / "a.exr")]
    found = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    peak, low, value, high = map(float, found.split())
    assert low < peak < high
    assert low < value < high
