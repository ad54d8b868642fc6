"""Small charts as SVG text; the style of the page colours them.

Every number has two decimals, so equal rows give equal bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from companion.campaigns.statistics import Rate

WIDTH, HEIGHT, EDGE = 320.0, 150.0, 26.0
BINS = 20


def n(number: float) -> str:
    """A coordinate.

    >>> n(1.0), n(2.346)
    ('1', '2.35')
    """
    return f"{number:.2f}".rstrip("0").rstrip(".")


def rate_bar(rate: Rate) -> str:
    """A rate with its interval, as a bar from 0 to 100 %."""
    low, share, high = (100 * each for each in (rate.low, rate.share, rate.high))
    return (
        f'<svg class="rate" viewBox="0 0 100 8" preserveAspectRatio="none" role="img" '
        f'aria-label="{escape(str(rate))}"><rect class="ground" width="100" height="8"/>'
        f'<rect class="interval" x="{n(low)}" y="1" width="{n(max(high - low, 0.5))}" height="6"/>'
        f'<rect class="share" x="{n(max(share - 0.4, 0))}" width="0.8" height="8"/></svg>'
    )


def histogram(values: Sequence[float], unit: str, title: str, limit: float | None = None) -> str:
    """How often each range of values occurs, and the limit below which values are bad."""
    low, high = min(values), max(values)
    if limit is not None:
        low, high = min(low, limit), max(high, limit)
    span = (high - low) or 1.0
    counts = [0] * BINS
    for value in values:
        counts[min(int((value - low) / span * BINS), BINS - 1)] += 1
    most, bar = max(counts), (WIDTH - 2 * EDGE) / BINS
    bars = []
    for i, count in enumerate(counts):
        side = _side(low + (i + 0.5) / BINS * span, limit)
        x, height = EDGE + i * bar + 0.5, count / most * (HEIGHT - 2 * EDGE)
        box = f'x="{n(x)}" y="{n(HEIGHT - EDGE - height)}" width="{n(bar - 1)}"'
        bars += [f'<rect class="{side}" {box} height="{n(height)}"/>'] if count else []
    if limit is not None:
        mark = n(EDGE + (limit - low) / span * (WIDTH - 2 * EDGE))
        bars.append(f'<path class="limit" d="M{mark} {n(EDGE - 10)}V{n(HEIGHT - EDGE)}"/>')
    return _framed(
        "".join(bars),
        title,
        left=f"{low:.3g} {unit}",
        right=f"{high:.3g} {unit}",
        top=f"{most} rows",
    )


def scatter(points: Sequence[tuple[float, float, bool]], names: tuple[str, str]) -> str:
    """A point for each row at the values of two factors, marked if it failed."""
    (x_low, x_high), (y_low, y_high) = (
        (min(p[axis] for p in points), max(p[axis] for p in points)) for axis in (0, 1)
    )
    marks = []
    for x, y, is_failure in sorted(points, key=lambda point: point[2]):
        left = EDGE + (x - x_low) / ((x_high - x_low) or 1.0) * (WIDTH - 2 * EDGE)
        top = HEIGHT - EDGE - (y - y_low) / ((y_high - y_low) or 1.0) * (HEIGHT - 2 * EDGE)
        if is_failure:  # another shape too, for readers who cannot tell the colours apart
            marks.append(f'<path class="bad" d="M{n(left - 3)} {n(top - 3)}l6 6m0 -6l-6 6"/>')
        else:
            marks.append(f'<circle class="good" cx="{n(left)}" cy="{n(top)}" r="2"/>')
    title = f"{names[0]} to the right, {names[1]} upwards; crosses failed"
    return _framed("".join(marks), title, f"{x_low:.3g}", f"{x_high:.3g}", f"{y_high:.3g}")


def _side(value: float, limit: float | None) -> str:
    return "bad" if limit is not None and value < limit else "good"


def _framed(inside: str, title: str, left: str, right: str, top: str) -> str:
    base, under, end = n(HEIGHT - EDGE), n(HEIGHT - 8), n(WIDTH - EDGE)
    axis = f'<path class="axis" d="M{n(EDGE)} {n(EDGE)}V{base}H{end}"/>'
    labels = (
        f'<text x="{n(EDGE)}" y="{under}">{escape(left)}</text>'
        f'<text class="end" x="{end}" y="{under}">{escape(right)}</text>'
        f'<text x="{n(EDGE)}" y="{n(EDGE - 8)}">{escape(top)}</text>'
    )
    box = f'viewBox="0 0 {n(WIDTH)} {n(HEIGHT)}" role="img" aria-label="{escape(title)}"'
    return (
        f'<figure><svg class="chart" {box}>{axis}{inside}{labels}</svg>'
        f"<figcaption>{escape(title)}</figcaption></figure>"
    )
