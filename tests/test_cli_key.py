"""`companion key` as a user meets it, and the commands that take a key."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import Companion

from companion.mavlink.key_file import make_key, read_key
from companion.mavlink.signing import SigningKey

MISSION = Path(__file__).parents[1] / "missions" / "surveillance.yaml"


def test_a_key_is_made_and_shown(companion: Companion, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.key"
    made = companion("key", "make", path)
    secret = read_key(path).secret.hex()
    assert made.code == 0 and str(path) in made.out and secret not in made.out
    shown = companion("key", "show", path)
    assert (shown.code, shown.out) == (0, f"{secret}\n")
    again = companion("key", "make", path)
    assert again.code == 2 and f"{path} is there already" in again.err


def test_a_passphrase_is_asked_for(
    companion: Companion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("getpass.getpass", lambda *_, **__: "correct horse")
    path = tmp_path / "vehicle.key"
    assert companion("key", "make", path, "--passphrase").code == 0
    assert read_key(path).secret == SigningKey.from_passphrase("correct horse").secret


@pytest.mark.parametrize(
    "command", [("run", MISSION), ("upload", MISSION), ("watch",)], ids=lambda c: c[0]
)
def test_a_key_that_others_can_read_is_used_by_no_command(
    companion: Companion, tmp_path: Path, command: tuple[object, ...]
) -> None:
    make_key(path := tmp_path / "vehicle.key", None)
    path.chmod(0o644)
    ended = companion(*command, "--signing-key", path, "--connect", "udpin://127.0.0.1:0")
    assert ended.code == 2 and "chmod 600" in ended.err


def test_an_unsigned_vehicle_needs_a_key(companion: Companion) -> None:
    ended = companion("watch", "--unsigned-vehicle")
    assert ended.code == 2 and "needs a --signing-key" in ended.err
