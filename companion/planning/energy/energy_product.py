"""A product with what its edges take of the battery, and what must be left at its nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from companion.mission.facts import at
from companion.planning.builtin.product import Product
from companion.planning.charger import Charger
from companion.planning.domain import WAIT, Action
from companion.planning.energy.approach import ChargeLeg, EnergyGraph, FlightLeg
from companion.planning.energy.paths import Paths
from companion.planning.lasso import Energy, Problem
from companion.slices import spent

_EDGE_US, _NODE_US = 2.0, 2.0
NEVER = 1 << 60
"""A level that is never there: the floor where no safe place can be reached."""


class EnergyProduct:
    """A product and its energy.

    Attributes:
        product: with all one-shot goals in it.
        energy: of the problem.
        sources: (edges,) the node from which each edge leads.
        actions: (edges,) the action of each.
        drains: (edges,) what each takes; of no account where it charges.
        chargers: by edge; None where it does not charge.
        is_charge: (edges,) whether it does.
        places: by node, where the vehicle is.
        floors: by node, what must be left there in a loop.
        graph: the same, as the search for a way into a loop sees it.

    Args:
        problem: with energy.
        product: of it.
    """

    def __init__(self, problem: Problem, product: Product) -> None:
        assert problem.energy is not None
        spent(_EDGE_US * len(product.ends) + _NODE_US * product.nodes)
        self.product = product
        self.energy: Energy = problem.energy
        self.sources = np.repeat(np.arange(product.nodes), np.diff(product.first))
        self.actions: list[Action] = [
            problem.actions[number] for number in product.actions.tolist()
        ]
        self.chargers: list[Charger | None] = [action.charger for action in self.actions]
        self.is_charge = np.array([charger is not None for charger in self.chargers], np.bool_)
        rest = problem.energy.rest
        drains = [rest if action is WAIT else action.drain for action in self.actions]
        self.drains = np.array(drains, np.int64)
        self.places = self._place_of_each()
        self.floors = [self._floor(place, in_loop=True) for place in self.places]
        self._leg_edges: list[list[int]] = [[] for _ in range(product.nodes)]
        self._charge_edges: list[list[int]] = [[] for _ in range(product.nodes)]
        self.graph = self._graph()

    def action(self, edge: int, in_loop: bool = True) -> Action:
        """The action of an edge, in a loop or on the way into it."""
        action = self.actions[edge]
        if action.charger is None or in_loop or not self.energy.is_short:
            return action
        return replace(action, charger=action.charger.bare or action.charger)

    def end(self, edge: int) -> int:
        """The node to which an edge leads."""
        return int(self.product.ends[edge])

    def start(self, edge: int) -> int:
        """The node from which it leads."""
        return int(self.sources[edge])

    def charger(self, edge: int) -> Charger:
        """Of an edge that charges."""
        charger = self.chargers[edge]
        assert charger is not None
        return charger

    def edge(self, node: int, number: int, is_charge: bool) -> int:
        """The edge of a leg of the graph, by its number there."""
        return (self._charge_edges if is_charge else self._leg_edges)[node][number]

    def inside(self, nodes: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(edges,) whether each stays within some nodes."""
        within = np.zeros(self.product.nodes, np.bool_)
        within[nodes] = True
        inside: NDArray[np.bool_] = within[self.sources] & within[self.product.ends]
        return inside

    def paths(self, edges: NDArray[np.bool_], starts: list[int], is_thrifty: bool) -> Paths:
        """The paths of least time or of least drain from some nodes along some edges."""
        numbers = np.flatnonzero(edges & ~self.is_charge)
        return Paths(
            self.product.nodes,
            (self.sources[numbers], self.product.ends[numbers], numbers),
            (self.product.costs[numbers], self.drains[numbers]),
            starts,
            is_thrifty,
        )

    def _floor(self, place: str, in_loop: bool) -> int:
        floor = self.energy.floor(place, in_loop)
        return NEVER if floor is None else floor

    def _place_of_each(self) -> list[str]:
        bits = {place: self.product.bit(at(place)) for place in self.energy.floors}
        facts = (self.product.facts(node) for node in range(self.product.nodes))
        return [next((p for p, bit in bits.items() if held & bit), "") for held in facts]

    def _graph(self) -> EnergyGraph:
        product = self.product
        legs: list[list[FlightLeg]] = [[] for _ in range(product.nodes)]
        charges: list[list[ChargeLeg]] = [[] for _ in range(product.nodes)]
        each = zip(
            self.sources.tolist(),
            product.ends.tolist(),
            product.costs.tolist(),
            self.drains.tolist(),
            self.chargers,
            strict=True,
        )
        for number, (start, end, cost_ms, drain, charger) in enumerate(each):
            if charger is not None:
                if self.energy.is_short:
                    charger = charger.bare or charger
                charges[start].append(ChargeLeg(end, charger))
                self._charge_edges[start].append(number)
            else:
                legs[start].append(FlightLeg(end, cost_ms, drain))
                self._leg_edges[start].append(number)
        floors = [self._floor(place, in_loop=False) for place in self.places]
        return EnergyGraph(legs, charges, floors)
