"""Any command can be a renderer that is measured; what goes wrong with it is said in its own words."""

from __future__ import annotations

import json
import sys
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import PeerError
from equaltime.experiments.peers.command import CommandPeer
from equaltime.experiments.peers.common import checked_image, uneven_samples, with_box_filter

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
WIDTH, HEIGHT = 6, 4

RENDERER = """
import json, os, struct, sys, time
spp, seed, out, width, height, mode = *map(int, sys.argv[1:3]), sys.argv[3], *map(int, sys.argv[4:6]), sys.argv[6]
if mode == "fails":
    print("no such scene\\nas this", file=sys.stderr)
    sys.exit(3)
if mode == "dies":
    os.kill(os.getpid(), 9)
if mode == "silent":
    sys.exit(0)
if mode == "text":
    open(out, "w").write("no image")
    sys.exit(0)
if mode == "small":
    width -= 1
value = float("nan") if mode == "nan" else spp
magic, channels = ("Pf", 1) if mode == "grey" else ("PF", 3)
with open(out, "wb") as file:
    file.write(f"{magic}\\n{width} {height}\\n-1.0\\n".encode())
    file.write(struct.pack("<f", value) * (width * height * channels))
print("rendered", file=sys.stderr)
print("a line before")
if mode == "times":
    print(json.dumps({"seconds": 0.001, "cpu_seconds": 0.0005, "spp": spp // 4 * 4 or 4, "other": "words"}))
if mode == "liar":
    print(json.dumps({"seconds": 1e6}))
if mode == "busy":
    end = time.process_time() + 0.2
    while time.process_time() < end:
        pass
"""


def scene(**changes: Any) -> et.Scene:
    return et.load(SCENE).with_(size=(WIDTH, HEIGHT), **changes)


@pytest.fixture
def renderer(tmp_path: Path) -> Path:
    path = tmp_path / "my renderer.py"
    path.write_text(RENDERER)
    return path


def peer(renderer: Path, mode: str = "ok") -> CommandPeer:
    return CommandPeer(
        "mine", f"'{sys.executable}' '{renderer}' {{spp}} {{seed}} {{out}}.pfm {{width}} {{height}} {mode}"
    )


def run(subject: CommandPeer, *ladder: int, seed: int = 1, of: et.Scene | None = None) -> list[Any]:
    assert subject.prepare(of or scene(), 1) == 0.0
    return list(subject.run(seed, ladder))


def test_each_count_is_a_run_with_an_image_and_times_of_its_own(renderer: Path) -> None:
    checkpoints = run(peer(renderer), 2, 8)
    assert [c.spp for c in checkpoints] == [2, 8]
    assert [c.image.shape for c in checkpoints] == [(HEIGHT, WIDTH, 3)] * 2
    assert [np.unique(c.image).tolist() for c in checkpoints] == [[2.0], [8.0]]
    assert checkpoints[0].image.dtype == np.float32
    assert all(c.cpu_s > 0.0 and 0.0 < c.wall_s < 60.0 for c in checkpoints)
    assert [c.paths for c in checkpoints] == [2 * WIDTH * HEIGHT, 8 * WIDTH * HEIGHT]


def test_the_processor_time_is_that_of_the_command(renderer: Path) -> None:
    (busy,) = run(peer(renderer, "busy"), 1)
    assert 0.2 <= busy.cpu_s <= busy.wall_s + 0.1


def test_a_run_ends_at_the_first_count_past_its_seconds(renderer: Path) -> None:
    subject = peer(renderer)
    subject.prepare(scene(), 1)
    assert len(list(subject.run(1, count(2), seconds=1e-9))) == 1


def test_a_command_may_say_its_own_times_and_count(renderer: Path) -> None:
    checkpoints = run(peer(renderer, "times"), 2, 4, 9)
    assert [(c.spp, c.wall_s, c.cpu_s) for c in checkpoints] == [(4, 0.001, 0.0005), (8, 0.001, 0.0005)]


def test_one_channel_is_grey(renderer: Path) -> None:
    assert (run(peer(renderer, "grey"), 3)[0].image == 3.0).all()


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        ("fails", ["code 3", "no such scene", "as this"]),
        ("dies", ["SIGKILL"]),
        ("silent", ["wrote no image", "{out}"]),
        ("text", ["cannot be used", "image.pfm"]),
        ("small", [f"expected an image of {WIDTH}x{HEIGHT}", f"found {WIDTH - 1}x{HEIGHT}"]),
        ("nan", [f"{WIDTH * HEIGHT} of {WIDTH * HEIGHT} pixels", "(0, 0)", "nan"]),
        ("liar", ["seconds is 1000000.0", "ran for"]),
    ],
)
def test_a_failure_is_told_in_words(renderer: Path, mode: str, words: list[str]) -> None:
    with pytest.raises(PeerError) as caught:
        run(peer(renderer, mode), 1)
    assert [word for word in ["mine", *words] if word not in str(caught.value)] == [], str(caught.value)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("render {spp} {seed}", ["must contain {out}"]),
        ("render {ssp} {seed} {out}", ["{ssp}", "{spp}"]),
        ("render '{spp} {seed} {out}", ["split into words", "quotation"]),
    ],
)
def test_a_command_that_cannot_work_is_refused_at_once(command: str, words: list[str]) -> None:
    with pytest.raises(PeerError) as caught:
        CommandPeer("mine", command)
    assert [word for word in ["mine", *words] if word not in str(caught.value)] == [], str(caught.value)


