"""The actions of a mission as bit masks, kept from plan to plan.

Only facts that some action changes have bits. All others, mainly beliefs and events, are constant
within a problem: they decide which actions exist, and a mission of 200 sites has 40,000 of them.
Actions with the same condition and the same deletes, such as the flights from a place, form a
group, which is tested for applicability only once.

Source: the successor generator of Helmert, The Fast Downward planning system, 2006.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import reduce
from operator import or_
from typing import NamedTuple

from companion.mission.facts import Fact
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.domain import Action, ConditionalEffect
from companion.slices import spent

_MASKING_US = 5
_TAKING_OVER_US = 2
_GROUPING_US = 1


class MaskedCondition(NamedTuple):
    """What must hold and what must not: facts that change (as bits), and facts that do not."""

    requires: int
    forbids: int
    requires_always: frozenset[Fact]
    forbids_always: frozenset[Fact]

    def holds(self, state: int) -> bool:
        """Whether a state satisfies the part about facts that change."""
        return self.requires & state == self.requires and not self.forbids & state

    def may_hold(self, facts: frozenset[Fact]) -> bool:
        """Whether the facts at the start satisfy the part about facts that do not change."""
        return self.requires_always <= facts and not self.forbids_always & facts


class MaskedEffect(NamedTuple):
    """A conditional effect over bit masks."""

    condition: MaskedCondition
    adds: int
    deletes: int


class MaskedAction(NamedTuple):
    """An action as bit masks; `number` is its index among the problem's actions."""

    number: int
    condition: MaskedCondition
    adds: int
    deletes: int
    cost_ms: int
    conditional: tuple[MaskedEffect, ...]


class ActionGroup:
    """Actions with the same condition and deletes, in their order; a conditional action is alone.

    Attributes:
        requires, forbids: facts (bits) that must hold, and that must not.
        numbers, costs: those of its actions.
        adds: facts (bits) that one of them adds, without conditional adds.
        may_add, deletes: facts (bits) that one of them may add or delete.
        conditional: effects with a condition.
        reads: facts (bits) in its condition and in those of its effects.
    """

    __slots__ = ("_adds", "actions", "adds", "conditional", "costs", "deletes",
                 "forbids", "may_add", "numbers", "reads", "requires")  # fmt: skip

    def __init__(self, actions: Sequence[MaskedAction]) -> None:
        first = actions[0]
        self.actions = actions
        self.requires, self.forbids = first.condition.requires, first.condition.forbids
        self.numbers = [action.number for action in actions]
        self.costs = [action.cost_ms for action in actions]
        self.conditional = first.conditional
        self._adds = [action.adds for action in actions]
        self.adds: int = reduce(or_, self._adds)
        self.deletes: int = reduce(or_, (e.deletes for e in self.conditional), first.deletes)
        self.reads, self.may_add = self.requires | self.forbids, self.adds
        for condition, adds, _ in self.conditional:
            self.reads |= condition.requires | condition.forbids
            self.may_add |= adds

    @property
    def rests_ms(self) -> list[int]:
        """The costs of actions that are always possible and change nothing."""
        if self.requires | self.forbids | self.deletes or self.conditional:
            return []
        return [ms for ms, adds in zip(self.costs, self._adds, strict=True) if not adds]

    def is_applicable(self, state: int) -> bool:
        """Whether the actions are applicable in a state."""
        return self.requires & state == self.requires and not self.forbids & state

    def ends(self, state: int) -> list[int]:
        """The state after each action."""
        if not self.conditional:
            kept = state & ~self.deletes
            return [kept | adds for adds in self._adds]
        (action,) = self.actions
        met = [effect for effect in self.conditional if effect.condition.holds(state)]
        adds = reduce(or_, (effect.adds for effect in met), action.adds)
        deletes = reduce(or_, (effect.deletes for effect in met), action.deletes)
        return [state & ~deletes | adds]

    def given(self, facts: frozenset[Fact], unavailable: set[int]) -> ActionGroup | None:
        """The group without some actions and impossible effects; None if nothing is left."""
        left = [
            action._replace(
                conditional=tuple(e for e in action.conditional if e.condition.may_hold(facts))
            )
            for action in self.actions
            if action.number not in unavailable
        ]
        return ActionGroup(left) if left else None


