"""A Python program flies a vehicle on a link, by `companion.run`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from moves import MOVE
from ports import free_instance, own_ports

from companion import FlightResult, LinkError, audit, load_mission, run
from companion.errors import CompanionError
from companion.flight_events.event import Stamped
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import RunFailed, StoppedAsAsked

pytestmark = pytest.mark.sockets

MISSION: dict[str, Any] = {
    "version": 1,
    "name": "there",
    "map": {"east_m": [-2, 6], "north_m": [-2, 6]},
    "limits": {"speed_mps": 3, "up_m": [0.5, 4], "fence": [[-2, -2], [6, -2], [6, 6], [-2, 6]]},
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
        "A": {"east_m": 3, "north_m": 3, "up_m": 2},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": {"move": MOVE},
    "initially": ["at(Home)"],
    "goal": "at(A)",
}
PATROL = {key: MISSION[key] for key in MISSION if key != "goal"} | {
    "task": {"patrol": "G F at(A) & G F at(Home)"}
}


@pytest.fixture
def vehicle() -> Iterator[str]:
    """A simulator in a process of its own; the URL on which it is heard."""
    instance = free_instance()
    command = [sys.executable, "-m", "sitl", *own_ports(instance), "--quiet"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as sitl:
        yield f"udpin://127.0.0.1:{14540 + instance}"
        sitl.send_signal(signal.SIGINT)


def test_a_mission_is_flown_to_its_end(vehicle: str, tmp_path: Path) -> None:
    told: list[Stamped] = []
    flight = run(
        load_mission(MISSION), vehicle, folder=tmp_path, on_event=told.append, timeout_s=300.0
    )
    assert isinstance(flight, FlightResult)
    assert (flight.exit_code, flight.failure) == (0, None)
    assert told == [stamped for stamped in flight.events if stamped.event.is_told]
    assert PlaceReached("A", "move(Home, A)") in [stamped.event for stamped in told]
    assert flight.trajectory.north_m[-1] == pytest.approx(3.0, abs=0.6)
    assert audit(flight) == audit(tmp_path)


def test_ctrl_c_lands_and_returns(vehicle: str) -> None:
    def interrupt(stamped: Stamped) -> None:
        if isinstance(stamped.event, PlaceReached):
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    flight = run(load_mission(PATROL), vehicle, on_event=interrupt, timeout_s=300.0)
    assert flight.exit_code == 0
    assert flight.events[-1].event == StoppedAsAsked()
    assert signal.getsignal(signal.SIGINT) is before


def test_no_vehicle_is_an_error_and_the_end_of_the_record(tmp_path: Path) -> None:
    told: list[Stamped] = []
    url = f"udpin://127.0.0.1:{14540 + free_instance()}"
    with pytest.raises(LinkError, match="no vehicle on") as error:
        run(load_mission(MISSION), url, folder=tmp_path, on_event=told.append, timeout_s=0.2)
    last = (tmp_path / "events.jsonl").read_text(encoding="utf-8").splitlines()[-1]
    assert read_line(last) == told[-1]
    assert told[-1].event == RunFailed(str(error.value), 4)
    assert 0.2 <= told[-1].time_s < 30.0


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"autopilot_fence": "uplod"}, "no autopilot_fence 'uplod'; there are upload, keep"),
        ({"rally_points": "all"}, "no rally_points 'all'"),
        ({"laps": 0}, "0 laps is not a limit"),
        ({"limit_s": -1.0}, "-1 s is not a limit"),
        ({"events": "/run/events"}, "cannot hear reports on /run/events"),
    ],
)
def test_a_wrong_argument_opens_nothing(wrong: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(CompanionError, match=said):
        run(load_mission(MISSION), folder=tmp_path / "run", **wrong)
    assert not (tmp_path / "run").exists()
