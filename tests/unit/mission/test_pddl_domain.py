"""Skills, sets, start and goal from PDDL; the example is tests/data/delivery."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import Location, MissionError
from companion.ltl.parser import parse
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.steps import Fly
from companion.planning.instances import instantiate
from companion.planning.planner import Planner

pytestmark = pytest.mark.slow
"""Reading a domain and a problem takes a tenth of a second."""
ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "tests" / "data" / "delivery"
Edit = Callable[[str, str, str], None]
Spoil = Callable[[str, str, str], Mission]
DOMAIN, PROBLEM = "delivery.pddl", "two_parcels.pddl"


@pytest.fixture(scope="module")
def delivery() -> Mission:
    return load_mission(EXAMPLE / "delivery.yaml")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the example."""
    copy = tmp_path / "tests" / "data" / "delivery"
    shutil.copytree(EXAMPLE, copy)
    shutil.copytree(ROOT / "missions" / "maps", tmp_path / "missions" / "maps")
    return copy


@pytest.fixture
def edit(folder: Path) -> Edit:
    """Replaces one text of one file of the copy."""

    def replace(name: str, old: str, new: str) -> None:
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")

    return replace


@pytest.fixture
def spoil(folder: Path, edit: Edit) -> Spoil:
    """Loads the copy after one more replacement."""

    def load(name: str, old: str, new: str) -> Mission:
        edit(name, old, new)
        return load_mission(folder / "delivery.yaml")

    return load


def test_types_are_sets_and_places_keep_their_spelling(delivery: Mission) -> None:
    assert delivery.sets["place"] == ("Home", "A", "B")
    assert delivery.sets["depot"] == ("Home",)
    assert delivery.sets["customer"] == ("A", "B")
    assert delivery.sets["parcel"] == ("p1", "p2")


def test_actions_are_skills(delivery: Mission) -> None:
    assert list(delivery.skills) == ["move", "pick_up", "drop", "hand_over"]
    move, hand_over = delivery.skills["move"], delivery.skills["hand_over"]
    assert move.parameters == (("from", "place"), ("to", "place"))
    assert move.distinct == (("from", "to"),)
    assert move.execute == (Fly("to"),)
    assert move.cost_s is None
    assert delivery.skills["drop"].cost_s == 5
    assert len(hand_over.conditional) == 2 * 3  # parcels, effects


def test_start_and_goal(delivery: Mission) -> None:
    assert delivery.initially >= {"at(Home)", "free", "in(p1, Home)", "wants(B, p2)"}
    assert delivery.task == {"goal": parse("F (delivered(p1) & delivered(p2))")}


def test_the_parcels_are_carried_one_at_a_time(delivery: Mission) -> None:
    """Every plan is checked by the planner itself; this one is the only sensible order."""
    planner = Planner(delivery, lambda origin, goal: 10.0)
    assert str(planner.plan()) == (
        "pick_up(p1, Home), move(Home, A), hand_over(A), move(A, Home), "
        "pick_up(p2, Home), move(Home, B), hand_over(B), (wait)^w"
    )


def test_a_goal_of_the_mission_file_comes_first(spoil: Spoil) -> None:
    goal = "problem: two_parcels.pddl\ngoal: delivered(p2)"
    mission = spoil("delivery.yaml", "problem: two_parcels.pddl", goal)
    assert mission.task == {"goal": parse("F delivered(p2)")}


def test_sets_of_the_mission_file_may_have_the_members(spoil: Spoil) -> None:
    """A domain without a problem: the mission file lists the members of its types."""
    sets = (
        "objects: [p1]\nsets: {place: [Home, A], customer: [A], depot: [Home], parcel: [p1]}\n"
        'initially: [at(Home), free, "in(p1, Home)", "wants(A, p1)"]\ngoal: delivered(p1)\n'
    )
    mission = spoil("delivery.yaml", "problem: two_parcels.pddl\n", sets)
    assert mission.sets["customer"] == ("A",)


@pytest.mark.parametrize("has_metric", [False, True])
def test_costs_of_the_domain(edit: Edit, spoil: Spoil, has_metric: bool) -> None:
    edit("delivery.pddl", "(:action move", "(:functions (total-cost) - number) (:action move")
    if has_metric:
        goal = "(delivered p1) (delivered p2))"
        edit("two_parcels.pddl", goal, f"{goal}) (:metric minimize (total-cost)")
    edit("delivery.yaml", 'USER_2)", cost: 5', 'USER_2)"')
    mission = spoil(
        "delivery.pddl",
        ":effect (and (free) (not (has ?x)) (in ?x ?p))",
        ":effect (and (free) (not (has ?x)) (in ?x ?p) (increase (total-cost) 7))",
    )
    assert mission.skills["drop"].cost_s == 7


