"""Reads the files that a scene includes, with limits on nesting and on repeated reading."""

from __future__ import annotations

from pathlib import Path
from typing import Final

__all__ = ["Includes"]

MOST_DEEP: Final = 15
"""Largest depth of files that include files, as in Mitsuba."""
MOST_READ_AGAIN: Final = 1 << 19
"""Largest total size, in bytes, of repeated readings of included files; includes can double with each level."""
A_FILE: Final = 1 << 10
"""Bytes that each repeated reading counts in addition to the file's size, for the work of opening the file."""


class Includes:
    """Reader of the files that one scene includes. It counts repeated readings against a limit."""

    def __init__(self) -> None:
        self._opened: set[Path] = set()
        self._read_again = 0

    def read(self, path: Path, depth: int) -> bytes:
        """Return the content of a file that is included at nesting level `depth`.

        Raises ValueError if the file cannot be read, `depth` is above `MOST_DEEP`, or too much was read repeatedly.
        """
        if depth > MOST_DEEP:
            raise ValueError(f"files include each other more than {MOST_DEEP} deep")
        try:
            content = path.read_bytes()
        except (OSError, ValueError) as error:
            raise ValueError(f"cannot be read: {getattr(error, 'strerror', None) or error}: {path}") from error
        if path in self._opened:
            self._read_again += len(content) + A_FILE
        self._opened.add(path)
        if self._read_again > MOST_READ_AGAIN:
            raise ValueError(f"files are included again and again: more than {MOST_READ_AGAIN} bytes")
        return content
