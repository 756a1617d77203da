"""A renderer, with its clock, that a test controls."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.moments import DTYPE

PIXELS = 12


class FakeRenderer:
    """Takes 1 ms a sample of the whole image; polls after every sample; stops exactly at its limit or pause."""

    def __init__(self, interrupt_at: float = np.inf, bad_sample: int | None = None) -> None:
        self.now, self.seconds_a_sample = 0.0, 0.001
        self.done = 0
        self.targets: list[int] = []
        self.nonfinite: list[tuple[int, int, int]] = []
        self.faulty: list[tuple[int, int, int, str]] = []
        self.interrupt_at, self.bad_sample = interrupt_at, bad_sample

    def clock(self) -> float:
        return self.now

    def advance(
        self,
        samples: int,
        seconds: float | None = None,
        poll: Callable[[], bool] | None = None,
        pause: float | None = None,
    ) -> bool:
        self.targets.append(samples)
        end = self.now + min(limit for limit in (seconds, pause, np.inf) if limit is not None)
        while self.done < samples:
            if self.now + self.seconds_a_sample > end + 1e-9:
                return False
            self.now += self.seconds_a_sample
            if self.now >= self.interrupt_at:
                raise KeyboardInterrupt
            if self.done == self.bad_sample:
                self.nonfinite.append((1, 2, self.done))
            self.done += 1
            if poll is not None and not poll():
                return False
        return True

    @property
    def moments(self) -> NDArray[Any]:
        moments = np.zeros((2, 3, PIXELS // 3), DTYPE)
        moments["count"] = self.done // 2
        moments["mean"] = np.arange(1.0, 3.0)[:, None, None, None]
        return moments

    @property
    def second_moments(self) -> NDArray[Any]:
        return np.zeros((2, 0, 0), DTYPE)

    @property
    def second_pixels(self) -> NDArray[np.int64]:
        return np.zeros((0, 0), np.int64)
