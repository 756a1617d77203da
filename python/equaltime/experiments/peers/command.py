"""A peer (another renderer) that is any command that writes an image: the way to add your own renderer.

::

    [[strategies]]
    label = "mine"
    peer.command = "./mine {scene} --samples {spp} --seed {seed} --output {out}"

The command is split as by a shell (quotes work) and run without a shell. Words in braces are replaced:

- ``{out}``     image file to write: linear RGB, row 0 at the top, in any format that OpenImageIO reads. The name ends
  in ``.exr`` or in the suffix that follows, as in ``{out}.pfm``
- ``{spp}``     samples per pixel
- ``{seed}``    31-bit seed; different seeds must give independent images
- ``{scene}``   the scene's original file, without the experiment's changes
- ``{json}``    file with the whole scene, changes included: see `equaltime.scene.export.plain`
- ``{width}``, ``{height}``, ``{max_depth}``   size of the image in pixels, and largest depth of paths
- ``{filter}``  pixel filter to use: always ``box``, whatever filter the scene's file has
- ``{python}``  the Python that runs equaltime
- ``{threads}`` threads to use: the number asked for, else the processors that the machine or container allows. A number
  that was asked for also confines the command to that many processors

The command's stdout may end in a JSON object like that of ``equaltime render --json``.
Then the object's ``seconds`` and ``cpu_seconds`` count as the times of rendering, and ``spp`` as the samples taken.
Without the object, the time is that of the whole process, loading included.

A command that exceeds its time limit is ended with its process group, and the experiment stops with an error. The limit
is 20 times the experiment's budget plus 60 seconds, or one hour if the experiment gives sample counts. The limit is
never less than ``reference.seconds`` plus 60 seconds. ``peer.limit = "30min"`` sets another limit.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError, PeerError
from equaltime.experiments.peers.common import checked_image, render_seed, uneven_samples, with_box_filter
from equaltime.experiments.peers.process import DEFAULT_LIMIT, end, ending, limited, tail
from equaltime.images import image_files as images
from equaltime.machine import allowed_processors, worker_threads
from equaltime.rendering.core_subject import Point, RendererKind
from equaltime.scene import Scene
from equaltime.scene.export.plain import mitsuba_dict
from equaltime.strict_json import json_text

__all__ = ["WORDS", "CommandPeer"]

WORDS = ("scene", "json", "spp", "seed", "out", "width", "height", "max_depth", "filter", "threads", "python")
"""Words that the command of another renderer may contain in braces, where values are filled in."""
NEEDED = ("spp", "seed", "out")
_WORD = re.compile(r"\{(\w*)\}")
_OUT = re.compile(r"\{out\}(\.\w+)?")


@dataclass
class CommandPeer:
    """A renderer that is a command, run once per image: the way to add any other renderer to an experiment.

    Raises PeerError if the command is invalid.
    """

    label: str
    command: str
    folder: Path = Path()
    """Folder in which the command runs."""
    limit: float = DEFAULT_LIMIT
    """Longest time of one run of the command, in seconds; a longer run is ended."""
    renderer: RendererKind = field(default="command", init=False)
    biased: bool = field(default=False, init=False)
    _arguments: list[str] = field(init=False, repr=False)
    _scene: Scene | None = field(default=None, init=False, repr=False)
    _threads: int = field(default=0, init=False, repr=False)

    def __post_init__(self) -> None:
        try:
            self._arguments = shlex.split(self.command)
        except ValueError as error:
            raise PeerError(f"{self.label}: the command cannot be split into words: {error}: {self.command}") from error
        words = set(_WORD.findall(self.command))
        if unknown := sorted(words - set(WORDS)):
            raise PeerError(f"{self.label}: unknown word {{{unknown[0]}}} in the command; known are {_braced(WORDS)}")
        if missing := [word for word in NEEDED if word not in words]:
            raise PeerError(f"{self.label}: the command must contain {_braced(missing)}: {self.command}")

    @property
    def name(self) -> str:
        """Name of this renderer in results: the command on one line."""
        return " ".join(self.command.split())

    @property
    def resizable(self) -> bool:
        """Whether the command learns the image size, from ``{json}`` or from ``{width}`` and ``{height}``."""
        return "{json}" in self.command or ("{width}" in self.command and "{height}" in self.command)

    def prepare(self, scene: Scene, threads: int) -> float:
        """Keep the scene, with a box filter, for later runs; return the set-up time, which is 0 seconds.

        Raises PeerError if the program is missing, or if the command needs a scene file and there is none.
        """
        if "{scene}" in self.command and scene.source is None:
            raise PeerError(
                f"{self.label}: {{scene}} needs a scene file, but this scene was made in memory; use {{json}} instead"
            )
        program = self._arguments[0].replace("{python}", sys.executable)
        place = self.folder / program if "/" in program else program
        if shutil.which(place) is None:
            raise PeerError(f"{self.label}: there is no program {place} that can be run")
        self._scene, self._threads = with_box_filter(scene), threads
        return 0.0

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Point]:
        """Run the command for each sample count per pixel in ``ladder``, and yield each image with its time and count.

        The first run that takes ``seconds`` or longer is the last.
        """
        done = 0
        for spp in ladder:
            checkpoint = self._render(spp, seed)
            if checkpoint.spp > done:  # skip a count that the renderer rounded to the last one
                done = checkpoint.spp
                yield checkpoint
            if seconds is not None and checkpoint.wall_s >= seconds:
                return

    def _render(self, spp: int, seed: int) -> Point:
        assert self._scene is not None, "prepare comes first"
        with tempfile.TemporaryDirectory() as folder:
            arguments, out = self._filled(Path(folder), self._scene, spp, seed)
            wall, cpu, said = self._call(arguments, self._threads)
            picture = self._picture(out)
            image = checked_image(self._image(picture), self._scene, self.label)
            samples = uneven_samples(picture.samples, self._scene)
        times = {"seconds": wall, "cpu_seconds": cpu, "spp": spp} | said
        paths = int(times["spp"]) * image.shape[0] * image.shape[1] if samples is None else int(samples.sum())
        return Point(int(times["spp"]), times["seconds"], times["cpu_seconds"], image, paths=paths, samples=samples)

    def _filled(self, folder: Path, scene: Scene, spp: int, seed: int) -> tuple[list[str], Path]:
        """Return the arguments with all words filled in, and the path of the image."""
        suffix = next((match[1] for part in self._arguments if (match := _OUT.search(part)) and match[1]), "")
        _, _, width, height = scene.model.sensor.film.crop
        values = {
            "scene": "" if scene.source is None else str(scene.source.absolute()),
            "json": str(folder / "scene.json"),
            "spp": str(spp),
            "seed": str(render_seed(seed, spp)),
            "out": str(folder / ("image" if suffix else "image.exr")),
            "width": str(width),
            "height": str(height),
            "max_depth": str(scene.max_depth),
            "filter": scene.model.sensor.film.rfilter.type,
            "python": sys.executable,
            "threads": str(worker_threads(self._threads)),
        }
        if "{json}" in self.command:
            integrator = {"type": "path", "max_depth": scene.max_depth}
            if scene.model.integrator.hides_emitters:
                integrator["hide_emitters"] = True
            try:
                plain = mitsuba_dict(scene.model, scene.assets) | {"integrator": integrator}
            except ValueError as error:
                raise PeerError(f"{self.label}: {error}") from error
            (folder / "scene.json").write_text(json_text(plain))
        filled = [_WORD.sub(lambda match: values[match[1]], part) for part in self._arguments]
        return filled, Path(values["out"] + suffix)

    def _call(self, arguments: list[str], threads: int) -> tuple[float, float, dict[str, Any]]:
        """Run the command to its end; return its wall and CPU seconds and the numbers that it prints."""
        with tempfile.TemporaryFile() as stdout, tempfile.TemporaryFile() as stderr:
            begin = perf_counter()
            with _confined(threads):
                process = subprocess.Popen(
                    arguments,
                    cwd=self.folder,
                    stdin=subprocess.DEVNULL,
                    stdout=stdout,
                    stderr=stderr,
                    start_new_session=True,
                )
            try:
                with limited(process, self.limit, self.label):
                    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # reaped below, after the timer
                _, status, usage = os.wait4(process.pid, 0)
                process.returncode = os.waitstatus_to_exitcode(status)
            except PeerError as error:
                process.wait()
                words = f"\n  {shlex.join(arguments)}{tail(stderr) or tail(stdout)}"
                raise PeerError(f"{error}{words}") from error
            except BaseException:
                end(process)
                raise
            wall = perf_counter() - begin
            if process.returncode != 0:
                raise PeerError(
                    f"{self.label}: the command ended with {ending(process.returncode)}: {shlex.join(arguments)}"
                    f"{tail(stderr) or tail(stdout)}"
                )
            return wall, usage.ru_utime + usage.ru_stime, self._said(stdout, wall)

    def _said(self, stdout: IO[bytes], wall: float) -> dict[str, Any]:
        """Return the numbers of the JSON object at the end of stdout; raises PeerError for an impossible number."""
        stdout.seek(0)
        text = stdout.read().decode(errors="replace").strip()
        said = _json_object(text) or _json_object(text[text.rfind("\n") + 1 :])
        numbers = {name: said[name] for name in ("seconds", "cpu_seconds", "spp") if name in said}
        for name, value in numbers.items():
            most = wall if name == "seconds" else 2**32
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value <= most:
                of = f"; its process ran for {wall:.3g}" if name == "seconds" else ""
                raise PeerError(f"{self.label}: the command says that {name} is {value!r}{of}")
        return numbers

    def _picture(self, path: Path) -> images.Picture:
        """Read the image that the command wrote."""
        if not path.exists():
            raise PeerError(f"{self.label}: the command ended well and wrote no image to {{out}}: {self.command}")
        try:
            return images.read(path)
        except ImageError as error:
            raise PeerError(f"{self.label}: the image cannot be used: {error}") from error

    def _image(self, picture: images.Picture) -> NDArray[np.float32]:
        """Return the image (H, W, 3); one channel is grey."""
        if len(picture.channels) == 1:
            return np.repeat(next(iter(picture.channels.values()))[..., None], 3, axis=-1)
        try:
            return picture.image
        except ImageError as error:
            raise PeerError(f"{self.label}: the image cannot be used: {error}") from error


def _json_object(text: str) -> Mapping[str, Any]:
    try:
        value = json.loads(text)
    except json.JSONDecodeError:
        return {}
    return value if isinstance(value, dict) else {}


@contextmanager
def _confined(threads: int) -> Iterator[None]:
    """Confine processes started in this context to ``threads`` processors (0 for all), if the system can."""
    allowed = allowed_processors()
    confine = 0 < threads < len(allowed)
    try:
        if confine:
            os.sched_setaffinity(0, sorted(allowed)[:threads])
        yield
    finally:
        if confine:
            os.sched_setaffinity(0, allowed)


def _braced(words: Iterable[str]) -> str:
    return ", ".join(f"{{{word}}}" for word in words)
