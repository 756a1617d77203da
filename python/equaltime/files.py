"""Writes files completely or not at all, removes temporary files of killed processes, and locks open files."""

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
    """Take the exclusive lock on the open file ``descriptor``; wait while another process holds the lock.

    Raises `OSError` if the system has no locks on files.
    """
    _flock(descriptor, wait=True)


def try_lock(descriptor: int) -> None:
    """Take the exclusive lock on the open file ``descriptor`` without waiting.

    Raises `BlockingIOError` if another process holds the lock, and another `OSError` if the system has no file locks.
    """
    _flock(descriptor, wait=False)


def _flock(descriptor: int, wait: bool) -> None:
    if fcntl is None:
        raise OSError(errno.ENOTSUP, "this system has no locks on files")
    fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


_NUMBERS = count()
"""Counter for names of temporary files: two of them at a time in one folder have different names."""


def to_disk(path: Path) -> None:
    """Wait until the data at ``path`` is on the disk: a file's content, or the names in a folder.

    Raises `OSError` if the system cannot write the data, such as on a full disk.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield the path of an empty temporary file beside ``path``; at the end of the block, rename it to ``path``.

    If the block raises, the temporary file is removed, and an existing file at ``path`` stays unchanged. A symbolic
    link stays a link, and its target is replaced. The new file gets the mode of the file that it replaces. Raises
    `OSError` if the file cannot be written, or if ``path`` is a pipe, a socket or a device.
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
    """Rename ``temporary``, a file that `beside` made, to ``path``; raises `FileExistsError` if ``path`` exists.

    Even if the process is killed, ``path`` is the complete file or does not exist. On a file system without hard
    links, a killed process may also leave an empty file at ``path``.
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
    """Make a folder and its missing parents, and wait until the names of all new folders are on the disk."""
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
    """Yield the path of an empty temporary file in the folder of ``path``, and remove that file after the block.

    A file that the block has renamed is kept. If the process is killed, its temporary file stays, until the next
    process that writes in the folder removes it. A lock marks a file that is being written, and ends with its process.
    Some network folders do not share locks between machines. Each temporary name therefore holds the machine's name,
    and other machines' files are left alone. Pass ``tidied`` if `tidy` was just called for this folder: `tidy`, which
    is slow in a large folder, is then skipped.
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
    """Remove the temporary files that killed processes of this machine left in ``folder``.

    Files that cannot be removed are skipped without an error.
    """
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
