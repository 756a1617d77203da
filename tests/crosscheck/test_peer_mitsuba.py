"""Mitsuba 3 as a renderer that is measured: its images, counts and times, and whether it may be compared."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import count
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import PeerError
from equaltime.experiments.peers import mitsuba
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.experiments.peers.mitsuba_worker import samples_per_pass
from equaltime.images.image_files import Layer, write

if find_spec("mitsuba") is None:
    pytest.skip("needs mitsuba", allow_module_level=True)

SCENES = Path(__file__).parents[2] / "scenes"
SIZE = (24, 16)


def scene(name: str = "cornell-box", size: tuple[int, int] = SIZE, max_depth: int = 4) -> et.Scene:
    return et.load(SCENES / f"{name}.toml").with_(size=size, max_depth=max_depth)


@pytest.fixture(scope="module")
def peer() -> Iterator[MitsubaPeer]:
    subject = MitsubaPeer("scalar", "scalar_rgb")
    yield subject
    subject.close()


@pytest.fixture
def closing() -> Iterator[list[MitsubaPeer]]:
    subjects: list[MitsubaPeer] = []
    yield subjects
    for subject in subjects:
        subject.close()


def test_each_count_is_a_render_with_times_of_its_own(peer: MitsubaPeer) -> None:
    assert peer.prepare(scene(), 1) > 0.0
    few, many = peer.run(1, (2, 8))
    assert (few.spp, many.spp) == (2, 8)
    assert few.image.shape == many.image.shape == (SIZE[1], SIZE[0], 3)
    assert few.image.dtype == np.float32
    assert not np.allclose(few.image, many.image)
    assert few.paths == 2 * SIZE[0] * SIZE[1]
    assert few.wall_s > 0.0
    assert many.wall_s > 0.0
    assert many.cpu_s > 0.0
    assert peer.version.startswith("3.")


def test_seeds_give_independent_images_and_the_same_seed_the_same(peer: MitsubaPeer) -> None:
    peer.prepare(scene(), 1)
    first, again, other = (next(peer.run(seed, (4,))).image for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_what_was_loaded_is_kept(peer: MitsubaPeer) -> None:
    small, large = scene(), scene(size=(48, 32))
    setups = [peer.prepare(one, 1) for one in (small, large, small)]
    assert setups[0] == setups[2]
    assert next(peer.run(1, (2,))).image.shape == (SIZE[1], SIZE[0], 3)


def test_the_count_that_the_sampler_takes_is_told_and_taken_once(closing: list[MitsubaPeer]) -> None:
    stratified = MitsubaPeer("stratified", "scalar_rgb", sampler="stratified")
    closing.append(stratified)
    stratified.prepare(scene(), 1)
    assert [checkpoint.spp for checkpoint in stratified.run(1, (2, 4, 6, 8, 12))] == [4, 9, 16]


def test_a_run_ends_at_the_first_count_past_its_seconds(peer: MitsubaPeer) -> None:
    peer.prepare(scene(), 1)
    assert len(list(peer.run(1, count(2), seconds=1e-9))) == 1


def test_a_sky_is_read_with_a_single_thread_too(peer: MitsubaPeer, tmp_path: Path) -> None:
    """Mitsuba's reader of EXR files waits for a second one for ever."""
    pixels = np.full((64, 128, 3), 0.5, np.float32)
    write(tmp_path / "sky.exr", "openexr", [Layer(("R", "G", "B"), pixels, {})])
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1]}
    sky = {"type": "envmap", "filename": str(tmp_path / "sky.exr")}
    seen = et.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": sky})
    peer.prepare(seen, 1)
    np.testing.assert_allclose(next(peer.run(1, (2,))).image, 0.5, rtol=1e-6)


