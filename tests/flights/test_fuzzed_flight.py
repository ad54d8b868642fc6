"""200,000 fuzzed datagrams in two flights over sockets, without a key and with one (both long).

In a shorter flight are as many in a second, without a key.

The same is flown as without them, setpoints keep their pace, and memory does not grow. A machine
may stand still for a moment, also for one program alone: so 99 of 100 periods are compared with an
empty loop's, and of the others none is so long that the simulator leaves OFFBOARD (the same is
flown). A flight beside which the empty loop stood still as well is flown again. In lockstep many
more are sent, in `tests/properties/test_frame_fuzz.py`.
"""

from __future__ import annotations

import pickle
import random
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
import pytest
from attacks import attacks, means_nothing
from hop import hop_in
from lossy_wire import lossy_wire
from ports import free_instance, own_ports
from test_sockets import (
    START_S,
    STORED,
    SURVEILLANCE,
    Run,
    in_lockstep,
    kinds_and_texts,
    recorded,
    run,
)

from companion.flight_events.hosting import DatagramsDropped, FramesRefused
from companion.mavlink.key_file import make_key

__all__ = ["run"]
pytestmark = [
    pytest.mark.sockets,
    pytest.mark.alone,
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux stamps datagrams so"),
]

PER_S = 2_000
LONG_S, SHORT_S = 50.0, 12.0
"""How long they are sent: the paper's task takes a minute, that of the hop twenty seconds."""
LATER_MAX_S = 0.1
GROWTH_MAX = 10_000_000
STOOD_STILL_S, ATTEMPTS = 0.5, 3
"""A flight beside which an empty loop stood still for so long is flown again: the autopilot leaves
OFFBOARD after a second, and on the way of a setpoint are three programs."""

ATTACKER = f"""
import os, pickle, socket, sys, time
os.nice(10)
to, datagrams = pickle.load(sys.stdin.buffer)
ports = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(4)]
begun_s, sent = time.monotonic(), 0
while sent < len(datagrams):
    for i in range(sent, min(int((time.monotonic() - begun_s) * {PER_S}), len(datagrams))):
        ports[i % len(ports)].sendto(datagrams[i], to)
        sent = i + 1
    time.sleep(0.01)
"""
"""Sends to a port, from four of its own, so many in a second. A program of its own that gives way
to others, as it would be on another machine: it takes no time from the wire."""


def attack(port: int, datagrams: list[bytes]) -> None:
    """Waits until all are sent."""
    told = pickle.dumps((("127.0.0.1", port), datagrams))
    subprocess.run([sys.executable, "-c", ATTACKER], input=told, check=True)


def fuzzed(number: int, system: int, is_signed: bool) -> list[bytes]:
    """With a key anything; without one, what is damaged or from somebody else."""
    rng, found = random.Random(system), list[bytes]()
    while len(found) < number:
        found += [d for d in attacks(rng) if is_signed or means_nothing(d, system)]
    return found[:number]


def period_s(times_s: list[float], share: float) -> float:
    """The period that a share of all does not exceed."""
    return float(np.quantile([b - a for a, b in pairwise(times_s)], share))


class Attacked(NamedTuple):
    """A flight that was attacked.

    Attributes:
        told: kinds and texts of what happened, but for the datagrams that were refused.
        setpoints_s: when each was sent.
        ticks_s: when an empty loop beside it sent.
        growth: bytes of memory that the companion has more after the attack than before it.
    """

    told: str
    setpoints_s: list[float]
    ticks_s: list[float]
    growth: int


def attacked(
    run: Run, mission: Path, log_dir: Path, lasts_s: float, signing: tuple[object, ...]
) -> Attacked:
    """Flies a mission, and sends for so long from the begin of the task on."""
    instance = free_instance()
    datagrams = fuzzed(int(lasts_s * PER_S), 1 + instance, bool(signing))
    world = mission.with_suffix(".sim.yaml")
    scenario = ("--scenario", world) if world.exists() else ()
    with lossy_wire(instance, loss=0.0) as wire:
        simulator = run("sitl", *own_ports(instance), *scenario, *signing)
        simulator.until_printed("companion on UDP", START_S)
        companion = run(
            *("companion", "run", mission, "--log-dir", log_dir, *signing),
            *("--connect", f"udpin://127.0.0.1:{wire.companion_port}", "--monitor", "off"),
        )
        companion.until_printed("flying the task", START_S)
        process = psutil.Process(companion.pid)
        before = process.memory_info().rss
        attack(wire.companion_port, datagrams)
        after = process.memory_info().rss
        assert companion.exit_code() == 0 or stood_still(wire.ticks_s), companion.printed
    told = kinds_and_texts(
        event
        for event in recorded(log_dir)
        if not isinstance(event, DatagramsDropped | FramesRefused)
    )
    return Attacked(told, wire.setpoints_s, wire.ticks_s, after - before)


def stood_still(ticks_s: list[float]) -> bool:
    """Whether the machine did, so that an empty loop was late."""
    return period_s(ticks_s, 1.0) > STOOD_STILL_S


@pytest.mark.parametrize(
    ("is_signed", "lasts_s"),
    [
        pytest.param(True, LONG_S, marks=pytest.mark.long, id="signed"),
        pytest.param(False, LONG_S, marks=pytest.mark.long, id="unsigned"),
        pytest.param(False, SHORT_S, id="short"),
    ],
)
def test_a_flight_is_as_without_them(
    is_signed: bool, lasts_s: float, run: Run, tmp_path: Path
) -> None:
    make_key(key := tmp_path / "vehicle.key", None)
    signing = ("--signing-key", key) if is_signed else ()
    mission = SURVEILLANCE if lasts_s == LONG_S else hop_in(tmp_path)
    flown = attacked(run, mission, tmp_path / "runs", lasts_s, signing)
    for again in range(1, ATTEMPTS):
        if stood_still(flown.ticks_s):
            flown = attacked(run, mission, tmp_path / f"runs{again}", lasts_s, signing)
    ours, empty = (
        " ".join(f"{1e3 * period_s(times_s, share):.1f}" for share in (0.5, 0.99, 1.0))
        for times_s in (flown.setpoints_s, flown.ticks_s)
    )
    print(
        f"periods p50 p99 max {ours} ms, of an empty loop {empty} ms; "
        f"{flown.growth / 1e6:.1f} MB more"
    )
    without = STORED.read_text("utf-8") if mission == SURVEILLANCE else in_lockstep(mission)
    assert flown.told == without
    assert period_s(flown.setpoints_s, 0.99) <= period_s(flown.ticks_s, 0.99) + LATER_MAX_S
    assert flown.growth <= GROWTH_MAX
