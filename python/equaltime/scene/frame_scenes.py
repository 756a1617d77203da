"""Scenes of an animation's frames: the scene of a file, once for each frame, with the frame's shutter."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from equaltime.errors import Problem, SceneError
from equaltime.examples import example_of
from equaltime.scene.frames import Frame
from equaltime.scene.motion import still, times_of_keys
from equaltime.scene.scene import GLTF, Scene, load_file

__all__ = ["frames_of"]

_OF_AN_ANIMATION = ("shutter", "time")
"""Definitions of glTF files that choose the time."""

_SAME = (
    ": all frames would be the same; if the file was converted from glTF, convert again with -D shutter=0,LAST, which "
    "keeps the animation up to LAST seconds"
)

_JUST = 1e-9
"""Share by which rounding may take a frame's time beyond that of a key."""


def frames_of(
    path: str | Path, frames: Sequence[Frame], defines: Mapping[str, object], *, substitute: bool = False
) -> Iterator[Scene]:
    """Yield the scene in the file ``path`` once for each of the ``frames`` of an animation, with the frame's shutter.

    ``defines`` has values for the variables of the file. With ``substitute``, unsupported plugins are replaced by
    similar ones instead of being refused. glTF files are read anew for each frame, since their animations are sampled
    while the shutter is open.

    Raises
    ------
    SceneError
        If the scene is invalid, if nothing in it is animated, or if ``defines`` already chooses its time.
    """
    path = Path(path)
    if twice := next((name for name in _OF_AN_ANIMATION if name in defines), None):
        raise SceneError((Problem(str(path), f"the frames choose the time: leave '{twice}' out"),))
    if (example_of(path) or path).suffix.lower() in GLTF:
        for frame in frames:
            scene = load_file(path, {**defines, "shutter": frame.shutter}, substitute=substitute)
            given = {name: value for name, value in scene.defines.items() if name != "shutter"}
            yield dataclasses.replace(scene, defines=given, frame=frame)
        return
    scene = load_file(path, defines, substitute=substitute)
    if still(scene.model) is scene.model:
        raise SceneError((Problem(str(path), f"nothing in the scene is animated{_SAME}"),))
    if standing := _standing(frames, *times_of_keys(scene.model)):
        scene = dataclasses.replace(scene, warnings=(*scene.warnings, standing))
    for frame in frames:
        yield dataclasses.replace(scene.with_(shutter=frame.shutter), frame=frame)


def _standing(frames: Sequence[Frame], first: float, last: float) -> str:
    """Return a warning on frames whose shutter is open only before the first key or after the last; "" without any."""
    spans = [(frame.number, *frame.shutter) for frame in frames]
    numbers = [n for n, opens, closes in spans if opens > last * (1.0 + _JUST) or closes < first * (1.0 - _JUST)]
    if not numbers:
        return ""
    others = len(numbers) - 1
    named = f"frame {numbers[0]}" + (f" and {others} other{'s' * (others > 1)}" if others else "")
    stand = "stand" if others else "stands"
    return f"the animation lasts from {first:g} s to {last:g} s: {named}, outside that time, {stand} still"
