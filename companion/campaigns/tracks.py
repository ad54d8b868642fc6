"""Simplifies the track of a flight, for its picture (Ramer, 1972; Douglas and Peucker, 1973)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

OFF_M = 0.05
"""Largest distance of the flown track from the simplified one."""
CENTIMETRES = 2


def simplified(
    track: Sequence[tuple[float, float]], off_m: float = OFF_M
) -> tuple[tuple[float, float], ...]:
    """The points, rounded to centimetres, that suffice to stay within `off_m` of a track.

    >>> simplified([(0.0, 0.0), (1.0, 0.01), (2.0, 0.0), (2.0, 2.0)])
    ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0))
    """
    if len(track) < 3:
        return _in_centimetres(track)
    points = np.array(track)
    kept = {0, len(points) - 1}
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        leg = points[last] - points[first]
        inner = points[first + 1 : last] - points[first]
        length = float(leg @ leg)
        share = np.clip(inner @ leg / length, 0.0, 1.0) if length > 0 else np.zeros(len(inner))
        away_m = np.linalg.norm(inner - share[:, None] * leg, axis=1)
        furthest = int(away_m.argmax())
        if away_m[furthest] > off_m:
            middle = first + 1 + furthest
            kept.add(middle)
            spans += [(first, middle), (middle, last)]
    return _in_centimetres([track[i] for i in sorted(kept)])


def _in_centimetres(track: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    return tuple((round(x, CENTIMETRES) + 0.0, round(y, CENTIMETRES) + 0.0) for x, y in track)
