"""A marker through its sightings: noise, strays, and what nobody lands on."""

from __future__ import annotations

import math
from random import Random

import pytest

from companion.geometry import Ned
from companion.motion.glide import MOST_MPS2, Glide
from companion.motion.marker_track import (
    FEWEST,
    HEIGHT_M,
    MOVED_M,
    WINDOW_S,
    ExpectedMarker,
    MarkerTrack,
)
from companion.motion.region import Area, Disc

PLACE = (10.0, 5.0, -7.0)
EXPECTED = ExpectedMarker(PLACE, Disc(2.0), 3.0)
MARKER = (10.5, 5.0, -3.0)
EVERY_S = 0.05


def seen(track: MarkerTrack, *positions: Ned, from_s: float = 0.0) -> list[str]:
    """The words of what was refused."""
    taken = [track.take(from_s + EVERY_S * i, p, 0.05) for i, p in enumerate(positions)]
    return [refusal.reason for refusal in taken if refusal]


def test_it_is_seen_from_the_third_sighting_on() -> None:
    track = MarkerTrack(EXPECTED)
    for i in range(FEWEST):
        assert track.position is None and track.age_s(1.0) == math.inf
        seen(track, MARKER, from_s=i * EVERY_S)
    assert track.position == pytest.approx(MARKER)
    assert track.age_s(1.0) == pytest.approx(1.0 - 2 * EVERY_S)


def test_noise_is_averaged_and_strays_move_nothing() -> None:
    track, rng = MarkerTrack(EXPECTED), Random(1)
    positions = [(*(m + rng.gauss(0.0, 0.05) for m in MARKER),) for _ in range(60)]
    for i in range(5, 60, 10):
        positions[i] = (11.5, 5.0, -3.0)
    refused = seen(track, *positions)  # type: ignore[arg-type]
    assert len(refused) == 6 and all("from where it was just before" in why for why in refused)
    assert track.position == pytest.approx(MARKER, abs=0.05)
    assert track.problem is None


@pytest.mark.parametrize(
    ("position", "why"),
    [
        ((12.4, 5.0, -3.0), "2.4 m from its place, outside the region"),
        ((10.0, 5.0, -3.0 + HEIGHT_M + 0.1), "1.9 m above home, not 3.0 m"),
        ((10.0, 5.0, -4.2), "4.2 m above home, not 3.0 m"),
    ],
)
def test_what_is_not_where_the_mission_says_is_refused(position: Ned, why: str) -> None:
    track = MarkerTrack(EXPECTED)
    assert all(why in each for each in seen(track, *[position] * 5))
    assert track.position is None and track.problem is None


def test_a_position_that_is_good_for_less_lets_more_pass() -> None:
    assert EXPECTED.why_not((12.4, 5.0, -3.0), 0.1) is not None
    assert EXPECTED.why_not((12.4, 5.0, -3.0), 0.2) is None


def test_a_region_may_be_a_polygon() -> None:
    expected = ExpectedMarker(PLACE, Area(((9.0, 4.0), (9.0, 6.0), (11.0, 6.0), (11.0, 4.0))), 3.0)
    assert expected.why_not((10.9, 5.9, -3.0), 0.0) is None
    assert expected.why_not((11.1, 5.9, -3.0), 0.0) is not None


def test_a_marker_that_moves_is_landed_on_by_nobody() -> None:
    track = MarkerTrack(EXPECTED)
    for i in range(200):
        seen(track, (9.0 + 0.3 * EVERY_S * i, 5.0, -3.0), from_s=EVERY_S * i)
        if track.problem is not None:
            break
    assert track.problem is not None and "has moved by 1." in track.problem.reason
    assert EVERY_S * i < (MOVED_M + 0.15) / 0.3 + 2 * WINDOW_S


def test_a_marker_that_is_laid_elsewhere_is_too() -> None:
    track = MarkerTrack(EXPECTED)
    seen(track, *[MARKER] * 20)
    seen(track, *[(9.0, 5.0, -3.0)] * 20, from_s=1.0)
    assert track.problem is not None and "laid elsewhere" in track.problem.reason


def test_a_stray_that_comes_first_is_forgotten() -> None:
    track = MarkerTrack(EXPECTED)
    seen(track, (9.0, 5.0, -3.0), *[MARKER] * 10)
    assert track.problem is None
    assert track.position == pytest.approx(MARKER)


def test_one_that_comes_back_a_little_beside_is_the_same() -> None:
    track = MarkerTrack(EXPECTED)
    seen(track, *[MARKER] * 20)
    seen(track, *[(10.0, 5.3, -3.2)] * 20, from_s=10.0)
    assert track.problem is None
    assert track.position == pytest.approx((10.0, 5.3, -3.2))


def test_a_glide_keeps_its_limits_and_stops_at_its_target() -> None:
    glide, before = Glide((0.0, 0.0, -7.0)), (0.0, 0.0, 0.0)
    samples = [glide.step((3.0, -4.0, -3.5), EVERY_S, 1.0, 1.5, 0.8) for _ in range(600)]
    for sample in samples:
        assert math.hypot(*sample.velocity[:2]) <= 1.0 + 1e-9
        assert -1.5 <= sample.velocity[2] <= 0.8 + 1e-9
        assert math.dist(sample.velocity, before) <= MOST_MPS2 * EVERY_S + 1e-9
        assert sample.position[2] <= -3.5 + 1e-3
        before = sample.velocity
    assert samples[-1].position == pytest.approx((3.0, -4.0, -3.5), abs=1e-3)
    assert glide.wait().velocity == (0.0, 0.0, 0.0)
