"""Twenty browsers and five ground stations watch a flight; the vehicle does not notice.

All in real time.

The autopilot leaves OFFBOARD if setpoints stay away for COM_OF_LOSS_T; we allow two ticks. What the
machine itself pauses is measured beside the flight, by a loop that does nothing but keep time.
"""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE_S, comes_true
from pictures import programs_do_not_draw
from ports import free_instance, own_ports
from pymavlink import mavutil

from sitl.link.routing import LinkName
from sitl.link.server import LOCAL_PORTS

pytestmark = [pytest.mark.sockets, pytest.mark.alone]

SURVEILLANCE = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
CLIENTS = 20
STATIONS = range(250, 255)
COMPANION, UNKNOWN = 191, 31999  # a component, a command
WATCHED_S = 12.0
SEEN = 3 * WATCHED_S  # snapshots that a quick client gets in this time
TICK_S = 0.05
ATTEMPTS = 3

EMPTY_LOOP = f"""
import select, sys, time
gaps_s, last_s = [], time.monotonic()
while not select.select([sys.stdin], [], [], max(0.0, last_s + {TICK_S} - time.monotonic()))[0]:
    now_s = time.monotonic()
    gaps_s.append(now_s - last_s)
    last_s = now_s
print(max(gaps_s))
"""
"""Twenty times a second until the standard input ends; its longest gap."""


class Client(threading.Thread):
    """Reads the stream, as slowly as it is told, until it ends or nobody asks any more."""

    def __init__(self, address: str, pause_s: float) -> None:
        super().__init__(daemon=True)
        self._address = address
        self._pause_s = pause_s
        self.heard = 0
        self.is_wanted = True

    def run(self) -> None:
        with (
            contextlib.suppress(OSError),
            urllib.request.urlopen(f"{self._address}/stream", timeout=PATIENCE_S) as stream,
        ):
            while self.is_wanted and (line := stream.readline()):
                self.heard += line.startswith(b"event: snapshots")
                time.sleep(self._pause_s)


class Stations(threading.Thread):
    """Ground stations behind a router: they ask, each twice a second, and get their own answers.

    Attributes:
        asked: how often each has asked.
        answered: system of a station -> answers to it.
        has_questions: whether they go on asking.
        is_wanted: whether they go on listening.
    """

    def __init__(self, instance: int) -> None:
        super().__init__(daemon=True)
        self._vehicle = 1 + instance
        port = LOCAL_PORTS[LinkName.GCS] + instance
        self._link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}")
        self.asked = 0
        self.answered = dict.fromkeys(STATIONS, 0)
        self.has_questions = self.is_wanted = True

    def run(self) -> None:
        next_s = time.monotonic()
        while self.is_wanted:
            if self.has_questions and time.monotonic() >= next_s:
                next_s += 0.5
                self.asked += 1
                for system in STATIONS:
                    self._link.mav.srcSystem = system
                    self._link.mav.heartbeat_send(6, 8, 0, 0, 4)
                    self._link.mav.param_request_list_send(self._vehicle, COMPANION)
                    self._link.mav.command_long_send(
                        self._vehicle, COMPANION, UNKNOWN, 0, *(0.0,) * 7
                    )
            message = self._link.recv_match(type="COMMAND_ACK", blocking=True, timeout=0.05)
            if message is not None and message.command == UNKNOWN:
                self.answered[message.target_system] += 1
        self._link.close()


@contextmanager
def empty_loop() -> Iterator[Callable[[], float]]:
    """Yields what ends it and tells its longest gap."""
    with subprocess.Popen(
        [sys.executable, "-c", EMPTY_LOOP], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as loop:
        yield lambda: float(loop.communicate()[0])


def test_setpoints_keep_their_pace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that is busy for a moment is no reason; one of three flights is undisturbed."""
    programs_do_not_draw(tmp_path, monkeypatch)
    lateness_s = []
    for attempt in range(ATTEMPTS):
        folder = tmp_path / str(attempt)
        empty_gap_s = watched_flight(folder)
        lateness_s.append(longest_gap_s(folder) - empty_gap_s)
        if lateness_s[-1] <= TICK_S:
            return
    raise AssertionError(f"later than an empty loop by {lateness_s} s")


def watched_flight(log_dir: Path) -> float:
    """All get what they ask for; the longest gap of an empty loop meanwhile."""
    instance = free_instance()
    arguments = [
        *("sim", SURVEILLANCE, *own_ports(instance), "--log-dir", log_dir),
        *("--monitor", "127.0.0.1:0"),
    ]
    command = [sys.executable, "-m", "companion", *map(str, arguments)]
    with (
        empty_loop() as longest_empty_gap_s,
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as flight,
    ):
        assert flight.stdout is not None
        address = ""
        for line in flight.stdout:
            if found := re.match(r"monitor +(http://\S+)", line):
                address = found[1]
            if line.endswith("flying the task\n"):
                break
        clients = [Client(address, pause_s=0.0 if i % 2 else 0.5) for i in range(CLIENTS)]
        stations = Stations(instance)
        threads: list[Client | Stations] = [*clients, stations]
        for thread in threads:
            thread.start()
        time.sleep(WATCHED_S)
        assert comes_true(lambda: have_seen(clients)), [client.heard for client in clients]
        stations.has_questions = False
        time.sleep(0.5)
        assert stations.asked > WATCHED_S
        assert comes_true(lambda: min(stations.answered.values()) >= stations.asked - 1)
        empty_gap_s = longest_empty_gap_s()
        flight.send_signal(signal.SIGINT)
        flight.send_signal(signal.SIGINT)
        flight.stdout.read()
        assert flight.wait(PATIENCE_S) in (0, 130)
    for thread in threads:
        thread.is_wanted = False
    for thread in threads:
        thread.join(PATIENCE_S)
    return empty_gap_s


def have_seen(clients: list[Client]) -> bool:
    """Each has seen the vehicle, the slow ones too, and most of the quick ones fly with it."""
    heard = [client.heard for client in clients]
    return min(heard) >= 5 and float(np.median(heard[1::2])) > SEEN


def longest_gap_s(log_dir: Path) -> float:
    """Between setpoints of the only run."""
    (folder,) = log_dir.iterdir()
    log = mavutil.mavlink_connection(str(folder / "flight.tlog"))
    times_s = []
    while (message := log.recv_match(type="SET_POSITION_TARGET_LOCAL_NED")) is not None:
        times_s.append(message._timestamp)
    log.close()
    assert times_s[-1] - times_s[0] > WATCHED_S - 1
    return float(np.diff(times_s).max())
