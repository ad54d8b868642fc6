"""HOA text: as the format's definition has it, and the same automaton once read back."""

from __future__ import annotations

import re

import pytest

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.hoa import to_hoa
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate

ANY = Label(frozenset(), frozenset())

SEARCH = """\
HOA: v1
name: "G(F at(A) | targetFound)"
States: 2
Start: 0
AP: 2 "at(A)" "targetFound"
acc-name: Buchi
Acceptance: 1 Inf(0)
properties: trans-labels explicit-labels trans-acc
properties: deterministic complete
--BODY--
State: 0
[0] 0 {0}
[!0&1] 0 {0}
[!0&!1] 1
State: 1
[0] 0 {0}
[!0] 1
--END--
"""


def read(text: str) -> BuchiAutomaton:
    """A reader for the part of HOA that one line a transition needs."""
    head, body = text.split("--BODY--\n")
    fields = dict(line.split(": ", 1) for line in head.splitlines())
    names = [name.replace('\\"', '"') for name in re.findall(r'"((?:[^"\\]|\\.)*)"', fields["AP"])]
    assert len(names) == int(fields["AP"].split()[0])
    transitions = []
    state = -1
    for line in body.splitlines():
        if line.startswith("State: "):
            state = int(line.removeprefix("State: "))
        elif edge := re.fullmatch(r"\[(.*)\] (\d+)(?: \{(.*)\})?", line):
            literals = [] if edge[1] == "t" else edge[1].split("&")
            label = Label(
                frozenset(names[int(x)] for x in literals if x[0] != "!"),
                frozenset(names[int(x[1:])] for x in literals if x[0] == "!"),
            )
            marks = frozenset(map(int, (edge[3] or "").split()))
            transitions.append(Transition(state, label, int(edge[2]), marks))
        else:
            assert line == "--END--"
    return BuchiAutomaton(
        int(fields["States"]),
        frozenset({int(fields["Start"])}),
        tuple(transitions),
        int(fields["Acceptance"].split()[0]),
        fields["name"][1:-1].replace('\\"', '"'),
    )


def test_text_of_a_conjunct_of_the_paper() -> None:
    assert to_hoa(translate(parse("G(F at(A) | targetFound)"))) == SEARCH


@pytest.mark.parametrize(
    "text",
    [
        "G((targetFound | targetReported) -> F targetReported)",
        "G(targetReported -> X at(Home))",
        "G F a & G F b & G F trans_ok(A, B)",
        "F G a | b U c",
        "false",
        "true",
    ],
)
def test_reading_it_back_gives_the_same_automaton(text: str) -> None:
    automaton = translate(parse(text))
    assert read(to_hoa(automaton)) == automaton


@pytest.mark.parametrize(
    ("text", "name", "acceptance"),
    [
        ("G a", "all", "0 t"),
        ("G F a", "Buchi", "1 Inf(0)"),
        ("G F a & G F b", "generalized-Buchi 2", "2 Inf(0)&Inf(1)"),
    ],
)
def test_acceptance(text: str, name: str, acceptance: str) -> None:
    lines = to_hoa(translate(parse(text))).splitlines()
    assert f"acc-name: {name}" in lines
    assert f"Acceptance: {acceptance}" in lines


@pytest.mark.parametrize(
    ("text", "verdicts"),
    [
        ("G F a", "deterministic complete"),
        ("G a", "deterministic"),
        ("false", "deterministic"),
        ("true", "deterministic complete"),
        ("F G a", ""),
    ],
)
def test_determinism_and_completeness_are_told(text: str, verdicts: str) -> None:
    lines = [
        line.removeprefix("properties: ")
        for line in to_hoa(translate(parse(text))).splitlines()
        if line.startswith("properties: ")
    ]
    assert lines == ["trans-labels explicit-labels trans-acc", *[verdicts] * bool(verdicts)]


def test_a_nondeterministic_automaton_may_be_complete() -> None:
    loops = [Transition(0, ANY, target, frozenset()) for target in (0, 1)]
    both = BuchiAutomaton(2, frozenset({0}), (*loops, Transition(1, ANY, 1, frozenset())), 0)
    assert "\nproperties: complete\n" in to_hoa(both)


STRING = r'"(?:\\.|[^\\"])*"'
INT, IDENTIFIER = r"(?:0|[1-9]\d*)", r"[a-zA-Z_][\w-]*"
ACC = rf"(?: \{{{INT}(?: {INT})*\}})?"
AUTOMATON = re.compile(
    rf"HOA: v1\nname: {STRING}\nStates: {INT}\n(?:Start: {INT}\n)*AP: {INT}(?: {STRING})*\n"
    rf"acc-name: (?:all|Buchi|generalized-Buchi {INT})\n"
    rf"Acceptance: {INT} (?:t|Inf\({INT}\)(?:&Inf\({INT}\))*)\n"
    rf"(?:properties:(?: {IDENTIFIER})+\n)+--BODY--\n"
    rf"(?:State: {INT}{ACC}\n(?:\[(?:t|!?{INT}(?:&!?{INT})*)\] {INT}{ACC}\n)*)*--END--\n"
)
"""The grammar of the format, as far as we use it, with its own tokens."""


def test_a_stream_follows_the_grammar_of_the_format() -> None:
    texts = ["G F a & F G at(B)", "false", "true", "a U (b & X !c)", "G a", "F ok(A, B)"]
    automata = [translate(parse(text)) for text in texts]
    odd = BuchiAutomaton(1, frozenset({0}), (), 0, 'C:\\"x"\\')
    parts = [to_hoa(x) for x in (*automata, odd)]
    parts += [to_hoa(state_based(x), marks_on_states=True) for x in automata]
    found = AUTOMATON.findall("".join(parts))
    assert found == parts


def test_quotes_in_names_are_escaped() -> None:
    label = Label(frozenset({'say "a"'}), frozenset())
    loop = Transition(0, label, 0, frozenset())
    automaton = BuchiAutomaton(1, frozenset({0}), (loop,), 0, 'a "b"')
    assert r'AP: 1 "say \"a\""' in to_hoa(automaton)
    assert read(to_hoa(automaton)) == automaton
