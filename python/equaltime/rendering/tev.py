"""Display of a render's passes in the viewer tev (https://github.com/Tom94/tev), over its network protocol.

A message is its length in bytes (uint32, this number included), a byte for its kind, and its fields. Numbers are little
endian, a bool is a byte, a text ends with a zero byte. Two kinds are sent: 4 creates an image of some channels, 6
updates a rectangle of an image, whose channels may be interleaved.
"""

from __future__ import annotations

import socket
import struct
import time
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import RenderError

__all__ = ["PORT", "Viewer"]

PORT = 14158
"""Port on which tev listens by default."""

_CREATE, _UPDATE = 4, 6
_CHANNELS = ("R", "G", "B")
_PATIENCE = 2.0
"""Seconds to wait for a viewer that does not accept data."""
_INTERVAL = 0.2
_MOST_SHARE = 0.02
"""Largest share of the time that goes into showing."""
_MOST_BYTES = 1 << 24
"""Largest number of pixel bytes in one message."""


class Viewer:
    """An image in the viewer tev that follows a render; it is passed to `equaltime.render` as ``show``.

    If the viewer cannot be reached, or closes, `problem` holds the reason, and nothing more is sent. The render goes on
    in any case.

    Parameters
    ----------
    address
        ``HOST:PORT``, or ``HOST``.
    name
        Name of the image in the viewer.

    Raises
    ------
    RenderError
        If the address is invalid.
    """

    def __init__(self, address: str = "localhost", name: str = "equaltime") -> None:
        host, _, port = address.rpartition(":") if ":" in address else (address, "", str(PORT))
        if not host or not port.isascii() or not port.isdigit() or not 0 < int(port) < 2**16:
            raise RenderError(f"tev: expected HOST:PORT, such as localhost:{PORT}, found '{address}'")
        self.problem: str | None = None
        """Reason why nothing more is sent to the viewer; None while it is shown images."""
        self._address, self._host, self._port = address, host.strip("[]"), int(port)
        self._name = name
        self._socket: socket.socket | None = None
        self._shape: tuple[int, ...] | None = None
        self._next = 0.0
        self._sender = ThreadPoolExecutor(1, "tev")
        self._sent: Future[None] | None = None

    @property
    def due(self) -> bool:
        """Whether another image should be sent now; always False after a problem with the connection.

        Images are sent at most every 0.2 s, and take at most 2 % of the time.
        """
        under_way = self._sent is not None and not self._sent.done()
        return self.problem is None and not under_way and time.monotonic() >= self._next

    def offer(self, image: NDArray[Any]) -> None:
        """Send a linear image (H, W, 3) in the background, since viewers may be slow.

        The caller must not change the array.
        """
        self._sent = self._sender.submit(self._show, image)

    def show(self, image: NDArray[Any]) -> None:
        """Send a linear image (H, W, 3) after the images queued by `offer`, and wait until it is sent or has failed."""
        self._sender.submit(self._show, image).result()

    def _show(self, image: NDArray[Any]) -> None:
        if self.problem is not None:
            return
        begin = time.monotonic()
        self.connect()
        try:
            if self._socket is not None:
                self._send(self._socket, np.ascontiguousarray(image, "<f4"))
        except (OSError, UnicodeError) as error:
            self._give_up(error)
        end = time.monotonic()
        self._next = end + max(_INTERVAL, (end - begin) / _MOST_SHARE)

    def connect(self) -> None:
        """Connect to the viewer, unless it is connected already.

        `show` connects too, but connecting may take a while, so a caller may connect early.
        """
        if self._socket is not None or self.problem is not None:
            return
        try:
            self._socket = socket.create_connection((self._host, self._port), _PATIENCE)
        except (OSError, UnicodeError) as error:  # an invalid host name cannot be encoded
            self._give_up(error)

    def _give_up(self, error: OSError | UnicodeError) -> None:
        said = getattr(error, "strerror", None) or str(error) or "no answer"
        self.problem = f"tev at {self._address}: {said}; the render goes on"
        self._hang_up()

    def close(self) -> None:
        """Disconnect from the viewer once it has received all images; the viewer keeps the last one."""
        self._sender.submit(self._hang_up).result()

    def _hang_up(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _send(self, to: socket.socket, image: NDArray[np.float32]) -> None:
        height, width, _ = image.shape
        if self._shape != image.shape:
            size = struct.pack("<3i", width, height, len(_CHANNELS))
            to.sendall(_message(_CREATE, True, self._name, size, *map(_text, _CHANNELS)))
            self._shape = image.shape
        rows = max(1, _MOST_BYTES // (4 * len(_CHANNELS) * width))
        for y in range(0, height, rows):
            band = image[y : y + rows]
            count = struct.pack("<i", len(_CHANNELS))
            place = struct.pack("<4i", 0, y, width, len(band))
            layout = struct.pack("<6q", 0, 1, 2, 3, 3, 3)  # where each channel begins, and steps to its next pixel
            fields = (count, *map(_text, _CHANNELS), place, layout, band.tobytes())
            to.sendall(_message(_UPDATE, False, self._name, *fields))


def _message(kind: int, grab_focus: bool, name: str, *fields: bytes) -> bytes:
    body = b"".join([struct.pack("<B?", kind, grab_focus), _text(name), *fields])
    return struct.pack("<I", 4 + len(body)) + body


def _text(words: str) -> bytes:
    return words.replace("\0", "").encode(errors="replace") + b"\0"
