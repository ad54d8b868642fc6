"""Writes a classical problem as PDDL text, the two files that any planner reads.

No predicate or action has parameters. Names become identifiers that every reader of PDDL accepts:
letters, digits, `-` and `_`. None is a keyword, and no two differ only in case. A comment above
each action gives its original name.

Source: McDermott et al., PDDL, 1998; `:action-costs` as in PDDL 3.1.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from companion.planning.compilation.classical import ClassicalAction, ClassicalProblem, Fluent

RESERVED = frozenset(
    "action all always and assign at at-most-once axiom constants decrease define domain duration "
    "effect either end exists forall functions goal hold-after hold-during imply increase init "
    "maximize metric minimize not object objects or over parameters precondition predicates "
    "preference problem requirements scale-down scale-up sometime start total-cost total-time "
    "types undefined when within".split()
)


def identifiers(names: Iterable[str]) -> list[str]:
    """An identifier for each name; all are different, even if case is ignored.

    >>> identifiers(["at(A)", "at(a)", "end", "7"])
    ['at-A', 'at-a-2', 'end-2', 'x7']
    """
    given: list[str] = []
    taken = set(RESERVED)
    for name in names:
        word = re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-_")
        word = word if word[:1].isalpha() else f"x{word}"
        chosen, number = word, 1
        while chosen.lower() in taken:
            number += 1
            chosen = f"{word}-{number}"
        taken.add(chosen.lower())
        given.append(chosen)
    return given


@dataclass(frozen=True)
class Naming:
    """The identifiers of fluents and of actions; all are different."""

    fluents: Mapping[Fluent, str]
    actions: Mapping[str, str]


def naming(classical: ClassicalProblem) -> Naming:
    """The identifiers of a problem."""
    actions = [action.name for action in classical.actions]
    words = identifiers([*actions, *classical.fluents])
    count = len(actions)
    return Naming(
        dict(zip(classical.fluents, words[count:], strict=True)),
        dict(zip(actions, words[:count], strict=True)),
    )


def to_pddl(classical: ClassicalProblem) -> tuple[str, str]:
    """The domain and the problem, as the text of two files."""
    names = naming(classical)
    word = names.fluents
    head = (
        f"; A temporal task as classical planning, encoding {classical.encoding}: "
        f"{len(classical.fluents)} fluents, {len(classical.actions)} actions.\n"
        "; The actions before actLoop are the prefix of the plan, those after it are its loop.\n"
    )
    requirements = [":strips"]
    if any(a.forbids or any(e.forbids for e in a.conditional) for a in classical.actions):
        requirements.append(":negative-preconditions")
    if classical.has_conditional_effects:
        requirements.append(":conditional-effects")
    domain = [
        f"{head}(define (domain task)",
        f"  (:requirements {' '.join(requirements)} :action-costs)",
        "  (:predicates",
        *(f"    ({word[fluent]}) ; {fluent}" for fluent in classical.fluents),
        "  )",
        "  (:functions (total-cost) - number)",
        *(line for action in classical.actions for line in _action(action, names)),
        ")",
    ]
    problem = [
        f"{head}(define (problem task-from-here) (:domain task)",
        "  (:init",
        *(f"    ({word[fluent]})" for fluent in sorted(classical.init)),
        "    (= (total-cost) 0)",
        "  )",
        f"  (:goal {_all_of(classical.goal, (), word)})",
        "  (:metric minimize (total-cost))",
        ")",
    ]
    return "\n".join(domain) + "\n", "\n".join(problem) + "\n"


def _action(action: ClassicalAction, names: Naming) -> Iterator[str]:
    word = names.fluents
    yield f"  ; {action.name}"
    yield f"  (:action {names.actions[action.name]}"
    yield "    :parameters ()"
    yield f"    :precondition {_all_of(action.requires, action.forbids, word)}"
    yield "    :effect (and"
    for fluent in sorted(action.deletes):
        yield f"      (not ({word[fluent]}))"
    for fluent in sorted(action.adds):
        yield f"      ({word[fluent]})"
    for effect in action.conditional:
        condition = _all_of(effect.requires, effect.forbids, word)
        yield f"      (when {condition} {_all_of(effect.adds, effect.deletes, word)})"
    yield f"      (increase (total-cost) {action.cost})))"


def _all_of(
    positive: Iterable[Fluent], negative: Iterable[Fluent], word: Mapping[Fluent, str]
) -> str:
    literals = [f"({word[fluent]})" for fluent in sorted(positive)]
    literals += [f"(not ({word[fluent]}))" for fluent in sorted(negative)]
    return f"(and {' '.join(literals)})"
