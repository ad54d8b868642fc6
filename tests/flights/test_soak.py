"""Two hours in flight over a link that loses a tenth of all datagrams, in real time.

A patrol that lands, charges and takes off again, some forty times. Memory does not grow, and
setpoints leave as regularly as an empty loop beside them turns:

    SOAK_MINUTES=10 scripts/test -m soak -s

tells figures every minute; without the variable it takes two hours.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np
import psutil
import pytest
from lossy_wire import LossyWire, lossy_wire
from ports import free_instance, own_ports
from test_sockets import START_S, Command, Run, run

from companion.flight_events.plans import LapCompleted
from companion.flight_events.reading import read_line

__all__ = ["run"]
pytestmark = [
    pytest.mark.soak,
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux stamps datagrams so"),
]

MISSION = Path(__file__).parents[2] / "missions" / "persistent_patrol.yaml"
SCENARIO = f"""
version: 1
map: {MISSION.parent}/maps/hall.yaml
battery: {{charge: 0.4}}
pads: [{{east_m: 9.6, north_m: 0.2, radius_m: 0.5, current_a: 100}}]
"""
LOSS = 0.1
LENGTH_S = 60.0 * float(os.environ.get("SOAK_MINUTES", "120"))
SETTLED_S = min(600.0, LENGTH_S / 2)
"""From then on memory does not grow."""
SAMPLE_S = 10.0
SAMPLES = 6
"""So many are a minute; figures of memory are the median of a minute."""
STREAM_ENDS_S = 1.0
"""COM_OF_LOSS_T: who sent nothing for so long, as on the ground, has begun another stream."""
GROWTH_MAX, LATER_MAX_S = 0.05, 0.025


class Memory(NamedTuple):
    """What the two processes keep in memory, in bytes."""

    companion: int
    simulator: int


def periods_s(times_s: list[float], share: float = 0.999) -> float:
    """The period that a share of all does not exceed, in seconds."""
    periods = [b - a for a, b in pairwise(times_s) if b - a < STREAM_ENDS_S]
    return float(np.quantile(periods, share))


def resident(command: Command) -> int:
    return int(psutil.Process(command.pid).memory_info().rss)


def told(begun_s: float, memory: Memory, wire: LossyWire) -> str:
    """A line of figures."""
    ours, empty = (
        " ".join(f"{1e3 * periods_s(times_s, share):.1f}" for share in (0.5, 0.99, 0.999, 1.0))
        for times_s in (wire.setpoints_s, wire.ticks_s)
    )
    return (
        f"{(time.monotonic() - begun_s) / 60:5.1f} min: companion {memory.companion / 1e6:.1f} MB, "
        f"simulator {memory.simulator / 1e6:.1f} MB, {len(wire.setpoints_s)} setpoints, periods "
        f"p50 p99 p99.9 max {ours} ms (empty loop {empty} ms)"
    )


def soak(companion: Command, simulator: Command, wire: LossyWire) -> list[Memory]:
    """Samples of memory until the time is over; the companion flies all the time."""
    begun_s = time.monotonic()
    samples: list[Memory] = []
    while time.monotonic() < begun_s + LENGTH_S:
        with pytest.raises(subprocess.TimeoutExpired):  # it has not ended
            companion.exit_code(SAMPLE_S)
        samples.append(Memory(resident(companion), resident(simulator)))
        if len(samples) % SAMPLES == 0:
            print(told(begun_s, samples[-1], wire), flush=True)
    return samples


def test_hours_in_flight_over_a_link_that_loses(run: Run, tmp_path: Path) -> None:
    scenario, instance = tmp_path / "soak.sim.yaml", free_instance()
    scenario.write_text(SCENARIO, encoding="utf-8")
    with lossy_wire(instance, LOSS) as wire:
        simulator = run("sitl", *own_ports(instance), "--scenario", scenario)
        simulator.until_printed("companion on UDP", START_S)
        connect = f"udpin://127.0.0.1:{wire.companion_port}"
        companion = run(
            *("companion", "run", MISSION, "--connect", connect, "--resume"),
            *("--log-dir", tmp_path / "runs", "--monitor", "off"),
        )
        companion.until_printed("flying the task", START_S)
        samples = soak(companion, simulator, wire)
        os.kill(companion.pid, signal.SIGINT)
        assert companion.exit_code() == 0, companion.printed
        later_s = periods_s(wire.setpoints_s) - periods_s(wire.ticks_s)
        np.savetxt(tmp_path / "setpoints.txt", wire.setpoints_s)
    first = round(SETTLED_S / SAMPLE_S)
    settled, last = samples[first - 1 : first - 1 + SAMPLES], samples[-SAMPLES:]
    for before, after in zip(zip(*settled, strict=True), zip(*last, strict=True), strict=True):
        assert median(after) <= (1 + GROWTH_MAX) * median(before)
    assert later_s <= LATER_MAX_S
    assert laps(tmp_path / "runs") > LENGTH_S / 120.0


def laps(log_dir: Path) -> int:
    """Of the only run."""
    (lines,) = log_dir.glob("*/events.jsonl")
    events = [read_line(line).event for line in lines.read_text(encoding="utf-8").splitlines()]
    return sum(isinstance(event, LapCompleted) for event in events)