def test_without_a_number_every_action_costs_one(edit: Edit, spoil: Spoil) -> None:
    """Where all costs are 1, the reader calls the metric the length of the plan."""
    edit(DOMAIN, "(:action move", "(:functions (total-cost) - number) (:action move")
    edit(PROBLEM, "(delivered p2))", "(delivered p2))) (:metric minimize (total-cost)")
    edit("delivery.yaml", ", cost: 5, timeout_s: 15}\n  hand", ", timeout_s: 15}\n  hand")
    one = "(increase (total-cost) 1)"
    edit(DOMAIN, "(not (at ?from))", f"(not (at ?from)) {one}")
    edit(DOMAIN, "(not (in ?x ?p)) (not (free))", f"(not (in ?x ?p)) (not (free)) {one}")
    edit(DOMAIN, "(not (has ?x)) (in ?x ?p)", f"(not (has ?x)) (in ?x ?p) {one}")
    mission = spoil(DOMAIN, "(delivered ?x) (not (has ?x)) (free)))", f"(free))) {one}")
    assert mission.skills["drop"].cost_s == 1


def test_a_universal_goal_is_written_out(spoil: Spoil) -> None:
    universal = "(forall (?x - parcel) (delivered ?x))"
    mission = spoil(PROBLEM, "(and (delivered p1) (delivered p2))", universal)
    assert mission.task == {"goal": parse("F (delivered(p1) & delivered(p2))")}


def test_a_universal_precondition_is_written_out(spoil: Spoil) -> None:
    universal = ":precondition (and (at ?c) (forall (?x - parcel) (not (in ?x ?c))))"
    mission = spoil(DOMAIN, ":precondition (at ?c)", universal)
    found = {a.name: a for a in instantiate(mission, lambda a, b: 1.0).actions}["hand_over(A)"]
    assert found.forbids == {"in(p1, A)", "in(p2, A)"}


def test_a_parameter_may_differ_from_a_constant(edit: Edit, spoil: Spoil) -> None:
    edit(PROBLEM, "Home - depot ", "")
    edit(DOMAIN, "(:predicates", "(:constants Home - depot) (:predicates")
    mission = spoil(DOMAIN, "(not (= ?from ?to))", "(not (= ?to Home))")
    moves = [a.name for a in instantiate(mission, lambda a, b: 1.0).actions if a.skill == "move"]
    assert moves == ["move(Home, A)", "move(Home, B)", "move(A, B)", "move(B, A)"]


def test_facts_exist_as_they_are_declared(spoil: Spoil) -> None:
    """No action speaks of `lit`."""
    mission = spoil(PROBLEM, "(free)", "(free) (lit A)")
    assert "lit(A)" in mission.initially
    mission = spoil("delivery.yaml", "problem: ", "task: {dark: G !lit(B)}\nproblem: ")
    assert mission.task == {"dark": parse("G !lit(B)")}
    with pytest.raises(MissionError, match=r"unknown fact lit\(p1\)"):
        spoil("delivery.yaml", "lit(B)", "lit(p1)")


def test_a_condition_may_be_about_what_never_holds(spoil: Spoil) -> None:
    """A declared predicate is no misspelling, whatever the problem says."""
    mission = spoil(DOMAIN, ":precondition (at ?c)", ":precondition (and (at ?c) (not (lit ?c)))")
    assert len(mission.skills["hand_over"].precondition) == 2


def test_an_object_may_have_the_name_of_a_type(spoil: Spoil) -> None:
    assert "depot" in spoil(PROBLEM, "p1 p2 - parcel", "p1 p2 depot - parcel").sets["parcel"]


