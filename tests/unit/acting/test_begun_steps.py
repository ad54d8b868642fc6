"""What is done again after an interruption of a skill, and what is not."""

from __future__ import annotations

from dataclasses import replace

import pytest
from kept_journal import KeptJournal
from rig import Rig
from synthetic import command, mission, reading

from companion.acting.executive_states import TaskStatus
from companion.acting.journal import (
    CommandIntended,
    CommandSettled,
    FlightBegun,
    JournalEntry,
    PhaseBegun,
    put_together,
)
from companion.flight_events.skills import SkillCompleted, SkillFailed
from companion.flight_events.sortie import Phase
from companion.mission.conditions import parse_condition
from companion.mission.model import Mission
from companion.mission.steps import Command, Wait
from companion.outcomes import Failed, Outcome, Progress
from companion.planning.task_changes import ActionInterrupted, TaskMoment

BEGUN = FlightBegun("m", "m.yaml", "0a", 0.0)
ARMING = PhaseBegun(Phase.ARMING)
ONE, TWO = (Command(25, 31009 + n, f"MAV_CMD_USER_{n}", (float(n),)) for n in (1, 2))


def doing(*steps: Command | Wait, **fields: object) -> Mission:
    skill = replace(command("do", "at(H)", "done"), execute=steps, **fields)  # type: ignore[arg-type]
    return mission("F done", skills=[skill])


def begin(flown: Mission, *answers: tuple[float, Outcome]) -> Rig:
    rig = Rig(flown)
    rig.flight.journal = journal = KeptJournal()
    journal.note(0.0, BEGUN)
    journal.note(0.0, ARMING)
    rig.flight.task.on_change = lambda change: journal.note(rig.flight.now_s, change)
    rig.vehicle.payloads.answers = [*answers]
    return rig.begin()


def unsettled(rig: Rig) -> list[str]:
    journal = rig.flight.journal
    assert isinstance(journal, KeptJournal)
    flight = put_together(journal.entries)
    assert flight is not None
    return [each.command for each in flight.unsettled]


def tick(rig: Rig, duration_s: float) -> None:
    for _ in range(round(duration_s / 0.05)):
        rig.tick()


def pause(rig: Rig, duration_s: float) -> None:
    rig.executive.pause()
    for _ in range(round(duration_s / 0.05)):
        rig.pass_time()
    rig.executive.resume()


def sent(rig: Rig) -> list[float]:
    return [parameters[0] for _, _, parameters in rig.vehicle.payloads.sent]


@pytest.mark.parametrize("pauses_s", [[0.2], [2.0], [60.0], [0.2, 0.2, 9.0]])
def test_a_command_is_sent_once_however_often_it_is_interrupted(pauses_s: list[float]) -> None:
    rig = begin(doing(ONE), (4.0, Progress.DONE))
    for pause_s in pauses_s:
        tick(rig, 0.5)
        pause(rig, pause_s)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0]
    assert rig.flight.now_s >= 4.0 and not rig.of(SkillFailed)


def test_what_is_refused_meanwhile_is_a_failed_try() -> None:
    rig = begin(doing(ONE, tries=2), (2.0, Failed("denied")), (1.0, Progress.DONE))
    tick(rig, 0.5)
    pause(rig, 5.0)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0, 1.0]


def test_the_steps_that_are_done_are_not_done_again() -> None:
    """The wait between them begins again."""
    rig = begin(doing(ONE, Wait(5.0), TWO))
    tick(rig, 4.0)
    pause(rig, 1.0)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0, 2.0]
    assert rig.flight.now_s == pytest.approx(11.0, abs=0.5)


def test_a_try_that_has_failed_does_all_of_it_anew() -> None:
    rig = begin(doing(ONE, Wait(1.0), TWO, tries=2), (0.0, Progress.DONE), (0.0, Failed("denied")))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0, 2.0, 1.0, 2.0]


def test_a_try_that_has_run_out_of_time_does_all_of_it_anew() -> None:
    rig = begin(doing(ONE, Wait(1.0), TWO, tries=2, timeout_s=3.0), (0.0, Progress.DONE))
    rig.vehicle.payloads.answers += [(9.0, Progress.DONE)]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0, 2.0, 1.0, 2.0]


@pytest.mark.parametrize(("heard_s", "is_confirmed"), [(0.2, False), (1.5, True), (4.0, True)])
def test_what_was_heard_since_the_command_confirms_it_after_an_interruption(
    heard_s: float, is_confirmed: bool
) -> None:
    """The sensor speaks once: before the command, while the payload works, or after its answer."""
    loaded = parse_condition("NAMED_VALUE_INT[load].value > 0")
    steps = doing(Wait(0.5), ONE, confirmed_by=loaded, timeout_s=30.0)
    rig = begin(steps, (2.0, Progress.DONE))
    tick(rig, heard_s if heard_s < 1.0 else 1.0)
    if not is_confirmed:
        rig.tick(reading("load"))
        tick(rig, 0.8)
    rig.executive.pause()
    while rig.flight.now_s < 6.0:
        rig.pass_time()
        is_heard = is_confirmed and abs(rig.flight.now_s - heard_s) < 0.01
        rig.acting.perception.take([reading("load")] if is_heard else [])
    rig.executive.resume()
    tick(rig, 2.0)
    assert bool(rig.of(SkillCompleted)) is is_confirmed
    assert sent(rig) == [1.0]


# -- the journal -----------------------------------------------------------------------------------


def test_what_is_interrupted_stays_open_in_the_journal_until_the_skill_is_done() -> None:
    rig = begin(doing(ONE, Wait(5.0)))
    tick(rig, 1.0)
    assert unsettled(rig) == ["MAV_CMD_USER_1"]
    pause(rig, 1.0)
    assert unsettled(rig) == ["MAV_CMD_USER_1"]
    rig.run_until(SkillCompleted)
    assert unsettled(rig) == []


def test_nothing_is_open_of_a_skill_that_has_failed() -> None:
    rig = begin(doing(ONE, Wait(1.0), TWO), (0.0, Progress.DONE), (0.5, Failed("denied")))
    tick(rig, 0.5)
    assert unsettled(rig) == ["MAV_CMD_USER_1"]
    rig.run_until(SkillFailed)
    assert unsettled(rig) == []


def test_a_command_that_was_not_sent_yet_is_not_open() -> None:
    rig = begin(doing(ONE))
    journal = rig.flight.journal
    assert isinstance(journal, KeptJournal)
    journal.is_kept = False
    tick(rig, 0.5)
    rig.executive.pause()
    assert sent(rig) == [] and unsettled(rig) == []


def test_an_interruption_settles_nothing() -> None:
    intended = CommandIntended(1, "do", "MAV_CMD_USER_1")
    interrupted = ActionInterrupted(TaskMoment(positions=1, now_s=0.0))
    entries: list[JournalEntry] = [BEGUN, ARMING, intended, interrupted]
    flight = put_together((0.0, entry) for entry in entries)
    assert flight is not None and flight.unsettled == (intended,)
    flight = put_together((0.0, entry) for entry in [*entries, CommandSettled(1)])
    assert flight is not None and flight.unsettled == ()
