"""Records and images of made-up runs of strategies whose speed, bias and tails are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import Row
from equaltime.images.metrics import Reference, measure

Array = NDArray[np.float64]


SIZE, REPEATS, TARGETS = 64, 6, (0.2, 0.1, 0.01)


SPP = (2, 4, 8, 16, 32, 64)


TRUTH = np.ones((SIZE, SIZE, 3))


@dataclass(frozen=True)
class Kind:
    """A strategy: its error is 1 / sqrt(spp), plus a bias; a sample takes 1 / speed seconds."""

    name: str
    speed: float = 1.0
    bias: float = 0.0
    heavy: bool = False
    estimate: bool = True

    def image(self, seed: int) -> list[Array]:
        """Return the images at all checkpoints."""
        rng = np.random.default_rng(seed)
        shape = (SPP[-1], SIZE, SIZE, 1)
        noise = (rng.pareto(2.2, shape) - 1.0 / 1.2) / 5.0 if self.heavy else rng.standard_normal(shape)
        return [TRUTH * (1.0 + self.bias + noise[:spp].mean(axis=0)) for spp in SPP]


KINDS = {
    "naive": Kind("naive,sampler=independent", speed=0.1),
    "best": Kind("best"),
    "cut": Kind("best,truncate=2", speed=4.0, bias=0.2),
    "fireflies": Kind("best,technique=bsdf", heavy=True, estimate=False),
}


def rows_of(label: str, kind: Kind, folder: ExperimentFolder, reference: Reference) -> list[Row]:
    rows = []
    for repeat in range(REPEATS):
        pictures = kind.image(1000 * list(KINDS).index(label) + repeat)
        path = folder.image("box", label, repeat)
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, pictures[-1].astype(np.float32))
        drift = 1.0 + 0.02 * repeat
        for number, (spp, picture) in enumerate(zip(SPP, pictures, strict=True)):
            last = number == len(SPP) - 1
            rows.append(
                Row(
                    scene="box",
                    digest="abc",
                    width=SIZE,
                    height=SIZE,
                    crop=(0, 0, SIZE, SIZE),
                    max_depth=8,
                    strategy=label,
                    name=kind.name,
                    renderer="core",
                    biased="truncate" in kind.name,
                    repeat=repeat,
                    seed=repeat,
                    checkpoint=number,
                    spp=spp,
                    wall_s=drift * spp / kind.speed,
                    cpu_s=2.0 * spp,
                    setup_s=0.1,
                    threads=2,
                    paths=None,
                    rays=None,
                    shadow_rays=None,
                    relmse=measure(picture, reference, ["relmse"])["relmse"].value,
                    mse=None,
                    mare=None,
                    flip=None,
                    reference_relmse=reference.relmse,
                    estimate=spp**-0.5 if kind.estimate else None,
                    estimate_low=0.9 * spp**-0.5 if kind.estimate else None,
                    estimate_high=1.1 * spp**-0.5 if kind.estimate else None,
                    last=last,
                    image=path.relative_to(folder.path).as_posix() if last else None,
                    machine="m",
                    build="b",
                    started="2024-01-01T00:00:00Z",
                )
            )
    return rows


def experiment(labels: tuple[str, ...] = tuple(KINDS), baseline: str = "naive") -> Experiment:
    scene = {"name": "box", "path": "box.toml"}
    strategies = [{"label": label, "strategy": "best"} for label in labels]
    return Experiment.model_validate(
        {"scenes": [scene], "strategies": strategies, "baseline": baseline, "targets": list(TARGETS), "budget": 20.0}
    )


def changed(rows: list[Row], label: str, **values: Callable[[Row], object]) -> list[Row]:
    """Return the rows with some numbers of one strategy changed."""
    return [
        replace(row, **{name: change(row) for name, change in values.items()}) if row.strategy == label else row
        for row in rows
    ]