SPOILT = [
    ("delivery.yaml", "  pick_up:", "  pick:", "the domain has no action pick"),
    ("delivery.yaml", "cost: flight_time", "effect: at(to)", "effect of move stands in the domain"),
    ("delivery.yaml", "two_parcels", "three_parcels", "cannot be read: No such file"),
    ("delivery.yaml", "components:", "sets: {parcel: [A]}\ncomponents:", "parcel is a type with"),
    ("delivery.pddl", "(at ?p - place)", "(at ?p - foo)", "cannot be read as PDDL"),
    ("delivery.pddl", "(define", "((define", "cannot be read as PDDL"),
    ("delivery.pddl", "(define", "(" * 50_000, "cannot be read as PDDL"),
    ("delivery.pddl", "(define", " " * 200_000, "has more than 65536 bytes"),
    ("delivery.pddl", ":precondition (at ?c)", ":precondition (or (at ?c) (free))", "supported"),
    ("two_parcels.pddl", "(at Home) ", "", "no fact says where the vehicle is"),
    ("two_parcels.pddl", "A B - customer", "A X - customer", "cannot be read as PDDL"),
    (PROBLEM, "p1 p2 - parcel", "p1 p2 - box", "there is no type box"),
    (PROBLEM, "p1 p2 - parcel", "p1 p2 p-3 p_3 - parcel", "p-3 and p_3 of the PDDL files are both"),
    (PROBLEM, "(and (delivered p1)", "(or (delivered p1)", "the goal in the PDDL files is not"),
    (PROBLEM, "(and (delivered p1) (delivered p2))", "(and)", "neither a task nor a goal"),
    (PROBLEM, "(:goal", ";", "two_parcels.pddl cannot be read as PDDL"),
    (DOMAIN, "(not (= ?from ?to))", "(= ?from ?to)", "is not supported: (from == to)"),
    (
        DOMAIN,
        "(and (has ?x) (wants ?c ?x))",
        "(or (has ?x) (wants ?c ?x))",
        "an effect of hand_over",
    ),
    (DOMAIN, "(lit ?p - place)", "(visit ?p - place)", "the predicate visit of the domain has a"),
    (DOMAIN, "(lit ?p - place)", "(true)", "the predicate true of the domain has a meaning"),
    (DOMAIN, "?c - customer)\n    :pre", "?p1 - customer)\n    :pre", "Undefined name found: c"),
]

FOREIGN = [
    (DOMAIN, "(:requirements :strips", "(:requirements :contingent :strips", "unknown facts"),
    (DOMAIN, "(:requirements :strips", "(:requirements :hierarchy :strips", "tasks and methods"),
    (PROBLEM, "(free)", "(free) (at 5 (lit A))", "facts that change at a time"),
    (PROBLEM, "(delivered p2))", "(delivered p2))) (:constraints (always (free))", "constraints"),
    (DOMAIN, "(free))))))", "(free))))) (:event e :parameters () :effect (free)))", "events"),
    (
        DOMAIN,
        "(free))))))",
        "(free))))) (:durative-action e :parameters () :duration (= ?duration 3) "
        ":effect (at end (free))))",
        "actions with durations",
    ),
]


@pytest.mark.parametrize(("name", "old", "new", "words"), FOREIGN)
def test_nothing_is_left_out_in_silence(
    spoil: Spoil, name: str, old: str, new: str, words: str
) -> None:
    with pytest.raises(MissionError, match=f"{name} has {words}.*not supported"):
        spoil(name, old, new)


def test_numbers_are_refused(edit: Edit, spoil: Spoil) -> None:
    edit(DOMAIN, "(:action move", "(:functions (fuel) - number) (:action move")
    with pytest.raises(MissionError, match="an effect of move in the PDDL files is not supported"):
        spoil(DOMAIN, "(not (at ?from))", "(not (at ?from)) (decrease (fuel) 1)")


def test_a_cost_under_a_condition_is_refused(edit: Edit, spoil: Spoil) -> None:
    edit(DOMAIN, "(:action move", "(:functions (total-cost) - number) (:action move")
    sometimes = "(when (lit ?to) (increase (total-cost) 1))"
    with pytest.raises(MissionError, match="an effect of move in the PDDL files is not supported"):
        spoil(DOMAIN, "(not (at ?from))", f"(not (at ?from)) {sometimes}")


def test_a_type_that_an_action_needs_has_members(edit: Edit, spoil: Spoil) -> None:
    edit(DOMAIN, "(:types place", "(:types truck place")
    with pytest.raises(MissionError, match="no object has the type truck, which drop needs"):
        spoil(DOMAIN, "drop\n    :parameters (", "drop\n    :parameters (?t - truck ")


def test_a_parameter_has_a_name_of_its_own(edit: Edit, spoil: Spoil) -> None:
    """p1 in an effect that is written out would be the parameter and the parcel."""
    edit(DOMAIN, "(wants ?c ?x)", "(wants ?p1 ?x)")
    edit(DOMAIN, ":precondition (at ?c)", ":precondition (at ?p1)")
    with pytest.raises(MissionError, match="the parameter p1 has the name of an object"):
        spoil(DOMAIN, "(?c - customer)\n", "(?p1 - customer)\n")


