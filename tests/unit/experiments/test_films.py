"""Images forming: when pictures are taken, what is kept of them, and how they are shown."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from equaltime.errors import ImageError
from equaltime.experiments.analysis.summarise import conclude
from equaltime.experiments.model.reader import read_experiment
from equaltime.experiments.model.summary import SceneResult
from equaltime.experiments.report import page
from equaltime.experiments.report.films import film_view, write_animation
from equaltime.experiments.report.looks import looks
from equaltime.experiments.run import single_run
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.forming import FRAMES, moments, read_film
from equaltime.experiments.run.runner import run

from .fake_summary import CONSTANTS, scene_result, summary
from .test_report import Page

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
LOOKS = looks(list(CONSTANTS), "naive")
TIMES = {"naive": (0.01, 0.02, 0.5, 1.0), "best": (0.3, 0.6, 1.2)}


def filmed(folder: Path) -> SceneResult:
    """Return a scene of which two strategies have films: picture k of each is grey of a level of its own."""
    scene = scene_result(folder)

    def with_film(label: str) -> Path:
        times = TIMES[label]
        levels = np.linspace(0.1, 0.9, len(times))[:, None, None, None]
        path = folder / f"{label}-film.npz"
        frames = np.broadcast_to(levels, (len(times), 8, 12, 3)).astype(np.float16)
        errors = np.array([np.nan, *(0.1 for _ in times[1:])])
        np.savez(path, frames=frames, spp=np.arange(2, 2 + len(times)), seconds=np.array(times), error=errors)
        return path

    strategies = (replace(one, film=with_film(one.label)) if one.label in TIMES else one for one in scene.strategies)
    return replace(scene, strategies=tuple(strategies))


def test_moments_lie_closer_at_the_beginning_and_end_with_the_run() -> None:
    counts = moments(10_000.0)
    steps = np.diff(counts)
    assert len(counts) == FRAMES
    assert counts[-1] == 10_000
    assert all(count % 2 == 0 for count in counts)
    assert (np.diff(steps) >= -2).all()
    assert moments(3.0)[0] == moments(0.0)[0] == 2


@pytest.fixture
def quickly(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(single_run, "flip", lambda image, truth: 0.5)
    monkeypatch.setattr(page, "write_figures", lambda *_: ())


@pytest.mark.usefixtures("quickly")
def test_an_experiment_that_wants_films_takes_them_once_and_keeps_them_out_of_the_records(tmp_path: Path) -> None:
    path = tmp_path / "x.toml"
    path.write_text(
        f'scenes = [{{ path = "{CORNELL}", size = [8, 8], max_depth = 2 }}]\nstrategies = ["bsdf", "best"]\n'
        'budget = "10ms"\nrepeats = 1\nthreads = 1\nanimate = true\nreference = { error = 0.5, seconds = 0.2 }\n'
    )
    experiment, out = read_experiment(path), tmp_path / "out"
    run(experiment, out)
    records = (out / "records.csv").read_bytes()
    film = read_film(ExperimentFolder(out).film("cornell-box", "best"))
    assert film.frames.shape == (len(film.spp), 8, 8, 3)
    assert (np.diff(film.spp) > 0).all()
    assert (np.diff(film.seconds) > 0).all()
    assert film.error[-1] > 0.0
    taken = ExperimentFolder(out).film("cornell-box", "best").read_bytes()
    run(experiment, out)
    assert ExperimentFolder(out).film("cornell-box", "best").read_bytes() == taken
    assert (out / "records.csv").read_bytes() == records
    found = conclude(experiment, out)
    assert all(strategy.film for strategy in found.scenes[0].strategies)
    assert "data-film" in (out / "report.html").read_text("utf-8")
    assert (out / "figures" / "cornell-box-forming.webp").exists()


def test_every_picture_is_in_the_sheet_with_its_time_and_words(tmp_path: Path) -> None:
    view = film_view(filmed(tmp_path), LOOKS, 0)
    assert view is not None
    naive, best = view.reels
    assert (naive.label, naive.times, best.times) == ("naive", TIMES["naive"], TIMES["best"])
    assert (naive.columns, naive.rows, view.seconds, view.aspect) == (4, 1, 1.2, "12 / 8")
    assert naive.says[0] == "10\N{NARROW NO-BREAK SPACE}ms, 2 spp"  # its error drowns in the reference's noise
    assert naive.says[1].endswith("3 spp; error of this run: 10\N{NARROW NO-BREAK SPACE}%")
    assert naive.uri.startswith("data:image/webp;base64,")


def test_a_scene_without_films_shows_none(tmp_path: Path) -> None:
    scene = scene_result(tmp_path)
    assert film_view(scene, LOOKS, 0) is None
    assert write_animation(tmp_path, "box", scene, 0) == ()


def test_a_film_that_cannot_be_read_is_left_out(tmp_path: Path) -> None:
    scene = filmed(tmp_path)
    (tmp_path / "best-film.npz").write_bytes(b"torn")
    with pytest.raises(ImageError):
        read_film(tmp_path / "best-film.npz")
    view = film_view(scene, LOOKS, 0)
    assert view is not None
    assert [reel.label for reel in view.reels] == ["naive"]


def test_the_animated_file_plays_at_true_speed(tmp_path: Path) -> None:
    (name,) = write_animation(tmp_path / "figures", "box", filmed(tmp_path), 0)
    assert name == "figures/box-forming.webp"
    with Image.open(tmp_path / name) as file:
        lasts = []
        for number in range(file.n_frames):
            file.seek(number)
            file.load()
            lasts.append(file.info["duration"])
        levels = np.asarray(file.convert("RGB"))[120]
    assert sum(lasts[:-1]) == pytest.approx(1200, abs=20)
    assert lasts == [20, 280, 200, 100, 400, 200, 2000]
    assert abs(int(levels[100, 0]) - int(levels[-100, 0])) < 6  # both have ended


def test_an_animated_file_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, folder = filmed(tmp_path), tmp_path / "figures"
    (name,) = write_animation(folder, "box", scene, 0)
    before = (tmp_path / name).read_bytes()

    def unfinished(_: object, file: Path, *__: object, **___: object) -> None:
        file.write_bytes(b"half")
        raise OSError

    monkeypatch.setattr(Image.Image, "save", unfinished)
    with pytest.raises(OSError):
        write_animation(folder, "box", scene, 0)
    assert [(file.name, file.read_bytes()) for file in folder.iterdir()] == [(Path(name).name, before)]


def test_moments_too_close_for_a_browser_are_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(TIMES, "naive", (0.301, 0.302, 1.195, 1.2))
    (name,) = write_animation(tmp_path / "figures", "box", filmed(tmp_path), 0)
    with Image.open(tmp_path / name) as file:
        assert file.n_frames == 4  # nothing yet, two at 0.3, one at 0.6, both ends at 1.2


def test_the_page_has_a_player_with_names_for_everything(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    value = replace(summary(tmp_path), scenes=(filmed(tmp_path),))
    shown = Page(page.write_report(value, tmp_path).read_text("utf-8"))
    reels = [figure for figure in shown.all("figure") if "data-times" in figure]
    assert [json.loads(str(reel["data-times"])) for reel in reels] == [list(TIMES["naive"]), list(TIMES["best"])]
    assert all(len(json.loads(str(reel["data-says"]))) == len(json.loads(str(reel["data-times"]))) for reel in reels)
    assert "figures/box-forming.webp" in shown.visible
