"""A small program that uses the whole face passes `mypy --strict`, and editors see the type of every name."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import equaltime as et

ROOT = Path(__file__).parents[2]

PROGRAM = """
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import equaltime as et


class Listener(et.Observer):
    def progress(self, progress: et.Progress) -> None:
        print(progress.samples, progress.error)

    def quoted(self, quote: et.Quote) -> None:
        print(quote.seconds, quote.spp, quote)


def main(folder: Path) -> et.Interval:
    scene: et.Scene = et.load(folder / "scene.toml").with_(size=(64, 64))
    plain: et.Scene = et.load_dict({"type": "scene"})
    strategy = et.Strategy.parse("best,sampler=sobol")
    result: et.Result = et.render(scene, error=0.02, strategy=strategy, observer=Listener())
    image: NDArray[np.float32] = result.image
    error: et.Estimate = result.error
    stats: et.Stats = result.stats
    files: tuple[Path, ...] = result.save(folder / "a.exr")
    again: et.Result = et.read(files[0])
    merged: et.Result = et.merge([again, et.render(scene, spp=16, seed=1)])
    compared: et.Comparison = et.compare(again, merged)
    with et.open_cluster("local:2") as cluster:
        quote: et.Quote = et.quote(scene, time=30.0, cluster=cluster)
    prices: et.PriceList = et.effects("scene.xml", quick=True)
    path: et.Replay = et.replay(plain, pixel=(1, 2), sample=0)
    passes: et.Progressive = et.progressive(scene, spp=8, resume=again)
    tests: et.SelfTest = et.selftest(only=["G1"])
    try:
        found: et.Summary = et.cost(scene, folder / "cost", quick=True, targets=["5%", 0.02])
    except (et.SceneError, et.RenderError) as problem:
        raise et.EqualtimeError(str(problem)) from problem
    for state in passes:
        print(state.spp)
    print(image.mean(), error.value, stats.rays, compared, quote, prices, path.radiance, tests.passed, found.verdict)
    ratio: et.Interval = found.scenes[0].strategies[0].ratio[0.1]
    return ratio
"""


def checked(program: str, folder: Path) -> str:
    """Return what mypy says of a program."""
    (folder / "program.py").write_text(program)
    settings = folder / "mypy.ini"
    settings.write_text(f"[mypy]\nstrict = true\nmypy_path = {ROOT / 'python'}\nfollow_imports = silent\n")
    command = [sys.executable, "-m", "mypy", "--config-file", str(settings), "--cache-dir", str(folder / "cache")]
    run = subprocess.run([*command, str(folder / "program.py")], capture_output=True, text=True, check=False)
    return run.stdout


def test_a_program_of_the_whole_face_is_typed(tmp_path: Path) -> None:
    assert checked(PROGRAM, tmp_path).startswith("Success")
    used = {name for name in et.__all__ if f"et.{name}" in PROGRAM}
    errors = {name for name in et.__all__ if name.endswith(("Error", "Sample", "Image", "Warning", "Problem"))}
    assert {*et.__all__} - errors - used == {"Experiment", "Viewer", "__version__"}


def test_a_wrong_type_is_seen(tmp_path: Path) -> None:
    wrong = PROGRAM.replace("error=0.02", "error='2 %'").replace("quote.spp, quote", "quote.samples")
    said = checked(wrong, tmp_path)
    assert '"error" to "render"' in said
    assert '"Quote" has no attribute "samples"' in said
