"""Reads a PDDL domain as part of a mission: its actions become skills, its types become sets.

The domain and problem files (`pddl_files.py`) are rewritten in the terms of a mission file, as if
the author had written facts such as `in(p1, Home)` and effects such as `free & (wants(c, x) ->
delivered(x))`. So they are checked, and errors are explained, in the same way. What an action does
in the world (`execute`) is given in the mission file.

PDDL ignores case. A name that the mission file also has is spelled as it is there; all others are
in lower case. `-` becomes `_`. Preconditions are conjunctions of facts, negated facts, and
inequalities of parameters. Effects may be conditional and universal. What a mission cannot express
(numbers other than the total cost, durations, disjunctions, ...) is refused, never left out.

Source: McDermott et al., PDDL, 1998; the paper, last point of Section III-C.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from companion.documents import Document, did_you_mean
from companion.errors import FormulaError, MissionError
from companion.mission.literals import parse_fact
from companion.mission.pddl_files import parsed
from companion.mission.schema import MissionFile
from companion.mission.skill_schema import SkillEntry

if TYPE_CHECKING:
    from unified_planning.model import Action, Effect, FNode, Problem, Type, Variable

OF_THE_DOMAIN = ("parameters", "precondition", "effect", "distinct")  # and not of the mission
TOTAL_COST = "total-cost"
MAX_EXPANSION = 10_000  # choices for the variables of all forall together

Binding = Mapping[str, str]
"""The values of the variables of a universal effect."""

Predicates = Mapping[str, tuple[tuple[str, ...], ...]]
"""The name of each predicate, and what each of its arguments may be."""

DomainReader = Callable[[MissionFile, Document, Path], tuple[MissionFile, Predicates]]
"""The type of `with_domain`."""


def with_domain(
    file: MissionFile, document: Document, folder: Path
) -> tuple[MissionFile, Predicates]:
    """Returns the mission file completed by its PDDL files, and the predicates that they declare.

    Raises:
        MissionError: a file cannot be read, uses what is not supported, or contradicts the mission
            file.
    """
    if file.domain is None:
        if file.problem is None:
            return file, {}
        raise MissionError(
            "a problem without a domain", document.key_at("problem"), "add domain: FILE.pddl"
        )
    imported = _Import(file, document, parsed(folder, file, document))
    return imported.merged(), imported.predicates()


@dataclass(frozen=True)
class _Import:
    """A parsed PDDL problem, translated into the terms of a mission file."""

    file: MissionFile
    document: Document
    problem: Problem
    expanded: Iterator[int] = field(default_factory=itertools.count)

    def merged(self) -> MissionFile:
        """Returns the mission file completed by the whole PDDL problem."""
        file = self.file
        self._refuse_one_name_for_two()
        actions = self.problem.actions
        skills = {self._spelled(action.name, file.skills): action for action in actions}
        self._refuse_unknown(skills)
        named = [self._member(thing.name) for thing in self.problem.all_objects]
        known = {*file.places, *file.objects}
        start = self.problem.explicit_initial_values.items()
        facts = [self._fact(fluent, {}) for fluent, value in start if value.is_true()]
        goal = self._goal() if file.goal is None and not file.task else file.goal
        return file.model_copy(
            update={
                "objects": [*file.objects, *(name for name in named if name not in known)],
                "sets": {**file.sets, **self._sets()},
                "skills": {name: self._skill(name, action) for name, action in skills.items()},
                "initially": list(dict.fromkeys([*file.initially, *facts])),
                "goal": goal,
            }
        )

    def predicates(self) -> Predicates:
        """Returns the predicates of which facts may exist."""
        declared: dict[str, tuple[tuple[str, ...], ...]] = {}
        for fluent in self.problem.fluents:
            name = self._spelled(fluent.name, self.file.events)
            domains = tuple(tuple(self._members(p.type)) for p in fluent.signature)
            if fluent.type.is_bool_type() and all(domains):
                self._refuse_predicate(name, len(domains))
                declared[name] = domains
        return declared

    def _refuse_predicate(self, name: str, arity: int) -> None:
        """Refuses words of the formula language, and an `at` with another meaning."""
        try:
            parse_fact(f"{name}(a)" if arity else name)
        except FormulaError:
            raise MissionError(
                f"the predicate {name} of the domain has a meaning of its own in formulas",
                self.document.where("domain"),
                "choose another name in the PDDL files",
            ) from None
        if name == "at" and arity != 1:
            raise MissionError(
                f"the predicate at of the domain has {arity} arguments",
                self.document.where("domain"),
                "at(PLACE) says where the vehicle is; give facts about other things another name",
            )

    def _refuse_one_name_for_two(self) -> None:
        pddl = self.problem
        kinds = (pddl.actions, pddl.fluents, pddl.user_types, pddl.all_objects)
        for things in (*kinds, *(action.parameters for action in pddl.actions)):
            names: dict[str, str] = {}
            for thing in things:
                plain = _plain(thing.name)
                if plain in names:
                    raise MissionError(
                        f"{names[plain]} and {thing.name} of the PDDL files are both {plain} here",
                        self.document.where("domain"),
                        "choose names that differ in more than - and _",
                    )
                names[plain] = thing.name

    def _refuse_unknown(self, skills: Mapping[str, Action]) -> None:
        for name in self.file.skills:
            if name not in skills:
                raise MissionError(
                    f"the domain has no action {name}",
                    self.document.key_at("skills", name),
                    f"its actions are {', '.join(skills)}. {did_you_mean(name, skills)}".rstrip(),
                )

    def _skill(self, name: str, action: Action) -> SkillEntry:
        entry = self.file.skills.get(name)
        if entry is None:
            raise MissionError(
                f"nothing says what the action {name} does in the world",
                self.document.where("domain"),
                f"add to skills: {name}: {{execute: ...}}",
            )
        for key in OF_THE_DOMAIN:
            if key in entry.model_fields_set:
                raise MissionError(
                    f"{key} of {name} stands in the domain already",
                    self.document.key_at("skills", name, key),
                    "remove one of the two",
                )
        self._refuse_empty_types(name, action)
        precondition, distinct = self._precondition(name, action)
        effects = [self._effect(name, effect) for effect in action.effects if not _is_cost(effect)]
        cost = entry.cost if entry.cost is not None else self._cost(name, action)
        return entry.model_copy(
            update={
                "parameters": {_plain(p.name): self._set_name(p.type) for p in action.parameters},
                "precondition": " & ".join(precondition) or None,
                "distinct": distinct,
                "effect": " & ".join(itertools.chain(*effects)) or None,
                "cost": cost,
            }
        )

    def _refuse_empty_types(self, name: str, action: Action) -> None:
        for parameter in action.parameters:
            if not self._members(parameter.type):
                kind = self._set_name(parameter.type)
                raise MissionError(
                    f"no object has the type {kind}, which {name} needs",
                    self.document.where("skills", name),
                    f"add objects to the PDDL problem, or a set here: sets: {{{kind}: [...]}}",
                )

    def _precondition(self, name: str, action: Action) -> tuple[list[str], list[list[str]]]:
        facts: list[str] = []
        distinct: list[list[str]] = []
        for condition in action.preconditions:
            for part, binding in self._conjuncts(condition, {}):
                if part.is_not() and part.arg(0).is_equals():
                    distinct.append([self._argument(a, binding) for a in part.arg(0).args])
                else:
                    facts.append(self._literal(part, binding, f"the precondition of {name}"))
        return facts, distinct

    def _effect(self, name: str, effect: Effect) -> Iterator[str]:
        """Yields the facts of one effect, for every choice of its variables."""
        where = f"an effect of {name}"
        if not effect.value.is_bool_constant():
            raise self._unsupported(where, str(effect))
        for binding in self._bindings(effect.forall, {}):
            fact = self._literal(effect.fluent, binding, where)
            text = fact if effect.value.is_true() else f"!{fact}"
            parts = self._conjuncts(effect.condition, binding)
            condition = " & ".join(self._literal(*part, where) for part in parts)
            yield f"({condition} -> {text})" if condition else text

    def _cost(self, name: str, action: Action) -> float | None:
        """Returns what an action adds to the total cost, which the reader moves into the metric."""
        costs = [effect.value for effect in action.effects if _is_cost(effect)]
        for metric in self.problem.quality_metrics:
            if metric.is_minimize_action_costs():
                costs += [cost for cost in [metric.get_action_cost(action)] if cost is not None]
            elif metric.is_minimize_sequential_plan_length():  # every action costs 1
                costs.append(self.problem.environment.expression_manager.Int(1))
            elif TOTAL_COST not in str(metric):
                raise self._unsupported("the metric", str(metric))
        for cost in costs:
            if not cost.is_constant():
                raise MissionError(
                    f"the cost of {name} depends on its parameters: {cost}",
                    self.document.where("skills", name),
                    "write cost: flight_time, or seconds, in the mission file",
                )
        return sum(float(cost.constant_value()) for cost in costs) or None

    def _goal(self) -> str | None:
        parts = (part for goal in self.problem.goals for part in self._conjuncts(goal, {}))
        return " & ".join(self._literal(*part, "the goal") for part in parts) or None

    def _conjuncts(self, node: FNode, binding: Binding) -> Iterator[tuple[FNode, Binding]]:
        """Yields the parts of a conjunction, with universal ones written out; nothing for true."""
        if node.is_and():
            for part in node.args:
                yield from self._conjuncts(part, binding)
        elif node.is_forall():
            for inner in self._bindings(node.variables(), binding):
                yield from self._conjuncts(node.arg(0), inner)
        elif not node.is_true():
            yield node, binding

    def _bindings(self, variables: Iterable[Variable], outer: Binding) -> Iterator[Binding]:
        """Yields every choice for the variables of a forall."""
        names = [variable.name for variable in variables]
        domains = [self._members(variable.type) for variable in variables]
        for members in itertools.product(*domains):
            if next(self.expanded) == MAX_EXPANSION:
                raise MissionError(
                    f"written out, the forall have more than {MAX_EXPANSION} parts in all",
                    self.document.where("domain"),
                    "use fewer variables under forall, or types with fewer objects",
                )
            yield {**outer, **dict(zip(names, members, strict=True))}

    def _sets(self) -> dict[str, list[str]]:
        """Returns the types with members; those without must be sets of the mission file."""
        sets: dict[str, list[str]] = {}
        for kind in self.problem.user_types:
            name = self._set_name(kind)
            members = [self._member(thing.name) for thing in self.problem.objects(kind)]
            if members and name in self.file.sets:
                what = f"{name} is a type with members in PDDL, and a set here"
                where = self.document.key_at("sets", name)
                raise MissionError(what, where, "remove one of the two")
            if members:
                sets[name] = members
        return sets

    def _members(self, kind: Type) -> list[str]:
        """Returns the members of a type; if PDDL lists none, those in the mission file."""
        members = [self._member(thing.name) for thing in self.problem.objects(kind)]
        return members or self.file.sets.get(self._set_name(kind), [])

    def _literal(self, node: FNode, binding: Binding, where: str) -> str:
        is_negative = node.is_not()
        atom = node.arg(0) if is_negative else node
        if not atom.is_fluent_exp() or not atom.type.is_bool_type():
            raise self._unsupported(where, str(node))
        return f"!{self._fact(atom, binding)}" if is_negative else self._fact(atom, binding)

    def _fact(self, atom: FNode, binding: Binding) -> str:
        name = self._spelled(atom.fluent().name, self.file.events)
        arguments = ", ".join(self._argument(argument, binding) for argument in atom.args)
        return f"{name}({arguments})" if arguments else name

    def _argument(self, node: FNode, binding: Binding) -> str:
        if node.is_variable_exp():
            return binding[node.variable().name]
        if node.is_parameter_exp():
            return _plain(node.parameter().name)
        return self._member(node.object().name)

    def _member(self, name: str) -> str:
        return self._spelled(name, {**self.file.places, **dict.fromkeys(self.file.objects)})

    def _set_name(self, kind: Type) -> str:
        return self._spelled(kind.name, self.file.sets)

    def _spelled(self, name: str, known: Iterable[str]) -> str:
        """Returns a name as the mission file spells it, if the file has it."""
        plain = _plain(name)
        return next((other for other in known if other.lower() == plain.lower()), plain)

    def _unsupported(self, where: str, what: str) -> MissionError:
        return MissionError(
            f"{where} in the PDDL files is not supported: {what[:200]}",
            self.document.where("domain"),
            "a condition is made of facts, (not FACT), (not (= A B)) in preconditions, and, forall",
        )


def _plain(name: str) -> str:
    return name.replace("-", "_")


def _is_cost(effect: Effect) -> bool:
    is_constant = effect.is_increase() and not effect.is_conditional() and not effect.forall
    return bool(is_constant) and effect.fluent.fluent().name == TOTAL_COST
