"""The step python(name, arguments): how it is read, and what is asked of what is installed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from companion.errors import FormulaError, MissionError
from companion.mission.installed_calls import functions_of
from companion.mission.loader import load_mission
from companion.mission.python_call import Named, PythonCall, parse_python
from companion.planning.planner import Planner
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Function
from companion.skills.catalogue import Catalogue, Installed, Parameter

WEIGHING = Path(__file__).parents[3] / "docs" / "examples" / "scale_skill" / "weighing.yaml"
POSITIONAL = "POSITIONAL_OR_KEYWORD"
SKILL = FunctionKind.SKILL


def parameter(name: str, annotation: str = "", default: str | None = None) -> Parameter:
    return Parameter(name, POSITIONAL, default, annotation)


RUN, PLACE, WAYPOINT = map(parameter, ("run", "place", "waypoint"))
AWAY = parameter("away_m", "float", "1.0")
WEIGH = Installed(
    Function(FunctionKind.SKILL, "weigh"),
    "scale-skill 1.0",
    (RUN, parameter("place", "str"), parameter("limit_kg", "float", "2.0")),
)
BESIDE = Installed(
    Function(FunctionKind.SUGGESTER, "beside"), "scale-skill 1.0", (RUN, PLACE, AWAY)
)
TEST = Installed(
    Function(FunctionKind.PLACE_TEST, "out_of_downwash"),
    "scale-skill 1.0",
    (RUN, PLACE, WAYPOINT, AWAY),
)
INSTALLED: Catalogue = {each.function: [each] for each in (WEIGH, BESIDE, TEST)}


def weighing(execute: str = "", installed: Catalogue | None = INSTALLED, **place: Any) -> Any:
    data: dict[str, Any] = YAML(typ="safe").load(WEIGHING.read_text(encoding="utf-8"))
    if execute:
        data["skills"]["weigh"]["execute"] = execute
    data["places"]["Rack"] |= place
    return load_mission(data, installed=None if installed is None else lambda _: installed)


def test_arguments_are_names_numbers_truths_and_texts() -> None:
    step = parse_python(
        """python( say.it, r, -2, 2.5, true, "a, (b)", 'c', loud=false, to = x )""", SKILL
    )
    given = (Named("r"), -2, 2.5, True, "a, (b)", "c")
    named = (("loud", False), ("to", Named("x")))
    assert step == PythonCall(Function(FunctionKind.SKILL, "say.it"), given, named)
    assert step.names == {"r", "x"}
    assert step.bound({"r": "A"}).call.arguments[0] == "A"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("python()", "nothing is not the name of a function"),
        ("python(3)", "3 is not the name of a function"),
        ("python(a=b)", "b is not the name of a function"),
        ("python(f, x=1, 2)", "2 has no name"),
        ("python(f, x=1, x=2)", "x is given twice"),
        ("python(f, 1e999)", "1e999 is not an argument"),
        ('python(f, "a)', "not an argument"),
        ("python(f,, 2)", "not an argument"),
        ("python(f, 2 3)", "not an argument"),
        ("python f", "not a call of a function"),
    ],
)
def test_what_is_no_call_is_refused(text: str, what: str) -> None:
    with pytest.raises(FormulaError) as refused:
        parse_python(text, SKILL)
    assert what in str(refused.value)


def test_a_mission_with_functions_is_planned_with_its_places_filled_in() -> None:
    mission = weighing()
    planned = Planner(mission).plan().lasso.prefix
    (step,) = next(action for action in planned if action.skill == "weigh").execute
    assert isinstance(step, PythonCall)
    assert step.call.text == "python(weigh, Rack, limit_kg=2.0)"
    names = {function.name for function in functions_of(mission)}
    assert names == {"weigh", "beside", "out_of_downwash"}


@pytest.mark.parametrize(
    ("execute", "says"),
    [
        ("python(wiegh, s)", ["the skill wiegh is not installed", "Did you mean weigh?"]),
        ("python(weigh)", ["missing a required argument: 'place'", "limit_kg: float = 2.0"]),
        ("python(weigh, s, 1, 2)", ["too many positional arguments"]),
        ("python(weigh, s, limit=3)", ["unexpected keyword", "Did you mean limit_kg?"]),
        ("python(weigh, s, run=3)", ["run of weigh is filled in by the companion"]),
        ("python(weigh, s, limit_kg=s)", ["limit_kg of weigh takes a number, not s"]),
        ("python(weigh, 3)", ["place of weigh takes a text, not 3"]),
        ("python(weigh, x)", ["x is not a parameter of weigh, place or object", "in quotes"]),
        ('python(weigh, s, limit_kg="2")', ["takes a number, not 2"]),
        ("pyton(weigh, s)", ["unknown primitive pyton", "Did you mean python?"]),
        ("python(weigh, s", ["its parenthesis is not closed", '"python(name, arguments)"']),
    ],
)
def test_a_call_that_cannot_be_made_says_what_to_write(execute: str, says: list[str]) -> None:
    with pytest.raises(MissionError) as refused:
        weighing(execute)
    assert refused.value.exit_code == 2
    assert str(refused.value).startswith("skills.weigh.execute")
    for words in says:
        assert words in str(refused.value)


def replaced(**changed: Any) -> Mapping[Function, list[Installed]]:
    return {**INSTALLED, WEIGH.function: changed["offers"]}


@pytest.mark.parametrize(
    ("installed", "says"),
    [
        ({}, ["the skill weigh is not installed", "installed are: none", "docs/skills.md"]),
        (
            replaced(offers=[WEIGH, Installed(WEIGH.function, "heavy 2.0")]),
            ["claimed by scale-skill 1.0 and heavy 2.0", "uninstall all but one"],
        ),
        (
            replaced(offers=[Installed(WEIGH.function, "scale-skill 1.0", failure="it is sad")]),
            ["the skill weigh of scale-skill 1.0: it is sad"],
        ),
    ],
)
def test_what_is_not_installed_once_is_refused(installed: Catalogue, says: list[str]) -> None:
    with pytest.raises(MissionError) as refused:
        weighing(installed=installed)
    for words in says:
        assert words in str(refused.value)


def test_a_place_names_its_suggesters_and_tests_at_their_place() -> None:
    with pytest.raises(MissionError, match=r"places\.Rack\.suggesters\[0\].*besides"):
        weighing(suggesters=["python(besides)"])
    with pytest.raises(MissionError, match=r"the test of places weigh is not installed"):
        weighing(tests=["python(weigh)"])
    with pytest.raises(MissionError, match=r"tests\[1\].*away_m of out_of_downwash"):
        weighing(tests=["python(out_of_downwash)", "python(out_of_downwash, true)"])
    with pytest.raises(MissionError, match="not a call of a function"):
        weighing(tests=["dry"])


def test_a_mission_that_is_not_to_be_flown_here_needs_nothing_installed() -> None:
    assert weighing("python(no_such_thing, s)", installed=None).name == "weighing"


def test_nothing_is_asked_for_a_mission_without_functions() -> None:
    def never(wanted: object) -> Catalogue:
        raise AssertionError

    surveillance = WEIGHING.parents[3] / "missions" / "surveillance.yaml"
    assert load_mission(surveillance, installed=never).name == "surveillance"