class MaskedActions:
    """Some actions as bit masks, in groups.

    Args:
        actions: the actions of a problem, or some of them.
        first_number: the index of the first one among the problem's actions.
        changed: facts that these or other actions change.
        bits: the bits of the facts.
        before: actions for the same changing facts; the masks of those that differ only in cost are
            reused.
    """

    def __init__(
        self,
        actions: Sequence[Action],
        first_number: int,
        changed: set[Fact],
        bits: FactBits,
        before: MaskedActions | None = None,
    ) -> None:
        self._changed, self._bits = changed, bits
        self._action_of: dict[str, Action] = {}
        self._mask_of: dict[str, MaskedAction] = {}
        self._requiring: dict[Fact, list[int]] = defaultdict(list)  # facts that do not change
        self._forbidding: dict[Fact, list[int]] = defaultdict(list)
        members: dict[tuple[int, ...], list[MaskedAction]] = defaultdict(list)
        for number, action in enumerate(actions, first_number):
            masked = before._taken_over(number, action) if before is not None else None
            masked = masked or self._masked(number, action)
            self._action_of[action.name], self._mask_of[action.name] = action, masked
            for fact in masked.condition.requires_always:
                self._requiring[fact].append(number)
            for fact in masked.condition.forbids_always:
                self._forbidding[fact].append(number)
            requires, forbids, *_ = masked.condition
            is_alone = bool(masked.conditional)
            key = (-1 - number,) if is_alone else (requires, forbids, masked.deletes)
            members[key].append(masked)
        self._groups = [ActionGroup(group) for group in members.values()]
        self._place_of = {n: place for place, g in enumerate(self._groups) for n in g.numbers}
        self._open = {
            place
            for place, group in enumerate(self._groups)
            for _, _, requires, forbids in (effect.condition for effect in group.conditional)
            if requires or forbids
        }
        self._required, self._forbidden = frozenset(self._requiring), frozenset(self._forbidding)

    def relies_on(self, facts: Iterable[Fact]) -> bool:
        """Whether it treats some of these facts as constant."""
        constants = self._required.union(
            self._forbidden,
            *(
                effect.condition.requires_always | effect.condition.forbids_always
                for place in self._open
                for effect in self._groups[place].conditional
            ),
        )
        return not constants.isdisjoint(facts)

    def given(self, facts: frozenset[Fact]) -> list[ActionGroup]:
        """The groups of actions that the facts at the start do not rule out."""
        unavailable = {n for fact in self._required - facts for n in self._requiring[fact]}
        unavailable.update(n for fact in self._forbidden & facts for n in self._forbidding[fact])
        spent(_GROUPING_US * len(self._groups))
        decided = self._open.union(self._place_of[number] for number in unavailable)
        if not decided:
            return self._groups
        groups = (
            group.given(facts, unavailable) if place in decided else group
            for place, group in enumerate(self._groups)
        )
        return [group for group in groups if group is not None]

    def _taken_over(self, number: int, action: Action) -> MaskedAction | None:
        """The existing mask of an action that differs at most in cost and number, if any."""
        known = self._action_of.get(action.name)
        if known is None or not _does_the_same(action, known):
            return None
        spent(_TAKING_OVER_US)
        masked = self._mask_of[action.name]
        if (masked.number, masked.cost_ms) == (number, action.cost_ms):
            return masked
        return masked._replace(number=number, cost_ms=action.cost_ms)

    def _masked(self, number: int, action: Action) -> MaskedAction:
        spent(_MASKING_US)
        mask = self._bits.mask
        adds, deletes = mask(action.adds), mask(action.deletes)  # facts that change have low bits
        condition = self._condition(action)
        effects = tuple(
            MaskedEffect(self._condition(effect), mask(effect.adds), mask(effect.deletes))
            for effect in action.conditional
        )
        return MaskedAction(number, condition, adds, deletes, action.cost_ms, effects)

    def _condition(self, of: Action | ConditionalEffect[Fact]) -> MaskedCondition:
        changed, mask = self._changed, self._bits.mask
        return MaskedCondition(
            mask(of.requires & changed),
            mask(of.forbids & changed),
            of.requires - changed,
            of.forbids - changed,
        )


class KnownActions:
    """The actions that every problem contains, as bit masks, and the bits of facts.

    Attributes:
        bits: the bits of the facts.

    Args:
        actions: converted to masks once and kept; other actions are converted each time.
    """

    def __init__(self, actions: Sequence[Action] = ()) -> None:
        self.bits = FactBits()
        self._changed: set[Fact] = set()
        self._masked = MaskedActions((), 0, self._changed, self.bits)
        self.keep(actions)

    def keep(self, actions: Sequence[Action]) -> None:
        """Replaces the actions that are kept."""
        self._keep(tuple(actions), self._changed | _changed_by(actions))

    def _keep(self, actions: tuple[Action, ...], changed: set[Fact]) -> None:
        """Assigns all attributes last, because the conversion takes long and may be abandoned."""
        before = self._masked if changed == self._changed else None
        masked = MaskedActions(actions, 0, changed, self.bits, before)
        self._actions, self._changed, self._masked = actions, changed, masked

    def state(self, facts: Iterable[Fact]) -> int:
        """The bits of those facts that actions change."""
        return self.bits.mask(self._changed.intersection(facts))

    def given(self, actions: tuple[Action, ...], facts: frozenset[Fact]) -> list[ActionGroup]:
        """The groups of a problem's actions that the facts at its start do not rule out."""
        known = len(self._actions) if actions[: len(self._actions)] == self._actions else 0
        more = actions[known:]
        new = _changed_by(more) - self._changed
        if self._masked.relies_on(new):
            self._keep(self._actions, self._changed | new)
        else:
            self._changed |= new
        groups = self._masked.given(facts) if known else []
        if more:
            groups = groups + MaskedActions(more, known, self._changed, self.bits).given(facts)
        return groups


def _does_the_same(one: Action, other: Action) -> bool:
    """Whether one was made from the other with at most another cost: they share their facts."""
    return (
        one.requires is other.requires
        and one.forbids is other.forbids
        and one.adds is other.adds
        and one.deletes is other.deletes
        and one.conditional is other.conditional
    )


def _changed_by(actions: Iterable[Action]) -> set[Fact]:
    changed: set[Fact] = set()
    for action in actions:
        changed |= action.adds
        changed |= action.deletes
        for effect in action.conditional:
            changed |= effect.adds
            changed |= effect.deletes
    return changed
