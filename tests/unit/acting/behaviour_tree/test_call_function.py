"""The leaf that calls a function: what it writes down first, what it waits for, how it is left."""

from __future__ import annotations

from dataclasses import replace

import pytest
from kept_journal import KeptJournal
from leaves import a_rig, later, run, tick
from py_trees.common import Status
from rig import Rig
from scripted_functions import ScriptedFunctions

from companion.acting.behaviour_tree.call_function import CALL_S, CallFunction
from companion.acting.behaviour_tree.kept_intention import DISK_S
from companion.acting.journal import CommandIntended, CommandSettled
from companion.flight_events.skills import SkillProgressed
from companion.mission.python_call import Named, PythonCall
from companion.outcomes import Failed, Progress
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Answer, CommandAsked, Function, Progressed, Returned

STEP = PythonCall(
    Function(FunctionKind.SKILL, "weigh"), (Named("A"), 2.5), components=(("gripper", 25),)
)
GRIP = CommandAsked("gripper", "MAV_CMD_DO_GRIPPER", (1.0, 0.0))


def leaf_of(
    *script: list[tuple[float, Answer]], timeout_s: float | None = None
) -> tuple[Rig, ScriptedFunctions, CallFunction]:
    rig, functions = a_rig(), ScriptedFunctions(*script)
    later(rig)
    rig.flight.functions = functions
    return rig, functions, CallFunction(rig.flight, STEP, timeout_s)


def test_it_succeeds_when_the_function_returns_and_the_vehicle_holds_meanwhile() -> None:
    rig, functions, leaf = leaf_of([(2.0, Returned())])
    begun_s = rig.flight.now_s
    assert run(rig, leaf) is Status.SUCCESS
    assert rig.flight.now_s - begun_s == pytest.approx(2.05, abs=0.06)
    assert rig.vehicle.setpoint is not None and rig.vehicle.setpoint.velocity == (0.0, 0.0, 0.0)
    (request,) = functions.requests
    assert request.call.text == "python(weigh, A, 2.5)"
    assert [place.name for place in request.places] == ["A"]
    assert (request.places[0].north_m, request.places[0].lat_deg) == (6.0, None)
    assert request.vehicle is not None and not request.vehicle.is_landed
    assert functions.cancelled == []


def test_it_fails_with_the_words_of_the_function() -> None:
    rig, _, leaf = leaf_of([(0.0, Failed("2.6 kg\x1b[2J"))])
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == r"2.6 kg\x1b[2J"


@pytest.mark.parametrize(("timeout_s", "limit_s"), [(3.0, 3.0), (None, CALL_S)])
def test_a_function_that_does_not_end_is_left(timeout_s: float | None, limit_s: float) -> None:
    rig, functions, leaf = leaf_of([], timeout_s=timeout_s)
    begun_s = rig.flight.now_s
    assert run(rig, leaf, 100.0) is Status.FAILURE
    assert rig.flight.now_s - begun_s == pytest.approx(limit_s, abs=0.15)
    assert leaf.feedback_message == f"not done after {limit_s:g} s"
    assert functions.cancelled == [1]


def test_nothing_is_called_before_the_journal_has_it() -> None:
    rig, functions, leaf = leaf_of([(0.0, Returned())])
    journal = KeptJournal()
    rig.flight.journal, journal.is_kept = journal, False
    for _ in range(20):
        assert tick(rig, leaf) is Status.RUNNING
    assert functions.requests == []
    assert journal.noted == [CommandIntended(1, "", "python(weigh, A, 2.5)")]
    journal.is_kept = True
    assert run(rig, leaf) is Status.SUCCESS
    assert len(journal.noted) == 1  # the end of the skill settles it


def test_a_disk_that_takes_nothing_fails_the_skill() -> None:
    rig, functions, leaf = leaf_of([(0.0, Returned())])
    rig.flight.journal = journal = KeptJournal()
    journal.is_kept = False
    assert run(rig, leaf, 2 * DISK_S) is Status.FAILURE
    assert functions.requests == []
    assert journal.noted[-1] == CommandSettled(1)


def test_what_interrupts_it_cancels_the_call_and_it_begins_anew() -> None:
    rig, functions, leaf = leaf_of([], [(0.0, Returned())])
    rig.flight.journal = journal = KeptJournal()
    assert tick(rig, leaf) is Status.RUNNING
    leaf.stop(Status.INVALID)
    assert functions.cancelled == [1]
    assert journal.noted[-1] == CommandSettled(1)
    assert run(rig, leaf) is Status.SUCCESS
    assert len(functions.requests) == 2


