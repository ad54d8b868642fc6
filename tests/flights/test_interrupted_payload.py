"""A payload that is at work while its skill is interrupted: how often it is commanded, and when.

The simulated payload says IN_PROGRESS and needs four seconds. Whatever comes between, it gets one
command, and its answer counts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import meadow
import pytest
from lockstep import COMPANION, Cut, Lockstep

from companion.flight_events.skills import OutcomeUnknown, PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.sortie import Phase, PhaseEntered, TaskSatisfied
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission

USER_1, USER_2 = dialect.MAV_CMD_USER_1, dialect.MAV_CMD_USER_2
PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
PAYLOAD = 25
WORK_S = 4.0
WORKS = {"result": "ACCEPTED", "after_s": WORK_S, "progress": True}

Interruption = Callable[[Lockstep, Cut], None]


def a_mission(task: dict[str, str] | None = None, **fields: Any) -> Mission:
    """Home, to A, and there a payload that is commanded."""
    work = {"precondition": "at(A)", "effect": "done", "cost": 5}
    work |= {"execute": ["command(payload, MAV_CMD_USER_1)", "wait(1)"]} | fields
    fence = [[-9, -9], [29, -9], [29, 9], [-9, 9]]
    return load_mission(
        meadow.DATA
        | {
            "components": {"payload": PAYLOAD},
            "sets": meadow.DATA["sets"] | {"Site": ["A"]},
            "skills": meadow.DATA["skills"] | {"work": work},
            "events": {"called": {"when": "COMMAND.MAV_CMD_USER_2"}},
            "limits": {"speed_mps": 4, "up_m": [1, 10], "fence": fence},
            "task": task or {"work": "F done", "home": "F G at(Home)"},
        }
    )


def flying_to_its_work() -> dict[str, Any]:
    """Fields of a skill that flies to the payload's place itself."""
    return {
        "parameters": {"from": "Place", "to": "Site"},
        "precondition": "at(from)",
        "effect": "done & at(to) & !at(from)",
        "execute": ["fly(to)", "command(payload, MAV_CMD_USER_1)", "wait(1)"],
    }


def fly(mission: Mission, air: Cut | None = None) -> Lockstep:
    """Until the payload has been at work for a second."""
    happens = [{"at_s": 0, "payload": WORKS}]
    payload = {"component": PAYLOAD, "command": "MAV_CMD_USER_1", "otherwise": "ACCEPTED"}
    world = world_of(mission, {"version": 1, "payload": payload, "happens": happens})
    air = air or Cut()
    flight = Lockstep(mission, world, up=air, down=air, has_station=True, resumes=True)
    flight.until(lambda: bool(sent_s(flight)))
    return flight.run_for(1.0)


def sent_s(flight: Lockstep) -> list[float]:
    """When the payload was commanded."""
    return [said.time_s for said in flight.commands if said.message.command == USER_1]


def pause(flight: Lockstep, air: Cut) -> None:
    flight.station_commands(PAUSE, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(8.0)
    flight.station_commands(PAUSE, 1.0, component=COMPANION)


def short_pause(flight: Lockstep, air: Cut) -> None:
    flight.station_commands(PAUSE, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(0.5)
    flight.station_commands(PAUSE, 1.0, component=COMPANION)


def pilot(flight: Lockstep, air: Cut) -> None:
    flight.station_chooses("AUTO.LOITER")
    flight.run(6.0)
    flight.station_commands(PAUSE, 1.0, component=COMPANION)


def lost_link(flight: Lockstep, air: Cut) -> None:
    """The final answer comes when the link is there again."""
    air.is_cut = True
    flight.run(2.5)
    air.is_cut = False


def call(flight: Lockstep, air: Cut) -> None:
    """An event that another plan answers, after this skill."""
    flight.station_commands(USER_2, component=COMPANION)


@pytest.mark.parametrize(
    "interruption",
    [
        short_pause,
        *(pytest.param(i, marks=pytest.mark.long) for i in (lost_link, call, pause, pilot)),
    ],
)
def test_it_is_commanded_once_and_its_answer_counts(interruption: Interruption) -> None:
    air = Cut()
    task = {"work": "F done", "come": "G (called -> F at(A))", "home": "F G at(Home)"}
    flight = fly(a_mission(task), air)
    interruption(flight, air)
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()
    assert len(sent_s(flight)) == 1
    assert flight.one(SkillCompleted).action == "work" and not flight.of(SkillFailed)


def test_killed_after_a_pause_it_is_not_commanded_again() -> None:
    """As without the pause: nobody knows what has become of the command."""
    flight = fly(a_mission(assumes="works"))
    short_pause(flight, Cut())
    flight.run(1.0)
    flight.kill()
    flight.run(3.0)
    flight.restart()
    flight.until_the_end()
    assert flight.one(OutcomeUnknown).action == "work"
    assert len(sent_s(flight)) == 1 and not flight.of(SkillCompleted)
    assert flight.of(PlaceReached)[-1].place == "Home"


@pytest.mark.parametrize("interruption", [pytest.param(short_pause, marks=pytest.mark.long), pilot])
def test_a_skill_that_flies_there_itself_goes_on_from_here_with_its_command(
    interruption: Interruption,
) -> None:
    air = Cut()
    flight = fly(a_mission(**flying_to_its_work()), air)
    interruption(flight, air)
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()
    assert flight.one(SkillCompleted).action == "work(here, A)"
    assert len(sent_s(flight)) == 1 and not flight.of(SkillFailed)


@pytest.mark.long
def test_killed_a_skill_that_flies_there_itself_is_not_done_again_from_anywhere() -> None:
    flight = fly(a_mission(**flying_to_its_work()))
    flight.kill()
    flight.run(3.0)
    flight.restart()
    flight.until_the_end()
    assert flight.one(OutcomeUnknown).action == "work(Home, A)"
    assert len(sent_s(flight)) == 1 and not flight.of(SkillCompleted)


@pytest.mark.long
def test_a_pause_that_has_ended_does_not_come_back_after_a_take_off() -> None:
    """A link that is lost in a pause leads back to the pause; a skill that fails on the ground, to
    the task.
    """
    steps = ["land()", "command(payload, MAV_CMD_USER_1)", "take_off()"]
    mission = a_mission(execute=steps, assumes="works")
    payload = {"component": PAYLOAD, "command": "MAV_CMD_USER_1", "otherwise": "DENIED"}
    air, world = Cut(), world_of(mission, {"version": 1, "payload": payload})
    flight = Lockstep(mission, world, up=air, down=air, has_station=True, resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.TASK).run(2.0)
    flight.station_commands(PAUSE, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED)
    air.is_cut = True
    flight.run(5.0)
    air.is_cut = False
    flight.until(lambda: len(flight.of(PhaseEntered, phase=Phase.PAUSED)) == 2).run(1.0)
    flight.station_commands(PAUSE, 1.0, component=COMPANION)
    flight.until_the_end()
    assert flight.of(SkillFailed) and flight.armings == 2
    assert len(flight.of(PhaseEntered, phase=Phase.PAUSED)) == 2
