"""A mission with a Python skill comes over MAVLink FTP to a companion that waits: flown or refused.

As commands over UDP, as docs/uploads.md and docs/skills.md have them. The package, if it is
installed at all, is on board alone.
"""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from offered import TEMPLATE, install_template, installed_in
from ports import free_instance, own_ports
from test_sockets import Run, run
from test_uploads import ANSWER_S, START_S

pytestmark = pytest.mark.sockets
__all__ = ["run"]

WEIGHING = TEMPLATE / "weighing.yaml"


@pytest.mark.parametrize("is_installed", [pytest.param(True, marks=pytest.mark.long), False])
def test_an_uploaded_mission_calls_what_is_installed_on_board_and_nothing_else(
    is_installed: bool, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    number = free_instance()
    ground = ("--connect", f"udpin://0.0.0.0:{14550 + number}")
    simulator = run("sitl", *own_ports(number))
    simulator.until_printed(str(14550 + number), START_S)
    folder = ("--log-dir", tmp_path / "runs", "--monitor", "off")
    with monkeypatch.context() as on_board_alone:
        if is_installed:
            install_template(tmp_path)
            installed_in(tmp_path / "site", on_board_alone)
        link = f"udpin://127.0.0.1:{14540 + number}"
        on_board = run("companion", "run", "--wait", "--connect", link, *folder)
    on_board.until_printed("hosting", START_S)

    upload = run("companion", "upload", WEIGHING, *ground, "--start")
    if not is_installed:
        assert upload.exit_code(ANSWER_S) == 2, upload.printed + on_board.printed
        assert "the skill weigh is not installed" in upload.printed
        assert "refused weighing.yaml:42:14: the skill weigh is not installed" in on_board.printed
        assert "taking off" not in on_board.printed
    else:
        assert upload.exit_code(ANSWER_S) == 0, upload.printed + on_board.printed
        watch = run("companion", "watch", *ground)
        assert watch.exit_code(ANSWER_S) == 0, watch.printed + on_board.printed
        assert "task satisfied, landed" in watch.printed
        assert "weigh(Rack) failed: 2.6 kg, and the limit is 2 kg" in on_board.printed
        assert "weigh(Shelf) done" in on_board.printed
    os.kill(on_board.pid, signal.SIGINT)
    assert on_board.exit_code(ANSWER_S) == 0, on_board.printed


def test_a_waiting_companion_that_was_killed_goes_on_and_calls_what_is_installed(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed after the first of two calls; the second is made by the one that goes on."""
    number = free_instance()
    ground = ("--connect", f"udpin://0.0.0.0:{14550 + number}")
    run("sitl", *own_ports(number)).until_printed(str(14550 + number), START_S)
    install_template(tmp_path)
    installed_in(tmp_path / "site", monkeypatch)
    asked = ["companion", "run", "--wait", "--resume", "--monitor", "off"]
    asked += ["--connect", f"udpin://127.0.0.1:{14540 + number}"]
    asked += ["--log-dir", str(tmp_path / "runs")]
    killed = run(*asked)
    killed.until_printed("hosting", START_S)
    upload = run("companion", "upload", WEIGHING, *ground, "--start")
    assert upload.exit_code(ANSWER_S) == 0, upload.printed
    killed.until_printed("weigh(Rack) failed: 2.6 kg, and the limit is 2 kg", ANSWER_S)
    os.kill(killed.pid, signal.SIGKILL)
    assert killed.exit_code(ANSWER_S) == -signal.SIGKILL

    resumed = run(*asked)
    resumed.until_printed("landed", ANSWER_S)
    assert "weigh(Shelf) done" in resumed.printed
    os.kill(resumed.pid, signal.SIGINT)
    assert resumed.exit_code(ANSWER_S) == 0, resumed.printed
