"""Who may fly, by the bounds themselves: scripts/mutate looks for those that no test here finds."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from fakes import on_hold
from states import changed

from companion.acting.plan_progress import GroundState, PlanProgress
from companion.acting.sortie.authority import (
    is_silent,
    loss_of_control,
    loss_of_link,
    not_at_home,
    not_handed_over,
    why_left_alone,
)
from companion.errors import CompanionError, LinkError
from companion.flight_events.sortie import Phase
from companion.geofence import KeptFence
from companion.geometry import GlobalOrigin
from companion.mission.places import Limits, Place
from companion.motion.position_error import greatest_error_m
from companion.motion.region import Disc
from companion.outcomes import Failed, Refusal
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.frame import Anchoring, FrameLocation
from companion.vehicle.ports.state import Mode, VehicleState

NOW_S = 10_000.0
FLYING = on_hold(NOW_S)
STANDING = changed(FLYING, is_armed=False, is_landed=True)
ABOUT_TO_FLY = replace(FLYING, is_landed=True)
HOME = Place("Home", (0.0, 0.0, -2.0), Disc(0.4))
EPSILON = 1e-6
LIMITS = Limits(2.0, (0.5, 4.0), ((-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)))


def flight(
    takeover: Takeover | None = None,
    is_landed_by_plan: bool = False,
    unnoticed: Failed | None = None,
    has_restarted: bool = False,
) -> Any:
    return SimpleNamespace(
        now_s=NOW_S,
        vehicle=SimpleNamespace(
            control=SimpleNamespace(takeover=takeover),
            goals=SimpleNamespace(has_restarted=has_restarted),
        ),
        progress=PlanProgress(
            ground=GroundState.ON_GROUND if is_landed_by_plan else GroundState.IN_AIR,
            unnoticed_landing=unnoticed,
        ),
    )


def reason(why: CompanionError | Refusal | None) -> str | None:
    if isinstance(why, Refusal):
        return why.reason
    return None if why is None else str(why)


# -- the link --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("state", "bound_s"), [(STANDING, 10.0), (ABOUT_TO_FLY, 1800.0), (FLYING, 1800.0)]
)
def test_only_what_stands_disarmed_is_given_up_soon(state: VehicleState, bound_s: float) -> None:
    assert loss_of_link(changed(state, motion_received_s=NOW_S - bound_s), NOW_S) is None
    loss = loss_of_link(changed(state, motion_received_s=NOW_S - bound_s - EPSILON), NOW_S)
    assert isinstance(loss, LinkError)
    assert str(loss) == f"no position from the vehicle for {bound_s:.0f} s"


UNKNOWN = "the vehicle's state is not known"
IN_USE = "the vehicle is armed or flying already; it is left alone"


@pytest.mark.parametrize(
    ("state", "why"),
    [
        (STANDING, None),
        (None, UNKNOWN),
        (changed(STANDING, motion_received_s=NOW_S - 11.0), UNKNOWN),
        (ABOUT_TO_FLY, IN_USE),
        (changed(FLYING, is_armed=False), IN_USE),
        (FLYING, IN_USE),
    ],
)
def test_a_run_begins_with_what_stands_disarmed(
    state: VehicleState | None, why: str | None
) -> None:
    assert reason(why_left_alone(state, NOW_S)) == why


def test_a_vehicle_that_was_disarmed_in_the_air_may_still_be_heard() -> None:
    falling = changed(FLYING, is_armed=False, motion_received_s=NOW_S - 11.0)
    assert loss_of_link(falling, NOW_S) is None


def test_what_is_not_heard_in_the_air_is_waited_for() -> None:
    assert not is_silent(changed(FLYING, motion_received_s=NOW_S - 3.0), NOW_S)
    assert is_silent(changed(FLYING, motion_received_s=NOW_S - 3.0 - EPSILON), NOW_S)
    assert not is_silent(changed(ABOUT_TO_FLY, motion_received_s=NOW_S - 60.0), NOW_S)


# -- home ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("accuracy_m", [0.0, 0.3])
def test_home_is_as_wide_as_its_radius_and_what_the_position_may_be_off_by(
    accuracy_m: float,
) -> None:
    state = changed(STANDING, accuracy_m=accuracy_m)
    wide_m = HOME.inner_m + greatest_error_m(accuracy_m)
    assert not_at_home(wide_m, state, HOME) is None
    assert reason(not_at_home(wide_m + EPSILON, state, HOME)) == (
        f"the vehicle stands {wide_m:.1f} m from Home, where the mission begins; put it there"
    )


@pytest.mark.parametrize(("accuracy_m", "further_m"), [(0.1, 0.0), (0.3, 1.0)])
def test_where_no_map_goes_along_it_may_have_landed_further_away(
    accuracy_m: float, further_m: float
) -> None:
    state = changed(STANDING, accuracy_m=accuracy_m)
    wide_m = HOME.inner_m + greatest_error_m(accuracy_m) + further_m
    assert not_at_home(wide_m, state, HOME, Anchoring.FIXED) is None
    refused = not_at_home(wide_m + EPSILON, state, HOME, Anchoring.RECALLED)
    assert reason(refused) == (
        f"the vehicle stands {wide_m:.1f} m from Home, where the mission begins; put it there\n"
        "    an earlier flight has begun there; restart the autopilot to begin elsewhere"
    )


@pytest.mark.parametrize("accuracy_m", [0.0, 0.3])
def test_who_stands_at_zero_of_a_mission_that_begins_elsewhere_is_told_what_to_write(
    accuracy_m: float,
) -> None:
    """He may stand at its home, or at its zero: nobody knows, and walls go along with that."""
    home = replace(HOME, position=(3.0, -8.5, -2.0))
    refused = "the vehicle stands 9.0 m from Home, where the mission begins; put it there"
    at_zero = changed(STANDING, accuracy_m=accuracy_m, position=(0.2, 0.0, 0.0))
    assert reason(not_at_home(9.0, at_zero, home)) == (
        f"{refused}\n    it stands at its autopilot's home position, and that is [0, 0] of the"
        " mission\n    if that is Home, write 8.5 m more for all that is east, and 3 m"
        " less for all that is north, its map included"
    )
    carried = changed(at_zero, position=(4.0, 0.0, 0.0))
    assert reason(not_at_home(9.0, carried, home)) == refused
    assert reason(not_at_home(9.0, at_zero, home, Anchoring.FIXED)) == refused
    assert reason(not_at_home(9.0, at_zero, HOME)) == refused


@pytest.mark.parametrize("gap_m", [10_000.0, 10_001.0, 123_400.0])
def test_a_home_that_is_further_than_ten_kilometres_is_a_slip(gap_m: float) -> None:
    told = reason(not_at_home(gap_m, STANDING, HOME))
    assert told is not None
    if gap_m == 10_000.0:
        assert told.startswith("the vehicle stands 10000.0 m from Home")
    else:
        far = f"the vehicle is {gap_m / 1000:.0f} km from Home, where the mission begins"
        assert told.splitlines()[0] == far
        assert "exchanged" not in told


@pytest.mark.parametrize(
    ("home_at", "remedy"),
    [
        ((-33.4497, -70.6995), "sitl --home -33.4497,-70.6995,ALTITUDE puts a simulated"),
        ((8.54559, 47.3977), "latitude and longitude are exchanged in one of them"),
        ((48.5, 108.6), "is it the right mission for this vehicle?"),
    ],
)
def test_where_both_are_is_told_of_a_vehicle_far_away(
    home_at: tuple[float, float], remedy: str
) -> None:
    zero = GlobalOrigin(*home_at, 488.0)
    state = changed(STANDING, position=zero.to_local(47.3977, 8.54559, 488.0))
    location = FrameLocation(zero, zero, is_asked_for=True, residual_m=0.0)
    told = reason(not_at_home(9e6, state, HOME, location=location))
    assert told is not None
    here, there = "47.3977, 8.54559", ", ".join(f"{degrees:g}" for degrees in home_at)
    assert f"where the mission begins: it is at {here}, and Home is at {there}\n" in told
    assert remedy in told
    assert ("exchanged" in told) is ("exchanged" in remedy)


# -- control ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", list(Phase))
def test_silence_and_a_takeover_end_it_in_every_phase(phase: Phase) -> None:
    silent = changed(FLYING, motion_received_s=NOW_S - 1801.0)
    pilot = Takeover(Mode.POSCTL, is_failsafe=False)
    assert isinstance(loss_of_control(phase, silent, flight(pilot)), LinkError)
    assert reason(loss_of_control(phase, FLYING, flight(pilot))) == str(pilot)


@pytest.mark.parametrize("phase", list(Phase))
@pytest.mark.parametrize("state", [FLYING, STANDING])
def test_one_whose_autopilot_has_restarted_is_not_flown(phase: Phase, state: VehicleState) -> None:
    """Whoever has it then, and wherever the plan has it."""
    pilot = Takeover(Mode.LOITER, is_failsafe=False)
    restarted = flight(pilot, is_landed_by_plan=True, has_restarted=True)
    assert reason(loss_of_control(phase, state, restarted)) == "the autopilot has restarted"


@pytest.mark.parametrize("phase", list(Phase))
@pytest.mark.parametrize(
    ("state", "on_the_ground"),
    [
        (STANDING, None),
        (FLYING, "the vehicle is armed or flying already; it is left alone"),
        (ABOUT_TO_FLY, "the vehicle is armed or flying already; it is left alone"),
        (
            replace(STANDING, is_landed=False),
            "the vehicle is armed or flying already; it is left alone",
        ),
    ],
)
def test_what_each_phase_may_find(
    phase: Phase, state: VehicleState, on_the_ground: str | None
) -> None:
    """What flies on the ground is left alone; what stands in flight was disarmed by somebody."""
    in_flight = (Phase.OFFBOARD, Phase.TASK, Phase.PAUSED, Phase.RETURNING, Phase.HOLDING)
    found = reason(loss_of_control(phase, state, flight()))
    if phase in (Phase.WAITING, Phase.CHECKING):
        assert found == on_the_ground
    elif phase in in_flight and state == STANDING:
        assert found == "the vehicle was disarmed"
        assert loss_of_control(phase, state, flight(is_landed_by_plan=True)) is None
    elif phase is Phase.OFFBOARD and state == ABOUT_TO_FLY:
        assert found == "the vehicle has landed", "a pilot gave it back as he landed"
    else:
        assert found is None


def test_a_landing_that_the_autopilot_does_not_notice_ends_the_sortie() -> None:
    landing = flight(unnoticed=Failed("still on its way down"))
    assert reason(loss_of_control(Phase.TASK, FLYING, landing)) == (
        "still on its way down\n"
        "    the autopilot goes on landing; where the vehicle stands already, disarm it by hand"
    )


# -- handing over ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("state", "why"),
    [
        (None, "no fresh position"),
        (changed(FLYING, motion_measured_s=NOW_S - 0.5), None),
        (changed(FLYING, motion_measured_s=NOW_S - 0.5 - EPSILON), "no fresh position"),
        (STANDING, "the vehicle is not in the air"),
        (ABOUT_TO_FLY, "the vehicle is not in the air"),
        (changed(FLYING, is_armed=False), "the vehicle is not in the air"),
        (changed(FLYING, heartbeat_received_s=NOW_S - 1.5), None),
        (changed(FLYING, heartbeat_received_s=NOW_S - 1.5 - EPSILON), "the mode is not known"),
        (changed(FLYING, heartbeat_received_s=-math.inf), "the mode is not known"),
        (
            changed(FLYING, mode=Mode.POSCTL),
            "POSCTL is flown; the pilot hands over by choosing hold",
        ),
        (
            changed(FLYING, mode=Mode.OFFBOARD),
            "OFFBOARD is flown; the pilot hands over by choosing hold",
        ),
        (FLYING, None),
    ],
)
def test_when_control_may_be_taken_back(state: VehicleState | None, why: str | None) -> None:
    assert reason(not_handed_over(state, NOW_S, False, LIMITS)) == why
    assert reason(not_handed_over(state, NOW_S, True, LIMITS)) == why


def test_of_failsafes_only_the_loss_of_our_stream_is_no_obstacle() -> None:
    held = changed(FLYING, is_failsafe=True)
    assert (
        reason(not_handed_over(held, NOW_S, False, LIMITS))
        == "a failsafe of the autopilot is active"
    )
    assert not_handed_over(held, NOW_S, True, LIMITS) is None


def test_what_a_return_has_carried_far_above_the_mission_is_to_be_brought_down() -> None:
    """There no setpoint would pass the gate."""

    def why(up_m: float) -> str | None:
        return reason(
            not_handed_over(changed(FLYING, position=(0.0, 0.0, -up_m)), NOW_S, True, LIMITS)
        )

    assert why(4.0 + 1.0) is None
    assert why(4.0 + 1.0 + EPSILON) == (
        "the vehicle is 5.0 m up, and the mission stays below 4 m; bring it down first"
    )


def test_what_is_outside_the_fence_is_to_be_brought_back() -> None:
    """A breach that the autopilot holds may follow on an interruption of our stream."""

    def why(north: float) -> str | None:
        state = changed(FLYING, position=(north, 0.0, -2.0))
        return reason(not_handed_over(state, NOW_S, True, LIMITS))

    assert why(9.0 - EPSILON) is None
    assert why(9.0 + EPSILON) == "the vehicle is outside the mission's fence; bring it back first"


def test_nor_is_it_taken_back_outside_a_fence_that_the_autopilot_keeps() -> None:
    kept = KeptFence((((-5.0, -5.0), (-5.0, 5.0), (5.0, 5.0), (5.0, -5.0)),), ())

    def why(north: float) -> str | None:
        state = changed(FLYING, position=(north, 0.0, -2.0))
        return reason(not_handed_over(state, NOW_S, True, LIMITS, kept))

    assert why(5.0 - EPSILON) is None
    outside = "the vehicle is outside the autopilot's own fence; bring it back first"
    assert why(5.0 + EPSILON) == outside
