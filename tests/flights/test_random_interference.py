"""Random flights that are interfered with: what they say of themselves is true over all of it.

The companion is killed and goes on with its journal, half of the times after a power failure that
takes all of the record; or an operator pauses, and a pilot takes the vehicle and gives it back; at
any time, in any phase, several times.
"""

from __future__ import annotations

from random import Random

import pytest
from lockstep import COMPANION, Lockstep
from random_flights import random_flight

from companion.errors import Aborted
from companion.flight_events.event import Stamped
from companion.flight_events.skills import SkillCompleted
from companion.flight_events.sortie import ControlYielded, FlightFoundAgain, Phase, PhaseEntered
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.record.audit import audit
from companion.record.events import record_of

LIMIT_S, PATIENCE_S = 240.0, 12.0
PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
HELD = PhaseEntered(Phase.PAUSED)
TAKEN_TO = ("AUTO.LOITER", "AUTO.RTL", "AUTO.LAND")
FEW, MANY = 1, 150
SEEDS = [*range(FEW), *(pytest.param(i, marks=pytest.mark.long) for i in range(FEW, MANY))]


class Interfered(Lockstep):
    """A random flight, its operator and its pilot."""

    def __init__(self, seed: int) -> None:
        given, world = random_flight(seed)
        given["patience_s"] = 5
        mission = load_mission(given)
        super().__init__(
            mission, world_of(mission, world), seed=seed, has_station=True, resumes=True
        )
        self.chance = Random(f"interference {seed}")
        self._is_record_lost = seed % 4 == 1

    def kill_and_restart(self) -> None:
        self.kill()
        self.run(self.chance.choice((0.3, 1.0, 3.0, 8.0, 20.0)))
        if self._is_record_lost:
            self.recorded.clear()
        self.restart()

    def pause(self) -> None:
        self.station_commands(PAUSE, 0.0, component=COMPANION)
        self.run(self.chance.uniform(0.1, 10.0))
        self.station_commands(PAUSE, 1.0, component=COMPANION)

    def take_over(self) -> None:
        if self.simulation.is_armed:
            self.station_chooses(self.chance.choice(TAKEN_TO))
            self.run(self.chance.uniform(0.2, 3.0))

    @property
    def is_waiting(self) -> bool:
        """Whether it goes on by a key alone."""
        kinds = PhaseEntered | ControlYielded | FlightFoundAgain
        told = [event for event in self.events if isinstance(event, kinds)]
        return bool(told) and told[-1] in (
            *self.of(ControlYielded),
            *self.of(FlightFoundAgain),
            HELD,
        )

    def give_back(self) -> None:
        """The pilot holds, and the operator says continue; else he lands."""
        if self.now_s > LIMIT_S / 2:
            self.station_chooses("AUTO.LAND")
        elif self.simulation.mode != "AUTO.LOITER":
            self.station_chooses("AUTO.LOITER")
        self.run(1.5)
        self.station_commands(PAUSE, 1.0, component=COMPANION)

    @property
    def record(self) -> list[Stamped]:
        """As a run folder has it: what a journal brings again stands in it once."""
        kept: list[Stamped] = []
        known = set[tuple[object, ...]]()
        for stamped in self.recorded:
            match stamped.event:
                case PositionLeft(number=number):
                    about: tuple[object, ...] = (number,)
                case ConjunctViolated(conjunct=conjunct, position=position):
                    about = (conjunct, position)
                case _:
                    about = ()
            if not about or about not in known:
                kept.append(stamped)
                known.add(about)
        return kept


@pytest.mark.parametrize("seed", SEEDS)
def test_a_flight_that_is_interfered_with_ends_as_it_says(seed: int) -> None:
    flight = Interfered(seed)
    chance = flight.chance
    ways = (flight.kill_and_restart,) if seed % 2 else (flight.pause, flight.take_over)
    due = sorted(chance.uniform(2.0, 60.0) for _ in range(chance.randint(1, 3)))
    waits_s = 0.0
    while not flight.companion.has_ended:
        assert flight.now_s < LIMIT_S, [event.text for event in flight.events]
        if due and flight.now_s >= due[0]:
            due.pop(0)
            chance.choice(ways)()
        flight.run(1.0)
        waits_s = waits_s + 1.0 if flight.is_waiting else 0.0
        if waits_s > PATIENCE_S:
            waits_s = 0.0
            flight.give_back()
    flight.simulation.settle()
    assert flight.simulation.collisions == 0 and not flight.simulation.is_damaged
    if flight.exit_code != Aborted.exit_code:
        assert not flight.simulation.is_armed
        found = audit(record_of(flight.record))
        assert not found.differs and not (flight.exit_code == 0 and found.is_failure)
    done = [event.action for event in flight.of(SkillCompleted) if event.action.startswith("work")]
    assert len(done) == len(set(done))
