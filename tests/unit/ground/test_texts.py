"""Events as STATUSTEXT: what is said, how bad it is, and how fast."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from companion.flight_events.hosting import MissionReady, MissionUnreadable, UploadChecked
from companion.flight_events.plans import LineDropped, LineTakenUp, NoPlanFound
from companion.flight_events.skills import PlaceReached, SkillFailed
from companion.flight_events.sortie import GoalFailed, RunFailed, TaskSatisfied
from companion.flight_events.word import ConjunctViolated
from companion.ground.texts import LONGEST, MESSAGE_S, PATIENCE_S, StatusTextQueue, severity
from companion.mavlink.framing import dialect

INFO, WARNING = dialect.MAV_SEVERITY_INFO, dialect.MAV_SEVERITY_WARNING


def drained(
    texts: StatusTextQueue, since_s: float = 0.0, seconds: float = 60.0
) -> list[tuple[float, Any]]:
    """All that leaves, with its time; asked twenty times a second."""
    times = [since_s + 0.05 * i for i in range(round(20 * seconds))]
    return [(now_s, message) for now_s in times for message in texts.due(now_s)]


def together(messages: list[Any]) -> list[str]:
    """The texts, put together as a receiver does."""
    whole: list[bytes] = []
    for message in messages:
        raw = message._text_raw.rstrip(b"\0")
        if message.id and message.chunk_seq:
            whole[-1] += raw
        else:
            whole.append(raw)
    return [raw.decode() for raw in whole]


def test_a_failed_run_is_critical_and_a_satisfied_one_a_notice() -> None:
    assert severity(TaskSatisfied()) == dialect.MAV_SEVERITY_NOTICE
    assert severity(RunFailed("lost", exit_code=5)) == dialect.MAV_SEVERITY_CRITICAL


def test_a_goal_that_is_not_reached_is_a_warning() -> None:
    assert severity(GoalFailed("not landed: denied")) == WARNING


def test_what_is_worse_has_the_smaller_number() -> None:
    violated = ConjunctViolated("safe", "G !low", position=1, facts=("low",))
    failed, no_plan = SkillFailed("do", "denied"), NoPlanFound(1, "denied", "no plan")
    reached = PlaceReached("A", "move(H, A)")
    numbers = [severity(event) for event in (violated, failed, no_plan, reached)]
    assert numbers == sorted(set(numbers))


def test_what_becomes_of_a_line_that_may_be_dropped_is_no_error() -> None:
    violated = ConjunctViolated("far", "G !low", position=1, facts=("low",), optional=True)
    assert severity(violated) == severity(LineDropped("far", "no plan keeps it")) == WARNING
    assert severity(LineTakenUp("far", anew=True)) == dialect.MAV_SEVERITY_NOTICE


def test_a_refused_upload_is_a_warning_and_an_accepted_one_a_notice() -> None:
    assert severity(UploadChecked("refused a.yaml", is_refused=True)) == WARNING
    assert severity(MissionUnreadable("no such file")) == WARNING
    accepted = [UploadChecked("a.yaml accepted", is_refused=False), MissionReady("a")]
    assert {severity(event) for event in accepted} == {dialect.MAV_SEVERITY_NOTICE}


@given(st.lists(st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"])), max_size=8))
def test_texts_arrive_in_order_and_whole_up_to_their_longest(said: list[str]) -> None:
    texts = StatusTextQueue()
    for text in said:
        texts.tell(0.0, WARNING, text)
    heard = together([m for _, m in drained(texts)])
    assert len(heard) == len(said)
    for whole, text in zip(said, heard, strict=True):
        if len(whole.encode()) <= LONGEST:
            assert text == whole
        else:
            assert len(text.encode()) <= LONGEST
            assert whole.startswith(text.removesuffix("..."))


def test_lines_become_one() -> None:
    texts = StatusTextQueue()
    texts.tell(0.0, WARNING, "weak failsafes\n    COM_OF_LOSS_T is 5\n    set 1")
    assert together([m for _, m in drained(texts)]) == ["weak failsafes; COM_OF_LOSS_T is 5; set 1"]


def test_a_burst_is_spread() -> None:
    texts = StatusTextQueue()
    for _ in range(20):
        texts.tell(0.0, WARNING, "x" * 60)
    times = [now_s for now_s, _ in drained(texts)]
    assert len(times) == 40
    assert all(b - a >= MESSAGE_S - 1e-9 for a, b in pairwise(times))


def test_of_what_waits_too_long_only_warnings_are_said() -> None:
    texts = StatusTextQueue()
    for i in range(100):
        texts.tell(0.0, INFO, f"info {i}")
        texts.tell(0.0, WARNING, f"warning {i}")
    left = drained(texts)
    assert [m.text for _, m in left if m.severity == WARNING] == [
        f"warning {i}" for i in range(100)
    ]
    assert all(now_s <= PATIENCE_S + 1e-9 for now_s, m in left if m.severity == INFO)


def test_at_the_end_all_is_said() -> None:
    texts = StatusTextQueue()
    for i in range(30):
        texts.tell(0.0, INFO, f"{i}")
    assert together(texts.rest()) == [f"{i}" for i in range(30)]
    assert texts.rest() == [] and texts.due(9.0) == []
