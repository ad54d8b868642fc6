"""Sections III and V: the mission of the paper, what it says happens, and its last claim.

The mission is missions/paper_section_v.yaml as it is shipped; the vehicle is a point that obeys.
Where we leave the paper (the history is kept, an event may restart a conjunct) the test says so.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from unittest.mock import Mock

import pytest
from happened import Replan
from rig import Rig
from synthetic import command, event, facts_of, mission, reading

from companion.acting.executive_states import TaskStatus
from companion.flight_events.facts import BeliefWithdrawn, MissionEventChanged
from companion.flight_events.plans import LapCompleted, NoPlanFound
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.ltl.formula import Formula
from companion.ltl.parser import parse
from companion.ltl.semantics import holds
from companion.ltl.translate import translate
from companion.mission.model import Mission
from companion.mission.signals import Signal
from companion.motion.layered_routes import LayeredRoutes
from companion.outcomes import Failed, Progress
from companion.planning.instances import Instances
from companion.planning.lasso import Problem, word
from companion.planning.solver import Solver
from companion.planning.task_state import TaskState

TARGET = (Signal("NAMED_VALUE_INT", "target", "value"), 1.0)
SITES = ("Home", "A", "B", "C", "r1", "r2", "r3")
UPLOAD_SITES = ("r1", "r2", "r3")
PHI = """
    G ((F at(A) | targetFound) & (F at(B) | targetFound) & (F at(C) | targetFound))
  & G ((targetFound | targetReported) -> F targetReported)
  & G (targetReported -> X at(Home))
