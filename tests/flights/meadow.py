"""A meadow, and what a ground station has drawn there: missions and flights of fences' tests."""

from __future__ import annotations

from typing import Any

from lockstep import VEHICLE, Lockstep
from moves import MOVE

from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.flights.simulated_world import world_of
from companion.geometry import Ned
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.vehicle.flight_memory import FlightMemory
from sitl.world.scenario import PX4_HOME

SQUARE = ((-15.0, -15.0), (-15.0, 35.0), (15.0, 35.0), (15.0, -15.0))
"""North and east."""
POND = ((5.0, 5.0), (5.0, 10.0), (10.0, 10.0), (10.0, 5.0))
POLYGON, CIRCLE = dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 5003


DATA: dict[str, Any] = {
    "version": 1,
    "name": "meadow",
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 3, "radius_m": 2},
        "A": {"east_m": 20, "north_m": 0, "up_m": 3},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": {"move": MOVE},
    "initially": ["at(Home)"],
    "task": {"visit": "F at(A) & F G at(Home)"},
}


def mission(fence: tuple[tuple[float, float], ...] = SQUARE, **limits: Any) -> Mission:
    """Home, and A 20 m east of it."""
    bounds = {"speed_mps": 4, "up_m": [1, 10], "fence": [[e, n] for n, e in fence]} | limits
    return load_mission(DATA | {"limits": bounds})


def stay(*steps: str, tries: int = 1) -> Mission:
    """From Home to A, and there a skill of these steps, such as one that lands."""
    skill = {"precondition": "at(A)", "effect": "done", "cost": 40, "execute": [*steps]}
    skill |= {"tries": tries}
    fence = [[-9, -9], [29, -9], [29, 9], [-9, 9]]
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": fence}
    skills = {"skills": DATA["skills"] | {"stay": skill}}
    return load_mission(DATA | skills | {"limits": limits, "task": {"stay": "F done"}})


MEADOW = mission(keep_out={"Pond": [[e, n] for n, e in POND]})


def start(
    asked: Mission = MEADOW,
    policy: UploadPolicy = UploadPolicy.UPLOAD,
    own: FlightMemory | None = None,
    **options: Any,
) -> Lockstep:
    """On its way, beside a ground station."""
    arming = ArmingTerms(fence=policy)
    usual: dict[str, Any] = {"has_station": True, "arming": arming, "memory": own}
    return Lockstep(asked, world_of(asked, None), **usual | options)


def station_uploads(flight: Lockstep, *items: tuple[int, float, Ned]) -> None:
    """A ground station writes a fence of (command, param1, point)."""
    upload(flight, *((command, first, PX4_HOME.to_global(at)) for command, first, at in items))


def upload(flight: Lockstep, *items: tuple[int, float, tuple[float, float, float]]) -> None:
    """The same with latitudes and longitudes."""
    kind = dialect.MAV_MISSION_TYPE_FENCE
    flight.is_companion_alive = False
    flight.run(0.2)
    flight.station_says(dialect.MAVLink_mission_count_message(VEHICLE, 1, len(items), kind))
    for seq, (command, first, (lat_deg, lon_deg, _)) in enumerate(items):
        flight.run(0.05)
        x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
        head = (VEHICLE, 1, seq, dialect.MAV_FRAME_GLOBAL, command, 0, 1, first, 0.0, 0.0, 0.0)
        flight.station_says(dialect.MAVLink_mission_item_int_message(*head, x, y, 0.0, kind))
    flight.run(0.2)
    flight.is_companion_alive = True


def areas(flight: Lockstep) -> tuple[Any, ...]:
    """Those that the autopilot has in force."""
    return flight.simulation._autopilot.fence.areas


def armed(flight: Lockstep) -> Lockstep:
    return flight.until_reported(PhaseEntered, 60.0, phase=Phase.ARMING)


def refused(flight: Lockstep) -> str:
    flight.until_the_end()
    assert flight.armings == 0 and flight.exit_code == 5
    return flight.ending.text


def push_out(flight: Lockstep) -> None:
    """Another sender tells the autopilot to fly away, in this tick."""
    mask, frame = 0b110111111000, dialect.MAV_FRAME_LOCAL_NED
    flight.station_says(
        dialect.MAVLink_set_position_target_local_ned_message(
            0, VEHICLE, 1, frame, mask, -40.0, 10.0, -3.0, 0, 0, 0, 0, 0, 0, 0, 0
        )
    )
