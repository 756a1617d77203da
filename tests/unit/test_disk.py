"""Files that take the place of others: what a process that is killed leaves, and what others are writing meanwhile."""

from __future__ import annotations

import errno
import fcntl
import os
import signal
import subprocess
import sys
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from equaltime import files as disk
from equaltime.experiments.run.folder import replacing
from equaltime.images import image_files as images

_KILLED = """
import os, signal, sys
from pathlib import Path
from equaltime.files import replacing
with replacing(Path(sys.argv[1])) as file:
    file.write_bytes(b"half")
    os.kill(os.getpid(), signal.{signal})
"""


def begin(output: Path, number: signal.Signals) -> subprocess.Popen[bytes]:
    """Begin to write a file in another process, which a signal meets half way."""
    return subprocess.Popen([sys.executable, "-c", _KILLED.format(signal=number.name), str(output)])


def write(output: Path) -> None:
    with disk.replacing(output) as file:
        file.write_bytes(b"whole")


def parts(folder: Path) -> list[Path]:
    return list(folder.glob(".equaltime-*.part"))


def test_what_a_killed_process_left_is_removed_by_the_next_that_writes_there(tmp_path: Path) -> None:
    assert begin(tmp_path / "a.exr", signal.SIGKILL).wait() == -signal.SIGKILL
    assert [part.read_bytes() for part in parts(tmp_path)] == [b"half"]
    write(tmp_path / "b.exr")
    assert [file.name for file in tmp_path.iterdir()] == ["b.exr"]


def test_what_a_living_process_writes_is_left_alone(tmp_path: Path) -> None:
    process = begin(tmp_path / "a.exr", signal.SIGSTOP)
    try:
        os.waitpid(process.pid, os.WUNTRACED)
        write(tmp_path / "b.exr")
        assert [part.read_bytes() for part in parts(tmp_path)] == [b"half"]
    finally:
        process.send_signal(signal.SIGCONT)
    assert process.wait() == 0
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {"a.exr": b"half", "b.exr": b"whole"}


def test_an_image_that_another_thread_writes_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The image library opens the file once more, by its name: it must be the one that is locked."""
    pixels = np.ones((4, 4, 3))

    def meanwhile(part: Path) -> None:
        monkeypatch.undo()
        thread = Thread(target=images.write_exr, args=(tmp_path / "b.exr", pixels))
        thread.start()
        thread.join()
        assert parts(tmp_path) == [part]

    monkeypatch.setattr(disk, "to_disk", meanwhile)
    images.write_exr(tmp_path / "a.exr", pixels)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.exr", "b.exr"]


def test_two_files_that_one_thread_writes_at_a_time_do_not_wait_for_each_other(tmp_path: Path) -> None:
    nested = """
import sys
from pathlib import Path
from equaltime.files import replacing
path = Path(sys.argv[1])
with replacing(path) as outer:
    outer.write_bytes(b"outer")
    with replacing(path) as inner:
        inner.write_bytes(b"inner")
    assert path.read_bytes() == b"inner"
