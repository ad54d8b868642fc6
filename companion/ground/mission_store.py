"""The folder of uploaded files, and what clients of MAVLink FTP may do in it.

A door: it opens files, all below one folder. Rules:
1. A path is a list of names between slashes, always from the root, with or without a slash in
   front. `upload_names.py` defines valid names: `..`, NUL, backslash and hidden files are not.
2. Each folder on the path is opened relative to the previous one, and never through a symbolic
   link. So no path leaves the root, whatever is stored there and whoever changes it meanwhile.
3. A file has at most 256 KiB. There are at most 64 files, 64 folders, and 4 MiB in all.
4. A file is written under a name that no client can use, in its folder, and then renamed.
5. Only the companion writes `verdict.json`; clients may read it.

Writing does not wait for the disk (fsync), as a tick would wait with it. After a power cut an
upload may be missing; a mission that was accepted but not flown is checked again (`uploads.py`).
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from companion.ground.ftp_sessions import MAX_FILE_BYTES
from companion.ground.upload_names import ENDINGS, MAX_DEPTH, NAME
from companion.mavlink.ftp_frames import FtpRefusal, Nak

VERDICT = "verdict.json"
MAX_FILES = 64
MAX_FOLDERS = 64
MAX_TOTAL_BYTES = 4 * 1024 * 1024

_TEMPORARY = ".new"
_FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_NAKS = {
    errno.ENOENT: Nak.FILE_NOT_FOUND,
    errno.ENOTDIR: Nak.FILE_NOT_FOUND,
    errno.ELOOP: Nak.FILE_NOT_FOUND,  # a symbolic link
    errno.EISDIR: Nak.FAIL,
    errno.EEXIST: Nak.FILE_EXISTS,
    errno.EACCES: Nak.FILE_PROTECTED,
    errno.EPERM: Nak.FILE_PROTECTED,
}


def names_of(path: str) -> tuple[str, ...]:
    """Returns the names of a path; none for the root.

    Raises:
        FtpRefusal: the path is not valid.

    >>> names_of("/maps/hall.yaml")
    ('maps', 'hall.yaml')
    """
    names = tuple(name for name in path.split("/") if name)
    if len(names) > MAX_DEPTH or not all(map(NAME.fullmatch, names)):
        raise FtpRefusal(Nak.FILE_NOT_FOUND)
    return names


class MissionStore:
    """The files below a folder, as `FtpServer` uses them.

    Args:
        root: created if missing.
    """

    def __init__(self, root: Path) -> None:
        root.mkdir(parents=True, exist_ok=True)
        self.root = root.resolve()

    def entries(self, path: str) -> list[str]:
        """Returns a folder's entries in the protocol's form: Dname; or Fname, a tab, the size."""
        with self._open(names_of(path)) as folder:
            return sorted(
                f"D{name}" if stat.S_ISDIR(status.st_mode) else f"F{name}\t{status.st_size}"
                for name, status in _listed(folder)
            )

    def read(self, path: str) -> bytes:
        """Returns the content of a file."""
        with self._place(path) as (folder, name):
            return _content(folder, name)

    def check_writable(self, path: str) -> None:
        """Raises unless a file can be written there."""
        with self._place(path) as (folder, name):
            self._check_new(folder, name, 0)

    def write(self, path: str, content: bytes) -> None:
        """Creates or replaces a file in one step."""
        with self._place(path) as (folder, name):
            self._check_new(folder, name, len(content))
            _replace(folder, name, content)

    def publish(self, verdict: bytes) -> None:
        """Writes `verdict.json`, which clients can only read."""
        with self._open(()) as folder:
            _replace(folder, VERDICT, verdict)

    def remove(self, path: str) -> None:
        """Removes a file, but not `verdict.json`."""
        with self._place(path) as (folder, name):
            _check_ours(name)
            os.unlink(name, dir_fd=folder)

    def make_folder(self, path: str) -> None:
        """Makes a folder in one that exists, up to 64 of them."""
        with self._place(path) as (folder, name):
            _check_ours(name)
            if sum(1 for _, is_folder, _ in self._all(()) if is_folder) >= MAX_FOLDERS:
                raise FtpRefusal(Nak.FAIL_ERRNO, errno.ENOSPC)
            os.mkdir(name, 0o700, dir_fd=folder)

    def remove_folder(self, path: str) -> None:
        """Removes an empty folder."""
        with self._place(path) as (folder, name):
            os.rmdir(name, dir_fd=folder)

    def rename(self, old: str, new: str) -> None:
        """Renames a file; replaces nothing."""
        with self._place(old) as (source, old_name), self._place(new) as (target, new_name):
            if stat.S_ISDIR(_status(source, old_name).st_mode):
                raise FtpRefusal(Nak.FILE_PROTECTED)
            _check_ours(old_name)
            _check_file_name(new_name)
            if _status_if_any(target, new_name) is not None:
                raise FtpRefusal(Nak.FILE_EXISTS)
            os.rename(old_name, new_name, src_dir_fd=source, dst_dir_fd=target)

    def copy_to(self, target: Path) -> None:
        """Creates a folder with all files as they are now.

        They are hard links, which is quick. As files are only ever replaced, the copy does not
        change.
        """
        target.mkdir(parents=True)
        for names, is_folder, _ in self._all(()):
            if is_folder:
                target.joinpath(*names).mkdir()
            elif names != (VERDICT,):
                os.link(self.root.joinpath(*names), target.joinpath(*names), follow_symlinks=False)

    def _check_new(self, folder: int, name: str, size: int) -> None:
        """Raises unless a file of this size may be written."""
        _check_file_name(name)
        if size > MAX_FILE_BYTES:
            raise FtpRefusal(Nak.FAIL_ERRNO, errno.EFBIG)
        sizes = [status.st_size for _, is_folder, status in self._all(()) if not is_folder]
        files, total_bytes = len(sizes) + 1, sum(sizes) + size
        replaced = _status_if_any(folder, name)
        if replaced is not None:
            if not stat.S_ISREG(replaced.st_mode):
                raise FtpRefusal(Nak.FILE_EXISTS)
            files, total_bytes = files - 1, total_bytes - replaced.st_size
        if files > MAX_FILES or total_bytes > MAX_TOTAL_BYTES:
            raise FtpRefusal(Nak.FAIL_ERRNO, errno.ENOSPC)

    def _all(
        self, names: tuple[str, ...]
    ) -> Iterator[tuple[tuple[str, ...], bool, os.stat_result]]:
        """Yields everything below a folder: names, whether it is a folder, status; a folder before
        its content.
        """
        with self._open(names) as folder:
            listed = _listed(folder)
        for name, status in listed:
            is_folder = stat.S_ISDIR(status.st_mode)
            yield (*names, name), is_folder, status
            if is_folder:
                yield from self._all((*names, name))

    @contextmanager
    def _open(self, names: tuple[str, ...]) -> Iterator[int]:
        """Opens a folder, name by name."""
        folder = -1
        try:
            folder = os.open(self.root, _FOLDER)
            for name in names:
                inner = os.open(name, _FOLDER, dir_fd=folder)
                os.close(folder)
                folder = inner
            yield folder
        except OSError as error:
            number = error.errno or 0
            raise FtpRefusal(_NAKS.get(number, Nak.FAIL_ERRNO), number % 256) from error
        finally:
            if folder >= 0:
                os.close(folder)

    @contextmanager
    def _place(self, path: str) -> Iterator[tuple[int, str]]:
        """Opens the folder of a path; yields it and the last name of the path."""
        names = names_of(path)
        if not names:
            raise FtpRefusal(Nak.FILE_PROTECTED)  # the root itself
        with self._open(names[:-1]) as folder:
            yield folder, names[-1]


def _listed(folder: int) -> list[tuple[str, os.stat_result]]:
    """Returns the files and folders in a folder that are visible to clients."""
    listed = [(name, _status(folder, name)) for name in os.listdir(folder) if NAME.fullmatch(name)]
    return [(n, s) for n, s in listed if stat.S_ISDIR(s.st_mode) or stat.S_ISREG(s.st_mode)]


def _status(folder: int, name: str) -> os.stat_result:
    return os.stat(name, dir_fd=folder, follow_symlinks=False)


def _status_if_any(folder: int, name: str) -> os.stat_result | None:
    try:
        return _status(folder, name)
    except FileNotFoundError:
        return None


def _check_ours(name: str) -> None:
    if name == VERDICT:
        raise FtpRefusal(Nak.FILE_PROTECTED)


def _check_file_name(name: str) -> None:
    if not name.endswith(ENDINGS):
        raise FtpRefusal(Nak.FILE_PROTECTED)


def _content(folder: int, name: str) -> bytes:
    file = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=folder)
    with os.fdopen(file, "rb") as stream:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            raise FtpRefusal(Nak.FILE_NOT_FOUND)
        return stream.read(MAX_FILE_BYTES)


def _replace(folder: int, name: str, content: bytes) -> None:
    """Writes a file under another name, and renames it into its place."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC
    with os.fdopen(os.open(_TEMPORARY, flags, 0o600, dir_fd=folder), "wb") as stream:
        stream.write(content)
    os.rename(_TEMPORARY, name, src_dir_fd=folder, dst_dir_fd=folder)
