"""The land detector: its table of transitions, and its times."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import GlobalOrigin
from sitl.autopilot.landing import AIRBORNE_S, CONTACT_S, LANDED_S, LandDetector, LandState
from sitl.flight.physics import FlightState, Physics

LANDED, LIFTING_OFF, IN_AIR, GROUND_CONTACT = LandState
STANDING = Physics(origin=GlobalOrigin(47.4, 8.5, 488.0)).state
FLYING = STANDING._replace(is_on_ground=False)
DT_S = 0.05


def after(detector: LandDetector, state: FlightState, seconds: float, climbs: bool = False) -> None:
    for _ in range(round(seconds / DT_S)):
        detector.update(state, climbs, 0.25, DT_S)


def test_a_flight_goes_through_all_states() -> None:
    detector, seen = LandDetector(), [LANDED]
    for state in [STANDING] * 3 + [FLYING] * 40 + [STANDING] * 40:
        after(detector, state, DT_S)
        if detector.state is not seen[-1]:
            seen.append(detector.state)
    assert seen == [LANDED, LIFTING_OFF, IN_AIR, GROUND_CONTACT, LANDED]


def test_a_hop_is_no_take_off() -> None:
    detector = LandDetector()
    after(detector, FLYING, AIRBORNE_S - DT_S)
    assert detector.state is LIFTING_OFF
    after(detector, STANDING, CONTACT_S + DT_S)
    assert detector.state is LANDED


def test_a_bounce_is_no_landing() -> None:
    detector = LandDetector()
    after(detector, FLYING, 1.0)
    after(detector, STANDING, LANDED_S - DT_S)
    assert detector.state is GROUND_CONTACT
    after(detector, FLYING, DT_S)
    assert detector.state is IN_AIR


@pytest.mark.parametrize("moves", [True, False])
def test_a_climb_and_a_fast_descent_are_no_rest(moves: bool) -> None:
    detector = LandDetector()
    after(detector, FLYING, 1.0)
    state = STANDING._replace(velocity=(0.0, 0.0, 0.3)) if moves else STANDING
    after(detector, state, 5.0, climbs=not moves)
    assert detector.state is IN_AIR


def test_one_that_is_not_armed_has_landed_wherever_it_is() -> None:
    """PX4's MulticopterLandDetector: a wreck that hangs on a roof is not waited for."""
    detector, falling = LandDetector(), FLYING._replace(velocity=(0.0, 0.0, 5.0))
    after(detector, falling, 1.0)
    for _ in range(round(LANDED_S / DT_S) + 1):
        detector.update(falling, False, 0.25, DT_S, is_armed=False)
    assert detector.state is LANDED


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.sampled_from([0.0, 1.0])), max_size=80))
def test_flags_and_states_agree(steps: list[tuple[bool, bool, float]]) -> None:
    """Landed is left after AIRBORNE_S off the ground, and reached after LANDED_S of rest."""
    detector, is_landed, rest_s, airborne_s = LandDetector(), True, LANDED_S, 0.0
    for is_on_ground, climbs, sink_mps in steps:
        state = STANDING._replace(is_on_ground=is_on_ground, velocity=(0.0, 0.0, sink_mps))
        detector.update(state, climbs, 0.25, DT_S)
        airborne_s = 0.0 if is_on_ground else airborne_s + DT_S
        is_resting = is_on_ground and not climbs and sink_mps <= 0.25
        rest_s = rest_s + DT_S if is_resting else 0.0
        is_landed = rest_s >= LANDED_S or (is_landed and airborne_s < AIRBORNE_S)
        assert detector.is_landed == is_landed
        assert detector.has_ground_contact == (rest_s >= CONTACT_S)
