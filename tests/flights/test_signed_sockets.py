"""Simulator, companion, upload and watch with keys, as commands over UDP: docs/signing.md.

Nothing without the key is answered, and what is forged on the way disturbs nobody.
"""

from __future__ import annotations

import os
import shlex
import signal
import socket
from pathlib import Path

import pytest
from ports import free_instance, own_ports
from test_sockets import Run, run
from test_uploads import ANSWER_S, MISSION, START_S, like_the_papers

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.key_file import make_key, read_key

pytestmark = pytest.mark.sockets
__all__ = ["run"]

SITL = "sitl --scenario missions/surveillance.sim.yaml --signing-key vehicle.key"
RUN = "companion run --signing-key vehicle.key"
SIGNED_UPLOAD = "companion upload missions/surveillance.yaml --start --signing-key vehicle.key"
SIGNED_WATCH = "companion watch --signing-key vehicle.key"


def test_a_signed_upload_is_flown_and_watched_to_its_end(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COMPANION_LOG_DIR", str(tmp_path / "runs"))
    number, key = free_instance(), tmp_path / "vehicle.key"
    make_key(key, None)
    make_key(other := tmp_path / "other.key", None)
    ports = {"14550": str(14550 + number), "14540": str(14540 + number)}
    ground = ("--connect", f"udpin://0.0.0.0:{ports['14550']}")

    def ours(command: str, *more: object) -> tuple[object, ...]:
        return (*shlex.split(command.replace("vehicle.key", str(key))), *more)

    hop = like_the_papers(tmp_path, "hop", "F at(A) & F G at(Home)")
    missions = MISSION.parent
    simulator = run(*ours(SITL.replace("missions/", f"{missions}/"), *own_ports(number)))
    simulator.until_printed(ports["14550"], START_S)
    link = ("--connect", f"udpin://127.0.0.1:{ports['14540']}", "--monitor", "off")
    on_board = run(*ours(RUN, *link))
    on_board.until_printed("hosting", START_S)

    unsigned = run("companion", "upload", hop, *ground, "--timeout", 5)
    assert unsigned.exit_code(ANSWER_S) == 4, unsigned.printed
    wrong = run("companion", "upload", hop, *ground, "--signing-key", other, "--timeout", 5)
    assert wrong.exit_code(ANSWER_S) == 4, wrong.printed
    assert "with another key" in wrong.printed and "companion key" not in wrong.printed
    command = SIGNED_UPLOAD.replace("missions/surveillance.yaml", str(hop))
    upload = run(*ours(command, *ground))
    assert upload.exit_code(ANSWER_S) == 0, upload.printed + on_board.printed
    forge(int(ports["14540"]))
    on_board.until_printed("taking off", ANSWER_S)
    watch = run(*ours(SIGNED_WATCH, *ground))
    assert watch.exit_code(ANSWER_S) == 0, watch.printed + on_board.printed
    assert "task satisfied, landed" in watch.printed
    os.kill(on_board.pid, signal.SIGINT)
    assert on_board.exit_code(ANSWER_S) == 0, on_board.printed
    assert "frames refused: " in on_board.printed and "frames refused: " in simulator.printed
    secret = read_key(key).secret
    for path in (p for p in (tmp_path / "runs").rglob("*") if p.is_file()):
        assert secret not in path.read_bytes() and secret.hex().encode() not in path.read_bytes()
    assert secret.hex() not in on_board.printed + simulator.printed + upload.printed


def forge(port: int) -> None:
    """An unsigned autopilot in another mode, and a pause, at the companion's port."""
    autopilot, operator = MavlinkCodec(1, 1), MavlinkCodec(255, 190)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        for frame in (
            autopilot.pack(dialect.MAVLink_heartbeat_message(2, 12, 1, 0x30000, 4, 3)),
            operator.pack(dialect.MAVLink_command_long_message(1, 191, 193, 0, *(0.0,) * 7)),
        ):
            udp.sendto(frame, ("127.0.0.1", port))