def test_a_command_over_several_lines_has_a_name_on_one() -> None:
    peer = CommandPeer("mine", "render {spp}\n  {seed}\t{out}")
    assert peer.name == "render {spp} {seed} {out}"


def test_a_program_that_is_not_there_is_missed_before_the_first_run() -> None:
    with pytest.raises(PeerError, match="no program no-such-renderer"):
        CommandPeer("mine", "no-such-renderer {spp} {seed} {out}").prepare(scene(), 1)


def test_a_scene_that_is_no_file_has_no_name() -> None:
    described = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}})
    with pytest.raises(PeerError, match=r"mine: \{scene\} needs a scene file, but .* made in memory; use \{json\}"):
        CommandPeer("mine", f"{sys.executable} {{scene}} {{spp}} {{seed}} {{out}}").prepare(described, 1)


def test_what_mitsuba_has_no_words_for_is_told_before_it_runs() -> None:
    keys = [{"time": time, "translate": [time, 0, 0]} for time in (0.0, 1.0)]
    ball = {"type": "sphere", "to_world": {"animation": keys}}
    sensor = {"type": "perspective", "shutter_close": 1.0}
    moving = et.load_dict({"type": "scene", "sensor": sensor, "ball": ball}).with_(size=(WIDTH, HEIGHT))
    with pytest.raises(PeerError, match="mine: Mitsuba 3 has no transforms that change with time"):
        run(CommandPeer("mine", f"{sys.executable} {{json}} {{spp}} {{seed}} {{out}}"), 1, of=moving)


def test_all_words_are_filled_in(tmp_path: Path) -> None:
    words = "{scene} {json} {spp} {seed} {width}x{height} {max_depth} {filter} {threads}"
    keep = f"open('{tmp_path}/words', 'w').write('|'.join(sys.argv[1:])); shutil.copy(sys.argv[2], '{tmp_path}')"
    command = f'{sys.executable} -c "import sys, shutil; {keep}" {words} {{out}}'
    with pytest.raises(PeerError, match="wrote no image"):
        run(CommandPeer("mine", command), 5, seed=7, of=scene(max_depth=3))
    scene_file, json_file, spp, seed, size, depth, rfilter, threads, out = (tmp_path / "words").read_text().split("|")
    assert scene_file == str(SCENE)
    assert (spp, size, depth, threads) == ("5", f"{WIDTH}x{HEIGHT}", "3", "1")
    assert rfilter == "box", "and not the tent of the scene's file"
    assert 0 <= int(seed) < 2**31
    assert out.endswith(".exr")
    assert json_file.endswith(".json")
    written = json.loads((tmp_path / "scene.json").read_text())
    assert written["sensor"]["film"]["rfilter"] == {"type": "box"}
    assert written["integrator"] == {"type": "path", "max_depth": 3}


def test_seeds_differ_between_runs_and_between_the_counts_of_a_run(tmp_path: Path) -> None:
    script = f"import sys; open('{tmp_path}/seeds', 'a').write(sys.argv[1] + ' ')"
    subject = CommandPeer("mine", f'{sys.executable} -c "{script}" {{seed}} {{spp}} {{out}}')
    for seed, spp in ((1, 4), (1, 8), (2, 4), (1, 4)):
        with pytest.raises(PeerError):
            run(subject, spp, seed=seed)
    *seeds, again = (tmp_path / "seeds").read_text().split()
    assert len(set(seeds)) == 3
    assert again == seeds[0]


def test_the_whole_film_is_cut_to_the_crop_window() -> None:
    cropped = scene(crop=(1, 2, 3, 2))
    whole = np.arange(HEIGHT * WIDTH * 3, dtype=np.float64).reshape(HEIGHT, WIDTH, 3)
    np.testing.assert_array_equal(checked_image(whole, cropped, "mine"), whole[2:4, 1:4])
    np.testing.assert_array_equal(checked_image(whole[:2, :3], cropped, "mine"), whole[:2, :3])


def test_a_box_filter_changes_the_filter_only() -> None:
    tent = scene()
    boxed = with_box_filter(tent)
    assert boxed.model.sensor.film.rfilter.type == "box"
    assert boxed.digest != tent.digest
    assert boxed.model.shapes == tent.model.shapes
    assert with_box_filter(boxed) is boxed


def test_sample_counts_that_differ_are_kept_and_cut_as_the_image_is() -> None:
    counts = np.arange(WIDTH * HEIGHT).reshape(HEIGHT, WIDTH)
    cropped = scene().with_(crop=(1, 2, 3, 2))
    np.testing.assert_array_equal(uneven_samples(counts, cropped), counts[2:4, 1:4])
    np.testing.assert_array_equal(uneven_samples(counts[2:4, 1:4], cropped), counts[2:4, 1:4])
    for nothing in (None, np.full_like(counts, 7), counts[1:]):
        assert uneven_samples(nothing, scene()) is None
