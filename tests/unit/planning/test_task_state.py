"""The word of a flight: which positions there are, and when the automata read them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic import command, event, facts_of, mission

from companion.ltl.automaton import successors
from companion.mission.events import Event
from companion.mission.model import Mission
from companion.planning.domain import WAIT, Action
from companion.planning.instances import departures
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState

BELIEFS = {f"trans_ok({a}, {b})" for a in "HAB" for b in "HAB" if a != b}


def state(asked: Mission) -> TaskState:
    return TaskState(Planner(asked, lambda origin, goal: 4.0))


def action(task: TaskState, name: str) -> Action:
    """An action that is known at present, by its name."""
    return next(a for a in task.problem()[0].actions if a.name == name)


def perform(task: TaskState, name: str) -> None:
    performed = action(task, name)
    task.begin(performed)
    task.complete(performed, 0.0)


def letters(task: TaskState, conjunct: int = 0) -> list[set[str]]:
    """What a conjunct has read, the present position included; without the beliefs."""
    return [set[str](letter) - BELIEFS for letter in task.problem()[1][conjunct]]


def test_position_0_is_the_state_at_the_start() -> None:
    task = state(mission("F at(A)"))
    assert letters(task) == [{"at(H)"}]
    assert task.word.positions == 0


def test_a_letter_holds_the_beliefs() -> None:
    task = state(mission("F at(A)"))
    task.withdraw(facts_of("trans_ok(H, A)"))
    assert task.problem()[1][0] == [{"at(H)"} | BELIEFS - {"trans_ok(H, A)"}]


def test_each_completed_skill_and_each_rest_appends_a_position() -> None:
    task = state(mission("F at(A)"))
    for name in ("move(H, A)", "wait", "move(A, B)"):
        perform(task, name)
    assert letters(task) == [{"at(H)"}, {"at(A)"}, {"at(A)"}, {"at(B)"}]
    assert task.word.positions == 3


def test_an_interrupted_skill_appends_none() -> None:
    task = state(mission("F at(A)"))
    task.begin(action(task, "move(H, A)"))
    task.interrupt()
    assert letters(task) == [{"at(H)"}]
    perform(task, "move(here, B)")
    assert letters(task) == [{"at(H)"}, {"at(B)"}]
    assert task.word.positions == 1


def test_a_position_is_read_when_it_is_left_and_an_event_may_change_it_until_then() -> None:
    found = event("found")
    task = state(mission("F found", events=[found]))
    task.take(found, True)
    assert letters(task) == [{"at(H)", "found"}]
    task.begin(WAIT)
    task.take(found, False)
    assert letters(task) == [{"at(H)", "found"}]
    task.complete(WAIT, 0.0)
    assert letters(task) == [{"at(H)", "found"}, {"at(H)"}]


def pulse(task: TaskState, raised: Event) -> None:
    """An event that rises and falls again."""
    task.take(raised, True)
    task.take(raised, False)


def test_a_rise_between_two_letters_is_in_the_next_one_alone() -> None:
    asked = event("asked")
    task = state(mission("G (asked -> F at(A))", events=[asked]))
    task.begin(action(task, "move(H, A)"))
    pulse(task, asked)
    assert task.facts == {"at(H)"}, "a precondition sees what holds now"
    task.complete(action(task, "move(H, A)"), 0.0)
    assert letters(task) == [{"at(H)"}, {"at(A)", "asked"}]
    perform(task, "move(A, B)")
    assert letters(task) == [{"at(H)"}, {"at(A)", "asked"}, {"at(B)"}]
    assert [set(position.risen) for position in task.word.left] == [set(), {"asked"}]


def test_a_rise_in_a_position_that_is_not_read_yet_is_in_its_letter() -> None:
    asked = event("asked")
    task = state(mission("F asked", events=[asked]))
    pulse(task, asked)
    assert letters(task) == [{"at(H)", "asked"}]
    assert task.problem()[0].unread == frozenset()


def test_what_still_holds_is_not_said_to_have_risen_before() -> None:
    asked = event("asked")
    task = state(mission("F asked", events=[asked]))
    task.begin(WAIT)
    task.take(asked, True)
    task.complete(WAIT, 0.0)
    task.leave()
    assert [(set(p.facts), set(p.risen)) for p in task.word.left] == [
        ({"at(H)"}, set()),
        ({"at(H)", "asked"}, set()),
    ]


def test_interrupted_and_failed_skills_consume_no_rise() -> None:
    asked = event("asked")
    task = state(
        mission("G (asked -> F done)", skills=[command("do", "at(H)", "done")], events=[asked])
    )
    pulse(task, asked)
    task.begin(action(task, "do"))
    pulse(task, asked)
    task.withdraw(facts_of("can_do"))
    task.interrupt()
    task.begin(action(task, "move(H, A)"))
    task.interrupt()
    assert task.problem()[0].unread == {"asked"}
    perform(task, "move(here, B)")
    assert [letter & {"asked"} for letter in letters(task)] == [{"asked"}, {"asked"}]


STEPS = ["begin", "complete", "interrupt", "rise", "fall", "pulse", "leave", "depart"]


@given(st.lists(st.tuples(st.sampled_from(STEPS), st.sampled_from("xy"))))
def test_no_rise_is_missing_from_the_word_and_none_is_in_two_letters(
    steps: list[tuple[str, str]],
) -> None:
    """Held against the definition: what each letter has to have of two events."""
    events = {name: event(name) for name in "xy"}
    task = state(mission("G (x -> F at(A)) & G (y -> F at(B))", events=events.values()))
    expected: list[set[str]] = []
    holds: set[str] = set()
    risen: set[str] = set()
    read = 0
    for step, name in [*steps, ("interrupt", "x"), ("begin", "x"), ("complete", "x")]:
        match step:
            case "begin" if task.running is None:
                task.begin(WAIT)
            case "complete" if task.running is not None:
                task.complete(WAIT, 0.0)
            case "interrupt":
                task.interrupt()
            case "rise" if name not in holds:
                task.take(events[name], True)
                holds.add(name)
                risen.add(name)
            case "fall" if name in holds:
                task.take(events[name], False)
                holds.discard(name)
            case "pulse" if name not in holds:
                pulse(task, events[name])
                risen.add(name)
            case "leave":
                task.leave()
            case "depart" if task.running is None:
                task.depart()
        while read < task.word.positions:
            expected.append(holds | risen)
            risen.clear()
            read += 1
    task.leave()
    expected += [holds | risen] if task.word.positions > read else []
    assert [set(position.facts) & {"x", "y"} for position in task.word.left] == expected
    assert not task.word.risen or task.word.positions == read


@pytest.mark.parametrize("formula", ["F at(A)", "X at(A)", "at(H) U at(B)", "G F at(A)"])
def test_a_plan_is_made_as_if_the_present_position_were_read(formula: str) -> None:
    """Leaving a position changes nothing in the problem: it was anticipated."""
    task = state(mission(formula))
    before = task.problem()
    task.begin(action(task, "move(H, A)"))
    assert task.problem() == before


def test_the_automata_advance_with_the_word() -> None:
    task = state(mission({"one": "F at(A)", "two": "X X at(B)"}))
    perform(task, "move(H, A)")
    perform(task, "move(A, B)")
    problem, histories = task.problem()
    for conjunct, states, history in zip(
        problem.conjuncts, problem.automaton_states, histories, strict=True
    ):
        expected = conjunct.automaton.initial
        for letter in history:
            expected = successors(conjunct.automaton, expected, letter)
        assert states == expected


def test_an_interrupted_flight_leaves_the_vehicle_at_no_place() -> None:
    task = state(mission("F at(A)"))
    task.begin(action(task, "move(H, A)"))
    task.interrupt()
    assert task.facts == {"at(here)"}
    assert {"trans_ok(here, A)", "trans_ok(here, B)", "trans_ok(here, H)"} <= task.all_facts
    assert {a.name for a in task.problem()[0].actions} >= {"move(here, A)", "move(here, H)"}


def test_an_interrupted_command_or_rest_leaves_it_where_it_is() -> None:
    task = state(mission("F done", skills=[command("do", "at(H)", "done")]))
    for name in ("do", "wait"):
        task.begin(action(task, name))
        task.interrupt()
        assert task.facts == {"at(H)"}
        assert task.running is None


def test_between_skills_there_is_nothing_to_interrupt() -> None:
    task = state(mission("F at(A)"))
    perform(task, "move(H, A)")
    task.interrupt()
    assert task.facts == {"at(A)"}


def test_beliefs_about_here_end_where_the_next_place_is_reached() -> None:
    """`here` is another place each time; what is known of a real place stays known."""
    task = state(mission("F at(A)"))
    task.depart()
    task.withdraw(facts_of("trans_ok(here, A)", "trans_ok(H, A)"))
    assert "trans_ok(here, A)" not in task.all_facts
    perform(task, "move(here, B)")
    assert task.withdrawn == {"trans_ok(H, A)"}


def test_a_belief_about_a_place_whose_name_contains_here_is_kept() -> None:
    task = state(mission("F at(A)"))
    task.withdraw(facts_of("can_use(there)"))
    perform(task, "wait")
    assert task.withdrawn == {"can_use(there)"}


def test_an_event_sets_and_clears_its_fact() -> None:
    found = event("found")
    task = state(mission("F at(A)", events=[found]))
    task.take(found, True)
    assert task.facts == {"at(H)", "found"}
    task.take(found, False)
    assert task.facts == {"at(H)"}


def test_an_event_restarts_the_conjuncts_that_it_names_and_no_other() -> None:
    found = event("found", restarts=["one"])
    task = state(mission({"one": "F at(A)", "two": "F at(B)"}, events=[found]))
    perform(task, "move(H, A)")
    task.take(found, True)
    assert letters(task, 0) == [{"at(A)", "found"}]
    assert letters(task, 1) == [{"at(H)"}, {"at(A)", "found"}]


def test_the_end_of_an_event_restarts_nothing() -> None:
    found = event("found", restarts=["one"])
    task = state(mission({"one": "F at(A)"}, events=[found]))
    task.take(found, True)
    perform(task, "move(H, A)")
    task.take(found, False)
    assert len(letters(task)) == 2


def test_departures_carry_what_a_move_carries() -> None:
    """A move from `here` differs from one from a place by its origin alone."""
    asked = mission("F at(A)")
    planner = Planner(asked, lambda origin, goal: 4.0)
    from_here = {a.name: a for a in departures(asked, planner.actions.flight_time)}
    assert set(from_here) == {"move(here, H)", "move(here, A)", "move(here, B)"}
    move = from_here["move(here, A)"]
    assert move.requires == {"at(here)", "trans_ok(here, A)"}
    assert move.adds == {"at(A)"}
    assert move.deletes == {"at(here)"}


def test_each_position_is_kept_as_it_was_left() -> None:
    found = event("found", restarts=["one"])
    task = state(mission({"one": "F at(A)", "two": "F trans_ok(H, A)"}, events=[found]))
    task.withdraw(facts_of("trans_ok(A, B)"))
    perform(task, "move(H, A)")
    task.take(found, True)
    task.begin(WAIT)
    task.interrupt()
    task.begin(action(task, "wait"))
    first, second = task.word.left
    mentioned = "trans_ok(H, A)"  # all other beliefs would say nothing to a reader of the task
    assert (first.number, first.restarted) == (0, ())
    assert first.facts == {"at(H)", mentioned}
    assert (second.number, second.restarted) == (1, ("one",))
    assert second.facts == {"at(A)", "found", mentioned}
    assert first.withdrawn == second.withdrawn == {"trans_ok(A, B)"}


def test_a_violation_is_noticed_once_and_again_after_a_restart() -> None:
    low, calm = event("low"), event("calm", restarts=["safe"])
    task = state(mission({"safe": "G !low", "goal": "F at(A)"}, events=[low, calm]))
    perform(task, "wait")
    task.take(low, True)
    perform(task, "wait")
    perform(task, "move(H, A)")
    task.take(calm, True)
    perform(task, "wait")
    assert [[c.name for c in p.violated] for p in task.word.left] == [[], ["safe"], [], ["safe"]]


def test_a_line_that_nothing_satisfies_is_violated_by_the_first_position() -> None:
    again = event("again", restarts=["never"])
    task = state(mission({"never": "F (at(A) & !at(A))"}, events=[again]))
    perform(task, "wait")
    perform(task, "wait")
    task.take(again, True)
    perform(task, "wait")
    assert [[c.name for c in p.violated] for p in task.word.left] == [["never"], [], ["never"]]


def test_who_departs_leaves_the_position_as_it_was() -> None:
    task = state(mission("F at(A)"))
    task.depart()
    assert [set(position.facts) for position in task.word.left] == [{"at(H)"}]
    assert task.facts == {"at(here)"}


# -- lines that may be dropped ---------------------------------------------------------------------

CALM = event("wind")
OPTIONAL = mission({"go": "G F at(A)", "calm": "G !wind"}, events=[CALM], priorities={"calm": 1})


def test_a_line_that_may_be_dropped_is_no_violation_of_the_task() -> None:
    task = state(OPTIONAL)
    task.take(CALM, True)
    perform(task, "move(H, A)")
    assert (task.violated, task.violated_kept) == ((), ("calm",))
    (position,) = task.word.left
    assert [conjunct.name for conjunct in position.violated] == ["calm"]


def test_a_violated_line_is_planned_for_as_if_it_began_anew() -> None:
    task = state(OPTIONAL)
    task.take(CALM, True)
    task.begin(action(task, "move(H, A)"))
    assert letters(task, 1) == [] and letters(task) == [{"at(H)", "wind"}]
    assert task.problem()[0].automaton_states[1] == task.problem()[0].conjuncts[1].automaton.initial


def test_a_line_that_is_taken_up_after_a_violation_begins_anew() -> None:
    task = state(OPTIONAL)
    task.take(CALM, True)
    assert task.drop(["calm"]) == ()
    perform(task, "move(H, A)")
    assert task.lines.may_take_up and task.violated_kept == ()
    task.take(CALM, False)
    assert task.drop([]) == ("calm",)
    perform(task, "move(A, H)")
    task.leave()
    assert [(p.dropped, p.restarted) for p in task.word.left] == [
        (("calm",), ()),
        ((), ("calm",)),
        ((), ()),
    ]
    assert letters(task, 1) == [{"at(A)"}, {"at(H)"}] and task.violated_kept == ()


def test_a_dropped_line_has_no_part_in_laps() -> None:
    lines = {"go": "G F at(A)", "far": "G F at(B)"}
    task = state(mission(lines, priorities={"far": 1}))
    task.drop(["far"])
    for name in ("move(H, A)", "move(A, H)", "move(H, A)", "move(A, H)"):
        perform(task, name)
    assert task.word.laps == 2
    task.drop([])
    for name in ("move(H, A)", "move(A, H)"):
        perform(task, name)
    assert task.word.laps == 2


def test_since_when_a_dropped_line_waits_is_known_when_it_is_taken_up() -> None:
    task = state(mission({"go": "G F at(A)", "far": "G F at(B)"}, priorities={"far": 1}))
    task.drop(["far"])
    for now_s, name in enumerate(("move(H, A)", "move(A, H)", "move(H, A)"), 1):
        performed = action(task, name)
        task.begin(performed)
        task.complete(performed, float(now_s))
    assert task.problem()[0].waiting_since_ms == (3000, 0)
