"""What a flight does about each change, against what the same state is planned for directly."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from synthetic import command, mission, move

from companion.acting.contingencies.answers import (
    Answer,
    ContingencyVerdict,
    GoesOn,
    LandsAt,
    Replans,
    StaysWhereItIs,
)
from companion.acting.contingencies.changes import (
    BeliefLost,
    ChargeAtFloor,
    ChargerLost,
    DrainUp,
    EventTurns,
    SiteLost,
)
from companion.acting.contingencies.listing import Contingencies
from companion.acting.contingencies.table import ContingencyTable
from companion.errors import CompanionError, NoPlanError
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.literals import parse_fact
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from companion.planning.planner import Planner

MISSIONS = Path(__file__).parents[4] / "missions"
DOCKED = """\
version: 1
name: two_sites
limits: {speed_mps: 5, up_m: [1, 15], fence: [[-20, -20], [120, -20], [120, 120], [-20, 120]]}
battery: {reserve: RESERVE, capacity_wh: 12}
places:
  Home: {east_m: 0, north_m: 0, up_m: 6}
  A: {east_m: 100, north_m: 0, up_m: 6}
  B: {east_m: 100, north_m: 100, up_m: 6}
  Dock: {east_m: 50, north_m: 50, up_m: 4}
sets: {Place: [Home, A, B, Dock], Pad: [Dock]}
events: {alarm: {when: "NAMED_VALUE_INT[alarm].value > 0", latch: true}}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    assumes: trans_ok(from, to)
    effect: at(to) & !at(from)
    execute: fly(to)
  recharge:
    parameters: {pad: Pad}
    precondition: at(pad)
    assumes: works(pad)
    effect: at(pad)
    charge_rate: [[0, 1], [80, 1], [100, 0.1]]
    execute: [land(), charge(auto), take_off()]
