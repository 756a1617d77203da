"""The command ``equaltime info``: prints the contents of a scene, of a saved render or of an experiment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from rich.table import Table

from equaltime.cli.info_experiment import (
    experiment_facts,
    experiment_summary,
    experiment_table,
    folder_facts,
    folder_summary,
    folder_table,
    verdicts,
)
from equaltime.cli.info_picture import picture_facts, picture_summary
from equaltime.cli.info_render import bright_dots, saved_render
from equaltime.cli.info_scene import scene_summary
from equaltime.cli.lines import in_columns
from equaltime.cli.messages import plain_console, print_json, print_lines, print_remarks
from equaltime.cli.options import AsJson, Define, Substitute, Verbose, parse_definitions
from equaltime.errors import ImageError, SceneError, StrategyError
from equaltime.examples import example_of
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.reader import is_experiment, make_experiment
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.stored import StoredExperiment, stored_experiments
from equaltime.images import preview
from equaltime.images.image_files import extension
from equaltime.rendering.render_file import holds_film, read_picture
from equaltime.rendering.render_record import checked
from equaltime.scene import Scene, SceneModel, load_file
from equaltime.scene.scene import named_files
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy
from equaltime.words import duration

__all__ = ["info"]

FAMILIES: Final = ("shape", "bsdf", "texture", "emitter", "medium")
"""Families of a scene's plugins whose objects ``equaltime info`` counts."""
_OF_RENDERS: Final = (
    *("scene", "digest", "size", "crop", "max_depth", "scene_max_depth", "strategy", "strategy_in_full", "biased"),
    *("without", "frame", "seed", "decision", "sources", "spp", "stopped_by", "error", "radiance_range", "seconds"),
    *("paths", "rays", "shadow_rays", "threads", "kernel", "effects", "substitutions", "software", "build"),
    "revisions",
)
"""Keys of a saved render's record that are printed, and the strategy with all its keys."""
_TITLES: Final = {"rays": "camera and bounce rays"}
"""Names of the keys whose own words say too little: shadow rays have a line of their own."""


def info(
    scene: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Scene file: TOML, Mitsuba 3 XML, glTF, OBJ or PLY; a saved render, OUT.exr; its picture, OUT.png "
            "or OUT.jpg; an experiment file; or the DIR of equaltime cost.",
            show_default=False,
        ),
    ],
    define: Define = None,
    substitute: Substitute = False,
    verbose: Verbose = False,
    as_json: AsJson = False,
) -> int:
    """Describe a scene, or how a saved render or an experiment was made and the command that would repeat it.

    For instance:

    * `equaltime info scene.toml`

    * `equaltime info out.exr`

    * `equaltime info report`, after `equaltime cost scene.toml -o report`

    * `equaltime info x3-light.toml`, an experiment: what it would run, and how long that takes
    """
    if extension(scene) == ".exr":
        return _of_render(scene, verbose, as_json)
    if extension(scene) in preview.EXTENSIONS:
        return _of_picture(scene, as_json)
    definitions = parse_definitions(define or ())
    if scene.is_dir():
        if definitions or substitute:
            raise typer.BadParameter("--define and --substitute are for scenes, not for a folder")
        return _of_folder(scene, verbose, as_json)
    try:
        loaded = load_file(scene, definitions, substitute=substitute)
    except SceneError:
        path = example_of(scene) or scene
        if not is_experiment(path):
            raise
        return _of_experiment(path, make_experiment(path, define=definitions, substitute=substitute), verbose, as_json)
    print_remarks(loaded)
    facts = _facts(loaded)
    if as_json:
        print_json(facts)
        return 0
    print_lines([*scene_summary(loaded, facts, verbose)])
    if verbose:
        print_lines(["", *in_columns(_rows(facts))])
    return 0


