"""Two sorties of one waiting companion, on a vehicle that behaves as a PX4 was seen to do.

It falls back to OFFBOARD after a landing, where it arms with setpoints alone; its estimate wanders,
so that home is set elsewhere at each arming; and its drag is heavy.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from lockstep import COMPANION, Lockstep, World
from preparations import Polled
from synthetic import mission

from companion.acting.journal import JournalledFlight
from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.hosting import RunNotBegun
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import FlightFoundAgain, RunEnded, RunFailed, TaskSatisfied
from companion.geometry import horizontal_distance
from companion.mavlink.framing import dialect
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns
from companion.run_sources.only_run import OnlyRun
from sitl.flight.estimate import Wander
from sitl.world.scenario import Scenario

START = dialect.MAV_CMD_MISSION_START
AS_PX4: World = (Scenario(airframe="px4_sih", wander=Wander(0.25, 0.3)), None)


class Hosted(Lockstep):
    """A companion that waits for MISSION_START; also its host."""

    uploads = None

    def __init__(self, flown: Mission, world: World, seed: int) -> None:
        super().__init__(flown, world, seed=seed, has_station=True, resumes=True)

    def _companion(self, journalled: JournalledFlight | None) -> Companion:
        first = OnlyRun(self._mission, self, journalled=journalled) if journalled else None
        return Companion(HostedRuns(self, self._mission, first), self._terms)

    def load(self, path: Path) -> Mission:
        raise AssertionError("nothing is uploaded")

    def prepare(self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None) -> Any:
        return Polled(mission, speed_max_mps)

    def begin_run(self, mission: Mission) -> Recorder:
        return self

    def end_run(self, recorder: Recorder) -> None:
        """Nothing is kept open."""

    def tell(self, stamped: Stamped) -> None:
        assert not isinstance(stamped.event, RunNotBegun), stamped.event

    def fly_again(self) -> None:
        """One more sortie, to its end."""
        before = len(self.of(RunEnded))
        self.station_commands(START, component=COMPANION)
        self.until(lambda: len(self.of(RunEnded)) > before)


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in (1, 2))])
def test_a_waiting_companion_flies_again_and_again(seed: int) -> None:
    flight = Hosted(mission("F (at(A) & F at(H))"), AS_PX4, seed)
    flight.run(2.0)
    flight.fly_again()
    assert flight.simulation.mode == "OFFBOARD" and not flight.simulation.is_armed
    flight.run(20.0)
    flight.fly_again()
    flight.run(1.0)
    flight.fly_again()
    assert flight.of(RunEnded) == [TaskSatisfied()] * 3
    assert flight.armings == 3
    assert horizontal_distance(flight.simulation.flight.position, (0.0, 0.0, 0.0)) < 1.0


def cut_off() -> Hosted:
    """Killed at A, in a sortie that was started."""
    flight = Hosted(mission("F (at(A) & F at(H))"), AS_PX4, seed=0)
    flight.run(2.0)
    flight.station_commands(START, component=COMPANION)
    flight.until_reported(PlaceReached, place="A").kill()
    return flight


def test_a_run_that_was_cut_off_goes_on_before_another_one_is_started() -> None:
    flight = cut_off()
    flight.run(3.0)
    flight.restart()
    flight.station_commands(START, component=COMPANION)  # it is flown already
    flight.until_reported(RunEnded)
    assert flight.of(FlightFoundAgain) and flight.armings == 1
    flight.run(20.0)
    assert flight.armings == 1
    flight.fly_again()
    assert flight.of(RunEnded) == [TaskSatisfied()] * 2
    assert flight.armings == 2


@pytest.mark.long
def test_a_run_that_was_cut_off_and_cannot_go_on_keeps_nobody_from_starting_another_one() -> None:
    """It has landed meanwhile, and is not armed again by itself."""
    flight = cut_off()
    flight.run(2.0)
    flight.station_chooses("AUTO.RTL")
    flight.until(lambda: not flight.simulation.is_armed)
    flight.restart()
    flight.until_reported(RunFailed)
    assert flight.armings == 1 and not flight.companion.has_ended
    flight.fly_again()
    assert flight.of(RunEnded)[-1] == TaskSatisfied() and flight.armings == 2
