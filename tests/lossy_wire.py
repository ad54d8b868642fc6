"""A link with losses between two processes, which notes when setpoints were sent.

It stands where the vehicle looks for its companion, which listens elsewhere. The kernel stamps what
arrives, so that a reader who is late changes no figure. Linux alone.
"""

from __future__ import annotations

import select
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from random import Random

from companion.mavlink.framing import dialect, message_id
from companion.tick import TICK_S
from sitl.link.routing import LinkName
from sitl.link.server import COMPANION_PORT, HOST, LOCAL_PORTS

SO_TIMESTAMPNS = 35  # asm-generic/socket.h; Python has no name for it
TIMESPEC = struct.Struct("qq")
LONGEST = 65535
SETPOINT: int = dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED

METRONOME = f"""
import select, socket, sys, time
udp, next_s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), time.monotonic()
while not select.select([sys.stdin], [], [], max(0.0, next_s - time.monotonic()))[0]:
    udp.sendto(b"tick", ("{HOST}", int(sys.argv[1])))
    next_s = max(next_s + {TICK_S}, time.monotonic())
"""
"""Sends twenty times a second, as the companion's loop does, until its standard input ends."""


class LossyWire(threading.Thread):
    """Hands datagrams on, but for a share of them, in either direction.

    Args:
        instance: of the simulator.
        loss: the share that is lost.

    Attributes:
        companion_port: where the companion has to listen.
        metronome_port: of an empty loop, which is stamped beside the companion's.
        setpoints_s: when each setpoint was sent, also those that were lost (Unix time).
        ticks_s: when the empty loop sent.
        newest: of the autopilot's messages by their ids, as datagrams, also if they were lost.
    """

    def __init__(self, instance: int, loss: float) -> None:
        super().__init__(daemon=True)
        self._vehicle_side, self._companion_side = _stamped(COMPANION_PORT + instance), _stamped(0)
        self._metronome_side = _stamped(0)
        self.companion_port = _free_port()
        self.metronome_port: int = self._metronome_side.getsockname()[1]
        self.setpoints_s: list[float] = []
        self.ticks_s: list[float] = []
        self.newest: dict[int, bytes] = {}
        self._vehicle = (HOST, LOCAL_PORTS[LinkName.OFFBOARD] + instance)
        self._loss, self._random = loss, Random(0)
        self._is_wanted = True

    def run(self) -> None:
        sides = [self._vehicle_side, self._companion_side, self._metronome_side]
        while self._is_wanted:
            for side in select.select(sides, [], [], 0.5)[0]:
                self._hand_on(side)
        for side in sides:
            side.close()

    def end(self) -> None:
        """Stops, and gives the ports back."""
        self._is_wanted = False
        self.join()

    def _hand_on(self, side: socket.socket) -> None:
        try:
            datagram, stamps, _, _ = side.recvmsg(LONGEST, 64)
        except ConnectionError:  # nobody listens any more, or not yet
            return
        seconds, nanoseconds = TIMESPEC.unpack(stamps[0][2])
        sent_s = seconds + nanoseconds / 1e9
        if side is self._metronome_side:
            self.ticks_s.append(sent_s)
            return
        is_down = side is self._companion_side
        if is_down and message_id(datagram) == SETPOINT:
            self.setpoints_s.append(sent_s)
        if not is_down and datagram[6] == dialect.MAV_COMP_ID_AUTOPILOT1:
            self.newest[message_id(datagram)] = datagram
        if self._random.random() < self._loss:
            return
        if is_down:
            self._vehicle_side.sendto(datagram, self._vehicle)
        else:
            self._companion_side.sendto(datagram, (HOST, self.companion_port))


def _stamped(port: int) -> socket.socket:
    """A socket of this machine that gets the time of each arrival."""
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
    udp.bind((HOST, port))
    return udp


def _free_port() -> int:
    """One that nobody has now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind((HOST, 0))
        return int(udp.getsockname()[1])


@contextmanager
def lossy_wire(instance: int, loss: float) -> Iterator[LossyWire]:
    """A wire, and an empty loop beside it, for as long as the context lasts."""
    wire = LossyWire(instance, loss)
    wire.start()
    beside = [sys.executable, "-c", METRONOME, str(wire.metronome_port)]
    with subprocess.Popen(beside, stdin=subprocess.PIPE) as metronome:
        try:
            yield wire
        finally:
            assert metronome.stdin is not None
            metronome.stdin.close()
            metronome.wait()
            wire.end()
