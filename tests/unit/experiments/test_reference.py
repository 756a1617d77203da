"""References: exact enough, honest about their own noise, rendered once and kept."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import ExperimentError
from equaltime.experiments.model.experiment import ReferenceWish
from equaltime.experiments.run import reference as references
from equaltime.experiments.run.reference import KnownReference, cache_folder, obtain, read, render, write
from equaltime.images import image_files as images
from equaltime.images.image_files import Window
from equaltime.rendering.render_file import RenderFile
from equaltime.scene import Scene
from equaltime.strategy import Strategy

SCENES = Path(__file__).parents[3] / "scenes"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return et.load(SCENES / "cornell-box.toml").with_(size=(24, 24), max_depth=3)


@pytest.fixture(scope="module")
def known(scene: Scene) -> KnownReference:
    return render(scene, error=0.1, seconds=20.0)


def test_rendering_ends_when_the_wanted_error_is_reached(known: KnownReference) -> None:
    assert known.error == pytest.approx(0.1, rel=0.05)
    assert known.facts["error"] == pytest.approx(known.error)
    assert known.facts["seconds"] < 20.0


def test_rendering_ends_when_the_time_is_used_up(scene: Scene) -> None:
    hasty = render(scene, error=1e-6, seconds=0.2)
    assert hasty.error > 1e-6
    assert hasty.facts["seconds"] < 2.0


def test_the_mean_is_that_of_the_halves(known: KnownReference) -> None:
    assert known.reference.halves is not None
    first, second = known.reference.halves
    assert not np.array_equal(first, second)
    np.testing.assert_allclose(known.reference.mean, 0.5 * (first + second))


def test_the_noise_that_is_known_is_that_between_the_halves(known: KnownReference) -> None:
    """The halves differ by twice the standard error; over 1728 numbers the mean square has a spread of some 5 %."""
    assert known.reference.halves is not None
    weight = 1.0 / known.reference.denominator
    between = float((weight * np.square(0.5 * (known.reference.halves[0] - known.reference.halves[1]))).mean())
    assert between == pytest.approx(known.reference.relmse, rel=0.3)


def test_it_agrees_with_a_render_of_another_technique_within_both_errors(scene: Scene, known: KnownReference) -> None:
    result = et.render(scene, spp=1024, strategy="best", seed=5)
    squares = np.square(result.image - known.reference.mean) / known.reference.denominator
    assert math.sqrt(float(squares.mean())) == pytest.approx(known.error, rel=0.25)


def test_unlimited_paths_get_a_roulette() -> None:
    room = et.load(SCENES / "montelight" / "simple.toml").with_(size=(8, 8))
    name = render(room, error=0.5, seconds=1.0).facts["strategy"]
    assert Strategy.parse(str(name)).roulette == "throughput"


def test_what_is_written_comes_back(known: KnownReference, tmp_path: Path) -> None:
    write(tmp_path / "deeper" / "r.npz", known)
    back = read(tmp_path / "deeper" / "r.npz")
    assert back.facts["spp"] == known.facts["spp"]
    assert back.reference.halves is not None
    assert known.reference.halves is not None
    np.testing.assert_array_equal(back.reference.mean, known.reference.mean)
    np.testing.assert_array_equal(back.reference.variance, known.reference.variance)
    np.testing.assert_array_equal(back.reference.halves, known.reference.halves)
    assert [path.name for path in (tmp_path / "deeper").iterdir()] == ["r.npz"]


def test_a_damaged_reference_is_refused_by_name(known: KnownReference, tmp_path: Path) -> None:
    path = tmp_path / "r.npz"
    write(path, known)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ExperimentError, match=r"r\.npz: cannot be read as a reference"):
        read(path)


@pytest.mark.parametrize(
    "changes",
    [
        {"mean": np.zeros((8, 8))},
        {"mean": np.full((8, 8, 3), "a")},
        {"mean": np.full((8, 8, 3), np.nan)},
        {"variance": np.zeros((4, 8, 3))},
        {"half_1": np.zeros((8, 8, 3), np.float32)},
        {"facts": np.array("[]")},
    ],
)
def test_a_reference_of_other_numbers_is_refused_by_name(changes: dict[str, Any], tmp_path: Path) -> None:
    good = {name: np.zeros((8, 8, 3)) for name in ("mean", "variance", "half_0", "half_1")}
    path = tmp_path / "r.npz"
    arrays: dict[str, Any] = {"facts": np.array("{}"), **good}
    np.savez(path, **arrays)
    read(path)
    np.savez(path, **{**arrays, **changes})
    with pytest.raises(ExperimentError, match=r"r\.npz: cannot be read as a reference: expected images"):
        read(path)


@pytest.fixture
def rendered(monkeypatch: pytest.MonkeyPatch, known: KnownReference) -> list[float]:
    """Let references be rendered by taking one from the drawer, and tell what errors were asked for."""
    asked: list[float] = []

    def take(scene: Scene, error: float, seconds: float, *_: object) -> KnownReference:
        asked.append(error)
        facts = {**known.facts, "seconds_allowed": seconds}
        return KnownReference(known.reference, facts)

    monkeypatch.setattr(references, "render", take)
    return asked


def test_a_reference_is_rendered_once(scene: Scene, rendered: list[float], tmp_path: Path) -> None:
    wish = ReferenceWish(error=0.1, seconds=20.0)
    first = obtain(scene, wish, tmp_path)
    again = obtain(scene, wish, tmp_path)
    assert rendered == [0.1]
    np.testing.assert_array_equal(first.reference.mean, again.reference.mean)


def test_one_that_is_not_good_enough_is_rendered_again(scene: Scene, rendered: list[float], tmp_path: Path) -> None:
    for error, seconds in ((0.1, 20.0), (0.2, 99.0), (0.01, 20.0), (0.01, 30.0)):
        obtain(scene, ReferenceWish(error=error, seconds=seconds), tmp_path)
    assert rendered == [0.1, 0.01]  # the third had as much time before, and would end where it did


def test_another_scene_has_another_reference(scene: Scene, rendered: list[float], tmp_path: Path) -> None:
    obtain(scene, ReferenceWish(error=0.1), tmp_path)
    obtain(scene.with_(max_depth=4), ReferenceWish(error=0.1), tmp_path)
    assert len(rendered) == 2


def test_a_damaged_cache_counts_as_none(scene: Scene, rendered: list[float], tmp_path: Path) -> None:
    (tmp_path / f"{scene.digest}.npz").write_bytes(b"PK")
    obtain(scene, ReferenceWish(error=0.1), tmp_path)
    obtain(scene, ReferenceWish(error=0.1), tmp_path)
    assert len(rendered) == 1


def test_a_reference_of_another_build_counts_as_none(scene: Scene, rendered: list[float], tmp_path: Path) -> None:
    known = obtain(scene, ReferenceWish(error=0.1), tmp_path)
    write(tmp_path / f"{scene.digest}.npz", KnownReference(known.reference, {**known.facts, "core": "another"}))
    obtain(scene, ReferenceWish(error=0.1), tmp_path)
    assert len(rendered) == 2


def test_a_cache_that_cannot_be_written_to_is_none(scene: Scene, rendered: list[float], tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    obtain(scene, ReferenceWish(error=0.1), tmp_path / "file")
    assert len(rendered) == 1


def test_the_cache_is_where_the_desktop_wants_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "equaltime" / "references"


def test_an_image_can_be_the_reference_and_its_standard_errors_its_noise(scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "r.exr"
    image, error = np.full((24, 24, 3), 0.5, np.float32), np.full((24, 24, 3), 0.01, np.float32)
    RenderFile(image, error, np.ones((24, 24), np.int64), {}, Window(0, 0, 24, 24)).write(path)
    known = obtain(scene, ReferenceWish(file=path))
    np.testing.assert_allclose(known.reference.mean, 0.5)
    np.testing.assert_allclose(known.reference.variance, 1e-4, rtol=2.0**-5)
    assert known.facts["file"] == str(path)


def test_a_pixel_of_the_reference_that_is_not_finite_is_named(scene: Scene, tmp_path: Path) -> None:
    image = np.ones((24, 24, 3), np.float32)
    image[3, 7] = np.nan
    images.write_exr(tmp_path / "r.exr", image)
    with pytest.raises(ExperimentError, match=r"reference\.file: .*r\.exr: pixel 7,3 is not finite"):
        obtain(scene, ReferenceWish(file=tmp_path / "r.exr"))


def test_an_image_of_another_size_is_refused(scene: Scene, known: KnownReference, tmp_path: Path) -> None:
    write(tmp_path / "r.npz", known)
    with pytest.raises(ExperimentError, match=r"reference\.file: .*r\.npz is 24x24, but the image is 12x12"):
        obtain(scene.with_(size=(12, 12)), ReferenceWish(file=tmp_path / "r.npz"))
    with pytest.raises(ExperimentError, match=r"reference\.file: .*missing\.exr: no such file"):
        obtain(scene, ReferenceWish(file=tmp_path / "missing.exr"))


def test_the_page_of_experiments_tells_strategy_seeds_and_limits_of_a_reference() -> None:
    page = (SCENES / "experiments" / "README.md").read_text()
    told = " ".join(page.partition("### References\n")[2].partition("\n### ")[0].split())
    fixed, wish = Strategy.parse(references.REFERENCE_STRATEGY), ReferenceWish()
    assert fixed == Strategy.parse("mis,lights=power")
    assert fixed.sampler == "independent"
    assert "always `mis,lights=power` with independent samples" in told
    assert f"`reference.error` ({100 * wish.error:g} %), or after `reference.seconds` ({wish.seconds:g} s)" in told
    assert min(references._SEEDS) > 2**63
    assert "seeds of a reference, which are above 2^63" in told


@pytest.mark.filterwarnings("ignore:with . repeat:equaltime.EqualtimeWarning")
def test_the_reference_of_an_experiment_s_folder_can_be_kept_for_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the page says: the file of the folder, or a render whose seed no run has."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    box: dict[str, Any] = {"path": str(SCENES / "cornell-box.toml"), "name": "box", "size": [16, 16], "max_depth": 3}
    common: dict[str, Any] = {"scenes": [box], "spp": [2, 4], "repeats": 3, "targets": ["50%"]}
    wish = {"error": 0.1, "seconds": 5.0}
    first = et.cost(et.Experiment(**common, strategies=["mis", "best"], reference=wish), tmp_path / "a")
    file = tmp_path / "a" / "references" / "box.npz"
    assert (known := read(file)).error == pytest.approx(first.scenes[0].reference_error)
    exr = tmp_path / "reference.exr"
    et.render(et.load(SCENES / "cornell-box.toml").with_(size=(16, 16), max_depth=3), spp=256, seed=2**32).save(exr)
    for number, path in enumerate((file, exr)):
        own = et.Experiment(**common, strategies=["mis", "best"], reference={"file": path})
        again = et.cost(own, tmp_path / str(number)).scenes[0]
        assert 0.0 < again.reference_error < 0.5
        assert path != file or again.reference_error == pytest.approx(known.error)
