"""Pictures of small Büchi automata as SVG: states in a row, in the order of reachability.

An edge to the next state is straight, one to the state before is an arc below, one to another state
goes down, along and up, and one to the same state is a loop above. An arrow from nowhere leads to
each initial state. States of a state-based acceptance have a double line. Otherwise, an edge has a
dot after its label for each acceptance set to which it belongs.
"""

from __future__ import annotations

from collections import defaultdict
from html import escape
from itertools import pairwise
from typing import NamedTuple

from svg_picture import svg_picture

from companion.ltl.automaton import BuchiAutomaton

RADIUS, GAP, CHARACTER, LINE = 16, 60, 7.3, 16
"""Pixels: radius of a state, least gap, width of a character, height of a line."""
TOP, LEFT = 34, 56
DOTS = "●○◆◇"
STYLE = (
    "text{font:12px monospace;fill:#222;paint-order:stroke;stroke:#fff;stroke-width:4}"
    ".t{font-weight:bold}"
    "circle,path{fill:none;stroke:#222;stroke-width:1.4}.a{fill:#222;stroke:none}"
)
ARROW = (
    '<marker id="a" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" '
    'orient="auto"><path class="a" d="M0 0L8 4L0 8z"/></marker>'
)


class Row(NamedTuple):
    """One automaton of a picture."""

    body: str
    width: float
    height: float


def picture(automata: list[BuchiAutomaton]) -> str:
    """The automata, one below the other, each under its name."""
    parts, width, height = [], 0.0, 0.0
    for automaton in automata:
        row = _row(automaton)
        parts.append(f'<g transform="translate(0 {height:.0f})">{row.body}</g>')
        width, height = max(width, row.width), height + row.height
    return svg_picture(parts, width, height, style=STYLE, definitions=ARROW)


def _row(automaton: BuchiAutomaton) -> Row:
    order = _order(automaton)
    labels = _labels(automaton)
    loops = [labels.get((state, state), []) for state in order]
    y = TOP + LINE * max(map(len, loops)) + 34
    xs = _places(order, labels)
    paths: list[str] = []
    texts = [f'<text class="t" x="8" y="18">{escape(automaton.name)}</text>']
    accepting = _accepting(automaton)
    for number, (state, x) in enumerate(zip(order, xs, strict=True)):
        if state in automaton.initial:
            paths.append(_path(f"M{x - 46:.0f} {y}H{x - RADIUS:.0f}"))
        radii = (RADIUS, RADIUS - 4) if state in accepting else (RADIUS,)
        paths += [f'<circle cx="{x:.0f}" cy="{y}" r="{radius}"/>' for radius in radii]
        texts.append(_text(x, y + 4, str(number)))
    for (source, target), written in labels.items():
        start, end = order.index(source), order.index(target)
        path, label_y = _edge(xs[start], xs[end], y, len(written), end - start)
        paths.append(_path(path))
        middle = (xs[start] + xs[end]) / 2
        texts += [_text(middle, label_y + LINE * i, line) for i, line in enumerate(written)]
    widest = max((len(text) for text in loops[-1]), default=0) * CHARACTER / 2
    width = max(xs[-1] + max(widest, RADIUS) + 12, 16 + CHARACTER * len(automaton.name))
    steps = [order.index(target) - order.index(source) for source, target in labels]
    below = max(_depth(step) + 30 if step not in (0, 1) else 12 for step in steps)
    return Row("".join(paths + texts), width, y + RADIUS + below)


def _order(automaton: BuchiAutomaton) -> list[int]:
    """The states, in the order in which they are reached from the initial ones."""
    order = sorted(automaton.initial)
    for state in order:  # grows in the loop
        order += sorted({t.target for t in automaton.outgoing[state]} - set(order))
    return order


def _accepting(automaton: BuchiAutomaton) -> frozenset[int]:
    if automaton.marks != 1 or not automaton.has_state_acceptance:
        return frozenset()
    return frozenset(t.source for t in automaton.transitions if t.marks)


def _labels(automaton: BuchiAutomaton) -> dict[tuple[int, int], list[str]]:
    """The labels between each two states, one per line."""
    is_on_states = bool(_accepting(automaton))
    found: dict[tuple[int, int], list[str]] = defaultdict(list)
    for each in automaton.transitions:
        dots = "" if is_on_states else "".join(f" {DOTS[mark]}" for mark in sorted(each.marks))
        found[each.source, each.target].append(f"{each.label}{dots}")
    return dict(found)


def _places(order: list[int], labels: dict[tuple[int, int], list[str]]) -> list[float]:
    """The positions of the states, such that labels do not overlap."""

    def widest(source: int, target: int) -> float:
        texts = labels.get((source, target), []) + (
            labels.get((target, source), []) if source != target else []
        )
        return max((len(text) for text in texts), default=0) * CHARACTER

    xs = [LEFT + max(0.0, widest(order[0], order[0]) / 2 - LEFT + 12)]
    for left, right in pairwise(order):
        loops = (widest(left, left) + widest(right, right)) / 2 + 16
        xs.append(xs[-1] + max(GAP + 2 * RADIUS, loops, widest(left, right) + 2 * RADIUS + 26))
    return xs


def _edge(start: float, end: float, y: float, lines: int, steps: int) -> tuple[str, float]:
    """The path of an edge that ends `steps` states further, and where its label begins."""
    if steps == 0:
        top = y - RADIUS - 30
        curve = f"C{start - 22:.0f} {top} {start + 22:.0f} {top} {start + 8:.0f} {y - 14}"
        return f"M{start - 8:.0f} {y - 14}{curve}", top + 1 - LINE * (lines - 1)
    if steps == 1:
        return f"M{start + RADIUS:.0f} {y}H{end - RADIUS:.0f}", y - 6 - LINE * (lines - 1)
    low = y + RADIUS + _depth(steps)
    if steps == -1:
        curve = f"Q{(start + end) / 2:.0f} {low + _depth(steps)} {end + 8:.0f} {y + 14}"
        return f"M{start - 8:.0f} {y + 14}{curve}", low + 16
    towards = 1 if steps > 0 else -1
    first, last, turn = start + 2 * towards, end - 2 * towards, 12 * towards
    along = f"V{low - 12}Q{first:.0f} {low} {first + turn:.0f} {low}H{last - turn:.0f}"
    up = f"Q{last:.0f} {low} {last:.0f} {low - 12}V{y + RADIUS}"
    return f"M{first:.0f} {y + RADIUS}{along}{up}", low + 16


def _depth(steps: int) -> int:
    """How far an edge extends below the states."""
    return 20 if steps == -1 else 30 + 26 * abs(steps) - (13 if steps > 0 else 0)


def _path(path: str) -> str:
    return f'<path d="{path}" marker-end="url(#a)"/>'


def _text(x: float, y: float, text: str) -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="middle">{escape(text)}</text>'
