"""An argument of another kind is a CompanionError that says what is expected, at every door."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from drawn import drawn
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import companion
from companion import CompanionError, MissionError, Planner, load_mission
from companion.api.drawings import mission_drawing
from companion.plans.draft_places import Given
from companion.plans.files import import_plan

MISSIONS = Path(__file__).parents[3] / "missions"
FIELD = load_mission(MISSIONS / "open_field.yaml")
PLANNER = Planner(FIELD)

NO_TEXT = st.one_of(
    st.integers(),
    st.floats(),
    st.binary(max_size=3),
    st.lists(st.integers(), max_size=2),
    st.just({1}),
) | st.builds(object)
NOTHING = NO_TEXT | st.none()
NO_VALUE = NOTHING | st.dictionaries(st.text(max_size=2), st.integers(), max_size=2)
NO_OBJECT = NO_VALUE | st.text(max_size=3)
NO_PATH = NO_TEXT | st.sampled_from(["a\0b", "\ud800"])
NO_WAIT = st.sampled_from([-1, float("nan"), None, "1"])
NO_SECONDS = NO_WAIT | st.sampled_from([1e30, -float("inf")])
NO_TABLE = NO_SECONDS.map(lambda given: {("Home", "Gate"): given}) | st.just({1: 2.0})
NAMES = st.sampled_from([None, "p", b"p", [1]])

DOORS: dict[str, tuple[Callable[[Any], Any], st.SearchStrategy[Any]]] = {
    "load_mission": (load_mission, NOTHING),
    "load_mission, folder": (lambda given: load_mission({}, given), NO_TEXT),
    "parse_formula": (companion.parse_formula, NO_VALUE),
    "translate": (companion.translate, NO_VALUE),
    "translate, exclusive": (lambda given: companion.translate("p", exclusive=given), NAMES),
    "to_dot": (companion.to_dot, NO_OBJECT),
    "to_hoa": (companion.to_hoa, NO_OBJECT),
    "Planner": (Planner, NO_OBJECT),
    "Planner, flight times": (lambda given: Planner(FIELD, given), NO_TEXT | st.text()),
    "Planner, seconds": (lambda given: Planner(FIELD, lambda a, b: given), NO_SECONDS),
    "Planner, a table": (lambda given: Planner(FIELD, given), NO_TABLE),
    "plan, at": (lambda given: PLANNER.plan(at=given), NO_TEXT),
    "plan, facts": (lambda given: PLANNER.plan(facts=[given]), NO_VALUE),
    "plan, without": (lambda given: PLANNER.plan(without=[given]), NO_VALUE),
    "plan, all facts": (lambda given: PLANNER.plan(facts=given), st.integers() | st.none()),
    "plan, objective": (lambda given: PLANNER.plan(objective=given), NO_VALUE),
    "plan, engine": (lambda given: PLANNER.plan(engine=given), NO_VALUE),
    "plan, timeout_s": (lambda given: PLANNER.plan(engine="none", timeout_s=given), NO_WAIT),
    "explain": (lambda given: PLANNER.explain(at=given), NO_TEXT),
    "product": (lambda given: PLANNER.product(facts=[given]), NO_VALUE),
    "transition_system": (lambda given: PLANNER.transition_system(at=given), NO_TEXT),
    "behaviour_tree": (companion.behaviour_tree, NO_VALUE | NO_PATH),
    "contingencies": (companion.contingencies, NO_OBJECT),
    "contingencies, jobs": (lambda given: companion.contingencies(FIELD, given), st.text()),
    "contingencies, no jobs": (
        lambda given: companion.contingencies(FIELD, given),
        st.integers(max_value=0),
    ),
    "contingencies, on_progress": (
        lambda given: companion.contingencies(FIELD, 1, given),
        NO_TEXT | st.text(),
    ),
    "audit": (companion.audit, NO_VALUE | NO_PATH),
    "simulate": (companion.simulate, NO_OBJECT),
    "simulate, scenario": (lambda given: companion.simulate(FIELD, given), NO_TEXT),
    "simulate, seed": (lambda given: companion.simulate(FIELD, seed=given), st.text() | st.none()),
    "simulate, laps": (lambda given: companion.simulate(FIELD, laps=given), st.text()),
    "simulate, limit_s": (lambda given: companion.simulate(FIELD, limit_s=given), st.text()),
    "simulate, timeout_s": (lambda given: companion.simulate(FIELD, timeout_s=given), NO_WAIT),
    "simulate, folder": (lambda given: companion.simulate(FIELD, folder=given), NO_PATH),
    "simulate, on_event": (lambda given: companion.simulate(FIELD, on_event=given), st.text()),
    "run": (companion.run, NO_OBJECT),
    "run, events": (lambda given: companion.run(FIELD, events=given), st.integers()),
    "run, laps": (lambda given: companion.run(FIELD, laps=given), st.text()),
    "run, connect": (lambda given: companion.run(FIELD, given), NO_VALUE),
    "import_plan": (lambda given: import_plan(given, Given()), NO_VALUE),
    "import_plan, given": (lambda given: import_plan("field.plan", given), NO_OBJECT),
    "mission_drawing": (lambda given: mission_drawing(given, None), NO_OBJECT),
    "mission_drawing, home": (lambda given: mission_drawing(FIELD, given), st.text()),
}


@pytest.mark.parametrize("door", DOORS)
@settings(drawn(10), suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_an_argument_of_another_kind_is_told(door: str, data: st.DataObject) -> None:
    call, values = DOORS[door]
    with pytest.raises(CompanionError):
        call(data.draw(values))


def test_what_is_expected_is_said() -> None:
    with pytest.raises(CompanionError, match="expected a mission, as of load_mission, and this is"):
        Planner("missions/open_field.yaml")  # type: ignore[arg-type]
    with pytest.raises(MissionError, match="a mission is a path, a YAML text or a dict, and this"):
        load_mission(None)  # type: ignore[arg-type]
    with pytest.raises(MissionError, match="a place is a text, and this is of type int"):
        PLANNER.plan(at=5)  # type: ignore[arg-type]


def test_a_plan_is_imported_by_the_text_of_its_path(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"none\.plan cannot be read"):
        import_plan(str(tmp_path / "none.plan"), Given())