"""
    subprocess.run([sys.executable, "-c", nested, str(tmp_path / "a")], check=True, timeout=60)
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("a", b"outer")]


@pytest.fixture
def synced(monkeypatch: pytest.MonkeyPatch) -> list[Path | str]:
    """The files and folders that were brought to the disk so far, and ``renamed`` in between."""
    events, sync, rename, link = list[Path | str](), os.fsync, os.replace, os.link

    def noted_sync(descriptor: int) -> None:
        events.append(Path(f"/proc/self/fd/{descriptor}").resolve())
        sync(descriptor)

    def noted_rename(old: Path, new: Path) -> None:
        rename(old, new)
        events.append("renamed")

    monkeypatch.setattr(os, "fsync", noted_sync)

    def noted_link(old: Path, new: Path) -> None:
        link(old, new)
        events.append("renamed")

    monkeypatch.setattr(os, "replace", noted_rename)
    monkeypatch.setattr(os, "link", noted_link)
    return events


def test_the_name_of_a_file_is_on_the_disk_like_its_content(tmp_path: Path, synced: list[Path | str]) -> None:
    with disk.replacing(tmp_path / "a") as file:
        pass
    assert synced == [file, "renamed", tmp_path]
    synced.clear()
    with disk.beside(tmp_path / "b") as file:
        disk.give_new_name(file, tmp_path / "b")
    assert synced == [file, "renamed", tmp_path]


def test_the_names_of_new_folders_are_on_the_disk(tmp_path: Path, synced: list[Path | str]) -> None:
    with replacing(tmp_path / "out" / "images" / "box" / "a.npy"):
        pass
    out = tmp_path / "out"
    assert set(synced) >= {tmp_path, out, out / "images", out / "images" / "box"}
    assert synced[-1] == out / "images" / "box"


def test_a_folder_that_cannot_be_brought_to_the_disk_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sync = disk.to_disk

    def files_alone(path: Path) -> None:
        if path.is_dir():
            raise OSError
        sync(path)

    monkeypatch.setattr(disk, "to_disk", files_alone)
    write(tmp_path / "a")
    assert (tmp_path / "a").read_bytes() == b"whole"


def test_a_new_name_is_never_that_of_another_file(tmp_path: Path) -> None:
    new, there = tmp_path / "new", tmp_path / "there"
    there.symlink_to("nowhere")
    with disk.beside(there) as file:
        file.write_bytes(b"whole")
        with pytest.raises(FileExistsError):
            disk.give_new_name(file, there)
        disk.give_new_name(file, new)
    assert there.is_symlink()
    assert new.read_bytes() == b"whole"
    assert not parts(tmp_path)


def test_a_process_killed_while_it_names_a_new_file_leaves_no_empty_one(tmp_path: Path) -> None:
    killed = """
import os, signal, sys
from pathlib import Path
from equaltime import files as disk
os.link = os.replace = lambda old, new: os.kill(os.getpid(), signal.SIGKILL)
path = Path(sys.argv[1])
with disk.beside(path) as file:
    disk.give_new_name(file, path)
"""
    ended = subprocess.run([sys.executable, "-c", killed, str(tmp_path / "a")], check=False, timeout=60)
    assert ended.returncode == -signal.SIGKILL
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize("interrupted", [False, True])
def test_a_new_name_without_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interrupted: bool) -> None:
    def no_links(*_: object) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "link", no_links)
    with disk.beside(tmp_path / "a") as file:
        file.write_bytes(b"whole")
        if interrupted:
            monkeypatch.setattr(os, "replace", interrupt)
            with pytest.raises(KeyboardInterrupt):
                disk.give_new_name(file, tmp_path / "a")
        else:
            disk.give_new_name(file, tmp_path / "a")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == ([] if interrupted else [b"whole"])


def test_a_name_that_is_taken_costs_no_sync(tmp_path: Path, synced: list[Path | str]) -> None:
    (tmp_path / "a").touch()
    with disk.beside(tmp_path / "a") as file, pytest.raises(FileExistsError):
        disk.give_new_name(file, tmp_path / "a")
    assert not synced


def test_what_cannot_be_judged_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    others = {".equaltime-another-machine-17-7f.part", ".equaltime-17-7f.part", ".equaltime-17.part", "mine.part"}
    for name in others:
        (tmp_path / name).touch()
    write(tmp_path / "a.exr")
    assert {file.name for file in tmp_path.iterdir()} == {*others, "a.exr"}
    begin(tmp_path / "a.exr", signal.SIGKILL).wait()

    def no_locks(*_: int) -> None:
        raise OSError

    monkeypatch.setattr(fcntl, "flock", no_locks)
    write(tmp_path / "a.exr")
    assert len(parts(tmp_path)) == len(others), "one more than those of others"


def test_a_file_that_was_finished_while_it_was_judged_does_not_take_the_next_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin(tmp_path / "a.exr", signal.SIGKILL).wait()
    (part,) = parts(tmp_path)
    lock = fcntl.flock

    def finished_before(descriptor: int, operation: int) -> None:
        if operation & fcntl.LOCK_NB:
            part.rename(tmp_path / "a.exr")
            part.write_bytes(b"next")
        lock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", finished_before)
    write(tmp_path / "b.exr")
    assert part.read_bytes() == b"next"


def test_a_file_that_was_tidied_away_before_it_was_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock, taken = fcntl.flock, []

    def tidied_before(descriptor: int, operation: int) -> None:
        if not taken:
            taken.extend(parts(tmp_path))
            taken[0].unlink()
        lock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", tidied_before)
    write(tmp_path / "a.exr")
    assert taken
    assert (tmp_path / "a.exr").read_bytes() == b"whole"
