"""Files of message signing: the key, and beside it the newest time stamps that were accepted.

1. A key file contains 64 hexadecimal digits, and only its owner may read it.
2. Each program keeps its own time stamps, in `KEY.PROGRAM.stamps`.
3. A thread writes the time stamps and replaces the file as a whole, so that no loop waits for a
   disk.

A door of the composition roots; `signing.py` has the rules of signing.
"""

from __future__ import annotations

import json
import logging
import os
import secrets
import stat
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from companion.errors import CompanionError, RequestError
from companion.mavlink.signing import (
    KEY_BYTES,
    LATEST,
    MayBeUnsigned,
    Signing,
    SigningKey,
    Stamps,
    Stream,
)

OWNER_ONLY = stat.S_IRUSR | stat.S_IWUSR
OTHERS = stat.S_IRWXG | stat.S_IRWXO

log = logging.getLogger(__name__)


def make_key(path: Path, passphrase: str | None) -> None:
    """Makes a key file, with a random key or the one that QGroundControl makes of a passphrase.

    Raises:
        RequestError: the file exists already.
        CompanionError: it cannot be written.
    """
    key = (
        SigningKey(secrets.token_bytes(KEY_BYTES))
        if passphrase is None
        else SigningKey.from_passphrase(passphrase)
    )
    try:
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, OWNER_ONLY), "w") as f:
            f.write(key.secret.hex() + "\n")
    except FileExistsError:
        hint = "remove it if nothing is signed with it any more, or choose another"
        raise RequestError(f"{path} is there already\n    {hint}") from None
    except OSError as error:
        raise CompanionError(f"cannot make the key file {path}: {error.strerror}") from error


def read_key(path: Path) -> SigningKey:
    """The key in a file.

    Raises:
        RequestError: the file cannot be read, others can read it, or it contains no key.
    """
    try:
        with path.open(encoding="ascii") as file:
            mode, text = os.fstat(file.fileno()).st_mode, file.read(4 * KEY_BYTES)
    except OSError as error:
        raise RequestError(
            f"cannot read the key file {path}: {error.strerror}\n"
            f"    companion key make {path} makes one"
        ) from error
    except ValueError:
        mode, text = 0, ""
    if mode & OTHERS:
        raise RequestError(
            f"others may read the key file {path}\n"
            f"    chmod 600 {path}; if others could have read it, make another key"
        )
    try:
        return SigningKey.from_hex(text.strip())
    except CompanionError as error:
        raise RequestError(f"{path}: {error}") from None


@contextmanager
def signing_by(
    path: Path | None, program: str, may_be_unsigned: MayBeUnsigned
) -> Iterator[Signing | None]:
    """Signs with the key of a file while the context lasts; None without a file.

    Args:
        path: the key file.
        program: who signs; each program has its own time stamps.
        may_be_unsigned: which frames need no signature.

    Raises:
        CompanionError: the key or the time stamps cannot be read.
    """
    if path is None:
        yield None
        return
    key = read_key(path)
    with closing(StampFile(path.with_name(f"{path.name}.{program}.stamps"))) as file:
        yield Signing(key, time.time(), may_be_unsigned, file.read(), file.write_soon)


class StampFile:
    """The time stamps of one program."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._news = threading.Condition()
        self._next: Stamps | None = None
        self._is_closing = False
        self._writer = threading.Thread(target=self._write, daemon=True)
        self._writer.start()

    def read(self) -> dict[Stream, int]:
        """The time stamps of the previous run; none if there was none.

        Raises:
            CompanionError: the file exists and cannot be read.
        """
        try:
            return _stamps_of(self._path.read_text(encoding="ascii"))
        except FileNotFoundError:
            return {}
        except (OSError, TypeError, ValueError) as error:
            raise CompanionError(
                f"cannot read {self._path}, by which old messages are refused: {error}\n"
                "    without it, what was sent in the last minute before now may be sent again"
            ) from error

    def write_soon(self, stamps: Stamps) -> None:
        """Lets the thread write the stamps, instead of any that still wait."""
        with self._news:
            self._next = stamps
            self._news.notify()

    def close(self) -> None:
        """Writes the stamps that still wait, and ends the thread."""
        with self._news:
            self._is_closing = True
            self._news.notify()
        self._writer.join()

    def _write(self) -> None:
        has_failed = False
        while (stamps := self._taken()) is not None:
            try:
                _replace(self._path, _text_of(stamps))
            except OSError as error:  # a full disk must not end a flight
                if not has_failed:
                    log.warning("cannot write %s: %s", self._path, error.strerror)
                has_failed = True

    def _taken(self) -> Stamps | None:
        """Waits for the next stamps to write; None at the end."""
        with self._news:
            self._news.wait_for(lambda: self._next is not None or self._is_closing)
            stamps, self._next = self._next, None
            return stamps


def _text_of(stamps: Stamps) -> str:
    named = {"/".join(map(str, stream)): stamp for stream, stamp in stamps.items()}
    return json.dumps(named, indent=1) + "\n"


def _stamps_of(text: str) -> dict[Stream, int]:
    """The stamps in the text of a file.

    Raises:
        TypeError, ValueError: it contains something else.
    """
    stamps = {}
    for name, stamp in dict(json.loads(text)).items():
        system, component, link = (int(part) for part in name.split("/"))
        if type(stamp) is not int or not 0 <= stamp < LATEST:
            raise ValueError(f"{stamp} is not a time stamp")
        stamps[system, component, link] = stamp
    return stamps


def _replace(path: Path, text: str) -> None:
    """Replaces a file as a whole, and flushes it to the disk."""
    partial = path.with_name(path.name + ".part")
    with os.fdopen(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, OWNER_ONLY), "w") as f:
        f.write(text)
        f.flush()
        os.fsync(f.fileno())
    os.replace(partial, path)
