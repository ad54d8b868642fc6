"""A flight over a serial line: a pseudo-terminal stands for it, and carries to the simulator.

As on a vehicle: companion run MISSION --connect serial:///dev/ttyTHS1:921600
"""

from __future__ import annotations

import os
import pty
import select
import socket
import threading
import tty
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

import pytest
from hop import hop_in
from ports import free_instance, own_ports
from test_sockets import FLIGHT_S, START_S, Run, run

from companion.mavlink.stream_frames import StreamFrames
from companion.record.events import read_events
from sitl.link.routing import LinkName
from sitl.link.server import COMPANION_PORT, LOCAL_PORTS

__all__ = ["run"]
pytestmark = pytest.mark.sockets

ITS_PORT = LOCAL_PORTS[LinkName.OFFBOARD]


class Line:
    """Carries between a pseudo-terminal and the UDP ports of a simulator.

    Attributes:
        device: the companion's end.
    """

    def __init__(self, instance: int) -> None:
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.device = os.ttyname(self._theirs)
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.bind(("127.0.0.1", COMPANION_PORT + instance))
        self._simulator = ("127.0.0.1", ITS_PORT + instance)
        self._is_closed = threading.Event()
        self._thread = threading.Thread(target=self._carry)
        self._thread.start()

    def _carry(self) -> None:
        frames = StreamFrames()
        ends: list[int | socket.socket] = [self._ours, self._udp]
        while not self._is_closed.is_set():
            for source in select.select(ends, [], [], 0.1)[0]:
                if source is self._udp:
                    with suppress(BlockingIOError):  # the line is full, as nobody reads it
                        os.write(self._ours, self._udp.recv(4096))
                    continue
                for frame in frames.take(os.read(self._ours, 4096)):
                    self._udp.sendto(frame, self._simulator)

    def close(self) -> None:
        self._is_closed.set()
        self._thread.join()
        self._udp.close()
        os.close(self._ours)
        os.close(self._theirs)


@pytest.fixture
def line_and_instance() -> Iterator[tuple[Line, int]]:
    instance = free_instance()
    with closing(Line(instance)) as line:
        yield line, instance


def test_a_mission_is_flown_over_a_serial_line(
    line_and_instance: tuple[Line, int], tmp_path: Path, run: Run
) -> None:
    line, instance = line_and_instance
    connect = f"serial://{line.device}:921600"
    run("sitl", *own_ports(instance))
    asked = ("run", hop_in(tmp_path), "--connect", connect, "--log-dir", tmp_path)
    companion = run("companion", *asked, "--monitor", "off", "--accept-weak-failsafes")
    companion.until_printed(f"waiting    for a vehicle on {connect}", START_S)
    assert companion.exit_code(FLIGHT_S) == 0, companion.printed
    assert "nanobind" not in companion.printed, "a library reports leaks at the exit"
    (events,) = tmp_path.glob("[0-9]*/events.jsonl")
    ending = read_events(events.parent).ending
    assert ending is not None and ending.exit_code == 0
