"""`companion audit`: recorded flights, and records that are hand-made, cut off or damaged."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple, TypeVar

import pytest
from commands import Companion

from companion.api.simulating import simulate
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import NoPlanFound, WrittenTreeAdopted
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import ReturnBegun, RunFailed, TaskSatisfied
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.flight_events.writing import line_of
from companion.ltl.conjuncts import conjuncts
from companion.ltl.parser import parse
from companion.ltl.semantics import holds
from companion.mission.loader import load_mission

ROOT = Path(__file__).parents[1]
MISSIONS = ROOT / "missions"
DOCUMENTED = "companion audit runs/2026-11-21T101500-surveillance"
"""The command in docs/run-folder.md."""
E = TypeVar("E", bound=FlightEvent)


def fly(mission: Path, folder: Path) -> Path:
    """A flight of a mission in the surveillance mission's world; its run folder."""
    simulate(load_mission(mission), MISSIONS / "surveillance.sim.yaml", folder=folder)
    return folder


@pytest.fixture(scope="module")
def good(surveillance_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return shutil.copytree(surveillance_run, tmp_path_factory.mktemp("good") / "run")


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, but the target must not be found, which the vehicle cannot choose."""
    folder = shutil.copytree(MISSIONS, tmp_path_factory.mktemp("missions") / "missions")
    path = folder / "surveillance.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("\ntask:\n", "\ntask:\n  calm: G !targetFound\n"))
    return fly(path, tmp_path_factory.mktemp("bad"))


def events(run: Path) -> list[FlightEvent]:
    return [read_line(line).event for line in (run / "events.jsonl").read_text().splitlines()]


def of(run: Path, kind: type[E]) -> list[E]:
    return [event for event in events(run) if isinstance(event, kind)]


def outcomes(companion: Companion, run: Path) -> tuple[int, dict[str, tuple[str, int | None]]]:
    """Exit code, and the outcome and position of each conjunct; the last one of a name."""
    ended = companion("audit", run, "--json")
    answer = json.loads(ended.out)
    assert answer["version"] == 1
    assert answer["satisfied"] is (ended.code == 0)
    return ended.code, {c["conjunct"]: (c["outcome"], c["position"]) for c in answer["conjuncts"]}


# -- flights ---------------------------------------------------------------------------------------


def test_the_surveillance_mission_is_satisfied(companion: Companion, good: Path) -> None:
    code, found = outcomes(companion, good)
    assert code == 0
    assert found == dict.fromkeys(["search", "upload", "return"], ("satisfied", None))
    answer = json.loads(companion("audit", good, "--json").out)
    assert answer["at_rest"] and not answer["torn"] and answer["differs"] == []
    assert answer["ending"] == "task satisfied, landed"
    places = [re.findall(r"at\((\w+)\)", " ".join(p["facts"])) for p in answer["positions"]]
    way = ["Home", "A", "B", "C", "A", "r1", "r2", "r2", "Home", "Home"]
    assert places == [[place] for place in way]
    assert not any(p["restarted"] for p in answer["positions"])


def test_the_paper_s_task_is_violated_over_the_whole_flight_and_satisfied_since(
    companion: Companion, tmp_path: Path
) -> None:
    run = fly(MISSIONS / "paper_section_v.yaml", tmp_path)
    assert outcomes(companion, run)[0] == 0
    answer = json.loads(companion("audit", run, "--json").out)
    assert [p["number"] for p in answer["positions"] if p["restarted"]] == [5]
    told = {(c["formula"], c["since"], c["outcome"], c["whole"]) for c in answer["conjuncts"][:3]}
    assert told == {
        ("G(F at(A) | targetFound)", 5, "satisfied", "satisfied"),
        ("G(F at(B) | targetFound)", 5, "satisfied", "unfulfilled"),
        ("G(F at(C) | targetFound)", 5, "satisfied", "unfulfilled"),
    }


def test_the_word_in_the_record_satisfies_the_task_of_the_file(good: Path) -> None:
    """The file and the record alone, by the semantics; nothing of the audit takes part."""
    task = load_mission(MISSIONS / "surveillance.yaml").task
    positions = of(good, PositionLeft)
    for name, formula in task.items():
        begun = max((p.number for p in positions if name in p.restarted), default=0)
        word = [frozenset(p.facts) for p in positions[begun:]]
        assert holds(formula, word[:-1], word[-1:]), name
    word = [frozenset(p.facts) for p in positions]
    assert not holds(task["upload"], word[:6], word[5:6])  # rest at r1 would not have done


def test_a_tree_written_by_hand_is_held_against_a_task_it_was_not_made_from(
    companion: Companion, tmp_path: Path
) -> None:
    folder = shutil.copytree(MISSIONS, tmp_path / "missions")
    path = folder / "by_hand.yaml"
    task = "\ntask:\n  report: F targetReported\n  never: G !at(C)\n  return: F G at(Home)\n"
    path.write_text(path.read_text(encoding="utf-8") + task, encoding="utf-8")
    run = fly(path, tmp_path / "run")
    code, found = outcomes(companion, run)
    assert code == 6
    done = [e for e in events(run) if isinstance(e, PlaceReached | SkillCompleted)]
    at_c = next(i for i, e in enumerate(done) if isinstance(e, PlaceReached) and e.place == "C")
    assert found == {
        "report": ("fulfilled", done.index(SkillCompleted("upload(r2)")) + 1),
        "never": ("violated", at_c + 1),
        "return": ("satisfied", None),
    }


def test_a_violating_flight_has_the_verdict_that_it_was_told_in_flight(
    companion: Companion, bad: Path
) -> None:
    (told,) = of(bad, ConjunctViolated)
    assert (told.conjunct, told.formula) == ("calm", "G !targetFound")
    code, found = outcomes(companion, bad)
    assert code == 6
    assert found["calm"] == ("violated", told.position)
    assert found["upload"] == ("unfulfilled", None)  # it went home without an upload
    answer = json.loads(companion("audit", bad, "--json").out)
    assert answer["differs"] == []
    column = [c["conjunct"] for c in answer["conjuncts"]].index("calm")
    states = [p["states"][column] for p in answer["positions"]]
    number = told.position
    assert states == ["open"] * number + ["false"] * (len(states) - number)
    assert answer["positions"][number]["facts"] == list(told.facts)


def test_after_a_violation_the_mission_does_what_is_left_and_says_why(bad: Path) -> None:
    told = [event for event in events(bad) if event.is_told]
    found = told.index(MissionEventChanged("targetFound", holds=True))
    no_plan, returning, reached = told[found + 1 : found + 4]
    assert isinstance(no_plan, NoPlanFound) and no_plan.reason == "target found"
    assert no_plan.explanation.startswith("no plan: calm cannot hold from here")
    assert returning == ReturnBegun("Home")
    assert isinstance(reached, PlaceReached) and reached.place == "Home"
    ended = events(bad)[-1]
    assert isinstance(ended, RunFailed) and ended.exit_code == 3


def test_people_and_programs_read_the_same(companion: Companion, bad: Path) -> None:
    ended = companion("audit", bad)
    assert ended.code == 6
    assert "does not satisfy the task: calm, upload" in ended.err
    answer = json.loads(companion("audit", bad, "--json").out)
    rows = re.findall(r"^ +(\d+)  \d\d:\d\d\.\d  ([.TF]+)  (.*?)(?:;.*)?$", ended.out, re.M)
    symbols = {"open": ".", "true": "T", "false": "F"}
    assert rows == [
        (str(p["number"]), "".join(symbols[s] for s in p["states"]), ", ".join(p["facts"]))
        for p in answer["positions"]
    ]
    for conjunct in answer["conjuncts"]:
        line = next(x for x in ended.out.splitlines() if x.endswith(conjunct["formula"]))
        assert line.startswith(conjunct["conjunct"])


def test_the_documented_command(
    companion: Companion, good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert DOCUMENTED in (ROOT / "docs" / "run-folder.md").read_text(encoding="utf-8")
    _, command, run = DOCUMENTED.split()
    shutil.copytree(good, tmp_path / run)
    monkeypatch.chdir(tmp_path)
    assert companion(command, run).code == 0


# -- hand-made records -----------------------------------------------------------------------------

Write = Callable[..., Path]


class Begun(NamedTuple):
    """A position with which conjuncts begin anew, or at which they are dropped."""

    facts: str
    restarted: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()


@pytest.fixture
def write(tmp_path: Path) -> Iterator[Write]:
    """Writes the record of a flight; its positions are given by their facts in one text."""

    def written(
        task: dict[str, str],
        *positions: str | Begun,
        rests: bool = False,
        priorities: dict[str, int] | None = None,
    ) -> Path:
        happened: list[FlightEvent] = [WrittenTreeAdopted(task, priorities or {})]
        for number, given in enumerate(positions):
            begun = given if isinstance(given, Begun) else Begun(given)
            is_last = number == len(positions) - 1
            left = PositionLeft(
                number,
                facts=tuple(begun.facts.split()),
                risen=(),
                reached_s=0.0,
                withdrawn=(),
                restarted=begun.restarted,
                for_ever=rests and is_last,
                dropped=begun.dropped,
            )
            happened.append(left)
        happened.append(TaskSatisfied())
        lines = [line_of(Stamped(1.0 * i, event)) for i, event in enumerate(happened)]
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (tmp_path / "events.jsonl").write_text(text, encoding="utf-8")
        return tmp_path

    yield written


@pytest.mark.parametrize(
    ("formula", "word", "rests", "outcome", "code"),
    [
        ("F p", ["", "p", ""], False, ("fulfilled", 1), 0),
        ("F p", ["", ""], False, ("open", None), 0),
        ("F p", ["", ""], True, ("unfulfilled", None), 6),
        ("G !p", ["", "q"], False, ("open", None), 0),
        ("G !p", ["", "q"], True, ("satisfied", None), 0),
        ("G !p", ["", "q p", ""], True, ("violated", 1), 6),
        ("G F p", ["p", ""], True, ("unfulfilled", None), 6),
        ("G F p", ["", "p"], True, ("satisfied", None), 0),
        ("G (p -> X q)", ["p", ""], False, ("violated", 1), 6),
        ("p", [], False, ("open", None), 0),
    ],
)
def test_the_outcome_of_a_word(
    formula: str,
    word: list[str],
    rests: bool,
    outcome: tuple[str, int | None],
    code: int,
    companion: Companion,
    write: Write,
) -> None:
    assert len(conjuncts(parse(formula))) == 1
    assert outcomes(companion, write({"it": formula}, *word, rests=rests)) == (
        code,
        {"it": outcome},
    )


def test_a_conjunct_that_begins_anew_forgets_what_it_read(
    companion: Companion, write: Write
) -> None:
    anew = Begun("q", ("it",))
    task = {"it": "F p", "other": "F p"}
    _, found = outcomes(companion, write(task, "p", anew, rests=True))
    assert found == {"it": ("unfulfilled", None), "other": ("fulfilled", 0)}


@pytest.mark.parametrize(
    ("formula", "before", "anew", "rests", "told"),
    [
        ("G F p", "", "p", True, "satisfied over the whole flight; satisfied"),
        ("G (F p | q)", "", "q", True, "violated over the whole flight; satisfied"),
        ("p U q", "r", "q", False, "violated over the whole flight; violated"),
        ("F p", "p", "q", False, "satisfied over the whole flight; holds so far"),
        ("G (F p | q)", "", "q", False, "holds so far over the whole flight; holds so far"),
    ],
)
def test_both_verdicts_are_told_of_a_conjunct_that_began_anew(
    formula: str,
    before: str,
    anew: str,
    rests: bool,
    told: str,
    companion: Companion,
    write: Write,
) -> None:
    run = write({"it": formula}, before, Begun(anew, ("it",)), rests=rests)
    ended = companion("audit", run)
    assert f"\n           {told} since position 1\n" in ended.out
    (conjunct,) = json.loads(companion("audit", run, "--json").out)["conjuncts"]
    assert conjunct["since"] == 1
    is_whole_failure = conjunct["whole"] in ("violated", "unfulfilled")
    assert is_whole_failure is told.startswith("violated")


def test_one_verdict_is_told_of_a_conjunct_that_did_not(companion: Companion, write: Write) -> None:
    run = write({"it": "F p"}, "", Begun("p", ("other",)))
    assert "over the whole flight" not in companion("audit", run).out
    (conjunct,) = json.loads(companion("audit", run, "--json").out)["conjuncts"]
    assert (conjunct["since"], conjunct["whole"]) == (0, conjunct["outcome"])


def test_a_violation_stays_one_when_its_conjunct_begins_anew(
    companion: Companion, write: Write
) -> None:
    anew = Begun("", ("it",))
    assert outcomes(companion, write({"it": "G !p"}, "p", anew))[1] == {"it": ("violated", 0)}


DROPPED = [Begun("", dropped=("it",)), Begun("q", dropped=("it",))]


@pytest.mark.parametrize(
    ("formula", "positions", "outcome", "told"),
    [
        ("G F p", ["p", *DROPPED], "unfulfilled", "priority 2, dropped at positions 1 to 2"),
        ("G !q", ["", *DROPPED], "violated", "priority 2, dropped at positions 1 to 2"),
        ("G !p", ["p", DROPPED[0]], "violated", "priority 2, dropped at position 1"),
        ("F p", ["", DROPPED[0], ""], "unfulfilled", "priority 2, dropped at position 1"),
        ("G p", [*DROPPED, "p"], "violated", "priority 2, dropped at positions 0 to 1"),
        ("F q", [DROPPED[0], "", DROPPED[1]], "fulfilled", "priority 2, dropped at positions 0, 2"),
        ("F p", ["p"], "fulfilled", "priority 2, never dropped"),
    ],
)
def test_a_line_that_may_be_dropped_is_told_and_is_no_failure(
    formula: str,
    positions: list[str | Begun],
    outcome: str,
    told: str,
    companion: Companion,
    write: Write,
) -> None:
    run = write({"it": formula}, *positions, rests=True, priorities={"it": 2})
    code, found = outcomes(companion, run)
    assert (code, found["it"][0]) == (0, outcome)
    assert f"\n           {told}\n" in companion("audit", run).out


def test_a_line_that_was_violated_is_judged_from_where_it_was_taken_up(
    companion: Companion, write: Write
) -> None:
    positions = ["p", Begun("", dropped=("it",)), Begun("", ("it",)), ""]
    run = write({"it": "G !p"}, *positions, rests=True, priorities={"it": 1})
    (conjunct,) = json.loads(companion("audit", run, "--json").out)["conjuncts"]
    assert (conjunct["outcome"], conjunct["whole"]) == ("satisfied", "violated")
    assert (conjunct["priority"], conjunct["dropped"]) == (1, [[1, 1]])
    told = companion("audit", run).out
    assert "violated over the whole flight; satisfied since position 2" in told
    assert "it is dropped" in told


def test_a_record_that_told_of_no_violation_is_noticed(companion: Companion, write: Write) -> None:
    ended = companion("audit", write({"it": "G !p"}, "p"))
    assert ended.code == 6
    assert "not the same in flight: it at position 0" in ended.out


def test_a_flight_without_a_task_shows_its_word(companion: Companion, write: Write) -> None:
    """As of a mission that brings its own tree."""
    ended = companion("audit", write({}, "p"))
    assert ended.code == 0
    assert "the mission has no task" in ended.out
    assert re.search(r"^ +0  00:01\.0 +p$", ended.out, re.M)


# -- cut off, or damaged ---------------------------------------------------------------------------


def test_a_run_that_was_cut_off_anywhere_is_audited_as_far_as_it_goes(
    companion: Companion, good: Path, tmp_path: Path
) -> None:
    whole = (good / "events.jsonl").read_bytes()
    first = whole.index(b"\n") + 1
    torn = 0
    for size in range(first, len(whole) - 1, len(whole) // 40):
        (tmp_path / "events.jsonl").write_bytes(whole[:size])
        ended = companion("audit", tmp_path)
        assert ended.code == 0, ended.err
        assert "none: the run was cut off" in ended.out
        is_torn = "the last line of events.jsonl is not whole" in ended.out
        torn += is_torn
        assert is_torn is (whole[size - 1 : size] != b"\n" and whole[size : size + 1] != b"\n")
    assert torn > 30


def damaged(good: Path, folder: Path, change: Callable[[list[str]], object]) -> Path:
    lines = (good / "events.jsonl").read_text(encoding="utf-8").splitlines()
    change(lines)
    (folder / "events.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


NO_FORMULA = Stamped(0.0, WrittenTreeAdopted({"it": "G ("}))


def replaced(number: int, text: str) -> Callable[[list[str]], object]:
    return lambda lines: lines.__setitem__(number, text)


def edited(**change: object) -> Callable[[list[str]], object]:
    """The first position with other values."""

    def edit(lines: list[str]) -> None:
        number = next(i for i, line in enumerate(lines) if '"position"' in line)
        lines[number] = json.dumps(json.loads(lines[number]) | change)

    return edit


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (replaced(2, '{"t_s": 1'), r"events\.jsonl:3:1: this line is not JSON\n"),
        (replaced(2, "[1]"), r"events\.jsonl:3:1: this line is not a JSON object"),
        (replaced(2, "{}"), r"events\.jsonl:3:1: kind is missing"),
        (edited(number=4), "position 4 stands where 0 is due"),
        (edited(number=True), "number is missing here"),
        (edited(facts="at(A)"), "facts is missing here"),
        (edited(facts=[1]), "facts is missing here, or not of its kind"),
        (edited(mood="good"), "mood has no place here"),
        (replaced(2, '{"t_s": 1, "kind": "?", "text": ""}'), r"3:1: \? is no kind of event"),
        (edited(t_s=float("nan")), "t_s is missing here"),
        (lambda lines: lines.pop(0), "no plan was made in this run"),
        (replaced(0, json.dumps(line_of(NO_FORMULA))), r"events\.jsonl:1:1: .*\n.*\^"),
    ],
)
def test_a_damaged_record_is_refused_with_its_place(
    change: Callable[[list[str]], object],
    message: str,
    companion: Companion,
    good: Path,
    tmp_path: Path,
) -> None:
    ended = companion("audit", damaged(good, tmp_path, change))
    assert ended.code == 2
    assert re.search(message, ended.err, re.S), ended.err


def test_a_folder_that_is_none_is_refused(companion: Companion, tmp_path: Path) -> None:
    ended = companion("audit", tmp_path / "nowhere")
    assert ended.code == 2
    assert "is no run folder" in ended.err
