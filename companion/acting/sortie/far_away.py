"""Explains why a mission does not begin if the vehicle is kilometres from where it has to begin."""

from __future__ import annotations

from companion.errors import Aborted
from companion.geometry import FAR_M, GlobalOrigin, horizontal_distance
from companion.mission.places import Place
from companion.vehicle.ports.frame import FrameLocation
from companion.vehicle.ports.state import VehicleState

_ELSEWHERE = "is it the right mission for this vehicle? companion sim begins where the mission does"


def far_away(
    gap_m: float, state: VehicleState, home: Place, location: FrameLocation | None
) -> Aborted:
    """The refusal, with both positions on the earth if these are known.

    Args:
        gap_m: distance of the vehicle from home.
        state: state of the vehicle.
        home: where the mission begins.
        location: where the frames lie on the earth.
    """
    what = f"the vehicle is {gap_m / 1000:.0f} km from {home.name}, where the mission begins"
    if location is None:
        return Aborted(f"{what}\n    {_ELSEWHERE}")
    vehicle_at, home_at = (
        location.zero.to_global(position)[:2] for position in (state.motion.position, home.position)
    )
    latitude, longitude = (f"{degrees:.6g}" for degrees in home_at)
    what += f": it is at {vehicle_at[0]:.6g}, {vehicle_at[1]:.6g}, and {home.name} is at "
    what += f"{latitude}, {longitude}"
    if _is_exchanged(vehicle_at, home_at):
        return Aborted(f"{what}\n    latitude and longitude are exchanged in one of them")
    simulator = f"sitl --home {latitude},{longitude},ALTITUDE puts a simulated vehicle there"
    return Aborted("\n    ".join([what, _ELSEWHERE, simulator]))


def _is_exchanged(a: tuple[float, float], b: tuple[float, float]) -> bool:
    """Whether one is near the other if its latitude and longitude are exchanged."""
    latitude_deg, longitude_deg = reversed(a)
    there = GlobalOrigin(*b, 0.0).to_local(latitude_deg, longitude_deg, 0.0)
    return abs(latitude_deg) <= 90 and horizontal_distance(there, (0.0, 0.0)) <= FAR_M