def _rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield name and value of each fact of a scene."""
    for name, value in facts.items():
        if name == "extensions":
            yield from value.items()
        elif name == "plugins":
            for family, counts in value.items():
                yield family, ", ".join(f"{count:,} {plugin}" for plugin, count in counts.items()) or "none"
        elif name == "files":
            yield name, f"{len(value):,}, {sum(value.values()):,} bytes" if value else "none"
        elif value is not None and not (name == "substitutions" and not value):
            yield name.replace("_", " "), "x".join(map(str, value)) if name == "size" else _in_words(value)


def _of_render(path: Path, verbose: bool, as_json: bool) -> int:
    record = read_picture(path).record
    if not record:
        raise ImageError(f"{path}: was not rendered by equaltime")
    if as_json:
        print_json(record)
        return 0
    print_lines([*saved_render(path, record, holds_film(path), verbose)])
    if verbose:
        print_lines([*bright_dots(path, record)])
        with suppress(StrategyError):  # of another version
            record = {**record, "strategy_in_full": Strategy.parse(checked(record, path)["strategy"]).in_full}
        told = (name for name in _OF_RENDERS if record.get(name) not in (None, [], False))
        titles = {name: _TITLES.get(name, name.replace("_", " ")) for name in told}
        rows = ((title, _of_record(name, record[name]) + _range(name, record)) for name, title in titles.items())
        print_lines(["", *in_columns(rows)])
    return 0


def _of_picture(path: Path, as_json: bool) -> int:
    facts = picture_facts(path)
    if as_json:
        print_json(facts)
    else:
        print_lines([*picture_summary(facts)])
    return 0


def _of_folder(folder: Path, verbose: bool, as_json: bool) -> int:
    """Describe the experiment in a folder, or those in its subfolders."""
    if not ExperimentFolder(folder).experiment.exists():
        found = stored_experiments(folder)
        if as_json:
            print_json({"experiments": [folder_facts(stored) for stored in found]})
        else:
            print_lines([*verdicts(folder, found)])
        return 0
    stored = StoredExperiment.read(folder)
    if as_json:
        print_json(folder_facts(stored))
        return 0
    print_lines([*folder_summary(stored, verbose)])
    if verbose:
        _print_more(folder_table(stored))
    return 0


def _of_experiment(path: Path, experiment: Experiment, verbose: bool, as_json: bool) -> int:
    scenes = experiment.load_scenes()
    if as_json:
        print_json(experiment_facts(path, experiment, scenes))
        return 0
    print_lines([*experiment_summary(path, experiment, scenes, verbose)])
    if verbose:
        _print_more(experiment_table(experiment))
    return 0


def _print_more(parts: Iterable[Table | str]) -> None:
    for part in parts:
        plain_console().print("", part, sep="\n", soft_wrap=isinstance(part, str), markup=False, highlight=False)


def _range(name: str, record: Mapping[str, Any]) -> str:
    """Return the least and the most samples of a pixel, behind their mean if they differ; empty for other facts."""
    samples = record["samples"]
    if name != "spp" or samples["min"] == samples["max"]:
        return ""
    return f", the mean of {samples['min']:,} to {samples['max']:,}: more where it is noisy"


def _of_record(name: str, value: Any) -> str:
    if name == "error":
        return f"{Interval.from_dict(value):%}"
    if name == "seconds":
        return duration(value)
    if name in ("max_depth", "scene_max_depth") and value < 0:
        return "no limit"
    if name == "radiance_range":
        return f"{value:.2g}, the brightest value over the darkest above 0"
    if name == "sources":
        return ", ".join(f"seed {source['seed']}: {source['samples']['max']} spp" for source in value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {'none' if said is None else said}" for key, said in value.items())
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        return {"size": "x", "crop": ","}.get(name, ", ").join(map(str, value))
    counts = isinstance(value, int) and not isinstance(value, bool) and name != "seed"
    return f"{value:,}" if counts else str(value)


def _facts(scene: Scene) -> dict[str, Any]:
    core = scene.core
    model = scene.model
    return {
        "scene": None if scene.source is None else str(scene.source),
        "digest": scene.digest,
        "size": list(scene.size),
        "max_depth": scene.max_depth,
        "spp": scene.spp,
        "shapes": core.shapes,
        "triangles": core.triangles,
        **({"instances": core.instances} if core.instances else {}),
        "lights": core.lights,
        "memory_bytes": core.memory_bytes,
        "integrator": model.integrator.type,
        "sensor": model.sensor.type,
        "filter": model.sensor.film.rfilter.type,
        "plugins": _plugins(model),
        "files": {str(path): path.stat().st_size for path in named_files(scene)},
        "effects": [name for name, used in core.effects().items() if used],
        "substitutions": [str(substitution) for substitution in scene.substitutions],
        **({} if scene.extensions is None else {"extensions": scene.extensions}),
        "phases": dict(scene.timings),
    }


def _plugins(model: SceneModel) -> dict[str, dict[str, int]]:
    """Return family → plugin → number of uses; an object used in several places counts once."""
    found: dict[str, dict[str, int]] = {family: {} for family in FAMILIES}
    for node in {id(node): node for node in model.nodes() if node.kind in found}.values():
        counts = found[node.kind]
        counts[node.title] = counts.get(node.title, 0) + 1
    return {family: dict(sorted(counts.items())) for family, counts in found.items()}


def _in_words(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{phase} {duration(seconds)}" for phase, seconds in value.items())
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"
    return f"{value:,}" if isinstance(value, int) else str(value)