def test_progress_is_told_now_and_then_the_newest() -> None:
    said = [(0.1 * n, Progressed(n / 100, f"{n}")) for n in range(101)]
    rig, _, leaf = leaf_of([*said, (10.0, Returned())])
    run(rig, leaf)
    told = [s.event for s in rig.flight.collect_reports()]
    assert told == [
        SkillProgressed("python(weigh, A, 2.5)", percent, str(percent)) for percent in (0, 50, 100)
    ]
    assert told[1].text == "python(weigh, A, 2.5): 50 %, 50"
    assert SkillProgressed("weigh(A)", None, "").text == "weigh(A): under way"


def test_a_command_that_it_asks_for_is_sent_once_when_the_journal_has_it() -> None:
    rig, functions, leaf = leaf_of([(0.5, GRIP), (0.5, Returned())])
    rig.flight.journal = journal = KeptJournal()
    rig.vehicle.payloads.answers = [(1.0, Progress.DONE)]
    assert run(rig, leaf) is Status.SUCCESS
    assert rig.vehicle.payloads.sent == [(25, 211, (1.0, 0.0))]
    assert functions.replies == [None]
    assert [each.command for each in journal.noted if isinstance(each, CommandIntended)] == [
        "python(weigh, A, 2.5)",
        "MAV_CMD_DO_GRIPPER",
    ]


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        (replace(GRIP, component="gripr"), "the mission has no component gripr"),
        (replace(GRIP, component=300), "the mission has no component 300"),
        (replace(GRIP, command="MAV_CMD_NONE"), "there is no command MAV_CMD_NONE"),
    ],
)
def test_a_command_that_is_none_is_refused_by_its_reply(asked: CommandAsked, says: str) -> None:
    rig, functions, leaf = leaf_of([(0.0, asked), (0.0, Failed("as told"))])
    assert run(rig, leaf) is Status.FAILURE
    assert functions.replies == [says]
    assert rig.vehicle.payloads.sent == []


def test_a_command_that_fails_is_replied_and_settled() -> None:
    rig, functions, leaf = leaf_of([(0.0, GRIP), (0.0, Returned())])
    rig.flight.journal = journal = KeptJournal()
    rig.vehicle.payloads.answers = [(0.5, Failed("denied"))]
    assert run(rig, leaf) is Status.SUCCESS
    assert functions.replies == ["denied"]
    assert CommandSettled(2) in journal.noted


def test_a_call_that_is_left_waits_for_its_command_no_longer() -> None:
    rig, functions, leaf = leaf_of([(0.0, GRIP)])
    rig.vehicle.payloads.answers = [(60.0, Progress.DONE)]
    for _ in range(5):
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    assert rig.vehicle.payloads.left == [1]
    assert functions.cancelled == [1]


def test_called_anew_it_gets_what_has_become_of_its_command() -> None:
    rig, functions, leaf = leaf_of([(0.0, GRIP)], [(0.0, GRIP), (0.0, Returned())])
    rig.vehicle.payloads.answers = [(3.0, Progress.DONE)]
    for _ in range(5):
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    later(rig)
    assert run(rig, leaf) is Status.SUCCESS
    assert functions.replies == [None]
    assert len(rig.vehicle.payloads.sent) == 1


def test_called_anew_it_may_ask_for_something_else() -> None:
    other = replace(GRIP, parameters=(1.0, 1.0))
    rig, _, leaf = leaf_of([(0.0, GRIP)], [(0.0, other), (0.0, Returned())])
    rig.vehicle.payloads.answers = [(9.0, Progress.DONE)]
    for _ in range(5):
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    assert run(rig, leaf) is Status.SUCCESS
    assert [parameters for *_, parameters in rig.vehicle.payloads.sent] == [(1.0, 0.0), (1.0, 1.0)]
    assert rig.vehicle.payloads.forgotten == [1, 2]


def test_a_function_that_has_returned_is_not_called_again_for_the_same_position() -> None:
    rig, functions, leaf = leaf_of([(0.0, Returned())])
    assert run(rig, leaf) is Status.SUCCESS
    assert run(rig, leaf) is Status.SUCCESS
    assert len(functions.requests) == 1
