"""Result of a render: its image, its error, its cost and how it was made."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, standard_error
from equaltime.film.focus import Focus
from equaltime.film.moments import sample_variance
from equaltime.film.second_nets import SecondNets
from equaltime.film.unseen import FAR_APART, Unseen, stated_error
from equaltime.images import image_files as images
from equaltime.images import preview, variance_picture
from equaltime.images.exposure import AUTO, Exposure, automatic_stops, checked_exposure
from equaltime.images.float32 import as_float32, beyond_float32
from equaltime.rendering.budget import Look, Stop, StoppedBy
from equaltime.rendering.decision import Decision
from equaltime.rendering.film_picture import ALPHA
from equaltime.rendering.origin import Origin
from equaltime.rendering.output_files import AovPicture, check_output, keep_others, keep_work
from equaltime.rendering.picture_tag import to_repeat
from equaltime.rendering.render_file import FORMAT, RenderFile
from equaltime.rendering.stated import asked_samples, not_as_asked, paths_up_to, stated
from equaltime.statistics.in_words import count
from equaltime.statistics.intervals import Interval
from equaltime.strict_json import to_json
from equaltime.words import Shown, duration, duration_of_runs

__all__ = ["Result", "Stats", "make_result", "uninterrupted"]


def uninterrupted(result: Result) -> Result:
    """Return the result if it is complete; raise `KeyboardInterrupt` if Ctrl-C cut the render short.

    Measurements use it, since a render that Ctrl-C ended would falsify them.
    """
    if result.stopped_by == "interrupt":
        raise KeyboardInterrupt
    return result


@dataclass(frozen=True, repr=False)
class Stats(Shown):
    """Cost of a render: time, rays and paths, and the code that rendered it."""

    phases: Mapping[str, float] = field(hash=False)
    """Seconds of each phase: ``load`` and ``build`` of the scene, ``render`` (first sample to final film), and
    ``estimate`` of the error. ``render`` counts all runs of a resumed render, and other phases count only the last run.
    Some renders have more: ``pilot`` if short renders measured what leaving effects out
    changes, and ``stop_pilot`` if a short render chose the sample count. ``save`` is for checkpoints, and ``outputs``
    for outputs beside the image."""
    paths: int
    """Camera paths: one per sample."""
    rays: int
    """Rays traced to find the nearest surface."""
    shadow_rays: int
    """Rays traced to test whether any surface is in the way."""
    kernel: str
    """Name of the compiled path tracer that was chosen for the scene."""
    threads: int
    effects: tuple[str, ...] = ()
    """Names of the effects (features such as media) that the scene uses."""
    build: Mapping[str, Any] | None = field(default=None, hash=False)
    """Facts of the build of the core, such as its compiler and the version of Embree."""
    cluster: str = ""
    """Numbers of processes, units of work and processor seconds on a cluster, in words; empty for one process."""
    revisions: tuple[str, ...] = ()
    """Commits of equaltime that took the samples, in order, each once: one, or more if the render was resumed or merged
    (`equaltime.revision`)."""
    runs: int = 1
    """Number of runs that took the samples: 1, and 1 more for each time that the render was resumed; of merged renders,
    the sum."""

    def __str__(self) -> str:
        rate = f"{self.rays_per_second / 1e6:.3g} M rays/s"
        threads = f"{self.threads} thread{'s' if self.threads > 1 else ''}"
        spent = duration_of_runs(self.seconds, self.runs)
        lines = [f"{self.paths} paths in {spent}, {rate} on {threads}, kernel '{self.kernel}'"]
        return "\n".join([*lines, ", ".join(f"{phase} {duration(took)}" for phase, took in self.phases.items())])

    @property
    def seconds(self) -> float:
        """Seconds from the first sample to the final film, of all runs together."""
        return self.phases["render"]

    @property
    def rays_per_second(self) -> float:
        """Rays traced per second of rendering, shadow rays included."""
        return (self.rays + self.shadow_rays) / self.seconds if self.seconds > 0 else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """A rendered image with its error bar and its cost.

    Its arrays are read-only: copy an array to change it.
    """

    image: NDArray[np.float32]
    """(H, W, 3): linear RGB radiance; 0 where ``samples`` is 0."""
    standard_error: NDArray[np.float32]
    """(H, W, 3): standard error of each pixel, pooled over its 7x7 neighbourhood; ``inf`` where unknown. Near a lamp or
    an edge it may be many times the pixel's own. The standard deviation of ``image`` over renders with several seeds is
    always the pixel's own. Before the samples have met rare bright paths, such as to a tiny lamp, it may be 2 to 3
    times too small. The upper limit of ``error`` then includes the light that may be missing, as far as it is known."""
    samples: NDArray[np.int64]
    """(H, W): number of samples of each pixel. The indices of a pixel's samples begin at 0."""
    error: Interval
    """Relative error of the image: 0.02 is 2 %. Its interval holds the true error in at least 95 % of cases, since it
    allows for light that no sample has met. A bias that was measured is included. A bias that was not measured, and the
    light of paths longer than ``max_depth``, are not."""
    stats: Stats
    stopped_by: StoppedBy
    """Reason why the render ended: the sample count, the time limit, the error asked for, the ``count`` that a pilot
    (short render) chose for an error, Ctrl-C, or a sample that was not a number. ``unfinished`` marks a render saved on
    the way."""
    origin: Origin
    moments: NDArray[Any] | None = None
    """(R, H, W): count, mean and deviation of the samples of each pixel in each of R replicates (parts of the samples),
    of the type `equaltime.film.moments.DTYPE`. None for another backend."""
    looks: tuple[Look, ...] = ()
    """Looks, in order: estimates of the error at which a render with an error target might have stopped."""
    bias: Interval | None = None
    """Relative error due to the effects (features such as media) that were left out, as short renders measured it; None
    if there are none. The bias of `Strategy.truncate` is not measured."""
    position: tuple[int, int, int] | None = None
    """Position from which passes resume: samples per pixel completed (mean), samples of the blocks already done in the
    running pass, and index of the next block."""
    missed: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """Images of the light that samples may have missed, (H, W, C) by name: ``unseen`` and ``lamps``. Such light raises
    the error's upper limit (`equaltime.film.unseen`)."""
    stop: Stop | None = None
    """Rule by which this render, or the saved render that it resumed, stops at an error; None without an error target.
    """
    aovs: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """Outputs beside the image that the integrator asks for: channels (H, W) by name."""
    degrees: float = 1.0
    """Degrees of freedom of the estimated variance of each pixel: the number of replicates (parts of a pixel's samples)
    less 1. For a merged render, each pixel has its own degrees (`equaltime.film.parts_of_merge`), and this is their
    harmonic mean."""
    parts: NDArray[Any] | None = None
    """(H, W): sums over the merged renders, from which variances follow (`equaltime.film.parts_of_merge`); None if the
    render was not merged."""
    common_doubt: float = 0.0
    """Relative standard deviation of a factor that the estimated variances of all pixels have in common. The factor is
    measured in few pixels, by further samples (`equaltime.film.second_nets`). 0 if there is no such factor."""
    second: SecondNets | None = None
    """Second nets: further samples of some pixels, not in the image, that show its noise
    (`equaltime.film.second_nets`). None if there are none."""
    decision: Decision = field(default_factory=Decision)
    """Decisions that the strategy left to the render: on splitting of paths, and on sample counts of pixels."""
    focus: Focus = field(default_factory=Focus.none)
    """Light that specular surfaces focus, which may put the error in doubt."""
    saved: Path | None = None
    """File from which the render was read, as an absolute path; None if it was rendered or merged just now."""

    def __post_init__(self) -> None:
        """Make the arrays read-only: image, error and moments describe each other. Errors print in per cent."""
        object.__setattr__(self, "error", self.error.in_unit("%"))
        object.__setattr__(self, "bias", None if self.bias is None else self.bias.in_unit("%"))
        second = None if self.second is None else self.second.moments
        arrays = (self.image, self.standard_error, self.samples, self.moments, self.parts, second)
        for array in (*arrays, *self.missed.values(), *self.aovs.values()):
            if array is not None:
                array.flags.writeable = False

    @property
    def spp(self) -> float:
        """Mean number of samples per pixel."""
        return float(self.samples.mean())

    @property
    def variance(self) -> NDArray[np.float64] | None:
        """Variance of one sample of each pixel, (H, W, 3), in squared units of the image; None for another backend.

        The variance shows where light is hard to find, whatever the number of samples. With ``sampler=independent``,
        ``variance / samples[..., None]`` is the squared standard error of each pixel, not pooled. With other samplers
        it is too large, often several times: the samples of a pixel even each other out. The scatter over renders with
        several seeds is right for every sampler. The variance is infinite in pixels with too few samples.
        """
        return None if self.moments is None else sample_variance(self.moments)

    @property
    def alpha(self) -> NDArray[np.float32] | None:
        """Opacity of each pixel, (H, W), in [0, 1] (`equaltime.rendering.outputs`); None if the film asks for none."""
        return self.aovs.get(ALPHA)

    @property
    def radiance_range(self) -> float:
        """Ratio of the largest radiance in the image to the smallest above 0, over all channels; 1 for a black image.

        The ratio is large in ordinary scenes too, such as one lamp in thick fog. Light of dim emitters may be missing
        only if `lint` finds emitters whose radiances differ by more than a factor of 1e12 (``radiance-range``).
        """
        least = float(np.min(self.image, where=self.image > 0.0, initial=np.inf))
        return float(self.image.max()) / least if least < np.inf else 1.0

    @property
    def record(self) -> dict[str, Any]:
        """Record of the render: JSON data that tell how it was made.

        `save` stores it in the EXR file, and ``--json`` prints it.
        """
        height, width = self.samples.shape
        window = self.origin.window
        return {
            "format": FORMAT,
            "software": images.SOFTWARE,
            **self.origin.record,
            "crop": [window.x, window.y, width, height],
            "spp": int(self.spp) if self.spp.is_integer() else self.spp,
            "samples": {"first": 0, "min": int(self.samples.min()), "max": int(self.samples.max())},
            "stopped_by": self.stopped_by,
            "stop": None if self.stop is None else self.stop.as_dict(),
            **({"decision": to_json(self.decision)} if self.decision != Decision() else {}),
            "error": self.error.as_dict(),
            **({} if self.parts is None else {"degrees": self.degrees}),
            **({"common_doubt": self.common_doubt} if self.common_doubt else {}),
            **({"focus": to_json(self.focus)} if self.focus.possible else {}),
            **({"radiance_range": self.radiance_range} if self.radiance_range > FAR_APART else {}),
            **({} if self.bias is None else {"bias": self.bias.as_dict()}),
            "looks": [[number if math.isfinite(number) else None for number in look] for look in self.looks],
            **({} if self.position is None else {"position": list(self.position)}),
            "seconds": self.stats.seconds,
            **({"runs": self.stats.runs} if self.stats.runs > 1 else {}),
            "phases": dict(self.stats.phases),
            "paths": self.stats.paths,
            "rays": self.stats.rays,
            "shadow_rays": self.stats.shadow_rays,
            "rays_per_s": self.stats.rays_per_second,
            "threads": self.stats.threads,
            "kernel": self.stats.kernel,
            "effects": list(self.stats.effects),
            "build": dict(self.stats.build) if self.stats.build else None,
            "revisions": list(self.stats.revisions),
        }

    def exposure(self, wanted: Exposure = AUTO, shown: float = 0.0) -> float:
        """Return the exposure of previews of the image, in stops; 1 is twice as bright.

        ``wanted`` is returned if it is a number of stops. For ``auto``, whole stops are chosen from the pixels that
        have samples. ``shown`` is the exposure of an earlier preview, which is returned unless the picture would be too
        dark or too bright with it. Raises ValueError for other values.
        """
        given = checked_exposure(wanted)
        if given != AUTO:
            return given
        seen, alpha = self.samples > 0, self._alpha
        if alpha is None:
            return automatic_stops(self.image[seen], shown)
        seen &= alpha > 0.0
        return automatic_stops(self.image[seen] / alpha[seen][:, None], shown)

    def save(
        self,
        path: str | os.PathLike[str],
        small: bool = False,
        *,
        exposure: Exposure = AUTO,
        shown: float = 0.0,
        aov: Collection[AovPicture] = (),
        overwrite: bool = False,
        background: Sequence[float] | None = None,
        metadata: bool = True,
        quality: int = preview.JPEG_QUALITY,
    ) -> tuple[Path, ...]:
        """Write the result and return the files written.

        Parameters
        ----------
        path
            ``NAME.exr`` gets the image, its standard error, the sample counts, the record, and the moments needed to
            resume or merge the render (`equaltime.rendering.render_file`). Its first subimage has the channels that the
            film asks for (`FilmPicture`). A preview ``NAME.png`` is written beside the EXR, in sRGB, with alpha if the
            film asks for alpha. A path ``NAME.png`` or ``NAME.jpg`` gets the preview alone; a JPEG has no alpha and
            shows the image over ``background`` or over black. An existing render that took more than a minute, or whose
            scene file has been edited since, is kept as ``NAME.exr~``, unless this render contains its samples (was
            resumed from it). A preview of another render is kept as ``NAME.png~``, unless it belongs to the EXR beside
            it.
        small
            Leave out of the EXR the data for resuming and merging, and the outputs beside the image. Round the image to
            11 significant bits (0.02 %).
        exposure
            Exposure of the preview in stops: 1 is twice as bright. ``auto`` chooses whole stops from the image
            (`Result.exposure`). The preview's description states an exposure that is not 0. Data in the EXR are never
            scaled. The record in the EXR holds a number of stops, so that `equaltime render --resume` keeps it.
        shown
            Exposure of an earlier preview in stops, which ``auto`` keeps while it suits the image.
        aov
            Further pictures. ``variance`` writes ``NAME.variance.png``, the variance of one sample in grey, darker
            where it is higher, on a logarithmic scale that its description states.
        overwrite
            Replace files of other programs, edited PNGs, and renders of other scenes, without keeping them. Else each
            is kept as ``NAME~``. A scene made in memory is another one unless its content is equal; a scene file is
            the same one even if it has changed.
        background
            Linear RGB colour behind the transparent parts of the preview, which then has no alpha. The exposure does
            not change it. None keeps the alpha of a PNG.
        metadata
            Whether pictures tell the scene's path, the error, and all that repeats the render. False leaves this out of
            a PNG or JPEG that is written alone, to hand on a picture without private facts.
        quality
            Quality of a JPEG, in [1, 100]. It changes no other file.

        Raises
        ------
        ImageError
            If a file cannot be written or kept; an earlier file stays unchanged.
        ValueError
            If ``exposure`` or ``quality`` is out of range, if ``background`` is no colour, if ``aov`` names an unknown
            picture or a variance that is not known, or if an EXR is to have no metadata.
        """
        paths, stops = check_output(Path(path), aov=aov), self.exposure(exposure, shown)
        if background is not None and len(background) != 3:
            raise ValueError(f"background is a linear colour (red, green, blue), found {background!r}")
        if not 1 <= quality <= 100:
            raise ValueError(f"the quality of a JPEG must be in [1, 100], found {quality!r}")
        if not metadata and (paths.exr is not None or paths.variance is not None):
            raise ValueError("only a PNG or JPEG that is written alone can do without metadata")
        variance = None if paths.variance is None else self._known_variance()
        description = f"{self._summary()}; {self.origin.strategy}"
        ours = (self.origin.scene, self.origin.digest)
        others = () if overwrite else keep_others(paths.all, *ours)
        kept = dict.fromkeys((*others, *keep_work(paths, self.record, *ours)))
        if paths.exr is not None:
            asked = {} if exposure == AUTO else {"exposure": stops}
            replace(self.file, record={**self.record, **asked}).write(paths.exr, description, small)
        repeat = to_repeat(self.record, stops, background, self.saved if paths.exr is None else None)
        preview.write(
            *(paths.preview, self.image, description, self.origin.scene, self._alpha, stops, repeat, background),
            metadata=metadata,
            quality=quality,
        )
        if paths.variance is not None and variance is not None:
            variance_picture.write_variance(paths.variance, variance, description, self.origin.scene)
        return (*paths.all, *kept)

    @property
    def _alpha(self) -> NDArray[np.float32] | None:
        """Return the alpha of pictures: None if the film asks for none, or if it was not rendered."""
        return self.alpha if self.origin.picture.alpha else None

    def _known_variance(self) -> NDArray[np.float64]:
        """Return the variance; raise ValueError if no pixel has one."""
        variance = self.variance
        if variance is None:
            raise ValueError("this result has no moments, so that the variance of its samples is not known")
        if not variance_picture.is_known(variance):
            raise ValueError("no pixel has the 3 samples that a variance needs")
        return variance

    @property
    def file(self) -> RenderFile:
        """Content of the EXR file that `Result.save` writes."""
        return RenderFile(
            self.image,
            self.standard_error,
            self.samples,
            self.record,
            self.origin.window,
            self.moments,
            self.parts,
            self.missed,
            {name: plane for name, plane in self.aovs.items() if name != ALPHA},
            self.origin.picture,
            self.alpha,
            self.second,
        )

    def _summary(self) -> str:
        height, width = self.samples.shape
        number, asked = stated(self.origin), self.origin.scene_max_depth
        asks = f" (the scene asks for {paths_up_to(asked)})" if number.paths and asked is not None else ""
        error = f"{number.noun} {self.error:%}{number.of_paths}{asks}"
        spp = f"{count(self.spp)} spp{not_as_asked(self.spp, asked_samples(self.stopped_by, self.position))}"
        return f"{width}x{height}, {spp}, {error}, stopped by {self.stopped_by}"

    def __repr__(self) -> str:
        return f"Result({self._summary()})"

    def _repr_png_(self) -> bytes:
        return preview.png_bytes(self.image, self._alpha, self.exposure())


