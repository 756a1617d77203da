"""Reads headers of Radiance pictures (``.hdr``): the orientation of the picture, and the header's variables.

OpenImageIO 3.2 confuses two of the eight orientations (``+X … +Y`` and ``-X … -Y``) and reports few of the variables.
The header, which is text, is therefore read here. See Ward, "File Formats", radsite.lbl.gov/radiance/refer.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

__all__ = ["header"]

MAGIC: Final = (b"#?RADIANCE", b"#?RGBE")
LONGEST: Final = 1 << 16
"""Largest size of a header in bytes; real headers have some hundred."""
ORIENTATIONS: Final = {
    **{"-Y +X": 1, "-Y -X": 2, "+Y -X": 3, "+Y +X": 4},
    **{"+X -Y": 5, "-X -Y": 6, "-X +Y": 7, "+X +Y": 8},
}
"""Exif's number of each orientation: direction from row to row, then direction within a row; y grows upwards."""
_VARIABLE: Final = re.compile(rb"(EXPOSURE|COLORCORR|PRIMARIES|PIXASPECT|GAMMA)=\s*(.*)")
_SIZE: Final = re.compile(rb"([-+][XY]) +\d+ +([-+][XY]) +\d+ *$")


def header(path: Path) -> tuple[int, dict[str, str]] | None:
    """Return Exif's orientation number (1 to 8) and the variables in the header, as text by name.

    Return None if the file is not a Radiance picture. Only variables that change colours or the aspect of pixels are
    returned. The values of a variable that occurs several times are joined by commas, in order.
    """
    with path.open("rb") as file:
        begin = file.read(LONGEST)
    if not begin.startswith(MAGIC):
        return None
    variables: dict[str, str] = {}
    lines = iter(begin.split(b"\n"))
    for line in lines:
        if not line.strip():
            break
        if match := _VARIABLE.match(line):
            name, value = (part.decode("latin-1").strip() for part in match.groups())
            variables[name] = f"{variables[name]}, {value}" if name in variables else value
    size = _SIZE.match(next(lines, b"").rstrip(b"\r"))
    words = b"" if size is None else b" ".join(size.groups())
    return ORIENTATIONS.get(words.decode(), 1), variables
