"""Layout of the file of a saved render. No other module knows the layout; `FORMAT` is the version written here.

A saved render is an OpenEXR file of several parts (subimages). Other programs read the first part.

========  ======================  =======================================================================
part      channels                content
========  ======================  =======================================================================
beauty    R G B, float32          the image: linear radiance, Rec. 709 primaries, in the scene's units; with
                                  ``small`` rounded to 11 significant bits, as half where half holds it;
                                  also A, or Y, or X Y Z, or half, if the film asks for it (`FilmPicture`)
image     R G B, float32          the image as above, if the beauty part does not hold it exactly
stderr    R G B, float32          standard error of each pixel, rounded to 6 significant bits; inf: unknown
samples   samples, uint32         number of samples of each pixel
moments   r0.mean.R.0 …, uint32   mean, count and spread of each replicate, to the bit (`equaltime.film.moments`)
parts     r0.parts.0 …, uint32    merged renders: sums over the parts (`equaltime.film.parts_of_merge`)
second    r0.mean.R.0 …, uint32   moments of the second nets of some pixels (`equaltime.film.second_nets`)
unseen    R G B, float32          radiance that samples may have missed (`equaltime.film.unseen`)
lamps     R G B share, float32    lamps smaller than a pixel, and their share of it (`equaltime.film.lamps`)
aovs      by the scene            outputs beside the image, float32 (`equaltime.rendering.outputs`)
========  ======================  =======================================================================

Beauty, stderr and samples are always there. A file saved with ``small`` has no other parts but image, and can be
neither resumed nor merged. Three attributes of the first part hold the rest. ``Software`` names the program.
``equaltime:record``, JSON, tells how the render was made. ``equaltime:sha256``, JSON, holds the SHA-256 of the record's
text and of each part's numbers. A file that does not match these sums is refused.

The keys of the record (s: seconds; px: pixels):

===========================  ===========================================================================================
key                          content
===========================  ===========================================================================================
format, software             version of this layout, and of equaltime
scene, digest                the scene's file (null: made in memory), and SHA-256 of its content
size, crop                   full film [width, height] and the image's window [x, y, width, height] in it, px
max_depth, scene_max_depth   longest paths of the image, and of the scene as written; -1: no limit
strategy, biased             name for `Strategy.parse`; whether its mean differs from the truth
without, bias                effects that were left out, if any, and the error due to that
seed, replicates, backend    with the strategy, these decide the bits
nets, second_net             independent nets of a pixel's samples: with 2 the replicates are two independent halves,
                             with 1 they are not; k, if one of k pixels has a second net
numbers                      version of the sampler's numbers; files without this key have version 1
transparent                  true if the background was made transparent, beside what the scene's film asks for
defines                      values of -D, by name, with which the scene's file was read
frame                        number of a frame of an animation (--frames), fps (frames a second), and blur (share of
                             the frame for which the shutter is open)
substitutions                parts of the scene that were replaced since they cannot be rendered
sources                      of a merged render: seed, samples, spp, stopped_by, stop, position, seconds and build of
                             each part, as in its own record
exposure                     stops of the preview, if a number was asked for; absent if they were automatic
picture                      colors, alpha and half of the first part, if it is not R, G, B in 32 bits (`FilmPicture`)
spp, samples                 mean samples a pixel; the first sample's number, and the least and most of a pixel
stopped_by, stop             reason of the end; rule by which the render was to stop at an error
decision                     roulette, splitting and counts, where the strategy left them to the render (`Decision`)
error, degrees, focus        relative error with its 95 % interval; degrees of freedom; light that is focused
common_doubt                 relative standard deviation of a factor that all variances have in common, if there is one
radiance_range               largest radiance over the smallest above 0, if that is more than 1e12
looks                        [samples, error, upper limit, brightest path] of each look on the way
position                     position of the passes: [samples, samples of the running pass, next block]
seconds, runs                rendering time of all runs together, s; number of runs, if the render was resumed or merged
phases                       time of each phase, s; phases other than render count only the last run
paths, rays, shadow_rays     numbers of each; rays_per_s is all rays over the seconds
threads, kernel, effects     threads, the compiled path tracer, and the effects that the scene uses
build, revisions             how the core was built; commits of equaltime that took the samples, and whether files were
                             changed since
===========================  ===========================================================================================
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.film.moments import (
    DTYPE,
    PARTS,
    channel_names,
    packed,
    packed_moments,
    packed_shape,
    unpacked,
    unpacked_moments,
)
from equaltime.film.second_nets import SecondNets
from equaltime.film.sums import second_net_pixels
from equaltime.images import image_files as images
from equaltime.images.image_files import RGB, SOFTWARE, Layer, Picture, Window
from equaltime.images.reading import read_part
from equaltime.rendering import format_1
from equaltime.rendering.film_picture import ALPHA, FilmPicture
from equaltime.rendering.render_record import checked
from equaltime.strict_json import json_text
from equaltime.words import shortened

__all__ = [
    "FORMAT",
    "RenderFile",
    "SavedFilm",
    "holds_film",
    "read_film",
    "read_outputs",
    "read_picture",
    "read_record",
]

FORMAT: Final = 2
_RECORD, _SHA256 = "equaltime:record", "equaltime:sha256"
_MISSED: Final = {"unseen": RGB, "lamps": (*RGB, "share")}
_STDERR_BITS: Final = 6
"""Significant bits of standard errors: 6 bits are within 1.6 %, and the 49 pixels behind an error give it to 10 %."""
_SMALL_BITS: Final = 11
_BEAUTY: Final = (*RGB, "X", "Y", "Z", ALPHA)
"""Channels that a first part may have, in the order of writing."""
_HALF: Final = (10 * 2.0**-14, 65504.0)
"""Least mean and largest value of an image that half holds to 11 bits, or to a thousandth of its mean."""


@dataclass(frozen=True, eq=False)
class RenderFile:
    """Content of the file of a saved render, to be written or as it was read."""

    image: NDArray[np.float32]
    """(H, W, 3): linear RGB."""
    standard_error: NDArray[np.float32]
    """(H, W, 3): standard error of each pixel; inf where unknown."""
    samples: NDArray[np.int64]
    """(H, W): number of samples of each pixel."""
    record: Mapping[str, Any]
    """JSON data that tell how the render was made: scene, strategy, seed, error, time and so on."""
    window: Window
    """Position (x, y) of the image's first pixel on the full film, and width and height of that film, in pixels."""
    moments: NDArray[Any] | None = None
    """(R, H, W): count, mean and deviation of the samples of each pixel in each of R replicates (parts of the samples),
    of the type `equaltime.film.moments.DTYPE`."""
    parts: NDArray[Any] | None = None
    """(H, W): sums over the merged renders, from which variances follow, of the type `equaltime.film.moments.PARTS`;
    None if nothing was merged."""
    missed: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """Light that samples may have missed: (H, W, C) by the name of the file's subimage, ``unseen`` or ``lamps``."""
    aovs: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """Outputs beside the image: (H, W) by the name of the channel."""
    picture: FilmPicture = field(default_factory=FilmPicture)
    """Channels and precision of the file's first subimage, which other programs read."""
    alpha: NDArray[np.float32] | None = None
    """(H, W): opacity of each pixel; None if the film does not ask for it."""
    second: SecondNets | None = None
    """Second nets: further samples of some pixels, not in the image, that show its noise. None if there are none."""

    def write(self, path: Path, description: str = "", small: bool = False) -> None:
        """Write the file at ``path``, whole or not at all.

        With ``small``, only rounded image, errors and sample counts are written. ``description`` is the image's
        description in the file.

        Raises
        ------
        ImageError
            If the file cannot be written; an earlier file stays unchanged.
        """
        image, kind = _rounded_image(self.image) if small else (np.asarray(self.image, np.float32), "float")
        parts = dict(self._looked_at(image, kind, small))
        if not small:
            parts |= dict(self._numbers(image))
        record = json_text({**self.record, "format": FORMAT})
        guard = {"record": _digest(record), **{name: _digest(part.pixels) for name, part in parts.items()}}
        parts["beauty"].attributes.update(
            {"Software": SOFTWARE, "ImageDescription": description, _RECORD: record, _SHA256: json_text(guard)}
        )
        images.write(path, "openexr", list(parts.values()), self.window)

    def _looked_at(self, image: NDArray[np.float32], kind: str, small: bool) -> Iterator[tuple[str, Layer]]:
        lossless = "pxr24" if small and kind == "float" else "zip"  # Pixar's 24 bits hold numbers rounded to 11 bits
        channels, pixels = self.picture.channels(self.alpha), self.picture.pixels(image, self.alpha)
        form = "half" if self.picture.half else kind
        pixels = _as_half(pixels) if form == "half" else pixels
        beauty = _part("beauty", channels, pixels, lossless if channels == RGB else "zip", form)
        beauty.attributes.update(self.picture.attributes)
        yield "beauty", beauty
        if not self.picture.is_exact:
            yield "image", _part("image", RGB, image, lossless, kind)
        yield "stderr", _part("stderr", RGB, _rounded(self.standard_error, _STDERR_BITS), "pxr24")
        counts = np.minimum(self.samples, np.iinfo(np.uint32).max).astype(np.uint32)
        yield "samples", _part("samples", ("samples",), counts[..., None])

    def _numbers(self, image: NDArray[np.float32]) -> Iterator[tuple[str, Layer]]:
        if self.moments is not None:
            names = channel_names(DTYPE, len(self.moments))
            yield "moments", _part("moments", names, packed_moments(self.moments, image))
        if self.parts is not None:
            yield "parts", _part("parts", channel_names(PARTS, 1), packed(self.parts[None]))
        if self.second is not None:
            second = self.second.moments
            yield "second", _part("second", channel_names(DTYPE, len(second)), packed(second))
        for name, planes in self.missed.items():
            yield name, _part(name, _MISSED[name], np.asarray(planes, np.float32))
        if self.aovs:
            planes = np.stack([np.asarray(plane, np.float32) for plane in self.aovs.values()], axis=-1)
            yield "aovs", _part("aovs", tuple(self.aovs), planes)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> RenderFile:
        """Return the content of the file at ``path``: all except the outputs beside the image, of which only alpha.

        Raises
        ------
        ImageError
            If the file is missing, no image, not rendered by equaltime, written by a later version, or damaged.
        """
        picture, guard = _guarded_picture(path)
        if not picture.record:
            raise ImageError(f"{path}: was not rendered by equaltime")
        record = checked(picture.record, path)
        moments, parts, second = _film(path, picture, guard)
        missed = {name: found for name, of in _MISSED.items() if (found := _guarded(path, name, of, guard)) is not None}
        film = {"moments": moments, "parts": parts, "second": second}
        there = {**{name: of is not None for name, of in film.items()}, **dict.fromkeys(missed, True)}
        known = {**there, "aovs": True, "image": True}
        if lacking := {name for name in guard or () if name not in _ALWAYS and not known.get(name)}:
            raise ImageError(f"{path}: is damaged: it lacks the part '{min(lacking)}'")
        shape = picture.image.shape
        errors = picture.standard_error if picture.standard_error is not None else np.full(shape, np.inf, np.float32)
        samples = picture.samples if picture.samples is not None else np.zeros(shape[:2], np.int64)
        form, alpha = FilmPicture.from_dict(record["picture"]), picture.channels.get(ALPHA)
        return cls(
            picture.image,
            errors,
            samples,
            record,
            picture.window,
            moments,
            parts,
            missed,
            picture=form,
            alpha=alpha,
            second=second,
        )