def test_many_samples_are_taken_in_passes_of_one_render(peer: MitsubaPeer, monkeypatch: pytest.MonkeyPatch) -> None:
    """False alarm: t beyond 6 with 14 degrees of freedom, one seed in 30 000."""
    peer.prepare(scene(), 1)
    whole = [next(peer.run(seed, (16,))) for seed in range(8)]
    monkeypatch.setattr(mitsuba, "MOST_IN_FLIGHT", 4 * SIZE[0] * SIZE[1])
    parts = [next(peer.run(seed, (16,))) for seed in range(8)]
    assert {checkpoint.spp for checkpoint in whole + parts} == {16}
    assert not np.array_equal(whole[0].image, parts[0].image)
    means = np.array([[checkpoint.image.mean() for checkpoint in side] for side in (whole, parts)])
    error = np.sqrt(means.var(axis=1, ddof=1).sum() / 8)
    assert abs(means[0].mean() - means[1].mean()) < 6.0 * error


def test_the_file_s_filter_is_replaced_by_a_box(peer: MitsubaPeer) -> None:
    """Of the two, only a tent makes neighbours alike."""
    assert scene().model.sensor.film.rfilter.type == "tent"
    peer.prepare(scene(), 1)
    noise = np.subtract(*(next(peer.run(seed, (16,))).image[..., 0] for seed in (1, 2)))
    correlation = np.corrcoef(noise[:, 1:].ravel(), noise[:, :-1].ravel())[0, 1]
    assert abs(correlation) < 0.2  # of 368 pairs: four standard errors; a tent has 0.5


@pytest.mark.parametrize(
    ("subject", "words"),
    [
        (MitsubaPeer("m", "scalar_rgbb"), ["no variant 'scalar_rgbb'", "scalar_rgb"]),
        (MitsubaPeer("m", "scalar_rgb", sampler="sobol"), ["sobol"]),
        (MitsubaPeer("m", "scalar_rgb", integrator="pathh"), ["pathh"]),
        (MitsubaPeer("m", "scalar_rgb", integrator="direct"), ["max_depth 2", "found 4"]),
        (MitsubaPeer("m", "scalar_rgb", python="/bin/false"), ["ended with code 1"]),
    ],
    ids=lambda value: "" if isinstance(value, list) else value.name,
)
def test_what_mitsuba_cannot_do_is_told(subject: MitsubaPeer, words: list[str]) -> None:
    with pytest.raises(PeerError) as caught:
        subject.prepare(scene(), 1)
    subject.close()
    assert [word for word in ["m", *words] if word not in str(caught.value)] == [], str(caught.value)


def test_a_missing_llvm_is_told_with_the_name_of_its_package() -> None:
    code = (
        "import equaltime as et; from equaltime.experiments.peers.mitsuba import MitsubaPeer;"
        f"MitsubaPeer('m').prepare(et.load({str(SCENES / 'cornell-box.toml')!r}), 1)"
    )
    environment = os.environ | {"DRJIT_LIBLLVM_PATH": "/nowhere/libLLVM.so"}
    ended = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60)
    assert "apt install libllvm19" in ended.stderr, ended.stderr


def test_a_process_that_dies_is_told_and_started_anew(closing: list[MitsubaPeer]) -> None:
    peer = MitsubaPeer("mortal", "scalar_rgb")
    closing.append(peer)
    peer.prepare(scene(), 1)
    assert peer._worker is not None
    os.killpg(peer._worker._process.pid, signal.SIGKILL)
    with pytest.raises(PeerError, match="SIGKILL"):
        next(peer.run(1, (2,)))
    assert peer.prepare(scene(), 1) > 0.0
    assert next(peer.run(1, (2,))).spp == 2


@pytest.mark.parametrize(
    ("spp", "pixels", "wavefront", "expected"),
    [(64, 100, 6400, 64), (64, 100, 6399, 32), (35, 100, 1000, 7), (37, 100, 1000, 1), (8, 100, 10, 1)],
)
def test_passes_are_of_equal_size_and_within_the_limit(spp: int, pixels: int, wavefront: int, expected: int) -> None:
    assert samples_per_pass(spp, pixels, wavefront) == expected