"""


@pytest.fixture
def rig(section_v: Mission, surveillance_routes: LayeredRoutes) -> Rig:
    return Rig(section_v, surveillance_routes)


def fly_section_5(rig: Rig) -> Rig:
    """The flight of Fig. 7: a target on the way to B for the second time, r1 refuses."""
    rig.begin()
    rig.vehicle.payloads.answers = [(2.0, Failed("denied")), (1.0, Progress.DONE)]
    rig.run_until(PlaceReached, place="A", times=2)
    for _ in range(60):
        rig.tick()
    rig.tick(TARGET)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    return rig


# -- Section V: the model --------------------------------------------------------------------------


def test_the_initial_state_s0(rig: Rig) -> None:
    """s0 = {at(Home), not targetFound} and canUpload(r) for each r; trans_ok is of Section IV-C."""
    moves = {f"trans_ok({a}, {b})" for a, b in itertools.permutations(SITES, 2)}
    uploads = {f"canUpload({r})" for r in UPLOAD_SITES}
    assert rig.task.facts == {"at(Home)"}
    assert rig.task.all_facts == {"at(Home)"} | uploads | moves


def test_the_two_action_templates_and_their_instances(rig: Rig) -> None:
    found = {a.name: a for a in rig.planner.actions.model.actions}
    moves = {f"move({a}, {b})" for a, b in itertools.permutations(SITES, 2)}
    uploads = {f"upload({r})" for r in UPLOAD_SITES}
    assert set(found) == moves | uploads | {"wait"}
    move_ab, upload = found["move(A, B)"], found["upload(r1)"]
    assert move_ab.requires - move_ab.assumes == {"at(A)"}
    assert move_ab.adds == {"at(B)"}
    assert move_ab.deletes == {"at(A)"}
    assert upload.requires == {"at(r1)", "targetFound", "canUpload(r1)"}
    assert upload.adds == {"targetReported"}
    assert upload.deletes == frozenset()


def test_the_task_is_the_paper_s_formula(section_v: Mission) -> None:
    """phi_search, phi_upload and phi_return, compared by what they say of words."""
    whole = parse(PHI)
    lines = [line for line in section_v.task.values() if isinstance(line, Formula)]
    assert len(lines) == len(section_v.task), "none has a time"
    facts = ["at(A)", "at(B)", "at(C)", "at(Home)", "targetFound", "targetReported"]
    letters = [frozenset({f}) for f in facts] + [facts_of("targetReported", "at(Home)")]
    for first, second, third in itertools.product(letters, repeat=3):
        prefix, loop = [first], [second, third]
        assert holds(whole, prefix, loop) == all(holds(line, prefix, loop) for line in lines)


# -- Section V: what happens -----------------------------------------------------------------------


def test_the_first_plan_cycles_among_a_b_and_c(rig: Rig) -> None:
    rig.begin()
    assert rig.story == ["move(Home, A), (move(A, B), move(B, C), move(C, A))^w"]


def test_the_first_plan_satisfies_the_formula(rig: Rig) -> None:
    rig.begin()
    problem, _ = TaskState(rig.planner).problem()
    assert rig.executive.lasso is not None
    prefix, loop = word(problem, rig.executive.lasso)
    assert holds(parse(PHI), [problem.facts, *prefix], loop)


def test_the_simulation_of_figure_7(rig: Rig) -> None:
    """(a) loops, (b) a target and so to r1, (c) r1 refuses and so to r2, and then home."""
    refused = SkillFailed("upload(r1)", "denied")
    assert fly_section_5(rig).story == [
        "move(Home, A), (move(A, B), move(B, C), move(C, A))^w",
        PlaceReached("A", "move(Home, A)"),
        PlaceReached("B", "move(A, B)"),
        PlaceReached("C", "move(B, C)"),
        LapCompleted(1),
        PlaceReached("A", "move(C, A)"),
        MissionEventChanged("targetFound", holds=True),
        Replan("target found", "move(here, r1), upload(r1), move(r1, Home), (wait)^w"),
        PlaceReached("r1", "move(here, r1)"),
        refused,
        BeliefWithdrawn("canUpload(r1)"),
        Replan(refused.text, "move(r1, r2), upload(r2), move(r2, Home), (wait)^w"),
        PlaceReached("r2", "move(r1, r2)"),
        SkillCompleted("upload(r2)"),
        PlaceReached("Home", "move(r2, Home)"),
    ]


def test_home_is_next_after_the_upload_with_nothing_in_between(rig: Rig) -> None:
    fly_section_5(rig)
    _, histories = rig.task.problem()
    letters = histories[-1]  # of phi_return, which nothing restarts
    reported = next(i for i, letter in enumerate(letters) if "targetReported" in letter)
    assert "at(r2)" in letters[reported]
    assert all("at(Home)" in letter for letter in letters[reported + 1 :])
    assert len(letters) > reported + 1


def test_the_word_that_was_flown_satisfies_what_was_never_restarted(rig: Rig) -> None:
    fly_section_5(rig)
    _, histories = rig.task.problem()
    for conjunct, letters in zip(rig.planner.conjuncts, histories, strict=True):
        assert holds(conjunct.formula, letters[:-1], letters[-1:])


def test_a_refused_site_is_not_tried_again(rig: Rig) -> None:
    rig.begin()
    rig.vehicle.payloads.answers = [
        (1.0, Failed("denied")),
        (1.0, Failed("denied")),
        (1.0, Progress.DONE),
    ]
    rig.run_until(PlaceReached, place="A")
    rig.tick(TARGET)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    failures = [(failed.action, failed.reason) for failed in rig.of(SkillFailed)]
    assert failures == [("upload(r1)", "denied"), ("upload(r2)", "denied")]
    assert rig.of(SkillCompleted) == [SkillCompleted("upload(r3)")]
    assert rig.executive.reports.replans == 3


def test_when_all_sites_refuse_there_is_no_plan_and_each_is_to_blame(rig: Rig) -> None:
    rig.begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))] * 3
    rig.tick(TARGET)
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    last = rig.one(NoPlanFound).explanation
    assert "no plan: upload cannot hold from here." in last
    assert "with canUpload(r1) or canUpload(r2) or canUpload(r3) there would be a plan" in last


# -- Sections III-C and V: only the initial state is modified --------------------------------------


def test_nothing_but_the_initial_state_changes_in_flight(
    section_v: Mission, surveillance_routes: LayeredRoutes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each conjunct is translated once, and skills are instantiated once, over the whole flight."""
    translated, instantiated = Mock(wraps=translate), Mock(wraps=Instances)
    monkeypatch.setattr("companion.planning.task_automata.translate", translated)
    monkeypatch.setattr("companion.planning.mission_actions.Instances", instantiated)
    planned = {verb: Mock(wraps=getattr(Solver, verb)) for verb in ("solve", "replan")}
    for verb, mock in planned.items():
        monkeypatch.setattr(Solver, verb, lambda *args, mock=mock: mock(*args))
    rig = Rig(section_v, surveillance_routes)
    automata = [conjunct.automaton for conjunct in rig.planner.conjuncts]
    actions = rig.planner.actions.model.actions
    fly_section_5(rig)

    calls = [call for mock in planned.values() for call in mock.call_args_list]
    problems: list[Problem] = [call.args[1] for call in calls]
    # Two before the flight, of which one is with the target found; and when it was: is the plan
    # still the best one?
    assert len(problems) == 5
    assert translated.call_count == len(automata) == 5
    assert instantiated.call_count == 2  # from places, and from here
    for problem in problems:
        assert problem.conjuncts is rig.planner.conjuncts
        assert all(c.automaton is a for c, a in zip(problem.conjuncts, automata, strict=True))
        own = problem.actions[: len(actions)]
        assert all(a is b for a, b in zip(own, actions, strict=True))
    departures = [len(problem.actions) - len(actions) for problem in problems]
    assert departures == [0, 0, 0, len(SITES), 0]  # moves from here, en route alone


