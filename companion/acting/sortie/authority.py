"""Authority over the vehicle: whether it is ours to fly, why not, and when it is ours again.

Control that was lost comes back only with two keys:

1. The vehicle is armed, in the air and on hold (AUTO.LOITER), with a fresh position and a mode that
   was heard just now. Either the pilot has chosen hold, to hand the vehicle over, or the autopilot
   holds because it no longer heard us (stream_loss.py).
2. The operator says "go on", or has said so beforehand for a hold of the second kind.
"""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.acting.plan_progress import GroundState
from companion.acting.sortie.far_away import far_away
from companion.acting.sortie.phases import ON_THE_GROUND, UNDER_TASK
from companion.errors import Aborted, CompanionError, LinkError
from companion.flight_events.sortie import Phase
from companion.geofence import KeptFence
from companion.geometry import FAR_M, is_in_polygon
from companion.mission.first_place import as_begun_at_zero, begins_at_zero
from companion.mission.places import Limits, Place
from companion.motion.position_error import EXACT_M, greatest_error_m
from companion.outcomes import Refusal
from companion.vehicle.ports.frame import Anchoring, FrameLocation
from companion.vehicle.ports.state import Mode, VehicleState

LINK_LOST_S = 10.0
"""Silence after which a sortie is given up, if the vehicle was on the ground and disarmed."""
NEVER_BACK_S = 1800.0
"""The same for a vehicle in the air: no battery lasts longer."""
SILENT_S = 3.0
"""Silence after which we wait for a vehicle in the air: nothing is sent, and no time counts."""
ASTRAY_M = 1.0
"""How far above the altitudes of the mission a vehicle on hold may be, by its own errors."""
LANDING_M = 1.0
"""How much further away an autopilot with a wrong velocity estimate may land. In PX4's own
simulator it is wrong by 0.4 m/s, for the 6 s that a landing from 2 m takes."""
LAID_BEFORE = "an earlier flight has begun there; restart the autopilot to begin elsewhere"
AT_ZERO = "it stands at its autopilot's home position, and that is [0, 0] of the mission"
UNNOTICED = "the autopilot goes on landing; where the vehicle stands already, disarm it by hand"
RESTARTED = "the autopilot has restarted"
FRESH_S = 0.5
"""Age of the position up to which an operator may give control back."""


def loss_of_link(state: VehicleState, now_s: float) -> LinkError | None:
    """An error if the vehicle has been silent for too long; None if it has not."""
    silence_s = state.motion.silence_s(now_s)
    if silence_s <= (LINK_LOST_S if state.is_standing else NEVER_BACK_S):
        return None
    return LinkError(f"no position from the vehicle for {silence_s:.0f} s")


def why_left_alone(state: VehicleState | None, now_s: float) -> Refusal | None:
    """Why no run may begin with this vehicle; None if one may."""
    if state is None or loss_of_link(state, now_s):
        return Refusal("the vehicle's state is not known")
    if not state.is_standing:
        return Refusal("the vehicle is armed or flying already; it is left alone")
    return None


def not_at_home(
    gap_m: float,
    state: VehicleState,
    home: Place,
    anchoring: Anchoring = Anchoring.BY_VEHICLE,
    location: FrameLocation | None = None,
) -> Aborted | None:
    """Returns why the mission may not begin where the vehicle stands; None if it may.

    The error of the position is added to the radius of home: a vehicle that has landed there, with
    an estimate that wanders, stands beside it and may begin again. If home does not move with the
    vehicle, it may have landed further away.

    Args:
        gap_m: distance of the vehicle from home.
        state: state of the vehicle.
        home: where the mission begins.
        anchoring: what decides where home lies.
        location: where the frames lie on the earth, if that is known.
    """
    is_fixed = anchoring is not Anchoring.BY_VEHICLE
    landing_m = LANDING_M if is_fixed and state.motion.accuracy_m > EXACT_M else 0.0
    if gap_m <= home.inner_m + greatest_error_m(state.motion.accuracy_m) + landing_m:
        return None
    if gap_m > FAR_M:
        return far_away(gap_m, state, home, location)
    what = f"the vehicle stands {gap_m:.1f} m from {home.name}, where the mission begins"
    advice = _way_out(state, home, anchoring)
    return Aborted("\n    ".join([f"{what}; put it there", *advice]))


