"""A new origin of the local frame, also in flight: what the autopilot keeps, and where.

PX4 accepts an origin from any sender (SET_GPS_GLOBAL_ORIGIN). Its local position jumps by the
difference, and so do home, the fence, rally points and the setpoint that it holds. Its modes
continue from the vehicle's place.

Source: PX4 1.16, src/modules/ekf2/EKF/ekf_helper.cpp (setLatLonOrigin), adjustSetpointForEKFResets.
Left out: the items of a mission that was uploaded, which stay where they were.
"""

from __future__ import annotations

from dataclasses import replace

from companion.geofence import FenceArea, FenceCircle
from companion.geometry import Ned, NorthEast
from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.return_destination import SafePoint
from sitl.flight.controllers import HorizontalGains, Maybe, TrajectorySetpoint
from sitl.flight.physics import FlightState


def reframed(before: Autopilot, state: FlightState, gains: HorizontalGains, by: Ned) -> Autopilot:
    """The autopilot in another local frame.

    Args:
        before: the autopilot before.
        state: the present estimate, in the new frame.
        gains: the gains of the horizontal position loops.
        by: what is added to every position.
    """
    after = Autopilot(before.parameters, state, gains)
    after.is_armed, after.is_crashed = before.is_armed, before.is_crashed
    after.control, after.health, after.flights = before.control, before.health, before.flights
    after.mission, after.status_texts = before.mission, before.status_texts
    after.cruise_mps, after.arming_refusal = before.cruise_mps, before.arming_refusal
    after.home = (before.home[0] + by[0], before.home[1] + by[1], before.home[2] + by[2])
    after.fence.areas = tuple(_moved_area(area, by) for area in before.fence.areas)
    after.safe_points = tuple(_moved_point(point, by) for point in before.safe_points)
    if before.mode == "OFFBOARD" and before.control.setpoint is not None:
        after.accept_setpoint(_moved_setpoint(before.control.setpoint, by))
    after.set_mode(before.intended_mode)
    return after


def _moved_setpoint(setpoint: TrajectorySetpoint, by: Ned) -> TrajectorySetpoint:
    north, east, down = (
        None if at is None else at + metres
        for at, metres in zip(setpoint.position, by, strict=True)
    )
    position: Maybe = (north, east, down)
    return replace(setpoint, position=position)


def _moved_point(point: SafePoint, by: Ned) -> SafePoint:
    north, east = point.position
    up_m = point.up_m if point.is_above_home else point.up_m - by[2]
    return replace(point, position=(north + by[0], east + by[1]), up_m=up_m)


def _moved_area(area: FenceArea, by: Ned) -> FenceArea:
    def moved(point: NorthEast) -> NorthEast:
        return (point[0] + by[0], point[1] + by[1])

    shape = area.shape
    if isinstance(shape, FenceCircle):
        return replace(area, shape=replace(shape, centre=moved(shape.centre)))
    return replace(area, shape=replace(shape, corners=tuple(map(moved, shape.corners))))
