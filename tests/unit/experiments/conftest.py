"""Fixtures: the records of made-up runs, and their summary."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from equaltime.experiments.analysis.summarise import summarise
from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import Row
from equaltime.experiments.run.reference import KnownReference, write
from equaltime.images.metrics import Reference

from .made_up_records import KINDS, TRUTH, experiment, rows_of


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Row]]:
    folder = ExperimentFolder(tmp_path_factory.mktemp("cost"))
    rng = np.random.default_rng(99)
    halves = (TRUTH + 0.01 * rng.standard_normal(TRUTH.shape), TRUTH + 0.01 * rng.standard_normal(TRUTH.shape))
    reference = Reference(0.5 * (halves[0] + halves[1]), np.full(TRUTH.shape, 0.5e-4), halves)
    write(folder.reference("box"), KnownReference(reference, {}))
    return folder.path, [row for label, kind in KINDS.items() for row in rows_of(label, kind, folder, reference)]


@pytest.fixture(scope="module")
def summary(recorded: tuple[Path, list[Row]]) -> Summary:
    return summarise(experiment(), recorded[1], recorded[0])


@pytest.fixture(scope="module")
def strategies(summary: Summary) -> Mapping[str, StrategyResult]:
    return {strategy.label: strategy for strategy in summary.scenes[0].strategies}