def test_a_replan_s_initial_state_is_what_was_observed(rig: Rig) -> None:
    fly_section_5(rig)
    assert rig.task.withdrawn == {"canUpload(r1)"}
    assert rig.task.facts == {"at(Home)", "targetFound", "targetReported"}


# -- Section III: words and replanning -------------------------------------------------------------


def test_an_interrupted_skill_appends_no_position() -> None:
    """The event on the way does not break X: what is next is the next place that is reached."""
    found = event("found")
    task = {"first": "X (at(A) | at(B))", "then": "F at(A) & (G !found | F at(B))"}
    rig = Rig(mission(task, events=[found])).begin()
    for _ in range(20):
        rig.tick()
    rig.tick(reading("found"))
    assert rig.executive.reports.replans == 1
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    _, (first, *_) = rig.task.problem()
    places = [sorted(f for f in letter if f.startswith("at(")) for letter in first]
    assert places[:3] == [["at(H)"], ["at(A)"], ["at(B)"]]


def test_a_change_that_does_not_matter_changes_nothing() -> None:
    """Section III-B replans when the state differs from the predicted one; we ask what of it."""
    lamp, found = event("lamp"), event("found")
    task = "G F at(A) & G F at(B) & G (found -> F at(H))"
    calm = Rig(mission(task, events=[lamp, found])).begin()
    disturbed = Rig(mission(task, events=[lamp, found])).begin()
    for i in range(400):
        calm.tick()
        disturbed.tick(reading("lamp", i // 7 % 2))
    assert disturbed.executive.reports.replans == 0
    assert disturbed.vehicle.flown == calm.vehicle.flown
    disturbed.tick(reading("found"))
    assert disturbed.executive.reports.replans == 1


def test_what_was_visited_is_not_visited_again() -> None:
    """The history is kept, where the paper starts from the automaton's initial states."""
    skills = [
        command("at_b", "at(B)", "done"),
        command("at_h", "at(H)", "done", cost_s=60.0),
    ]
    task = {"visit": "F (at(A) & F at(B))", "report": "F done"}
    rig = Rig(mission(task, skills=skills)).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied")), (1.0, Progress.DONE)]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.executive.reports.replans == 1
    assert rig.places == ["A", "B", "H"]


def test_without_its_history_the_planner_would_visit_it_again() -> None:
    """The other half of the argument: from the initial states, A is still to be visited at B."""
    rig = Rig(mission("F (at(A) & F at(B))")).begin()
    rig.run_until(PlaceReached, place="B")
    forgetful = TaskState(rig.planner)
    forgetful.facts = facts_of("at(B)")
    assert str(rig.planner.solver.solve(*rig.task.problem())) == "(wait)^w"
    again = "move(B, A), move(A, B), (wait)^w"
    assert str(rig.planner.solver.solve(*forgetful.problem())) == again


def test_an_event_may_restart_a_conjunct(section_v: Mission, rig: Rig) -> None:
    """The mission file says which: else the sites that search still demanded came first."""
    kept_events = {n: replace(e, restarts=frozenset()) for n, e in section_v.events.items()}
    strict = Rig(replace(section_v, events=kept_events), rig.flight.routes)
    for asked in (strict, rig):
        asked.begin()
        asked.run_until(PlaceReached, place="A")
        asked.tick(TARGET)
    first_goals = [str(asked.executive.lasso).split(",")[1] for asked in (strict, rig)]
    assert first_goals[1] == " r1)"
    assert first_goals[0] in (" B)", " C)")