_ALWAYS: Final = frozenset({"record", "beauty", "stderr", "samples"})


def read_picture(path: str | os.PathLike[str]) -> Picture:
    """Return the image of any image file, with standard errors, sample counts and record if equaltime wrote it.

    The record tells how the render was made. Raises `ImageError` if the file cannot be read.
    """
    return _guarded_picture(path)[0]


def read_record(path: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return the record in a file's header, without checks: JSON data that tell how the render was made.

    The result is empty if the file has none or cannot be read.
    """
    with suppress(ImageError):
        return _json(images.read_attributes(path).get(_RECORD, "{}"), _RECORD, path)
    return {}


def read_outputs(path: str | os.PathLike[str]) -> dict[str, NDArray[np.float32]]:
    """Return the outputs beside the image in a file, (H, W), by the name of the channel; empty if there are none."""
    found = read_part(path, "aovs", "float")
    return {} if found is None else {name: found[1][..., i].copy() for i, name in enumerate(found[0])}


class SavedFilm(NamedTuple):
    """Samples of a saved render, from which the variance of each pixel follows. Missing fields are None."""

    moments: NDArray[Any] | None
    """(R, H, W): count, mean and deviation of the samples of each pixel in each of R replicates (parts of the samples).
    """
    parts: NDArray[Any] | None
    """(H, W): sums over the renders that were merged."""
    second: SecondNets | None
    """Second nets: further samples of some pixels, not in the image, that show its noise."""


def read_film(path: str | os.PathLike[str]) -> SavedFilm:
    """Return the samples in the file of a saved render: counts, means and deviations of the pixels.

    Raises `ImageError` if the file cannot be read.
    """
    return _film(path, *_guarded_picture(path))


def holds_film(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file has the moments (counts, means, deviations) that resuming and merging need.

    Raises `ImageError` if the file is damaged.
    """
    return read_part(path, "moments", "uint") is not None


Guard = Mapping[str, str] | None
"""Sums that guard a file against damage: SHA-256 by the name of the subimage. None in a file of format 1."""


def _guarded_picture(path: str | os.PathLike[str]) -> tuple[Picture, Guard]:
    picture = images.read(path)
    text = picture.attributes.get(_RECORD)
    if text is None:
        return picture, None
    record = _json(text, _RECORD, path)
    _check_format(record, path)
    found = picture.attributes.get(_SHA256)
    if found is None:
        if record.get("format", 1) != 1:
            raise ImageError(f"{path}: is damaged: it lacks the attribute {_SHA256}")
        return replace(picture, record=record), None
    guard = _json(found, _SHA256, path)
    if lacking := _ALWAYS - {*guard}:
        raise ImageError(f"{path}: is damaged: the attribute {_SHA256} lacks '{min(lacking)}'")
    _check(text, "record", guard, path)
    _check(_beauty(picture), "beauty", guard, path)
    if "image" in guard:
        image = _guarded(path, "image", RGB, guard)
        if image is None:
            raise ImageError(f"{path}: is damaged: it lacks the part 'image'")
        picture = replace(picture, channels={**picture.channels, **{c: image[..., i] for i, c in enumerate(RGB)}})
    errors, samples = _guarded(path, "stderr", RGB, guard), _guarded(path, "samples", ("samples",), guard, "uint")
    if errors is None or samples is None or {errors.shape[:2], samples.shape[:2]} != {picture.image.shape[:2]}:
        raise ImageError(f"{path}: its parts are not of one size")
    more = {**{f"stderr.{c}": errors[..., i] for i, c in enumerate(RGB)}, "samples": samples[..., 0]}
    return replace(picture, record=record, channels={**picture.channels, **more}), guard


def _beauty(picture: Picture) -> NDArray[np.float32]:
    """Return the pixels (H, W, C) of the first part in the order in which they were written."""
    there = [name for name in _BEAUTY if name in picture.channels]
    return np.stack([picture.channels[name] for name in there or picture.channels], axis=-1)


def _json(text: str, name: str, path: str | os.PathLike[str]) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:  # raised by endless numbers, or by deep nesting
        raise ImageError(f"{path}: the attribute {name} is damaged: {error}") from error
    return found if isinstance(found, dict) else {}


def _check_format(record: Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    found = record.get("format", 1)
    if isinstance(found, int) and found > FORMAT:
        raise ImageError(
            f"{path}: was saved by a later version of equaltime, in format {found}; this version reads formats up to "
            f"{FORMAT}"
        )


def _guarded(
    path: str | os.PathLike[str],
    name: str,
    channels: Sequence[str] | Callable[[int], Sequence[str]],
    guard: Guard,
    kind: str = "float",
) -> NDArray[Any] | None:
    """Return the pixels (H, W, C) of a part; None if there is no such part.

    ``channels`` gives the order of the channels, which may depend on their number. EXR does not keep the order.
    """
    found = read_part(path, name, kind)
    if found is None:
        return None
    wanted = channels(len(found[0])) if callable(channels) else channels
    place = {channel: i for i, channel in enumerate(found[0])}
    if {*wanted} != {*place}:
        raise ImageError(f"{path}: the part '{name}' has other channels than {shortened(', '.join(wanted), 80)}")
    pixels = np.ascontiguousarray(found[1][..., [place[channel] for channel in wanted]])
    if guard is not None:
        _check(pixels, name, guard, path)
    return pixels


def _check(numbers: NDArray[Any] | str, name: str, guard: Mapping[str, str], path: str | os.PathLike[str]) -> None:
    if _digest(numbers) != guard.get(name):
        raise ImageError(f"{path}: is damaged: '{name}' is not what was saved (its SHA-256 differs)")


def _digest(numbers: NDArray[Any] | str) -> str:
    if isinstance(numbers, str):
        return hashlib.sha256(numbers.encode(errors="surrogateescape")).hexdigest()
    whole = np.ascontiguousarray(numbers)
    found = hashlib.sha256(f"{whole.dtype.str} {whole.shape} ".encode())
    found.update(whole.reshape(-1).view(np.uint8).data)
    return found.hexdigest()


def _film(path: str | os.PathLike[str], picture: Picture, guard: Guard) -> SavedFilm:
    if picture.record.get("format", 1) == 1:
        return SavedFilm(format_1.read_moments(path), format_1.read_parts(path), None)
    second = _second(path, picture.record, guard)
    return SavedFilm(_moments(path, picture.image, guard), _sums(path, picture.image, guard), second)


def _moments(path: str | os.PathLike[str], image: NDArray[np.float32], guard: Guard) -> NDArray[Any] | None:
    words = _guarded(path, "moments", lambda count: channel_names(DTYPE, count // DTYPE.itemsize), guard, "uint")
    if words is None:
        return None
    _check_words(words, image, path)
    return unpacked_moments(words, image)


def _sums(path: str | os.PathLike[str], image: NDArray[np.float32], guard: Guard) -> NDArray[Any] | None:
    words = _guarded(path, "parts", channel_names(PARTS, 1), guard, "uint")
    if words is None:
        return None
    _check_words(words, image, path)
    return np.asarray(unpacked(words, image.shape[1], PARTS)[0])


def _second(path: str | os.PathLike[str], record: Mapping[str, Any], guard: Guard) -> SecondNets | None:
    words = _guarded(path, "second", lambda count: channel_names(DTYPE, count // DTYPE.itemsize), guard, "uint")
    if words is None:
        return None
    of = checked(record, path)
    _, _, width, height = of["crop"]
    try:
        pixels = second_net_pixels(of["seed"], width, height, of["second_net"])
    except ValueError as error:
        raise ImageError(f"{path}: its record is damaged: 'second_net' is {of['second_net']}: {error}") from error
    if words.shape[:2] != packed_shape(*pixels.shape):
        raise ImageError(f"{path}: its parts are not of one size")
    return SecondNets(unpacked(words, pixels.shape[1], DTYPE), pixels)


def _check_words(words: NDArray[np.uint32], image: NDArray[np.float32], path: str | os.PathLike[str]) -> None:
    if words.shape[:2] != packed_shape(*image.shape[:2]):
        raise ImageError(f"{path}: its parts are not of one size")


def _rounded_image(image: NDArray[Any]) -> tuple[NDArray[np.float32], str]:
    """Return an image that needs half the space, and the type of its channels."""
    least, most = _HALF
    if image.size and float(np.abs(image).max()) <= most and float(image.mean()) >= least:
        return _as_half(image), "half"
    return _rounded(image, _SMALL_BITS), "float"


def _as_half(numbers: NDArray[Any]) -> NDArray[np.float32]:
    """Return the nearest numbers that half holds."""
    most = _HALF[1]
    return np.asarray(np.clip(numbers, -most, most).astype(np.float16), np.float32)


def _rounded(numbers: NDArray[Any], bits: int) -> NDArray[np.float32]:
    """Round to this number of significant bits; infinities and NaN stay."""
    values = np.ascontiguousarray(numbers, np.float32)
    dropped = 24 - bits
    up = (values.view(np.uint32) + np.uint32(1 << (dropped - 1))) & np.uint32(2**32 - (1 << dropped))
    return np.where(np.isfinite(values), up.view(np.float32), values)


def _part(
    name: str, channels: tuple[str, ...], pixels: NDArray[Any], compression: str = "zip", kind: str = ""
) -> Layer:
    return Layer(channels, pixels, {"compression": compression, "oiio:subimagename": name}, kind)
