"""Every answer to every command of a flight: 15 s after its first sending it is said what follows.

Eleven answers (sitl/world/faults.py) to five commands. On the ground the sortie ends with exit code
5 and says why; in the air the vehicle holds and lands, or is left to its autopilot.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from campaign import sweep
from lockstep import Lockstep
from synthetic import command, mission

from companion.errors import Aborted
from companion.flight_events.sortie import (
    GoalFailed,
    Phase,
    PhaseEntered,
    RunEnded,
    SetpointRefused,
    StoppedAsAsked,
    TaskSatisfied,
)
from companion.mavlink.framing import dialect
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from sitl.world.faults import ANSWERS, Answer
from sitl.world.scenario import read_scenario

pytestmark = pytest.mark.faults

STATED_WITHIN_S = 15.0
OFFBOARD_S = 9.0
"""When the flight is in OFFBOARD: the fence has been written, and it has climbed."""
STOPPED_S = 10.0
"""When the operator stops the flight to hold and to land: the task is flown then."""
SHORT = mission("F (at(A) & F at(H))")


class Asked(NamedTuple):
    """A command of the flight.

    Attributes:
        phase: in which it is sent.
        name: of the MAV_CMD.
        from_s: from when on it is answered so.
    """

    phase: Phase
    name: str
    from_s: float = 0.0


COMMANDS = {
    "arm": Asked(Phase.ARMING, "MAV_CMD_COMPONENT_ARM_DISARM"),
    "take-off": Asked(Phase.TAKE_OFF, "MAV_CMD_NAV_TAKEOFF"),
    "offboard": Asked(Phase.OFFBOARD, "MAV_CMD_DO_SET_MODE"),
    "hold": Asked(Phase.HOLDING, "MAV_CMD_DO_SET_MODE", OFFBOARD_S),
    "land": Asked(Phase.LANDING, "MAV_CMD_NAV_LAND"),
}
IN_WORDS = {
    Answer.ACCEPTED_WITHOUT_EFFECT: "after 1[23] s",  # OFFBOARD is asked for after a second
    Answer.TEMPORARILY_REJECTED: "temporarily rejected",
    Answer.IN_PROGRESS: "no final answer",
    Answer.NO_ANSWER_WITHOUT_EFFECT: "no answer",
}
"""What is said of an answer, if not its name."""


def fly(
    *answers: tuple[str, Answer | None, float],
    parameters: dict[str, float] | None = None,
    flown: Mission = SHORT,
) -> Lockstep:
    """A flight whose commands are answered so from some time on."""
    happens = [
        {"at_s": at_s, "answer": {"command": name, "answer": answer and answer.value}}
        for name, answer, at_s in answers
    ]
    world = {"version": 1, "happens": happens, "parameters": parameters or {}}
    return Lockstep(flown, read_scenario(world))


def fly_to_the_end(flight: Lockstep, is_stopped: bool) -> Lockstep:
    """To its end; the operator stops it where holding and landing are asked for by that."""
    if is_stopped:
        flight.run(STOPPED_S)
        flight.companion.stop()
    return flight.until_the_end()


def stated_after_s(flight: Lockstep, asked: Asked) -> float:
    """Time from the first sending of the command to the first news that follow from it."""
    begun_s = flight.time_of(PhaseEntered, phase=asked.phase)
    number = getattr(dialect, asked.name)
    sent_s = next(
        s.time_s for s in flight.commands if s.message.command == number and s.time_s >= begun_s
    )
    news = (PhaseEntered, GoalFailed, RunEnded)
    return next(
        s.time_s - sent_s
        for s in flight.reports
        if isinstance(s.event, news) and s.time_s > begun_s
    )


def all_pairs() -> Iterator[Any]:
    """A fifth of the answers to each command, each answer to one; the sweeps have the others."""
    for number, asked_for in enumerate(COMMANDS):
        for at, answer in enumerate(Answer):
            is_rest = (at + number) % len(COMMANDS) != 0
            marks = [pytest.mark.long] if is_rest else []
            yield pytest.param(asked_for, answer, marks=marks, id=f"{asked_for}-{answer.name}")


@pytest.mark.parametrize(("asked_for", "answer"), [*all_pairs()])
def test_it_is_said_what_follows(asked_for: str, answer: Answer) -> None:
    asked, has_effect = COMMANDS[asked_for], ANSWERS[answer].has_effect
    is_stopped = asked_for in ("hold", "land")
    flight = fly_to_the_end(fly((asked.name, answer, asked.from_s)), is_stopped)
    assert stated_after_s(flight, asked) <= STATED_WITHIN_S
    if has_effect:
        assert flight.ending == (StoppedAsAsked() if is_stopped else TaskSatisfied())
        assert flight.of(GoalFailed) == []
        assert not flight.simulation.is_armed
        return
    word = IN_WORDS.get(answer, answer.lower())
    if asked_for == "take-off":
        word += "|disarmed"  # 10 s after its arming, by the autopilot
    assert flight.exit_code == Aborted.exit_code
    assert flight.of(GoalFailed)[0].reason.startswith("not ")
    assert re.search(word, flight.of(GoalFailed)[0].reason)
    assert re.search(word, flight.ending.text)
    assert_left_well(flight, asked_for)


def assert_left_well(flight: Lockstep, asked_for: str) -> None:
    """Where and how the vehicle is left after a command that never had its effect."""
    up_m = -flight.simulation.flight.position[2]
    flight.run(3.0)
    if asked_for == "arm":
        assert flight.armings == 0 and flight.setpoints == []
    elif asked_for == "land":
        assert flight.of(GoalFailed)[-1].reason.endswith(
            "; the autopilot has the vehicle, in AUTO.LOITER"
        )
        assert up_m == pytest.approx(2.0, abs=0.3)
    else:
        assert not flight.simulation.is_armed
        assert up_m < 0.1
    assert flight.simulation.collisions == 0


def test_a_take_off_without_effect_is_given_up_though_the_autopilot_stays_armed() -> None:
    """PX4 disarms by itself after COM_DISARM_PRFLT, 10 s, unless that is switched off."""
    accepted = (COMMANDS["take-off"].name, Answer.ACCEPTED_WITHOUT_EFFECT, 0.0)
    flight = fly(accepted, parameters={"COM_DISARM_PRFLT": -1})
    flight.until_reported(PhaseEntered, phase=Phase.LANDING)
    assert flight.one(GoalFailed).reason == "not airborne after 12 s"
    assert stated_after_s(flight, COMMANDS["take-off"]) <= STATED_WITHIN_S
    flight.until(lambda: flight.simulation.mode == "AUTO.LAND", limit_s=1.0)


FAILING = [answer for answer in Answer if not ANSWERS[answer].has_effect]


@pytest.mark.parametrize(
    "answer",
    sweep(
        FAILING,
        few=lambda answer: answer in (Answer.DENIED, Answer.NO_ANSWER_WITHOUT_EFFECT),
    ),
)
def test_without_hold_and_without_landing_the_failsafe_is_the_last_resort(answer: Answer) -> None:
    """The stream ends at once, and PX4's offboard-loss failsafe holds."""
    flight = fly(("MAV_CMD_DO_SET_MODE", answer, OFFBOARD_S), ("MAV_CMD_NAV_LAND", answer, 0.0))
    fly_to_the_end(flight, is_stopped=True)
    holding, landing = flight.of(GoalFailed)
    assert holding.reason.startswith("not holding")
    assert "setpoints end, so that the autopilot's offboard-loss failsafe" in landing.reason
    assert flight.now_s - STOPPED_S <= 2 * STATED_WITHIN_S
    assert flight.simulation.mode == "OFFBOARD"
    ended_s = flight.now_s
    flight.run(2.0)
    assert flight.setpoints[-1].time_s <= ended_s
    assert flight.simulation.mode == "AUTO.LOITER"


