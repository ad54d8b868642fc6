"""What is done again after an interruption of a skill, and what is not."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rig import Rig
from synthetic import command, mission

from companion.acting.executive_states import TaskStatus
from companion.acting.journal import (
    CommandIntended,
    CommandSettled,
    FlightBegun,
    JournalEntry,
    put_together,
)
from companion.flight_events.skills import SkillCompleted, SkillFailed
from companion.mission.model import Command, Mission, Wait
from companion.planning.task_changes import TaskChange
from companion.vehicle.port import Failed, Outcome, Progress

ONE, TWO = (Command(25, 31009 + n, f"MAV_CMD_USER_{n}", (float(n),)) for n in (1, 2))


class Kept:
    """A journal whose entries are on the disk at once."""

    is_kept = True

    def __init__(self) -> None:
        self.entries: list[JournalEntry] = [FlightBegun("m", "m.yaml", "0a", 0.0)]

    def note(self, now_s: float, entry: JournalEntry) -> None:
        self.entries.append(entry)

    @property
    def unsettled(self) -> list[str]:
        flight = put_together((0.0, entry) for entry in self.entries)
        assert flight is not None
        return [each.command for each in flight.unsettled]


def doing(*steps: Command | Wait, **fields: object) -> Mission:
    skill = replace(command("do", "at(H)", "done"), execute=steps, **fields)  # type: ignore[arg-type]
    return mission("F done", skills=[skill])


def begin(flown: Mission, *answers: tuple[float, Outcome]) -> Rig:
    rig = Rig(flown)
    rig.flight.journal = journal = Kept()
    rig.flight.task.on_change = lambda change: journal.note(rig.flight.now_s, change)
    rig.vehicle.payloads.answers = [*answers]
    return rig.begin()


def unsettled(rig: Rig) -> list[str]:
    journal = rig.flight.journal
    assert isinstance(journal, Kept)
    return journal.unsettled


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
    assert isinstance(journal, Kept)
    journal.is_kept = False
    tick(rig, 0.5)
    rig.executive.pause()
    assert sent(rig) == [] and unsettled(rig) == []


def test_an_interruption_settles_nothing() -> None:
    intended = CommandIntended(1, "do", "MAV_CMD_USER_1")
    entries = [FlightBegun("m", "m.yaml", "0a", 0.0), intended, TaskChange("interrupt", ())]
    flight = put_together((0.0, entry) for entry in entries)
    assert flight is not None and flight.unsettled == (intended,)
    flight = put_together((0.0, entry) for entry in [*entries, CommandSettled(1)])
    assert flight is not None and flight.unsettled == ()
