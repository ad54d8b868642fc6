"""Twenty browsers and five ground stations watch a flight; the vehicle does not notice.

All in real time.

The autopilot leaves OFFBOARD if setpoints stay away for COM_OF_LOSS_T; we allow two ticks.
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
from pathlib import Path

import numpy as np
import pytest
from ports import free_instance
from pymavlink import mavutil

from sitl.link.routing import LinkName
from sitl.link.server import PORTS

pytestmark = pytest.mark.sockets

SURVEILLANCE = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
CLIENTS = 20
STATIONS = range(250, 255)
COMPANION, UNKNOWN = 191, 31999  # a component, a command
WATCHED_S = 12.0
LONGEST_GAP_S = 0.1


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
            urllib.request.urlopen(f"{self._address}/stream", timeout=30) as stream,
        ):
            while self.is_wanted and (line := stream.readline()):
                self.heard += line.startswith(b"event: snapshots")
                time.sleep(self._pause_s)


class Stations(threading.Thread):
    """Ground stations behind a router: they ask, each twice a second, and get their own answers.

    Attributes:
        asked: how often each has asked.
        answered: system of a station -> answers to it.
    """

    def __init__(self, instance: int) -> None:
        super().__init__(daemon=True)
        self._vehicle = 1 + instance
        port = PORTS[LinkName.GCS][0] + instance
        self._link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}")
        self.asked = 0
        self.answered = dict.fromkeys(STATIONS, 0)
        self.is_wanted = True

    def run(self) -> None:
        next_s = time.monotonic()
        while self.is_wanted:
            if time.monotonic() >= next_s:
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


def test_setpoints_keep_their_pace(tmp_path: Path) -> None:
    instance = free_instance()
    arguments = [
        *("sim", SURVEILLANCE, "-i", instance, "--log-dir", tmp_path),
        *("--monitor", "127.0.0.1:0"),
    ]
    command = [sys.executable, "-m", "companion", *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as flight:
        assert flight.stdout is not None
        address = ""
        for line in flight.stdout:
            if found := re.match(r"monitor +(http://\S+)", line):
                address = found[1]
            if line.endswith("flying the task\n"):
                break
        clients = [Client(address, pause_s=0.0 if i % 2 else 0.5) for i in range(CLIENTS)]
        stations = Stations(instance)
        for thread in (*clients, stations):
            thread.start()
        time.sleep(WATCHED_S)
        stations.is_wanted = False
        stations.join(5)
        flight.send_signal(signal.SIGINT)
        flight.send_signal(signal.SIGINT)
        flight.stdout.read()
        assert flight.wait(30) in (0, 130)
    for client in clients:
        client.is_wanted = False
    for client in clients:
        client.join(30)
    assert stations.asked > WATCHED_S
    assert min(stations.answered.values()) >= stations.asked - 1
    heard = [client.heard for client in clients]
    assert min(heard) >= 5, "each has seen the vehicle, the slow ones too"
    assert np.median(heard[1::2]) > 3 * WATCHED_S

    (folder,) = tmp_path.iterdir()
    log = mavutil.mavlink_connection(str(folder / "flight.tlog"))
    times_s = []
    while (message := log.recv_match(type="SET_POSITION_TARGET_LOCAL_NED")) is not None:
        times_s.append(message._timestamp)
    log.close()
    assert times_s[-1] - times_s[0] > WATCHED_S - 1
    gaps_s = np.diff(times_s)
    assert gaps_s.max() <= LONGEST_GAP_S
