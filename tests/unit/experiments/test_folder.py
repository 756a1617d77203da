"""The folder of an experiment: tidying leaves alone what others write."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from equaltime.errors import ExperimentError
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.run.folder import ExperimentFolder


def test_tidying_removes_what_a_killed_experiment_was_writing_and_nothing_else(tmp_path: Path) -> None:
    part = f".equaltime-{os.uname().nodename}-17-7f.part"
    ours = [part, f"figures/{part}", f"references/{part}", f"images/room/{part}"]
    others = [".equaltime-elsewhere-17-7f.part", f"more/{part}", "images/room/a.npy"]
    for name in (*ours, *others):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    ExperimentFolder(tmp_path).tidy()
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()) == sorted(others)


@pytest.mark.parametrize(
    ("content", "place"),
    [
        ("[]", ""),
        ('{"references": 5}', ": references"),
        ('{"references": {"box": 5}}', ": references.box"),
        ('{"references": {"box": {"caveat": 5}}}', ": references.box"),
        ('{"own_depths": {"box": {"max_depth": "8"}}}', ": own_depths.box"),
        ('{"workers": {"tcp://a:1": {"host": 5}}}', ": workers.tcp://a:1"),
        ('{"workers": {"tcp://a:1": {"ran": 5}}}', ": workers.tcp://a:1"),
        ('{"agreements": {"box": {"mitsuba": []}}}', ": agreements.box.mitsuba"),
        ('{"agreements": {"box": {"mitsuba": {"agrees": "no"}}}}', ": agreements.box.mitsuba"),
        ('{"agreements": {"box": {"mitsuba": {"p": "0"}}}}', ": agreements.box.mitsuba"),
    ],
)
def test_a_damaged_provenance_is_an_error_with_its_place(tmp_path: Path, content: str, place: str) -> None:
    (tmp_path / "provenance.json").write_text(content)
    with pytest.raises(ExperimentError) as caught:
        ExperimentFolder(tmp_path).read_provenance()
    assert str(caught.value).startswith(f"{tmp_path}/provenance.json{place}: is damaged; put a copy of the file there")


def test_json_that_is_nested_without_end_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "provenance.json").write_text("[" * 100_000)
    with pytest.raises(ExperimentError, match=r"provenance\.json: cannot be read"):
        ExperimentFolder(tmp_path).read_provenance()


@pytest.mark.parametrize("identity", ["5", "[]", "{}", '{"scenes": [], "strategies": {}}', "null"])
def test_a_damaged_identity_is_an_error_with_its_place(tmp_path: Path, identity: str) -> None:
    (tmp_path / "experiment.json").write_text(f'{{"identity": {identity}}}')
    with pytest.raises(ExperimentError, match=r"experiment\.json: identity: is damaged; put a copy of the file there"):
        ExperimentFolder(tmp_path).claim({"scenes": {}, "strategies": {}}, Experiment.model_construct())