def make_result(
    pixels: PixelStatistics,
    stats: Stats,
    stopped_by: StoppedBy,
    origin: Origin,
    moments: NDArray[Any] | None = None,
    looks: tuple[Look, ...] = (),
    bias: Interval | None = None,
    position: tuple[int, int, int] | None = None,
    hidden: Unseen | None = None,
    parts: NDArray[Any] | None = None,
    stop: Stop | None = None,
    second: SecondNets | None = None,
    decision: Decision | None = None,
) -> Result:
    """Return the result of a render from its pixels; its cost includes the time to compute its errors.

    The result shares ``moments`` and the moments of ``second`` with the caller.

    Parameters
    ----------
    pixels
        Mean, variance and sample count of every pixel.
    hidden
        Light that samples may have missed, which raises the error's upper limit; None leaves it out.
    stats, stopped_by, origin, moments, looks, bias, position, parts, stop, second, decision
        Fields of the result, which documents them.

    Raises
    ------
    BrightImage
        If float32 cannot hold the image; the error holds the result.
    """
    begin = time.perf_counter()
    image = as_float32(pixels.mean)
    errors = standard_error(pixels)
    brightest = max((look.brightest for look in looks), default=0.0)
    error = stated_error(pixels, hidden, brightest=brightest).with_bias(bias)
    stats = replace(stats, phases={**stats.phases, "estimate": time.perf_counter() - begin})
    missed = {} if hidden is None else hidden.parts(*pixels.samples.shape)
    result = Result(
        image,
        errors,
        pixels.samples,
        error,
        stats,
        stopped_by,
        origin,
        moments,
        looks,
        bias,
        position,
        missed,
        stop,
        degrees=pixels.degrees,
        parts=parts,
        common_doubt=pixels.common_doubt,
        second=second,
        decision=Decision() if decision is None else decision,
        focus=Focus.none() if hidden is None else hidden.focus,
    )
    beyond = beyond_float32(pixels.mean, (origin.window.x, origin.window.y), origin.scene or "")
    if beyond is not None:
        raise beyond.with_result(result)
    return result
