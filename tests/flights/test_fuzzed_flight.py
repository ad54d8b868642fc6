"""200,000 fuzzed datagrams in two flights over sockets, without a key and (long) with one.

The same is flown as without them, setpoints keep their pace, and memory does not grow. A machine
may stand still for a moment, also for one program alone: so 99 of 100 periods are compared with an
empty loop's, and of the others none is so long that the simulator leaves OFFBOARD (the same is
flown). In lockstep many more are sent, in `tests/properties/test_frame_fuzz.py`.
"""

from __future__ import annotations

import contextlib
import random
import socket
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import psutil
import pytest
from attacks import attacks, means_nothing
from lossy_wire import lossy_wire
from ports import free_instance, own_ports
from test_sockets import START_S, STORED, SURVEILLANCE, Run, recorded, run

from companion.flight_events.hosting import DatagramsDropped, FramesRefused
from companion.mavlink.key_file import make_key

__all__ = ["run"]
pytestmark = [
    pytest.mark.sockets,
    pytest.mark.alone,
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux stamps datagrams so"),
]

NUMBER = 100_000
LASTS_S = 45.0
"""The task takes a minute."""
BATCH_S = 0.01
LATER_MAX_S = 0.1
GROWTH_MAX = 10_000_000


class Attacker(threading.Thread):
    """Sends to a port, from four of its own.

    Args:
        port: the victim's.
        datagrams: all that it sends, evenly over LASTS_S.
    """

    def __init__(self, port: int, datagrams: list[bytes]) -> None:
        super().__init__(daemon=True)
        self._to = ("127.0.0.1", port)
        self._datagrams = datagrams

    def run(self) -> None:
        with contextlib.ExitStack() as stack:
            ports = [
                stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                for _ in range(4)
            ]
            begun_s, sent = time.monotonic(), 0
            while sent < len(self._datagrams):
                share = (time.monotonic() - begun_s) / LASTS_S
                for i in range(sent, min(int(share * NUMBER), len(self._datagrams))):
                    ports[i % len(ports)].sendto(self._datagrams[i], self._to)
                    sent = i + 1
                time.sleep(BATCH_S)


def fuzzed(system: int, is_signed: bool) -> list[bytes]:
    """With a key anything; without one, what is damaged or from somebody else."""
    rng, found = random.Random(system), list[bytes]()
    while len(found) < NUMBER:
        found += [d for d in attacks(rng) if is_signed or means_nothing(d, system)]
    return found[:NUMBER]


def period_s(times_s: list[float], share: float) -> float:
    """The period that a share of all does not exceed."""
    return float(np.quantile([b - a for a, b in pairwise(times_s)], share))


@pytest.mark.parametrize(
    "is_signed",
    [pytest.param(True, marks=pytest.mark.long, id="signed"), pytest.param(False, id="unsigned")],
)
def test_a_flight_is_as_without_them(is_signed: bool, run: Run, tmp_path: Path) -> None:
    instance, key = free_instance(), tmp_path / "vehicle.key"
    make_key(key, None)
    signing = ("--signing-key", key) if is_signed else ()
    datagrams = fuzzed(1 + instance, is_signed)
    scenario = SURVEILLANCE.with_suffix(".sim.yaml")
    with lossy_wire(instance, loss=0.0) as wire:
        simulator = run("sitl", *own_ports(instance), "--scenario", scenario, *signing)
        simulator.until_printed("companion on UDP", START_S)
        companion = run(
            *("companion", "run", SURVEILLANCE, "--log-dir", tmp_path / "runs", *signing),
            *("--connect", f"udpin://127.0.0.1:{wire.companion_port}", "--monitor", "off"),
        )
        companion.until_printed("flying the task", START_S)
        attacker, process = Attacker(wire.companion_port, datagrams), psutil.Process(companion.pid)
        before = process.memory_info().rss
        attacker.start()
        attacker.join()
        after = process.memory_info().rss
        assert companion.exit_code() == 0, companion.printed
    told = [
        f"{event.kind} {event.text}\n"
        for event in recorded(tmp_path / "runs")
        if not isinstance(event, DatagramsDropped | FramesRefused)
    ]
    ours, empty = (
        " ".join(f"{1e3 * period_s(times_s, share):.1f}" for share in (0.5, 0.99, 1.0))
        for times_s in (wire.setpoints_s, wire.ticks_s)
    )
    print(
        f"periods p50 p99 max {ours} ms, of an empty loop {empty} ms; "
        f"{(after - before) / 1e6:.1f} MB more"
    )
    assert "".join(told) == STORED.read_text(encoding="utf-8")
    assert period_s(wire.setpoints_s, 0.99) <= period_s(wire.ticks_s, 0.99) + LATER_MAX_S
    assert after - before <= GROWTH_MAX