initially: [at(Home)]
task: {patrol: "patrolling(A, B) | F alarm", leave: "G (alarm -> F G at(Home))"}
"""


FIELD = """\
version: 1
limits: {speed_mps: 4, up_m: [1, 15], fence: [[-20, -20], [60, -20], [60, 60], [-20, 60]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 6}
  A: {east_m: 40, north_m: 0, up_m: 6}
  B: {east_m: 40, north_m: 40, up_m: 6}
sets: {Place: [Home, A, B]}
events: {alarm: {when: COMMAND.MAV_CMD_USER_1}}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    assumes: trans_ok(from, to)
    effect: at(to) & !at(from)
    execute: fly(to)
"""

BOUNDED = f"""\
{FIELD}name: bounded
initially: [at(Home)]
task:
  often: revisit(A) <= 45 s
  answer: G (alarm -> F[<=BOUND] at(Home))
  other: "G F at(B)"
"""

RESTING = f"""\
{FIELD}  rest: {{precondition: at(Home), effect: rested, execute: [land(), wait(5), take_off()]}}
name: resting
initially: [at(Home)]
task: {{rest: F rested, visit: F at(A), answer: "G (alarm -> F at(B))"}}
"""


def table_of(asked: Mission) -> ContingencyTable:
    found = Contingencies(asked)
    return found.table(map(found.answer, found.questions))


def shipped(name: str) -> Mission:
    return load_mission(MISSIONS / f"{name}.yaml")


def answers(table: ContingencyTable, label: str) -> list[Answer]:
    """By position."""
    return [each.answer for each in table.contingencies if each.label == label]


def verdicts(table: ContingencyTable, label: str) -> str:
    return "".join(answer.verdict.letter for answer in answers(table, label))


@pytest.fixture(scope="module")
def surveillance() -> ContingencyTable:
    return table_of(shipped("surveillance"))


def test_the_positions_are_those_of_prefix_and_loop(surveillance: ContingencyTable) -> None:
    told = [(p.number, p.place, p.ahead, p.is_in_loop) for p in surveillance.positions]
    assert told == [
        (0, "Home", "move(Home, A)", False),
        (1, "A", "move(A, B)", True),
        (2, "B", "move(B, C)", True),
        (3, "C", "move(C, A)", True),
    ]


def test_an_event_is_answered_from_where_the_vehicle_is(surveillance: ContingencyTable) -> None:
    found = answers(surveillance, "targetFound comes")
    plans = [str(answer.plan) for answer in found if isinstance(answer, Replans)]
    near = "move(here, r2), upload(r2), move(r2, Home), (wait)^w"
    assert plans == [near, *3 * [near.replace("r2", "r1")]]


def test_what_fails_in_the_plan_for_an_event_fails_where_it_is_done(
    surveillance: ContingencyTable,
) -> None:
    found = answers(surveillance, "targetFound comes, then canUpload(r1) withdrawn")
    plans = {str(answer.plan) for answer in found if isinstance(answer, Replans)}
    assert (len(found), plans) == (3, {"move(r1, r2), upload(r2), move(r2, Home), (wait)^w"})


def test_there_is_a_plan_where_a_planner_finds_one(surveillance: ContingencyTable) -> None:
    """For beliefs, by the planner from the same place: another way to the same question."""
    planner, asked = Planner(shipped("surveillance")), 0
    for each in surveillance.contingencies:
        if isinstance(each.change, BeliefLost) and each.after is None:
            place = surveillance.positions[each.position].place
            is_possible = planner.explain(at=place, without=[each.change.belief]) is None
            assert isinstance(each.answer, GoesOn | Replans) == is_possible
            asked += 1
    assert asked == 16


def test_a_lost_site_of_the_patrol_leads_home(surveillance: ContingencyTable) -> None:
    for answer in answers(surveillance, "no way to B"):
        assert isinstance(answer, LandsAt)
        assert (answer.place, answer.waits_for) == ("Home", ("the map",))
        assert answer.why == "no plan: search cannot hold from here."
    assert verdicts(surveillance, "no way to r1") == "===="


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("", marks=pytest.mark.long),
        pytest.param(DOCKED.replace("RESERVE", "20"), marks=pytest.mark.long),
        BOUNDED.replace("BOUND", "30 s"),
    ],
    ids=["surveillance", "on a battery", "with bounds"],
)
def test_the_answers_do_not_depend_on_what_was_asked_before(text: str) -> None:
    asked = Contingencies(load_mission(text) if text else shipped("surveillance"))
    there = [asked.answer(question) for question in asked.questions]
    back = [asked.answer(question) for question in reversed(asked.questions)]
    assert there == back[::-1]


@pytest.mark.parametrize(("bound", "expected"), [("30 s", "PPP"), ("15 s", "PPS"), ("10 s", "PSS")])
def test_bounds_in_time_count_from_where_the_vehicle_is(bound: str, expected: str) -> None:
    """Home is 12 s from A, and 17 s from B; at first the vehicle is there."""
    table = table_of(load_mission(BOUNDED.replace("BOUND", bound)))
    assert verdicts(table, "alarm comes") == expected


def test_lines_are_dropped_as_in_flight() -> None:
    table = table_of(shipped("night_watch"))
    for label in ("dockInUse comes", "no way to Dock"):
        found = answers(table, label)
        assert {a.dropped for a in found if isinstance(a, Replans)} == {("dock",)}
    dropped = [c for c in table.contingencies if c.answer.verdict.letter == "D"]
    assert f" planned ({len(dropped)} with lines dropped), " in table.summary


def test_a_tree_by_hand_has_no_table() -> None:
    with pytest.raises(CompanionError, match="a tree of its own, which nothing replaces"):
        Contingencies(shipped("by_hand"))


def test_a_mission_without_a_plan_has_no_table() -> None:
    with pytest.raises(NoPlanError):
        Contingencies(mission("F done", skills=[command("do", "!at(H) & at(H)", "done")]))


@pytest.mark.parametrize(
    ("otherwise", "does", "is_asked"),
    [
        (Otherwise.LAND, "lands where it is", True),
        (Otherwise.HOLD, "holds where it is", True),
        (Otherwise.RETURN_HOME, "lands where it is", False),
    ],
)
def test_without_a_safe_place_it_stays(otherwise: Otherwise, does: str, is_asked: bool) -> None:
    asked = mission("F at(A) & F G at(H)", otherwise=otherwise)
    (lost,) = answers(table_of(asked), "no way to H")[:1]
    assert isinstance(lost, StaysWhereItIs)
    assert (lost.does, lost.is_asked) == (does, is_asked)
    assert lost.verdict is ContingencyVerdict.WHERE_IT_IS


def test_a_pulse_comes_and_passes() -> None:
    """Its rise is in the next letter, so that the plan does what it asks for once."""
    called = parse_condition("COMMAND.MAV_CMD_USER_1")
    pulse = Event("called", called, None, latch=False, for_s=0.0, restarts=frozenset())
    table = table_of(mission("G F at(A) & G (called -> F at(B))", "HAB", events=[pulse]))
    (first, *_) = answers(table, "called comes")
    assert isinstance(first, Replans)
    assert any("B" in step.arguments for step in (*first.plan.prefix, *first.plan.loop))


@pytest.mark.parametrize(("retry_s", "verdict"), [(20, "P"), (90, "S")])
def test_a_belief_that_comes_back_is_waited_for(retry_s: int, verdict: str) -> None:
    """As long as the patience of the mission lasts, a minute."""
    asked = mission("F at(A)", otherwise=Otherwise.RETURN_HOME)
    fly = replace(move(), assumes=(parse_fact("may_fly"),), retry_after_s=float(retry_s))
    asked = replace(asked, skills={"move": fly})
    (first, *_) = answers(table_of(asked), "may_fly withdrawn")
    assert first.verdict.letter == verdict
    if isinstance(first, Replans):
        assert first.waited_s == retry_s


@pytest.fixture(scope="module")
def docked() -> ContingencyTable:
    """Two sites, and a dock between them that the plan charges at."""
    return table_of(load_mission(DOCKED.replace("RESERVE", "20")))


class TestBattery:
    """With the mission above."""

    def test_positions_have_the_charge_of_the_worst_lap(self, docked: ContingencyTable) -> None:
        percents = [position.charge_percent for position in docked.positions]
        assert percents[0] == 100.0
        loop = [p for p in docked.positions if p.is_in_loop]
        assert loop[0].ahead == "recharge(Dock)"
        assert all(p is not None and p > 20 for p in percents)

    def test_a_charger_that_fails_is_landed_on(self, docked: ContingencyTable) -> None:
        """It has failed on the ground, with too little for another place."""
        at = next(p.number for p in docked.positions if p.ahead == "recharge(Dock)")
        lost = [c for c in docked.contingencies if isinstance(c.change, ChargerLost)]
        assert lost[at].answer == LandsAt("Dock", _why(lost[at].answer), ())
        assert {c.answer.verdict.letter for c in lost} == {"S"}

    def test_with_the_floor_some_safe_place_is_reached(self, docked: ContingencyTable) -> None:
        for each in docked.contingencies:
            if isinstance(each.change, ChargeAtFloor) and isinstance(each.answer, Replans):
                assert each.answer.reserve_wh < 0.1  # to charge takes more than to land
            elif isinstance(each.change, ChargeAtFloor):
                assert each.answer.verdict.letter in "=S", each

    def test_more_drain_may_take_from_the_reserve(self, docked: ContingencyTable) -> None:
        found = [c.answer for c in docked.contingencies if isinstance(c.change, DrainUp)]
        assert {answer.verdict.letter for answer in found} == {"P", "R"}
        last = found[-1]
        assert isinstance(last, Replans) and 0 < last.reserve_wh < 2.4
        (*_, first) = [*last.plan.prefix, *last.plan.loop][:2]
        assert first.action == "recharge(Dock)"

    def test_without_a_reserve_it_is_unsafe(self) -> None:
        table = table_of(load_mission(DOCKED.replace("RESERVE", "0")))
        unsafe = {str(each.change) for each in table.unsafe}
        assert "all takes 25 % more" in unsafe
        assert table.summary.endswith(f"{len(table.unsafe)} unsafe")

    def test_what_begins_on_the_ground_is_finished_first(self, docked: ContingencyTable) -> None:
        """An event that comes while it lands, and a site of the flight after it."""
        at = next(p.number for p in docked.positions if p.ahead == "recharge(Dock)")
        called = answers(docked, "alarm comes")[at]
        assert isinstance(called, Replans)
        assert str(called.plan) == "move(here, Home), (wait)^w"
        after = docked.positions[at + 1].ahead.removesuffix(")").rpartition(", ")[2]
        assert verdicts(docked, f"no way to {after}")[at] == "S"


def _why(answer: Answer) -> str:
    assert isinstance(answer, LandsAt)
    return answer.why


def test_kinds_come_in_a_fixed_order(surveillance: ContingencyTable) -> None:
    def kinds(position: int) -> Iterable[type]:
        found = (c for c in surveillance.contingencies if c.position == position and not c.after)
        return list(dict.fromkeys(type(c.change) for c in found))

    assert [kinds(n) for n in range(4)] == 4 * [[EventTurns, BeliefLost, SiteLost]]
    numbers = [each.position for each in surveillance.contingencies]
    assert numbers == sorted(numbers)


def test_an_event_that_is_true_for_a_moment_on_the_ground_is_answered_in_the_air() -> None:
    """The plan on the ground is finished first, and reads the event before anybody may answer."""
    table = table_of(load_mission(RESTING))
    assert table.positions[0].ahead == "rest"
    answer = answers(table, "alarm comes")[0]
    assert isinstance(answer, Replans)
    assert "B)" in str(answer.plan)
