"""Strongly connected components, against networkx."""

from __future__ import annotations

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.components import acyclic, components_by_name, reaching, strong_components

GRAPHS = st.integers(1, 12).flatmap(
    lambda n: st.lists(st.lists(st.integers(0, n - 1), max_size=4), min_size=n, max_size=n)
)


@given(GRAPHS)
def test_components_are_those_of_networkx_in_reverse_topological_order(
    graph: list[list[int]],
) -> None:
    reference = nx.DiGraph([(node, t) for node, targets in enumerate(graph) for t in targets])
    reference.add_nodes_from(range(len(graph)))
    components = strong_components(graph)
    assert set(map(frozenset, components)) == set(
        map(frozenset, nx.strongly_connected_components(reference))
    )
    seen: set[int] = set()
    for component in components:
        seen.update(component)
        assert all(target in seen for node in component for target in graph[node])


@pytest.mark.slow
def test_components_of_a_long_path_do_not_recurse() -> None:
    path = [[node + 1] for node in range(50_000)] + [[]]
    assert len(strong_components(path)) == 50_001


@given(GRAPHS)
def test_what_is_on_no_cycle_is_alone_in_its_component(graph: list[list[int]]) -> None:
    named = {f"n{node}": [f"n{t}" for t in targets] for node, targets in enumerate(graph)}
    assert components_by_name(named) == [
        [f"n{node}" for node in component] for component in strong_components(graph)
    ]
    reference = nx.DiGraph([(name, t) for name, targets in named.items() for t in targets])
    on_cycles = {name for cycle in nx.simple_cycles(reference, 12) for name in cycle}
    assert acyclic(named) == named.keys() - on_cycles


@given(GRAPHS, st.data())
def test_what_reaches_an_accepting_component(graph: list[list[int]], data: st.DataObject) -> None:
    components = strong_components(graph)
    accepting = data.draw(
        st.lists(st.booleans(), min_size=len(components), max_size=len(components))
    )
    reference = nx.DiGraph([(node, t) for node, targets in enumerate(graph) for t in targets])
    reference.add_nodes_from(range(len(graph)))
    ends = {c[0] for c, is_accepting in zip(components, accepting, strict=True) if is_accepting}
    expected = {n for n in reference if n in ends or ends & nx.descendants(reference, n)}
    assert reaching(graph, components, accepting) == expected
