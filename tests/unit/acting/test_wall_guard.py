"""The vehicle itself is kept off walls by its setpoints, whatever it flies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from fakes import on_hold
from rig import Rig
from states import changed
from synthetic import mission

from companion.acting.wall_guard import WallGuard
from companion.flight_events.skills import WallNear
from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import SpeedLimits
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion
from companion.motion.trajectory import AT_REST, Sample
from companion.vehicle.ports.state import VehicleState
from companion.vehicle_profile import VehicleProfile

SETPOINT: Ned = (3.0, 1.0, -2.0)
"""0.7 m from the wall, which ends at east 0.3 m."""
PROFILE = VehicleProfile()


def room() -> OccupancyGrid:
    """6 m wide, with walls 0.3 m thick."""
    occupied = np.ones((60, 60), dtype=np.bool_)
    occupied[3:-3, 3:-3] = False
    return OccupancyGrid(occupied, 0.1, (0.0, 0.0))


def routes(
    *keep_out: tuple[tuple[float, float], ...],
    fence_m: float = 0.0,
    grid: OccupancyGrid | None = None,
) -> LayeredRoutes:
    """A room, and a place in its middle."""
    made = LayeredRoutes(
        grid or room(),
        {"M": PlaceRegion((3.0, 3.0, -2.0), Disc(0.5), is_exclusive=True)},
        ((0.0, fence_m), (0.0, 6.0), (6.0, 6.0), (6.0, fence_m)),
        PROFILE.clearance_m,
        SpeedLimits(2.0, 2.0, 8.0),
        keep_out=keep_out,
    )
    made.find(10**6)
    return made


def at(east_m: float, *, is_landed: bool = False) -> VehicleState:
    return changed(on_hold(0.0), position=(3.0, east_m, -2.0), is_landed=is_landed)


def told(position: Ned = SETPOINT) -> Sample:
    return Sample(position, AT_REST, AT_REST, is_finished=True)


def test_a_setpoint_is_moved_for_a_vehicle_that_drifts_to_a_wall_and_told_of_once() -> None:
    guard = WallGuard(routes(), PROFILE)
    moved, news = guard.kept_off(told(), at(0.85))
    assert moved[1] > SETPOINT[1] and (moved[0], moved[2]) == (3.0, -2.0)
    assert news is None  # it has its margin
    _, news = guard.kept_off(told(), at(0.7))
    assert news == WallNear(0.05)
    assert guard.kept_off(told(), at(0.8))[1] is None
    assert guard.kept_off(told(), at(0.7))[1] is None
    guard.kept_off(told(), at(0.95))
    assert guard.kept_off(told(), at(0.7))[1] is not None


def test_a_vehicle_on_the_ground_or_unknown_moves_nothing() -> None:
    guard = WallGuard(routes(), PROFILE)
    assert guard.kept_off(told(), at(0.7, is_landed=True)) == (SETPOINT, None)
    assert guard.kept_off(told(), None) == (SETPOINT, None)


def test_a_start_beside_a_wall_is_no_deviation() -> None:
    here = (3.0, 0.6, -2.0)
    assert WallGuard(routes(), PROFILE).kept_off(told(here), at(0.6)) == (here, None)


def test_where_the_position_is_good_for_less_it_is_kept_off_earlier() -> None:
    asked, far = routes(), (3.0, 1.6, -2.0)
    assert WallGuard(asked, PROFILE).kept_off(told(far), at(1.3))[0] == far
    asked.add_clearance(0.6)
    assert WallGuard(asked, PROFILE).kept_off(told(far), at(1.3))[0][1] > far[1]


def test_no_setpoint_is_moved_into_a_zone_or_through_the_fence() -> None:
    zone = ((2.0, 1.05), (4.0, 1.05), (4.0, 1.5), (2.0, 1.5))
    assert WallGuard(routes(zone), PROFILE).kept_off(told(), at(0.7))[0] == SETPOINT
    beyond = routes(fence_m=4.0)
    assert WallGuard(beyond, PROFILE).kept_off(told(), at(0.7))[0] == SETPOINT


def test_no_setpoint_is_moved_from_one_wall_into_the_next() -> None:
    """In a passage, with a position that is off by a metre for a moment."""
    occupied = np.ones((60, 60), dtype=np.bool_)
    occupied[:, 10:28] = False
    obstacles = OccupancyGrid(occupied, 0.1, (0.0, 0.0))
    passage, told_m = routes(grid=obstacles), 1.55
    north, east, down = WallGuard(passage, PROFILE).kept_off(told((3.0, told_m, -2.0)), at(2.6))[0]
    assert east < told_m and (north, down) == (3.0, -2.0)
    assert obstacles.clearance_m((north, east)) >= PROFILE.radius_m


def test_what_is_flown_goes_on_from_the_setpoint_as_it_was() -> None:
    rig = Rig(mission("F at(A)"))
    flight, edge = rig.flight, (3.0, -1.0, -2.0)
    flight.routes.find(10**6)
    rig.vehicle.change(position=(3.0, -1.5, -2.0))
    flight.guidance.fly(told(edge))
    assert flight.guidance.setpoint is not None and flight.guidance.setpoint.position == edge
    assert rig.vehicle.setpoint is not None
    assert rig.vehicle.setpoint.position[1] > edge[1]


def test_a_flight_that_is_taken_beside_its_route_keeps_its_margin_to_a_pillar() -> None:
    pillar = np.zeros((100, 100), dtype=np.bool_)
    pillar[48:52, 29:35] = True  # 0.9 m east of the way from H to A
    asked = replace(mission("F at(A)"), grid=OccupancyGrid(pillar, 0.1, (-2.0, -2.0)))
    rig = Rig(asked)
    rig.vehicle.drift = (0.0, 0.6, 0.0)
    rig.begin()
    least_m = 9.0

    def is_over() -> bool:
        nonlocal least_m
        assert rig.vehicle.state is not None
        least_m = min(least_m, asked.grid.clearance_m(rig.vehicle.state.motion.position[:2]))
        return rig.vehicle.state.motion.position[0] > 5.0

    rig.run(is_over)
    assert least_m >= PROFILE.radius_m + PROFILE.margin_m  # 0.3 m, were it not for the guard
    assert not rig.of(WallNear)
