"""Writes files completely or not at all, removes files that killed processes left, and locks open files."""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from urllib.parse import quote

__all__ = ["beside", "give_new_name", "lock", "make_folder", "replacing", "tidy", "to_disk", "try_lock"]


try:
    import fcntl
except ImportError:  # a system without POSIX locks
    fcntl = None  # type: ignore[assignment]  # looked at before every use


def lock(descriptor: int) -> None:
    """Take the exclusive lock on an open file; wait while another process holds the lock.

    Raises `OSError` if the system has no locks on files.
    """
    _flock(descriptor, wait=True)


def try_lock(descriptor: int) -> None:
    """Take the exclusive lock on an open file without waiting.

    Raises `BlockingIOError` if another process holds the lock, and another `OSError` if there are no locks.
    """
    _flock(descriptor, wait=False)


def _flock(descriptor: int, wait: bool) -> None:
    if fcntl is None:
        raise OSError(errno.ENOTSUP, "this system has no locks on files")
    fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


_NUMBERS = count()
"""Counter for names of temporary files: two of them at a time in one folder have different names."""


def to_disk(path: Path) -> None:
    """Wait until a file's content, or the names in a folder, are on the disk.

    Raises `OSError`: a full disk may be noticed only here.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield an empty temporary file beside ``path``, and rename the file to ``path`` at the end of the block.

    If the block raises, the temporary file is removed, and an existing file at ``path`` stays unchanged. A symbolic
    link stays a link: its target is replaced, and the new file gets the target's mode. Raises `OSError`, also if
    ``path`` is a pipe, a socket or a device.
    """
    path = Path(os.path.realpath(path))
    mode = _mode(path)
    with beside(path) as temporary:
        if mode is not None:
            temporary.chmod(mode)
        yield temporary
        to_disk(temporary)  # a machine that stops after the renaming must find the whole file
        os.replace(temporary, path)
        _name_to_disk(path)


def give_new_name(temporary: Path, path: Path) -> None:
    """Give a temporary file of `beside` the new name ``path``; raises `FileExistsError` if the name is taken.

    If the process is killed, ``path`` is the complete file or does not exist. On a file system without hard links,
    ``path`` may then also be an empty file.
    """
    if os.path.lexists(path):  # before the file is synced, which takes long
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    to_disk(temporary)
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:  # no links here, or a failure that the other way meets too
        _rename_to_new(temporary, path)
    _name_to_disk(path)


def _rename_to_new(temporary: Path, path: Path) -> None:
    """Rename a file to a name that is reserved first; raises `FileExistsError` if it is taken."""
    os.close(os.open(path, os.O_CREAT | os.O_EXCL, 0o666))
    try:
        os.replace(temporary, path)
    except BaseException:
        path.unlink(missing_ok=True)
        raise


def make_folder(path: Path) -> None:
    """Make a folder and its missing parents. On return, the names of all new folders are on the disk."""
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for folder in missing:
        _name_to_disk(folder)


def _name_to_disk(path: Path) -> None:
    """Wait until a new name is on the disk. A folder that refuses is no error: the file is there in any case."""
    with suppress(OSError):
        to_disk(path.parent)


@contextmanager
def beside(path: Path, tidied: bool = False) -> Iterator[Path]:
    """Yield an empty temporary file in the folder of ``path``; at the end of the block, remove it if not renamed.

    If the process is killed, its temporary file stays. The next process that writes in the folder removes that file.
    A lock marks a file that is being written; the lock ends with the process. Some network folders do not share locks
    between machines. The file's name therefore holds the machine's name, and other machines' files are left alone.
    ``tidied`` says that the caller has just called `tidy` for this folder, which takes time in a large folder.
    """
    if not tidied:
        tidy(path.parent)
    # without the name itself, which may already be as long as a name can be
    temporary = path.with_name(f"{_machine()}-{os.getpid()}-{next(_NUMBERS):x}.part")
    descriptor = _locked(temporary)
    try:
        yield temporary
    except OSError as error:
        if error.filename is not None:
            raise
        # a write knows no name, and NumPy's no number either
        raise OSError(error.errno or errno.EIO, error.strerror or str(error), str(path)) from error
    finally:
        with suppress(OSError):  # the disk's own complaint counts
            temporary.unlink(missing_ok=True)
        os.close(descriptor)


def _mode(path: Path) -> int | None:
    """Return the mode of a file that is to be replaced, None if there is none; raises OSError if it is no file."""
    try:
        found = path.stat().st_mode
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(found):
        raise OSError(errno.EINVAL, "is a pipe, a socket or a device, and no file", str(path))
    return stat.S_IMODE(found)


def tidy(folder: Path) -> None:
    """Remove the temporary files in ``folder`` that killed processes of this machine left, as far as possible."""
    part = re.compile(re.escape(_machine()) + r"-\d+-[0-9a-f]+\.part")
    with suppress(OSError):
        for left in [file for file in folder.iterdir() if part.fullmatch(file.name)]:
            with suppress(OSError):
                _remove_if_left(left)


def _machine() -> str:
    return f".equaltime-{quote(os.uname().nodename, safe='')}"


def _locked(path: Path) -> int:
    """Make a file, and lock it; who tidies may have taken it in between."""
    while True:
        descriptor = os.open(path, os.O_CREAT | os.O_RDWR, 0o666)
        with suppress(OSError):  # where there are no locks, nobody takes it
            lock(descriptor)
        if _is(path, descriptor):
            return descriptor
        os.close(descriptor)


def _is(path: Path, descriptor: int) -> bool:
    """Tell whether a file that was opened still has its name."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False


def _remove_if_left(part: Path) -> None:
    descriptor = os.open(part, os.O_RDWR)
    try:
        try_lock(descriptor)  # OSError if somebody writes it
        if _is(part, descriptor):  # and not another by now, since this one was finished
            part.unlink()
    finally:
        os.close(descriptor)
