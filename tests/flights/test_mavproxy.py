"""MAVProxy, as an authority from outside, is content with the simulator.

It runs headless as its users run it, with commands on its standard input; what it prints is held
against what it prints with a real PX4. The simulator runs in real time: MAVProxy is busy with each
message, and on a slow machine it never catches up with a simulator that is faster.
"""

import re
import signal
import subprocess
import sys
import sysconfig
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from ports import free_instance, own_ports

pytestmark = pytest.mark.sockets

MAVPROXY = Path(sysconfig.get_path("scripts")) / "mavproxy.py"
ANSWER_S = 120.0  # wall time that no answer needs
NOT_ACKNOWLEDGED_S = 6.0
"""MAVProxy does not acknowledge a list that it has read. A PX4 waits for that for 5 s, and takes no
plan from it meanwhile; so does the simulator."""

PLAN = """QGC WPL 110
0\t1\t3\t16\t0\t0\t0\t0\t47.397742\t8.545594\t0\t1
1\t0\t3\t22\t0\t0\t0\t0\t47.397742\t8.545594\t5\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.397842\t8.545594\t5\t1
3\t0\t2\t20\t0\t0\t0\t0\t0\t0\t0\t1
"""


class MAVProxy:
    """A running MAVProxy."""

    def __init__(self, port: int, system: int, folder: Path) -> None:
        self._process = subprocess.Popen(
            [
                sys.executable,
                MAVPROXY,
                f"--master=udpin:127.0.0.1:{port}",
                f"--target-system={system}",
                f"--state-basedir={folder}",
                "--nowait",
            ],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.printed = ""
        self._news = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            with self._news:
                self.printed += line
                self._news.notify_all()

    def type(self, command: str, *expected: str) -> None:
        """Type a command and wait until all patterns have been printed after it, in order."""
        start = len(self.printed)
        assert self._process.stdin
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()
        self.expect(*expected, start=start)

    def repeat(self, command: str, expected: str, pause_s: float = 1.0) -> None:
        """Type a command again and again until a pattern was printed after the first time."""
        start, end_s = len(self.printed), time.monotonic() + ANSWER_S
        while not self._is_printed(expected, start, pause_s):
            assert time.monotonic() < end_s, f"{expected} not in:\n{self.printed[start:]}"
            self.type(command)

    def expect(self, *patterns: str, start: int = 0, limit_s: float = ANSWER_S) -> None:
        is_printed = self._is_printed(".*".join(patterns), start, limit_s)
        assert is_printed, f"{patterns} not in:\n{self.printed[start:]}"

    def _is_printed(self, pattern: str, start: int, limit_s: float) -> bool:
        """Waits until a pattern has been printed."""
        wanted = re.compile(pattern, re.DOTALL)
        with self._news:
            return self._news.wait_for(
                lambda: wanted.search(self.printed, start) is not None, limit_s
            )

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()


@pytest.fixture
def mavproxy(tmp_path: Path) -> Iterator[MAVProxy]:
    instance = free_instance()
    command = [sys.executable, "-m", "sitl", *own_ports(instance)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as simulator:
        assert simulator.stdout
        simulator.stdout.readline()
        client = MAVProxy(14550 + instance, 1 + instance, tmp_path)
        try:
            client.expect("Detected vehicle", r"Received \d+ parameters")
            yield client
        finally:
            client.close()
            simulator.send_signal(signal.SIGINT)
            assert simulator.wait(timeout=ANSWER_S) == 0


def test_it_connects_reads_all_and_flies(mavproxy: MAVProxy, tmp_path: Path) -> None:
    for told in ("GPS lock at 488 meters", "Mode LOITER", "fence enabled"):
        assert told in mavproxy.printed
    assert "fence breach" not in mavproxy.printed
    mavproxy.type("param show MIS_TAKEOFF_ALT", r"MIS_TAKEOFF_ALT +2\.5")
    mavproxy.type("param set MIS_TAKEOFF_ALT 4")  # in the background, and nothing is printed
    mavproxy.repeat("param fetch MIS_TAKEOFF_ALT", "MIS_TAKEOFF_ALT = 4")
    mavproxy.type("wp list", "Requesting 0 waypoints")
    mavproxy.type("arm throttle", "COMPONENT_ARM_DISARM: ACCEPTED", "ARMED")
    mavproxy.type("takeoff 495", "NAV_TAKEOFF: ACCEPTED", "Mode TAKEOFF", "Mode LOITER")
    mavproxy.type("long 178 1 3 -1 0 0 0 0", "DO_CHANGE_SPEED: ACCEPTED")
    mavproxy.type("guided 47.3978 8.5456 10", "DO_REPOSITION: ACCEPTED")
    mavproxy.type("long 176 209 6 0", "DO_SET_MODE: TEMPORARILY_REJECTED")
    mavproxy.type("long 176 1 4 5", "DO_SET_MODE: ACCEPTED", "Mode RTL")
    mavproxy.type("long 21 0 0 0 0 0 0 0", "NAV_LAND: ACCEPTED", "LAND>", "DISARMED")


def test_it_loads_and_lists_plans(mavproxy: MAVProxy, tmp_path: Path) -> None:
    plan, fence, rally = (tmp_path / name for name in ("plan.txt", "fence.txt", "rally.txt"))
    plan.write_text(PLAN)
    mavproxy.type(f"wp load {plan}", "Loaded 4 waypoints", "Sent all 4 waypoints")
    mavproxy.type("wp list", "Requesting 4 waypoints", r"3 .*20|Saved 4")
    fence.write_text(
        "QGC WPL 110\n"
        + "".join(
            f"{i}\t0\t0\t5001\t4\t0\t0\t0\t{47.3977 + n * 1e-3}\t{8.5455 + e * 1e-3}\t0\t1\n"
            for i, (n, e) in enumerate([(-1, -1), (-1, 1), (1, 1), (1, -1)])
        )
    )
    mavproxy.repeat(f"fence load {fence}", "Sent all 4 fence items", NOT_ACKNOWLEDGED_S)
    mavproxy.type("fence list", "Requesting 4 fence items")
    rally.write_text("QGC WPL 110\n0\t0\t3\t5100\t0\t0\t0\t0\t47.3977\t8.5455\t20\t1\n")
    mavproxy.repeat(f"rally load {rally}", "Sent all 1 rally items", NOT_ACKNOWLEDGED_S)
    mavproxy.type("rally list", "Requesting 1 rally items")
