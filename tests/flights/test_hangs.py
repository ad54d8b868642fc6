"""A companion's process hangs in flight, in each way that a process can: setpoints end with it.

The process is a Python program that flies by `companion.run`, and hangs in its own function when
the vehicle is at A, or is stopped from outside. What it sends is stamped by the kernel.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hop import hop_in
from lossy_wire import LossyWire, lossy_wire
from patience import PATIENCE_S, comes_true
from ports import free_instance, own_ports
from test_sockets import START_S, Run, run

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.px4_modes import mode_name

__all__ = ["run"]
pytestmark = [
    pytest.mark.sockets,
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux stamps datagrams so"),
]

SILENT_WITHIN_S = 0.3
PROGRAM = """
import ctypes, re, sys, threading, time
from companion import load_mission, run
from companion.flight_events.skills import PlaceReached

def in_c():
    ctypes.PyDLL(None).sleep(600)  # a PyDLL does not let go of the interpreter's lock

def in_a_long_regular_expression():
    re.match("(a+)+b", 64 * "a")

def deadlocked():
    lock = threading.Lock()
    with lock, lock:
        pass

def in_a_loop():
    while True:
        pass

def from_outside():
    pass

def for_a_while():
    time.sleep(8)

def at_a_place(stamped):
    if isinstance(stamped.event, PlaceReached):
        print(f"hangs at {time.time()}", flush=True)
        globals()[sys.argv[3]]()

print("ended:", run(load_mission(sys.argv[1]), sys.argv[2], on_event=at_a_place).failure)
"""


class Flown(NamedTuple):
    """The program that flies, and the wire on which it is heard."""

    program: subprocess.Popen[str]
    wire: LossyWire

    def until_it_hangs(self) -> float:
        """Waits until it is at A; returns when that was (Unix time)."""
        assert self.program.stdout is not None
        line = self.program.stdout.readline()
        assert line.startswith("hangs at "), line
        return float(line.split()[-1])

    def heard(self, message: int) -> Any:
        """What the autopilot said last."""
        (found,) = MavlinkCodec(0, 0).parse(self.wire.newest[message])
        return found

    def is_on_hold(self) -> bool:
        """Whether the vehicle has stopped, in AUTO.LOITER, by a failsafe."""
        beat = self.heard(dialect.MAVLINK_MSG_ID_HEARTBEAT)
        at = self.heard(dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED)
        is_failsafe = beat.system_status >= dialect.MAV_STATE_CRITICAL
        is_slow = max(map(abs, (at.vx, at.vy, at.vz))) < 0.2
        return is_slow and is_failsafe and mode_name(beat.custom_mode) == "AUTO.LOITER"


Start = Callable[[str], Flown]


@pytest.fixture
def start(run: Run, tmp_path: Path) -> Iterator[Start]:
    """Begins a flight that will hang in a way."""
    instance = free_instance()
    programs = []
    with lossy_wire(instance, loss=0.0) as wire:
        simulator = run("sitl", *own_ports(instance))
        simulator.until_printed("companion on UDP", START_S)
        connect = f"udpin://127.0.0.1:{wire.companion_port}"

        def begin(way: str) -> Flown:
            command = [sys.executable, "-c", PROGRAM, str(hop_in(tmp_path)), connect, way]
            programs.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
            return Flown(programs[-1], wire)

        yield begin
        for program in programs:
            program.kill()
            program.communicate()


@pytest.mark.parametrize(
    "way",
    [
        "in_c",
        pytest.param("in_a_long_regular_expression", marks=pytest.mark.long),
        pytest.param("deadlocked", marks=pytest.mark.long),
        pytest.param("in_a_loop", marks=pytest.mark.long),
        "from_outside",
    ],
)
def test_a_process_that_hangs_is_silent_and_the_vehicle_holds(way: str, start: Start) -> None:
    flown = start(way)
    hung_s = flown.until_it_hangs()
    if way == "from_outside":
        hung_s = time.time()
        os.kill(flown.program.pid, signal.SIGSTOP)
    assert comes_true(flown.is_on_hold)
    assert flown.program.poll() is None
    assert hung_s - 1.0 < flown.wire.setpoints_s[-1] <= hung_s + SILENT_WITHIN_S


@pytest.mark.parametrize(
    "way", [pytest.param("for_a_while", marks=pytest.mark.long), "from_outside"]
)
def test_a_process_that_wakes_up_leaves_the_vehicle_to_its_failsafe(way: str, start: Start) -> None:
    """Much has arrived meanwhile, the oldest first: what it says is not taken for the present.

    Setpoints, even one that was made before, would bring a PX4 back to OFFBOARD.
    """
    flown = start(way)
    hung_s = flown.until_it_hangs()
    if way == "from_outside":
        time.sleep(0.02)  # it has sent, and waits for the next tick
        hung_s = time.time()
        os.kill(flown.program.pid, signal.SIGSTOP)
    assert comes_true(flown.is_on_hold)
    if way == "from_outside":
        time.sleep(5.0)  # several times what is taken in at once
        os.kill(flown.program.pid, signal.SIGCONT)
    said, _ = flown.program.communicate(timeout=PATIENCE_S)
    assert "a failsafe of the autopilot has control, in AUTO.LOITER" in said
    assert flown.wire.setpoints_s[-1] <= hung_s + SILENT_WITHIN_S
    assert flown.is_on_hold()
