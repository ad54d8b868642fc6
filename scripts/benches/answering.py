"""The time from a change of an event to its answer, in real time over UDP."""

from __future__ import annotations

import gc
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from random import Random
from statistics import median
from typing import Any

from benches import ROOT, Row
from companion.acting.journal import Journal, NoJournal
from companion.acting.sortie.preflight.arming_terms import ArmingTerms
from companion.acting.sortie.terms import SortieTerms
from companion.app import Companion
from companion.clock import ScaledClock
from companion.driving import fly
from companion.flight_events.event import Stamped
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.tree import NodesChanged
from companion.geometry import Ned
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.loader import load_mission
from companion.run_sources.only_run import OnlyRun
from companion.vehicle.endpoints import UdpPort
from companion.vehicle.link import Link
from companion.vehicle.run_clocks import ClockReading
from sitl.link.server import COMPANION_PORT, HOST

INSTANCE = 96  # of the simulator, away from any other one that runs
PORT = COMPANION_PORT + INSTANCE
MOVE = {
    "parameters": {"from": "Place", "to": "Place"},
    "precondition": "at(from)",
    "effect": "at(to) & !at(from)",
    "execute": "fly(to)",
}
PATROL: dict[str, Any] = {
    "version": 1,
    "name": "patrol",
    "map": {"east_m": [-5, 25], "north_m": [-5, 25]},
    "limits": {"speed_mps": 2, "up_m": [0.5, 5], "fence": [[-3, -3], [22, -3], [22, 22], [-3, 22]]},
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
        "A": {"east_m": 9, "north_m": 0, "up_m": 2},
        "B": {"east_m": 18, "north_m": 9, "up_m": 2},
        "C": {"east_m": 0, "north_m": 18, "up_m": 2},
    },
    "sets": {"Place": ["Home", "A", "B", "C"]},
    "events": {"red": {"when": "NAMED_VALUE_INT[red].value > 0"}},
    "skills": {"move": MOVE},
    "initially": ["at(Home)"],
    "task": {"a": "G F at(A)", "b": "G F (at(B) | red)", "c": "G F (at(C) | !red)"},
}
"""Visits A and B in turn, or A and C while it is red."""


class Answers(Link):
    """Link and recorder that note when the first setpoint of each new plan leaves."""

    def __init__(self) -> None:
        super().__init__(UdpPort(HOST, PORT))
        self.is_flown = threading.Event()
        self.times_s: list[float] = []
        self.journal: Journal = NoJournal()
        self.name = ""
        self._is_replanned = self._is_due = False

    def report(self, stamped: Stamped) -> None:
        """Waits for a new plan, then for its first move."""
        if isinstance(stamped.event, PlanReplaced):
            self._is_replanned = True
        elif isinstance(stamped.event, NodesChanged) and stamped.event.tip.startswith("move_cmd"):
            self.is_flown.set()
            self._is_due, self._is_replanned = self._is_due or self._is_replanned, False

    def clocks(self, reading: ClockReading) -> None:
        """Ignores the clocks."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Ignores packets."""

    def position(self, now_s: float, position: Ned) -> None:
        """Ignores positions."""

    def send(self, datagrams: list[bytes]) -> None:
        """Notes the time of an awaited setpoint."""
        super().send(datagrams)
        if self._is_due:
            self.times_s.append(time.perf_counter())
            self._is_due = False


class Asked(Companion):
    """A companion that can be made to answer events only in ticks."""

    waits = False

    def is_urgent(self, now_s: float, datagrams: list[bytes]) -> bool:
        """As in the companion, or False while it waits for ticks."""
        return not self.waits and super().is_urgent(now_s, datagrams)


def answering(runs: int) -> Iterator[Row]:
    """From an event's datagram to the new plan's first setpoint; the peer answers only in ticks."""
    command = [sys.executable, "-m", "sitl", "-i", str(INSTANCE)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE) as sitl:
        assert sitl.stdout is not None
        sitl.stdout.readline(), sitl.stdout.readline()  # the ports are open
        link = Answers()
        asked: list[tuple[bool, float]] = []
        try:
            terms = SortieTerms(arming=ArmingTerms(accepts_weak_failsafes=True))
            companion = Asked(OnlyRun(load_mission(PATROL), link), terms)
            asking = threading.Thread(
                target=ask, args=(companion, link, max(3, runs // 2), asked), daemon=True
            )
            asking.start()
            fly(companion, link, ScaledClock(), 30.0)
            asking.join()
        finally:
            gc.unfreeze()
            link.close()
            sitl.terminate()
    took = [(waits, answer_s(at_s, link.times_s)) for waits, at_s in asked]
    ours, peer = (
        median(1000 * each_s for waits, each_s in took if waits is which) for which in (False, True)
    )
    yield Row("event to setpoint of the new plan", ours, "ms", "waiting for the tick", peer)


def ask(companion: Asked, link: Answers, times: int, asked: list[tuple[bool, float]]) -> None:
    """Changes the event now and then in flight; then lands the companion."""
    link.is_flown.wait(60.0)
    random, target = Random(0), MavlinkCodec(1 + INSTANCE, 42)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        for number in range(2 * times):
            time.sleep(random.uniform(1.1, 1.6))
            companion.waits = number % 4 >= 2  # for red as often as for not red
            said = dialect.MAVLink_named_value_int_message(0, b"red", (number + 1) % 2)
            asked.append((companion.waits, time.perf_counter()))
            udp.sendto(target.pack(said), (HOST, PORT))
    time.sleep(0.5)
    companion.stop()


def answer_s(at_s: float, answers_s: list[float]) -> float:
    """The time to the first answer."""
    return next(answered_s for answered_s in answers_s if answered_s > at_s) - at_s
