"""Origin of a render: everything that decides its bits except the sample counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from equaltime.images.image_files import Window
from equaltime.rendering.film_picture import FilmPicture
from equaltime.scene.frames import Frame
from equaltime.strict_json import to_json

__all__ = ["Origin"]


@dataclass(frozen=True)
class Origin:
    """Everything that decides the bits of a render except the sample counts, to repeat, resume or merge the render."""

    scene: str | None
    """The scene's file, as an absolute path; None for a scene made in memory."""
    digest: str
    """SHA-256 of the scene's content."""
    window: Window
    """Position (x, y) of the image's first pixel on the full film, and width and height of that film, in pixels."""
    max_depth: int
    """Length of the longest paths in the image, counted as Mitsuba's ``max_depth``; -1 if there is no limit."""
    strategy: str
    """The strategy's name; `Strategy.parse` reads it."""
    biased: bool
    seed: int
    replicates: int
    """Number of replicates: parts of each pixel's samples whose differences give the error."""
    backend: str
    """Renderer: ``core``, or ``embreex`` for the cross-check."""
    without: tuple[str, ...] = ()
    """Names of the effects that were left out, such as ``media``; the render is biased if there are any."""
    substitutions: tuple[str, ...] = ()
    """Parts of the scene that were replaced because they cannot be rendered."""
    sources: tuple[Mapping[str, Any], ...] = field(default=(), hash=False)
    """Sample counts, seconds and build for each seed of a merged render; empty for a render that was not merged."""
    nets: int = 2
    """Number of independent nets (low-discrepancy point sets) that a pixel's samples form. If it is the number of
    replicates, the replicates are independent; else it is 1, and they are halves of one net."""
    numbers: int = 1
    """Version of the sampler's numbers: samples of two versions do not form one point set."""
    second_net: int = 0
    """k, if one of k pixels has a second net: further samples, not in the image, that show its noise. 0 if there are
    none."""
    scene_max_depth: int | None = None
    """The ``max_depth`` that the scene asks for, which may differ from ``max_depth`` here; None if unknown."""
    transparent: bool = False
    """Whether the user asked for a transparent background, beside what the scene's film asks for."""
    defines: Mapping[str, str] = field(default_factory=dict, compare=False, hash=False)
    """Values for the variables of the scene's file, as text; the digest already contains what they change."""
    frame: Frame | None = field(default=None, compare=False)
    """Frame of an animation that the image shows; None for other renders. The digest already contains what the frame
    changes."""
    picture: FilmPicture = field(default_factory=FilmPicture, compare=False)
    """Form of the picture that the film asks for; the bits of the render do not depend on it."""

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Origin:
        """Return the origin of a render from its record (JSON data that tell how it was made).

        The record must be complete, as `equaltime.rendering.render_record.checked` returns it.
        """
        return cls(
            scene=record["scene"],
            digest=record["digest"],
            window=Window(*record["crop"][:2], *record["size"]),
            max_depth=record["max_depth"],
            strategy=record["strategy"],
            biased=record["biased"],
            seed=record["seed"],
            replicates=record["replicates"],
            backend=record["backend"],
            without=tuple(record["without"]),
            substitutions=tuple(record["substitutions"]),
            sources=tuple(record["sources"]),
            nets=record["nets"],
            numbers=record["numbers"],
            second_net=record["second_net"],
            scene_max_depth=record["scene_max_depth"],
            transparent=record["transparent"],
            defines=record["defines"],
            frame=_frame(record["frame"]),
            picture=FilmPicture.from_dict(record["picture"]),
        )

    @property
    def record(self) -> dict[str, Any]:
        """Return the origin as JSON data, as a part of the data that a result's file states on how it was made."""
        return {
            "scene": self.scene,
            "digest": self.digest,
            "size": [self.window.full_width, self.window.full_height],
            "max_depth": self.max_depth,
            "scene_max_depth": self.scene_max_depth,
            "strategy": self.strategy,
            "biased": self.biased,
            "seed": self.seed,
            "replicates": self.replicates,
            "nets": self.nets,
            "numbers": self.numbers,
            **({"second_net": self.second_net} if self.second_net else {}),
            "backend": self.backend,
            **({"without": list(self.without)} if self.without else {}),
            **({"transparent": True} if self.transparent else {}),
            **({"defines": dict(self.defines)} if self.defines else {}),
            **({} if self.frame is None else {"frame": asdict(self.frame)}),
            "substitutions": list(self.substitutions),
            "sources": [dict(source) for source in self.sources],
            **({} if self.picture == FilmPicture() else {"picture": to_json(self.picture)}),
        }


def _frame(record: Mapping[str, Any] | None) -> Frame | None:
    return None if record is None else Frame(record["number"], record["fps"], record["blur"])
