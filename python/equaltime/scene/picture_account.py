"""The account of a picture: a list of the channels and attributes in its file that the reader has not used.

The account begins with all channels and attributes that OpenImageIO finds. A reader removes each one that it uses, and
the rest is reported. Attributes that only describe the file, such as dates and compression, are not listed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from equaltime.words import shortened

__all__ = ["PictureAccount"]

DESCRIPTIONS: Final = frozenset(
    {
        *("Artist", "Copyright", "DateTime", "DocumentName", "HostComputer", "Make", "Model", "Software"),
        *("ImageDescription", "ImageID", "TargetPrinter", "thumbnail_image", "thumbnail_width", "thumbnail_height"),
        *("thumbnail_nchannels", "compression", "CompressionQuality", "planarconfig", "name", "version", "view"),
        *("multiView", "XResolution", "YResolution", "ResolutionUnit", "FramesPerSecond", "framesPerSecond"),
        *("capDate", "utcOffset", "longitude", "latitude", "altitude", "focus", "ExposureTime", "FNumber"),
        *("isoSpeed", "expTime", "aperture", "keyCode", "timeCode", "smpte:TimeCode", "smpte:KeyCode"),
        *("screenWindowCenter", "screenWindowWidth", "worldtocamera", "worldtoscreen", "worldToNDC", "fovcot"),
        *("whiteLuminance", "WhiteLuminance", "previewImage", "preview", "CICP", "colorInteropID", "wrapmodes"),
    }
)
"""Attributes that change no texel."""
OF_FORMATS: Final = (
    *("Exif", "GPS", "IPTC", "XMP", "xmp", "dc", "photoshop", "crs", "aux", "oiio", "openexr", "tiff", "png", "jpeg"),
    *("gif", "webp", "bmp", "dpx", "cineon", "targa", "hdr", "iff", "jpeg2000", "jpegxl", "pnm", "psd", "rla", "sgi"),
    *("fits", "dds", "softimage", "ICCProfile", "nuke", "equaltime"),
)
"""Prefixes, before the colon, of attributes that tell how a file or a photograph was made."""
USED: Final = frozenset(
    {
        *("Orientation", "PixelAspectRatio", "chromaticities", "oiio:ColorSpace", "oiio:Gamma", "ICCProfile"),
        *("ICCProfile:profile_description", "jpeg:ColorSpace", "tiff:ColorSpace", "textureformat", "hdr:exposure"),
    }
)
"""Attributes that readers of pictures use or must report."""
MOST_NAMES: Final = 6


class PictureAccount:
    """The channels and attributes of one picture that its reader has not used yet, and the reader's remarks.

    At the end of reading, `told` lists the channels and attributes that remain, for the user.
    """

    def __init__(self, spec: Any) -> None:
        self._channels = dict.fromkeys(str(name) for name in spec.channelnames)
        self._attributes = {str(each.name): each.value for each in spec.extra_attribs if _bears(each)}
        self._notes: dict[str, None] = {}

    def channels(self, *names: str) -> None:
        """Record that the reader uses the channels called `names`, so that they are not reported as unused."""
        for name in names:
            self._channels.pop(name, None)

    def attribute(self, name: str, *harmless: object) -> Any:
        """Return the value of the attribute `name`, and record that the reader uses it.

        Return None if the attribute is missing, or if its value is one of `harmless`: values that change nothing.
        """
        value = self._attributes.pop(name, None)
        return None if value in harmless else value

    def note(self, message: str) -> None:
        """Add a remark for the user about the picture file, unless an equal one was added before."""
        self._notes[message] = None

    def told(self) -> tuple[str, ...]:
        """Return the remarks for the user, one text each.

        They are the reader's own remarks, then one that lists unused channels, and one that lists unused attributes.
        """
        return (*self._notes, *self._left())

    def _left(self) -> Iterator[str]:
        if self._channels:
            yield f"channels that are not used: {_listed(list(self._channels))}"
        if self._attributes:
            values = [f"{name} = {_short(value)}" for name, value in self._attributes.items()]
            yield f"attributes that are not used: {_listed(values)}"


def _bears(attribute: Any) -> bool:
    """Tell whether an attribute may change the picture; text that no reader asks for is only a description."""
    name = str(attribute.name)
    if name in USED:
        return True
    described = name in DESCRIPTIONS or name.partition(":")[0] in OF_FORMATS
    return not described and not isinstance(attribute.value, str)


def _listed(words: list[str]) -> str:
    more = f" and {len(words) - MOST_NAMES} more" if len(words) > MOST_NAMES else ""
    return ", ".join(words[:MOST_NAMES]) + more


def _short(value: object) -> str:
    return f"{value.size} numbers" if isinstance(value, np.ndarray) else shortened(value, 40)
