"""Pictures of short flights as SVG: the track from above, and beside it the word.

The track has an arrow to each position, whose number is at its place. Beside it are the positions
with their times and letters, as the automata read them, and the events between them. The loop of
the plan, which is flown for ever, is marked on its left by a line with an omega.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from html import escape
from itertools import pairwise
from math import dist
from typing import NamedTuple

from svg_picture import svg_picture

from companion import FlightResult
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.word import PositionLeft
from companion.geometry import Ned, enu_from_ned
from companion.mission.facts import AT, Fact

SCALE, MARGIN, LINE, TOP, CHARACTER = 5.0, 48.0, 17, 24, 7.3
"""Pixels: per metre, around the places, of a line and before the first one, of a character."""
RADIUS, HEAD, STEP = 5, 20, 20
"""Pixels of a place, and of the straight end of an arrow; ticks between two points."""
STYLE = (
    "text{font:12px monospace;fill:#222;paint-order:stroke;stroke:#fff;stroke-width:4}"
    ".n{font-weight:bold}.e{fill:#b84a00}circle{fill:#fff;stroke:#222;stroke-width:1.4}"
    "path{fill:none;stroke:#0065a3;stroke-width:1.6;stroke-linejoin:round}.a{fill:#0065a3;stroke:none}"
    ".w{stroke:#222}"
)
ARROW = (
    '<marker id="a" viewBox="0 0 8 8" refX="12" refY="4" markerWidth="8" markerHeight="8" '
    'markerUnits="userSpaceOnUse" orient="auto"><path class="a" d="M0 0L8 4L0 8z"/></marker>'
)


Pixel = Callable[[Ned], tuple[float, float]]
"""Converts a position to its pixel."""


class Row(NamedTuple):
    """A position with its number, or an event without one, at a time."""

    time_s: float
    number: int | None
    text: str


def picture(flight: FlightResult) -> str:
    """The flight from the beginning of its task to its last position."""
    positions = [each.event for each in flight.events if isinstance(each.event, PositionLeft)]
    rows = _rows(flight, positions)
    places = [place.position for place in flight.mission.places.values()]
    easts, norths, _ = zip(*map(enu_from_ned, places), strict=True)
    west, north = min(easts), max(norths)

    def pixel(ned: Ned) -> tuple[float, float]:
        east_m, north_m, _ = enu_from_ned(ned)
        return MARGIN + (east_m - west) * SCALE, 0.8 * MARGIN + (north - north_m) * SCALE

    left = 2 * MARGIN + (max(easts) - west) * SCALE + 12
    parts = [*_way(flight, positions, pixel), *_places(flight, positions, pixel)]
    parts += _table(rows, left, len(positions) - loop_of(flight))
    width = left + CHARACTER * (11 + max(len(row.text) for row in rows))
    height = max(1.6 * MARGIN + (north - min(norths)) * SCALE, TOP + LINE * len(rows))
    return svg_picture(parts, width, height, style=STYLE, definitions=ARROW)


def loop_of(flight: FlightResult) -> int:
    """How many of the last positions are repeated for ever."""
    *_, last = (e.event for e in flight.events if isinstance(e.event, PositionLeft))
    *_, plan = (e.event.plan for e in flight.events if isinstance(e.event, PlanMade | PlanReplaced))
    return 1 if last.for_ever else len(plan.loop)


def _rows(flight: FlightResult, positions: Sequence[PositionLeft]) -> list[Row]:
    """The positions, and the events until the last one, in the order of time."""
    rows = [Row(p.reached_s, p.number, ", ".join(p.facts)) for p in positions]
    rows += [
        Row(each.time_s, None, each.event.words)
        for each in flight.events
        if isinstance(each.event, MissionEventChanged) and each.time_s <= positions[-1].reached_s
    ]
    return sorted(rows, key=lambda row: row.time_s)


def _way(flight: FlightResult, positions: Sequence[PositionLeft], pixel: Pixel) -> Iterator[str]:
    """An arrow to each position at another place, through the vehicle's position in each second."""
    track = flight.trajectory
    for start, end in pairwise(positions):
        chosen = (track.times_s >= start.reached_s) & (track.times_s <= end.reached_s)
        points = [pixel(tuple(each)) for each in track.positions[chosen][::STEP]]
        if place_of(start) != place_of(end):
            goal = pixel(_where(flight, end))
            points = [*(each for each in points if dist(each, goal) > HEAD), goal]
            path = "L".join(dict.fromkeys(f"{x:.0f} {y:.0f}" for x, y in points))
            yield f'<path d="M{path}" marker-end="url(#a)"/>'


def _places(flight: FlightResult, positions: Sequence[PositionLeft], pixel: Pixel) -> Iterator[str]:
    """Each place with its name, and the numbers of its positions; also positions between places."""
    numbers: dict[tuple[float, float], list[str]] = defaultdict(list)
    for name, place in flight.mission.places.items():
        x, y = pixel(place.position)
        numbers[x, y] = []
        yield f'<circle cx="{x:.0f}" cy="{y:.0f}" r="{RADIUS}"/>'
        yield _text(x, y + 20, name, "middle")
    for each in positions:
        numbers[pixel(_where(flight, each))].append(str(each.number))
    top, middle = min(y for _, y in numbers), sum(x for x, _ in numbers) / len(numbers)
    for (x, y), here in numbers.items():
        if y == top:
            yield _text(x, y - 11, " ".join(here), "middle", "n")
        else:
            side, anchor = (-10, "end") if x < middle else (10, "start")
            yield _text(x + side, y + 4, " ".join(here), anchor, "n")


def _where(flight: FlightResult, position: PositionLeft) -> Ned:
    """The position of a place, or of the vehicle between places."""
    if place := flight.mission.places.get(place_of(position)):
        return place.position
    track = flight.trajectory
    north, east, down = track.positions[track.times_s.searchsorted(position.reached_s)]
    return float(north), float(east), float(down)


def _table(rows: Sequence[Row], left: float, first_looped: int) -> Iterator[str]:
    """Number, time and letter of each position; time and name of each event."""
    for i, row in enumerate(rows):
        y = TOP + LINE * i
        if row.number is not None:
            yield _text(left, y, str(row.number), "end", "n")
        yield _text(left + 50, y, f"{row.time_s:.1f} s", "end")
        yield _text(left + 62, y, row.text, "start", "e" if row.number is None else "l")
    looped = next(i for i, row in enumerate(rows) if row.number == first_looped)
    top, bottom = TOP + LINE * looped - 12, TOP + LINE * (len(rows) - 1) + 4
    yield f'<path class="w" d="M{left - 20:.0f} {top}V{bottom}"/>'
    yield _text(left - 26, (top + bottom) / 2 + 4, "ω", "end", "n")


def place_of(position: PositionLeft) -> str:
    """The name of the place, or `here` between places."""
    facts = map(Fact.parse, position.facts)
    return next(fact.arguments[0] for fact in facts if fact.predicate == AT)


def _text(x: float, y: float, text: str, anchor: str, kind: str = "") -> str:
    about = f' class="{kind}"' if kind else ""
    place = f'x="{x:.0f}" y="{y:.0f}"'
    return f'<text {place} text-anchor="{anchor}"{about}>{escape(text)}</text>'