def test_a_vehicle_that_is_left_on_hold_but_does_not_hold_is_held_until_the_last_resort() -> None:
    """Without a payload there is no plan, and the mission holds; no setpoint is out of date."""
    left = mission("F done", skills=[command("do", "at(A)", "done")], otherwise=Otherwise.HOLD)
    flight = fly(("MAV_CMD_DO_SET_MODE", Answer.ACCEPTED_WITHOUT_EFFECT, OFFBOARD_S), flown=left)
    flight.until_the_end()
    assert flight.one(GoalFailed).reason == (
        "not holding after 12 s; setpoints end, so that the autopilot's offboard-loss failsafe "
        "takes the vehicle"
    )
    assert flight.of(SetpointRefused) == []
    flight.run(2.0)
    assert flight.simulation.mode == "AUTO.LOITER"


@pytest.mark.parametrize(
    "asked_for",
    [
        pytest.param(name, marks=[] if name in ("arm", "hold") else [pytest.mark.long])
        for name in COMMANDS
    ],
)
def test_a_rejection_for_a_time_only_delays(asked_for: str) -> None:
    asked = COMMANDS[asked_for]
    rejected = (asked.name, Answer.TEMPORARILY_REJECTED, asked.from_s)
    is_stopped = asked_for in ("hold", "land")
    flight = fly(rejected, (asked.name, None, STOPPED_S + 7.0 if is_stopped else 11.0))
    fly_to_the_end(flight, is_stopped)
    assert flight.exit_code == 0
    assert flight.of(GoalFailed) == []
