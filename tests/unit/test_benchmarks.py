"""Every benchmark still runs, in its smallest form: what it prints then says nothing, but that it prints it does."""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[1] / "bench"
SMALLEST = {
    "adaptive_gain": "--seeds 2 --size 16 --spp 16 --images 4 --scenes lens",
    "automatic": "--seeds 2 --side 16 --spp 4 --scenes scenes/cornell-box.toml",
    "cost_of_measuring": "--repeats 1 --size 16 16 --spp 4",
    "coverage_of_merges": "--groups 2 --size 8 --reference 64 --scenes flat",
    "coverage_of_compare": "--seeds 2 --size 16 --spp 256 --scenes flat",
    "coverage_of_stops": "--seeds 2 --size 8 --paths 1e4 --scenes lens",
    "coverage_of_records": "--seeds 2 --size 8 --spp 4 --reference 64",
    "file_sizes": "--height 36 --most 2",
    "flat_memory": "--spp 4 --many 16",
    "kernels": "--repeats 1 --scenes scenes/cornell-box.toml",
    "kill_resume": "--kills 1",
    "light_tree": "--repeats 1 --counts 2 16",
    "limit_and_scaling": "--repeats 1 --triangles 2000",
    "loading": "--repeats 1 --triangles 2000",
    "many": "--repeats 1 --share 0.01",
    "memory": "--repeats 1",
    "mis_grid": "--spp 4 --size 8 8",
    "motion": "--repeats 1",
    "robust_intersection": "--repeats 1 --triangles 2000",
    "stated_errors": "--seeds 4 --size 8 --counts 2 8 --scenes flat",
    "selection_by_stops": "--seeds 2 --size 8 --reference 64 --most 64 --scenes flat",
    "sampler_noise": "--seeds 3 --width 8 --counts 4 8 --scenes scenes/cornell-box.toml",
    "short_passes": "--seeds 1 --size 16 --scenes ball",
    "small_lights": "--repeats 1 --side 8",
    "strategies": "best,sampler=independent --repeats 1 --size 16 16 --scenes scenes/cornell-box.toml",
}
ELSEWHERE = {
    "against_mitsuba": "needs a peer",
    "agreement": "needs a peer",
    "build_variants": "builds the core anew",
    "building": "builds the core anew",
    "cluster": "takes minutes, and the suite injects the same faults",
    "history": "needs valgrind",
    "inert": "needs valgrind",
    "instructions": "needs valgrind",
    "lattice_vector": "takes minutes, and writes the vector",
    "loading_beside_mitsuba": "needs a peer",
    "quotes": "watches the load of the machine, and takes minutes at the least",
    "removed_fields": "builds the core anew, and needs valgrind",
    "special_cases": "builds the core anew",
}


def test_every_benchmark_of_the_table_is_tried_or_says_why_not() -> None:
    listed = re.findall(r"^\| `python tests/bench/(\w+)\.py", (BENCH / "README.md").read_text(), re.MULTILINE)
    assert sorted(listed) == sorted([*SMALLEST, *ELSEWHERE])


def test_every_benchmark_finds_what_it_imports() -> None:
    absent = {name for name, why in ELSEWHERE.items() if why == "needs a peer" and find_spec("mitsuba") is None}
    names = sorted({path.stem for path in BENCH.glob("*.py")} - absent)
    code = "; ".join(f"import {name}" for name in names)
    done = subprocess.run([sys.executable, "-c", code], cwd=BENCH, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", SMALLEST)
def test_a_benchmark_runs_in_its_smallest_form(name: str) -> None:
    command = [sys.executable, str(BENCH / f"{name}.py"), *SMALLEST[name].split()]
    done = subprocess.run(command, cwd=BENCH.parents[1], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) > 4
