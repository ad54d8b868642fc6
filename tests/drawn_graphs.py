"""Random graphs for tests of reductions, with sets of letters or cubes as labels."""

from __future__ import annotations

from hypothesis import strategies as st

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, with_letters
from companion.ltl.labels import Alphabet, Cube, LetterSet

CubeGraph = LabelledGraph[Cube]
ALPHABET = Alphabet(("a", "b"))
LITERALS = (0b01, 0b10, 0b00)
"""p, !p, or nothing of a proposition p."""

CUBES = st.builds(
    lambda a, b: Cube(a | b << 2), st.sampled_from(LITERALS), st.sampled_from(LITERALS)
)


def graphs_of_cubes(most_nodes: int = 5, most_marks: int = 2) -> st.SearchStrategy[CubeGraph]:
    """Graphs of a few nodes; several edges may have the same label, marks and target."""

    def edges(size: int, marks: int) -> st.SearchStrategy[CubeGraph]:
        edge = st.builds(
            LabelledEdge, CUBES, st.integers(0, (1 << marks) - 1), st.integers(0, size - 1)
        )
        leaving = st.lists(st.lists(edge, max_size=4), min_size=size, max_size=size)
        return leaving.map(lambda edges: LabelledGraph(edges, marks))

    sizes = st.tuples(st.integers(1, most_nodes), st.integers(0, most_marks))
    return sizes.flatmap(lambda drawn: edges(*drawn))


def by_letters(graph: CubeGraph) -> LabelledGraph[LetterSet]:
    """The graph with sets of letters as labels."""
    return with_letters(graph, ALPHABET, Budget())
