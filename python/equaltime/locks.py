"""Locks on open files, which end with the process that holds them."""

from __future__ import annotations

import errno

try:
    import fcntl
except ImportError:  # a system without POSIX locks
    fcntl = None  # type: ignore[assignment]  # looked at before every use

__all__ = ["lock", "try_lock"]


def lock(descriptor: int) -> None:
    """Wait until nobody else has the lock on a file, and take it; raises `OSError` where there are no locks."""
    _flock(descriptor, wait=True)


def try_lock(descriptor: int) -> None:
    """Take the lock on a file; raises `BlockingIOError` if somebody has it, another `OSError` without locks."""
    _flock(descriptor, wait=False)


def _flock(descriptor: int, wait: bool) -> None:
    if fcntl is None:
        raise OSError(errno.ENOTSUP, "this system has no locks on files")
    fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