def _way_out(state: VehicleState, home: Place, anchoring: Anchoring) -> list[str]:
    """What to do instead of carrying the vehicle to where the mission begins."""
    if anchoring is Anchoring.RECALLED:
        return [LAID_BEFORE]
    near_m = home.inner_m + greatest_error_m(state.motion.accuracy_m)
    is_at_zero = math.hypot(*state.motion.position[:2]) <= near_m
    if anchoring is Anchoring.FIXED or not is_at_zero or begins_at_zero(home):
        return []
    return [AT_ZERO, f"if that is {home.name}, {as_begun_at_zero(home)}"]


def loss_of_control(phase: Phase, state: VehicleState, flight: Flight) -> CompanionError | None:
    """Why the sortie is no longer ours to fly, or never was."""
    if silence := loss_of_link(state, flight.now_s):
        return silence
    if flight.vehicle.goals.has_restarted:
        return Aborted(RESTARTED)
    if takeover := flight.vehicle.control.takeover:
        return Aborted(str(takeover))
    if phase in ON_THE_GROUND and not state.is_standing:
        return Aborted("the vehicle is armed or flying already; it is left alone")
    is_flying = phase in (Phase.OFFBOARD, *UNDER_TASK, Phase.HOLDING)
    is_stopped = flight.progress.ground is GroundState.DISARMED
    if (unnoticed := flight.progress.unnoticed_landing) is not None:
        return Aborted(f"{unnoticed.reason}\n    {UNNOTICED}")
    is_down_by_plan = flight.progress.is_landed_by_plan and not is_stopped
    if is_flying and state.is_standing and not is_down_by_plan:
        return Aborted("the vehicle was disarmed")
    if phase is Phase.OFFBOARD and state.is_landed and not flight.progress.is_landed_by_plan:
        return Aborted("the vehicle has landed")  # a pilot has, and gave it back on the ground
    return None


def is_silent(state: VehicleState, now_s: float) -> bool:
    """Whether nothing is heard of a vehicle in the air for some seconds."""
    return state.motion.silence_s(now_s) > SILENT_S and not state.is_landed


def not_handed_over(
    state: VehicleState | None,
    now_s: float,
    is_hold_by_stream_loss: bool,
    limits: Limits,
    kept: KeptFence | None = None,
) -> Refusal | None:
    """Returns why control may not be taken back now; None if it may.

    Args:
        state: state of the vehicle.
        now_s: the present time.
        is_hold_by_stream_loss: whether the autopilot holds only because it no longer heard us.
        limits: of the mission; the gate passes no setpoint far above or outside of them.
        kept: the autopilot's own fence, if the flight keeps to it as well.
    """
    if state is None or state.motion.age_s(now_s) > FRESH_S:
        return Refusal("no fresh position")
    if not state.is_flying:
        return Refusal("the vehicle is not in the air")
    if not state.heartbeat.is_recent(now_s):
        return Refusal("the mode is not known")
    if state.heartbeat.is_failsafe and not is_hold_by_stream_loss:
        return Refusal("a failsafe of the autopilot is active")
    if (mode := state.heartbeat.mode) is not Mode.LOITER:
        return Refusal(f"{mode.value} is flown; the pilot hands over by choosing hold")
    up_m, (_, ceiling_m) = -state.motion.position[2], limits.up_m
    if up_m > ceiling_m + ASTRAY_M:
        above = f"the vehicle is {up_m:.1f} m up, and the mission stays below {ceiling_m:g} m"
        return Refusal(f"{above}; bring it down first")
    if not is_in_polygon(state.motion.position, limits.fence):
        return Refusal("the vehicle is outside the mission's fence; bring it back first")
    if kept is not None and not kept.allows(state.motion.position):
        return Refusal("the vehicle is outside the autopilot's own fence; bring it back first")
    return None