def test_at_has_one_argument(folder: Path) -> None:
    (folder / DOMAIN).write_text(
        "(define (domain d) (:types parcel place - object depot customer - place)"
        " (:predicates (at ?x - parcel ?p - place) (free) (has ?x - parcel)"
        " (in ?x - parcel ?p - place) (wants ?c - customer ?x - parcel) (delivered ?x - parcel))"
        " (:action move :parameters (?x - parcel ?to - place)"
        " :precondition (has ?x) :effect (at ?x ?to)))",
        encoding="utf-8",
    )
    problem = (folder / PROBLEM).read_text(encoding="utf-8")
    (folder / PROBLEM).write_text(problem.replace("(at Home)", "(at p1 Home)"), encoding="utf-8")
    mission = (folder / "delivery.yaml").read_text(encoding="utf-8")
    start, end = mission.index("  pick_up:"), len(mission)
    (folder / "delivery.yaml").write_text(mission[:start] + mission[end:], encoding="utf-8")
    with pytest.raises(MissionError, match="the predicate at of the domain has 2 arguments"):
        load_mission(folder / "delivery.yaml")


def test_a_mistake_is_located_in_its_file(spoil: Spoil) -> None:
    with pytest.raises(MissionError, match="Found invalid expression: p3") as caught:
        spoil(PROBLEM, "(in p2 Home)", "(in p3 Home)")
    where = caught.value.where
    assert isinstance(where, Location) and where.path.endswith(PROBLEM)
    assert (where.line, where.column) == (4, 44)


@pytest.mark.parametrize(
    "text", ["", "(", ")", "()", "(" * 60_000, "(define (domain d))", "\0", "ä"]
)
def test_a_text_that_is_no_domain(folder: Path, text: str) -> None:
    (folder / DOMAIN).write_text(text, encoding="utf-8")
    with pytest.raises(MissionError):
        load_mission(folder / "delivery.yaml")


def test_forall_has_a_limit(edit: Edit, spoil: Spoil) -> None:
    """Counted while it is written out: 4 parcels and 9 variables have 262,144 choices."""
    edit(PROBLEM, "p1 p2 - parcel", "p1 p2 p3 p4 - parcel")
    deep = "(delivered ?x)"
    for variables in ("?a ?b ?x", "?d ?e ?f", "?g ?h ?i"):
        deep = f"(forall ({variables} - parcel) {deep})"
    with pytest.raises(MissionError, match="more than 10000 parts"):
        spoil(PROBLEM, "(and (delivered p1) (delivered p2))", deep)


def _tokens(name: str) -> list[str]:
    text = re.sub(";.*", "", (EXAMPLE / name).read_text(encoding="utf-8"))
    return re.findall(r"[()]|[^\s()]+", text)


TOKENS = [*_tokens(DOMAIN), *_tokens(PROBLEM), "or", "exists", "=", "#t", "5", "increase"]


@pytest.mark.slow
@drawn(25)
@given(
    st.sampled_from([DOMAIN, PROBLEM]),
    st.lists(st.tuples(st.integers(0, 250), st.none() | st.sampled_from(TOKENS)), max_size=3),
)
def test_any_spoilt_text_is_a_mission_or_a_mission_error(
    tmp_path_factory: pytest.TempPathFactory, name: str, spoilt: list[tuple[int, str | None]]
) -> None:
    """The reader itself raises whatever it likes: IndexError, TypeError, AttributeError, ..."""
    folder = tmp_path_factory.mktemp("spoilt")
    for path in EXAMPLE.iterdir():
        text = path.read_text(encoding="utf-8").replace("../../../missions", str(ROOT / "missions"))
        (folder / path.name).write_text(text, encoding="utf-8")
    tokens = _tokens(name)
    for position, token in spoilt:
        tokens[position % len(tokens)] = token or ""
    (folder / name).write_text(" ".join(tokens), encoding="utf-8")
    try:
        mission = load_mission(folder / "delivery.yaml")
    except MissionError:
        return
    assert instantiate(mission, lambda a, b: 1.0).actions


@pytest.mark.slow
@pytest.mark.parametrize(("name", "old", "new", "message"), SPOILT)
def test_a_mistake_is_answered(spoil: Spoil, name: str, old: str, new: str, message: str) -> None:
    with pytest.raises(MissionError) as caught:
        spoil(name, old, new)
    assert message in str(caught.value)


def test_an_action_that_nothing_executes(spoil: Spoil) -> None:
    line = '  drop: {execute: "command(payload, MAV_CMD_USER_2)", cost: 5, timeout_s: 15}\n'
    with pytest.raises(MissionError, match="nothing says what the action drop does"):
        spoil("delivery.yaml", line, "")


def test_deep_nesting(spoil: Spoil) -> None:
    deep = "(and " * 5_000 + "(at ?c)" + ")" * 5_000
    with pytest.raises(MissionError, match="cannot be read as PDDL"):
        spoil("delivery.pddl", ":precondition (at ?c)", f":precondition {deep}")
