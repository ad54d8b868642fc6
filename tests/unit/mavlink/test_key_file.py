"""Key files are their owner's alone, and time stamps come back as they were written."""

from __future__ import annotations

import os
import stat
import threading
from contextlib import closing
from pathlib import Path

import pytest

from companion.errors import CompanionError
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.key_file import StampFile, make_key, read_key, signing_by
from companion.mavlink.signing import SigningKey, harmless

FRAME = MavlinkCodec(1, 1).pack(dialect.MAVLink_system_time_message(0, 0))


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    make_key(tmp_path / "a.key", None)
    return tmp_path / "a.key"


def test_a_key_is_random_and_its_file_is_the_owner_s(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        for name in ("a", "b"):
            make_key(tmp_path / name, None)
    finally:
        os.umask(before)
    assert mode(tmp_path / "a") == 0o600
    assert read_key(tmp_path / "a").secret != read_key(tmp_path / "b").secret
    assert (tmp_path / "a").read_text() == read_key(tmp_path / "a").secret.hex() + "\n"


def test_a_key_of_a_passphrase(tmp_path: Path) -> None:
    make_key(tmp_path / "a", "correct horse")
    assert read_key(tmp_path / "a").secret == SigningKey.from_passphrase("correct horse").secret


def test_a_key_that_is_there_is_not_replaced(key_file: Path) -> None:
    before = key_file.read_bytes()
    with pytest.raises(CompanionError, match="is there already"):
        make_key(key_file, None)
    assert key_file.read_bytes() == before


@pytest.mark.parametrize("others", [0o040, 0o004, 0o020, 0o002, 0o644])
def test_a_key_that_others_have_access_to_is_refused(key_file: Path, others: int) -> None:
    key_file.chmod(0o600 | others)
    with pytest.raises(CompanionError, match=r"others may read .*\n.*chmod 600"):
        read_key(key_file)


@pytest.mark.parametrize("content", [b"", b"00" * 31, b"\xff" * 64, b"00" * 500])
def test_a_file_without_a_key_is_refused_by_its_name(key_file: Path, content: bytes) -> None:
    key_file.write_bytes(content)
    with pytest.raises(CompanionError, match=r"a\.key: a signing key is|has 32 bytes"):
        read_key(key_file)


def test_a_missing_key_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(CompanionError, match=r"companion key make .*none"):
        read_key(tmp_path / "none")


def test_without_a_file_there_is_no_signing() -> None:
    with signing_by(None, "run", harmless) as signing:
        assert signing is None


def test_old_captures_are_refused_after_a_restart(key_file: Path) -> None:
    """By the files alone, whatever the clock says."""
    with signing_by(key_file, "run", harmless) as first, signing_by(key_file, "x", harmless) as x:
        assert first is not None and x is not None
        captured = x.send(0.0, [FRAME])
        assert first.receive(0.0, captured) == captured
    with signing_by(key_file, "run", harmless) as second:
        assert second is not None
        assert second.receive(0.0, captured) == []
        later = x.send(60.0, [FRAME])
        assert second.receive(60.0, later) == later
    stamps = key_file.with_name("a.key.run.stamps")
    assert mode(stamps) == 0o600 and '"1/1/0"' in stamps.read_text()
    assert read_key(key_file).secret.hex() not in stamps.read_text()


def test_stamps_come_back_and_the_newest_win(tmp_path: Path) -> None:
    path = tmp_path / "stamps"
    with closing(StampFile(path)) as file:
        assert file.read() == {}
        for number in range(100):
            file.write_soon({(1, 191, 0): number, (255, 190, 7): 2**46 + number})
    with closing(StampFile(path)) as file:
        assert file.read() == {(1, 191, 0): 99, (255, 190, 7): 2**46 + 99}
    assert [p.name for p in tmp_path.iterdir()] == ["stamps"]


@pytest.mark.parametrize("text", ["", "[1]", '{"1/1": 3}', '{"1/1/0": -1}', '{"1/1/0": 1e99}', "7"])
def test_stamps_that_are_spoilt_are_told(tmp_path: Path, text: str) -> None:
    path = tmp_path / "stamps"
    path.write_text(text)
    with closing(StampFile(path)) as file, pytest.raises(CompanionError, match="cannot read"):
        file.read()


def test_a_disk_that_is_full_ends_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with closing(StampFile(tmp_path / "missing" / "stamps")) as file:
        for number in range(3):
            file.write_soon({(1, 1, 0): number})
    assert len(caplog.records) == 1


def test_no_thread_is_left(key_file: Path) -> None:
    before = threading.active_count()
    with signing_by(key_file, "run", harmless):
        assert threading.active_count() == before + 1
    assert threading.active_count() == before
