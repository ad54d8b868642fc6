"""A companion that is cut off in flight, and another one that goes on: what is sent, and when.

The simulated vehicle holds, as PX4 does with COM_OBL_RC_ACT 5, once the stream of setpoints is
lost. The one that goes on has nothing but the journal.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path
from random import Random

import meadow
import pytest
from lockstep import Lockstep, World

from companion.acting.journal import CommandIntended, VehicleSeen
from companion.errors import Aborted, NoPlanError
from companion.flight_events.event import Stamped
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import LapCompleted
from companion.flight_events.skills import OutcomeUnknown, PlaceReached, SkillCompleted
from companion.flight_events.sortie import (
    ControlRegained,
    ControlTakenBack,
    FlightFoundAgain,
    Phase,
    PhaseEntered,
    RunFailed,
    TaskSatisfied,
)
from companion.flight_events.word import ConjunctViolated, PositionLeft, ViolatedBefore
from companion.mavlink.framing import Message, dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.record.audit import audit
from companion.record.events import record_of
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
CONTINUE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
COMPANION = 191
PAYLOAD = 25
BACK_S = 5.0
"""From the last key to control."""
CAMPAIGN = (pytest.mark.faults, pytest.mark.long)
SENT = ("SET_POSITION_TARGET_LOCAL_NED", "COMMAND_LONG")
QUESTIONS = (dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAV_CMD_RUN_PREARM_CHECKS)


@pytest.fixture
def flight() -> Lockstep:
    """To A on a meadow and back."""
    return meadow.start(meadow.mission(), resumes=True)


@pytest.fixture
def searching(surveillance: Mission, short_hall: World) -> Lockstep:
    return Lockstep(surveillance, short_hall, has_station=True, resumes=True)


def under_way(flight: Lockstep) -> Lockstep:
    flight.until_reported(PlaceReached, place="A").run(2.0)
    return flight


def cut_off(flight: Lockstep, away_s: float = 3.0) -> int:
    """Killed, and started again; returns how much was sent before."""
    flight.kill()
    flight.run(away_s)
    flight.restart()
    return len(flight.said)


def sent_since(flight: Lockstep, before: int) -> list[str]:
    """Setpoints and commands; what is asked of an autopilot is none."""
    messages = [said.message for said in flight.said[before:]]
    return [m.get_type() for m in messages if m.get_type() in SENT and not is_question(m)]


def is_question(message: Message) -> bool:
    return message.get_type() == "COMMAND_LONG" and message.command in QUESTIONS


def says_continue(flight: Lockstep) -> None:
    flight.station_commands(CONTINUE, 1.0, component=COMPANION)


def test_a_companion_that_was_killed_goes_on(searching: Lockstep) -> None:
    """Also where the record of its flight is lost, which can be audited from then on."""
    under_way(searching).recorded.clear()
    before = cut_off(searching)
    searching.until_reported(FlightFoundAgain)
    assert not sent_since(searching, before)
    searching.until_reported(ControlTakenBack)
    assert searching.now_s - searching.time_of(FlightFoundAgain) < BACK_S
    searching.until_the_end()
    assert searching.ending == TaskSatisfied() and searching.armings == 1
    assert [e.action for e in searching.of(SkillCompleted)] == ["upload(r2)"]
    assert searching.places[0] == "A" and searching.places[-2:] == ["r2", "Home"]
    record = record_of(searching.recorded)
    assert record.is_headless and record.task.keys() == {"search", "upload", "return"}
    assert [each.number for each in record.positions] == list(range(len(record.positions)))
    assert not audit(record).is_failure


@pytest.mark.long
def test_laps_are_counted_on(surveillance: Mission, short_hall: World) -> None:
    scenario, walls = short_hall
    quiet = replace(scenario, events=())
    flight = Lockstep(surveillance, (quiet, walls), has_station=True, resumes=True)
    cut_off(flight.until_reported(LapCompleted))
    flight.until_reported(LapCompleted, lap=2)
    assert [event.lap for event in flight.of(LapCompleted)] == [1, 2]


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        *(pytest.param("surveillance", s, marks=CAMPAIGN) for s in range(28)),
        *(pytest.param("delivery", s, marks=CAMPAIGN) for s in range(29)),
    ],
)
def test_killed_at_any_time_no_action_is_done_twice(name: str, seed: int) -> None:
    """Operators say "continue" where nobody else takes the vehicle back."""
    chance = Random(seed)
    mission = load_mission(MISSIONS / f"{name}.yaml")
    world = read_scenario(MISSIONS / f"{name}.sim.yaml")
    flight = Lockstep(mission, world, seed=seed, has_station=True, resumes=True)
    flight.run(chance.uniform(0.5, 50.0))
    cut_off(flight, chance.choice([0.3, 1.0, 3.0, 8.0]))
    while not flight.companion.has_ended:
        assert flight.now_s < 200.0, [event.text for event in flight.events]
        flight.run(8.0)
        if flight.events[-1] in flight.of(FlightFoundAgain):
            says_continue(flight)
    done = Counter(e.action for e in flight.of(SkillCompleted))
    unknown = {e.action for e in flight.of(OutcomeUnknown)}
    assert max(done.values(), default=0) <= 1 and not unknown & done.keys()
    is_left_alone = flight.ending.exit_code == Aborted.exit_code
    assert flight.ending == TaskSatisfied() or unknown or is_left_alone
    assert flight.armings == 1 and not flight.simulation.is_armed
    assert flight.simulation.collisions == 0


@pytest.mark.long
def test_killed_again_at_once_it_knows_the_time(flight: Lockstep) -> None:
    """Before the one that goes on has heard anything: its clock goes on from where it was."""
    under_way(flight)
    for _ in range(2):
        cut_off(flight)
    times_s = [time_s for time_s, _ in flight.journal.entries]
    assert times_s == sorted(times_s)
    flight.until_the_end()
    assert flight.one(FlightFoundAgain).away_s == pytest.approx(3.0, abs=0.2)
    assert flight.ending == TaskSatisfied()


def test_positions_that_the_record_lacks_are_told_with_their_own_times() -> None:
    """The journal was on the disk before the power failed, the end of the record was not."""
    task = {"often": "revisit(A) <= 60 s", "back": "G F at(Home)"}
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
    mission = load_mission(meadow.DATA | {"task": task, "limits": limits})
    flight = meadow.start(mission, resumes=True)
    flight.until(lambda: flight.places.count("A") == 2).run(1.0)
    before = left(flight)
    flight.recorded.clear()
    cut_off(flight, 8.0)
    flight.until_reported(ControlTakenBack)
    assert len(before) > 2 and left(flight) == before


def violated_twice() -> Lockstep:
    """Late for A by a pause, in which the alarm comes; it has flown home for that."""
    task = {"visit": "F at(A)", "quick": "F[<=14s] at(A)", "calm": "G !alarm"}
    lost = {"far": {"formula": "G !alarm", "priority": 2}}
    fence = [[-9, -9], [30, -9], [30, 9], [-9, 9]]
    given = {
        "task": task | lost,
        "events": {"alarm": {"when": "COMMAND.MAV_CMD_USER_1", "latch": True}},
        "limits": {"speed_mps": 2, "up_m": [1, 10], "fence": fence},
        "otherwise": "return_home",
        "patience_s": 0,
    }
    flight = meadow.start(load_mission(meadow.DATA | given), resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.TASK).run(2.0)
    flight.station_commands(CONTINUE, 0.0, component=COMPANION)
    flight.until_reported(ConjunctViolated, conjunct="quick")
    flight.station_commands(dialect.MAV_CMD_USER_1, component=COMPANION)
    says_continue(flight)
    return flight.until_reported(ConjunctViolated, conjunct="calm").run_for(0.4)


def test_what_was_violated_before_is_told_as_that_and_is_in_the_record_once() -> None:
    flight = violated_twice()
    before = word_of(flight)
    assert [(each.conjunct, each.position) for each in flight.of(ConjunctViolated)] == [
        ("quick", 0),
        ("calm", 1),
        ("far", 1),
    ]
    flight.reports.clear()
    flight.recorded[:] = [e for e in flight.recorded if e not in before]  # the power took them
    heard = len(flight.heard)
    cut_off(flight)
    assert word_of(flight) == before  # at once, with its own times
    flight.until_the_end()
    assert flight.one(ViolatedBefore) == ViolatedBefore(("quick", "calm"))
    texts = [s.message.text for s in flight.heard[heard:] if hasattr(s.message, "text")]
    told = [text for text in texts if "violated at" in text or "violated before" in text]
    assert told == ["violated before the interruption: quick, calm"]
    found = audit(record_of(flight.recorded))
    assert not found.differs and flight.exit_code == NoPlanError.exit_code


def word_of(flight: Lockstep) -> list[Stamped]:
    kinds = PositionLeft | ConjunctViolated
    return [each for each in flight.recorded if isinstance(each.event, kinds)]


def left(flight: Lockstep) -> list[Stamped]:
    return [each for each in flight.recorded if isinstance(each.event, PositionLeft)]


@pytest.mark.parametrize("seed", [0, *(pytest.param(s, marks=CAMPAIGN) for s in range(1, 10))])
def test_a_pilot_who_takes_over_meanwhile_is_left_alone(searching: Lockstep, seed: int) -> None:
    """In whatever mode, and also if he holds: the operator has not said "continue"."""
    chance = Random(seed)
    under_way(searching).run(chance.uniform(0.0, 25.0))
    searching.kill()
    searching.run(chance.uniform(0.5, 4.0))
    searching.station_chooses(chance.choice(["AUTO.LOITER", "AUTO.RTL", "AUTO.LAND"]))
    searching.run(1.0)
    searching.restart()
    before = len(searching.said)
    searching.run(20.0)
    assert not sent_since(searching, before) and not searching.of(ControlTakenBack)


def test_a_vehicle_that_has_landed_is_not_armed_again(flight: Lockstep) -> None:
    under_way(flight).kill()
    flight.station_chooses("AUTO.LAND")
    flight.until(lambda: not flight.simulation.is_armed)
    flight.restart()
    before = len(flight.said)
    flight.until_the_end()
    assert flight.ending == RunFailed(
        "the companion was away, and the vehicle has landed; it is not armed again", 5
    )
    flight.run(5.0)
    assert not sent_since(flight, before) and flight.armings == 1


def test_one_that_lands_soon_after_is_told_as_that(flight: Lockstep) -> None:
    """It is in OFFBOARD again then, as before the landing; no pilot has chosen that."""
    under_way(flight).kill()
    flight.station_chooses("AUTO.LAND")
    flight.until(lambda: flight.simulation.flight.position[2] > -0.4)
    flight.restart()
    assert flight.simulation.is_armed
    flight.until_the_end()
    assert flight.simulation.mode == "OFFBOARD" and flight.armings == 1
    assert flight.ending == RunFailed(
        "the companion was away, and the vehicle has landed; it is not armed again", 5
    )


@pytest.mark.long
def test_a_landing_that_was_to_be_is_watched_to_its_end(flight: Lockstep) -> None:
    flight.until_reported(PhaseEntered, phase=Phase.LANDING).run(2.0)
    before = cut_off(flight)
    flight.until_the_end()
    assert flight.ending == TaskSatisfied() and not sent_since(flight, before)


@pytest.mark.long
def test_a_flight_that_had_not_begun_to_arm_begins_anew(flight: Lockstep) -> None:
    flight.until_reported(PhaseEntered, phase=Phase.CHECKING)
    cut_off(flight)
    assert not flight.of(FlightFoundAgain)
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()


@pytest.mark.long
def test_in_the_take_off_an_operator_is_asked(flight: Lockstep) -> None:
    """The autopilot climbs and holds by itself: that is no failsafe."""
    flight.until_reported(PhaseEntered, phase=Phase.TAKE_OFF).run(1.0)
    before = cut_off(flight)
    flight.run(15.0)
    assert flight.simulation.mode == "AUTO.LOITER" and not sent_since(flight, before)
    says_continue(flight)
    flight.until_reported(ControlRegained).until_the_end()
    assert flight.ending == TaskSatisfied()


def test_a_vehicle_that_is_elsewhere_is_asked_about(flight: Lockstep) -> None:
    under_way(flight)
    moved = [
        (t, replace(e, position=(e.position[0], e.position[1] + 40.0, e.position[2])))
        if isinstance(e, VehicleSeen)
        else (t, e)
        for t, e in flight.journal.entries
    ]
    flight.kill()
    flight.journal.entries[:] = moved
    flight.run(3.0)
    flight.restart()
    before = len(flight.said)
    flight.run(10.0)
    assert not sent_since(flight, before)
    assert "from where it was: hold, then continue" in flight.one(FlightFoundAgain).text
    says_continue(flight)
    flight.until_reported(ControlRegained)


def test_a_pause_goes_on(flight: Lockstep) -> None:
    under_way(flight)
    flight.station_commands(CONTINUE, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(1.0)
    cut_off(flight)
    flight.until_reported(ControlTakenBack).run(10.0)
    assert flight.of(PhaseEntered)[-1].phase is Phase.PAUSED
    says_continue(flight)
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()


@pytest.mark.parametrize(  # before the autopilot's own hold, and in it
    "away_s", [0.1, pytest.param(3.0, marks=pytest.mark.long)]
)
def test_a_flight_home_goes_on(searching: Lockstep, away_s: float) -> None:
    under_way(searching)
    searching.station_commands(RETURN, component=COMPANION)
    searching.until_reported(PhaseEntered, phase=Phase.RETURNING).run(1.0)
    cut_off(searching, away_s)
    searching.until_the_end()
    assert searching.exit_code == 0 and searching.places[-1:] != ["r2"]
    assert not searching.of(SkillCompleted)


@pytest.mark.parametrize("is_repeatable", [False, True])
def test_what_may_have_been_done_is_not_done_again_unless_it_may_be(
    surveillance: Mission, short_hall: World, is_repeatable: bool
) -> None:
    """Killed in the tick in which the command leaves."""
    skills = dict(surveillance.skills)
    skills["upload"] = replace(skills["upload"], is_repeatable=is_repeatable)
    mission = replace(surveillance, skills=skills)
    flight = Lockstep(mission, short_hall, has_station=True, resumes=True)
    flight.until(lambda: any(isinstance(e, CommandIntended) for _, e in flight.journal.entries))
    cut_off(flight)
    flight.until_the_end()
    first = flight.one(OutcomeUnknown).action
    commands = [s for s in flight.commands if s.message.target_component == PAYLOAD]
    assert flight.ending == TaskSatisfied() and commands
    done = [e.action for e in flight.of(SkillCompleted)]
    assert first not in done
    withdrawn = [e.belief for e in flight.of(BeliefWithdrawn)]
    assert bool(withdrawn[:1]) and len(done) == 1
