"""A product with the energy that its edges take, and the floors at its nodes."""

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
"""A level that is never reached: the floor where no safe place can be reached."""


class EnergyProduct:
    """A product and its energy.

    Attributes:
        product: with all one-shot goals in it.
        energy: the energy of the problem.
        sources: (edges,) the node where each edge begins.
        actions: (edges,) the action of each edge.
        drains: (edges,) the energy that each edge takes; meaningless if it charges.
        chargers: by edge; None if it does not charge.
        is_charge: (edges,) whether the edge charges.
        places: by node, where the vehicle is.
        floors: by node, the lowest level allowed there in a loop.
        graph: the same product, in the form that the search for a path into a loop uses.

    Args:
        problem: a problem with energy.
        product: the product of the problem.
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
        """The action of an edge, in a loop or on the path into it."""
        action = self.actions[edge]
        if action.charger is None or in_loop or not self.energy.is_short:
            return action
        return replace(action, charger=action.charger.bare or action.charger)

    def end(self, edge: int) -> int:
        """The node to which an edge leads."""
        return int(self.product.ends[edge])

    def start(self, edge: int) -> int:
        """The node where an edge begins."""
        return int(self.sources[edge])

    def charger(self, edge: int) -> Charger:
        """The charger of an edge that charges."""
        charger = self.chargers[edge]
        assert charger is not None
        return charger

    def edge(self, node: int, number: int, is_charge: bool) -> int:
        """The edge of a leg or charge of the graph, by its number at a node."""
        return (self._charge_edges if is_charge else self._leg_edges)[node][number]

    def inside(self, nodes: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(edges,) whether each edge stays within some nodes."""
        within = np.zeros(self.product.nodes, np.bool_)
        within[nodes] = True
        inside: NDArray[np.bool_] = within[self.sources] & within[self.product.ends]
        return inside

    def paths(self, edges: NDArray[np.bool_], starts: list[int], is_thrifty: bool) -> Paths:
        """The paths of least time, or of least energy, from some nodes along some edges."""
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
