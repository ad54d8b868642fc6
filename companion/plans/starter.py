"""A commented mission as a starting point, and its world: for `companion new`.

The user chooses a space and a task. Each pair gives a complete mission, which passes the check and
flies in the simulator as it is. Places have the names that the task uses; the user replaces their
coordinates. starter_tasks.py has the texts of the tasks.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from companion.geometry import GlobalOrigin
from companion.plans.starter_tasks import TASKS, StarterTask, TaskName

PX4_HOME = GlobalOrigin(47.397742, 8.545594, 488.0)
"""Where PX4's simulators start."""


class StarterSpace(StrEnum):
    """Where a mission is flown."""

    HALL = "hall"
    FIELD = "field"
    EARTH = "earth"


SPACES = {
    StarterSpace.HALL: "indoors, with walls",
    StarterSpace.FIELD: "outdoors, in metres from home, without a map",
    StarterSpace.EARTH: "outdoors, in latitude and longitude",
}


@dataclass(frozen=True)
class Starter:
    """The two files.

    Attributes:
        mission: the text of NAME.yaml.
        world: the text of NAME.sim.yaml.
    """

    mission: str
    world: str


@dataclass(frozen=True)
class _Layout:
    """A space in numbers: metres east, north and up of Home, which is (0, 0).

    Attributes:
        about: what the reader has to know about it, as comments.
        sites: the places of the task, in its order.
        fence: corners.
        walls: the walls of the map, one per line; None without a map.
    """

    about: tuple[str, ...]
    speed_mps: float
    up_m: float
    sites: tuple[tuple[float, float], ...]
    fence: tuple[tuple[float, float], ...]
    walls: tuple[str, ...] | None
    wind: str


_HALL = _Layout(
    about=(
        "A hall with a wall in its middle. The walls are drawn here; a map of your own, an image",
        "with its scale, is named by `map: maps/NAME.yaml` (docs/missions.md).",
    ),
    speed_mps=2.0,
    up_m=2.0,
    sites=((14, 0), (14, 8), (0, 8)),
    fence=((-1.5, -1.5), (15.5, -1.5), (15.5, 9.5), (-1.5, 9.5)),
    walls=("{east_m: [6.8, 7.2], north_m: [-2, 5]}",),
    wind="{east_mps: 0.2, north_mps: 0.1, turbulence_mps: 0.05}    # a draught",
)
_FIELD = _Layout(
    about=("An open field: there is no map, the fence says where the vehicle may be.",),
    speed_mps=5.0,
    up_m=6.0,
    sites=((40, 0), (40, 30), (0, 30)),
    fence=((-20, -20), (60, -20), (60, 50), (-20, 50)),
    walls=None,
    wind="{east_mps: 3, north_mps: 1, turbulence_mps: 0.3}",
)


def starter(
    name: str, space: StarterSpace, task: TaskName, home: GlobalOrigin = PX4_HOME
) -> Starter:
    """A mission and its world.

    >>> made = starter("first", StarterSpace.FIELD, TaskName.PATROL)
    >>> made.mission.splitlines()[7]
    'name: first'

    Args:
        name: the name of the mission.
        space: where it is flown.
        task: what it does.
        home: its home, for a mission in latitude and longitude.
    """
    layout = _HALL if space is StarterSpace.HALL else _FIELD
    earth = home if space is StarterSpace.EARTH else None
    chosen = TASKS[task]
    return Starter(
        "\n".join(_mission(name, layout, chosen, earth)) + "\n",
        "\n".join(_world(name, layout, chosen, earth)) + "\n",
    )


def _mission(
    name: str, layout: _Layout, task: StarterTask, earth: GlobalOrigin | None
) -> list[str]:
    fence = ", ".join(_corner(corner, earth) for corner in layout.fence)
    order = "[lat, lon]" if earth else "[east, north]"
    up_m = f"[1, {layout.up_m + 4:g}]"
    sites = dict(zip(task.sites, layout.sites, strict=True))
    places = {"Home": (0.0, 0.0)} | sites
    names = ", ".join(places)
    return [
        *_comment(*task.story),
        "#",
        f"#     companion check {name}.yaml        is there a plan, and which?",
        f"#     companion sim {name}.yaml          flies it in the world of {name}.sim.yaml",
        f"#     companion run {name}.yaml          flies it on a vehicle (docs/real-vehicle.md)",
        "",
        "version: 1",
        f"name: {name}",
        *(["frame: wgs84       # places and fence in latitude and longitude"] if earth else []),
        "",
        *_comment(*(_EARTH_ABOUT if earth else layout.about)),
        *_map(layout),
        "limits:",
        f"  speed_mps: {layout.speed_mps:g}",
        f"  up_m: {up_m:<17}# above Home, the lowest and the highest",
        f"  fence: [{fence}]    # {order} corners",
        "",
        "# `Home` is where the vehicle stands when the mission begins.",
        "places:",
        *(f"  {place}: {_place(at, layout.up_m, earth)}" for place, at in places.items()),
        "",
        "sets:",
        f"  Place: [{names}]",
        *task.sets,
        "",
        *task.before_skills,
        *_MOVE,
        *task.skills,
        "",
        "# What is true at the beginning; all else is false.",
        "initially: [at(Home)]",
        "",
        *task.task,
        "",
        "# What is done when no plan is left.",
        "otherwise: return_home",
    ]


def _world(name: str, layout: _Layout, task: StarterTask, earth: GlobalOrigin | None) -> list[str]:
    home = []
    if earth is not None:
        at = f"latitude_deg: {earth.latitude_deg:.6f}, longitude_deg: {earth.longitude_deg:.6f}"
        home = [f"home: {{{at}, altitude_m: {earth.altitude_m:g}}}"]
    return [
        f"# The world of {name}.yaml, for the simulator alone: the vehicle is not told.",
        "# docs/scenario.md names all that may happen.",
        "",
        "version: 1",
        *home,
        *(_map(layout) or ["map: {east_m: [-60, 100], north_m: [-60, 90], walls: []}", ""]),
        f"wind: {layout.wind}",
        *task.world(dict(zip(task.sites, layout.sites, strict=True))),
    ]


_EARTH_ABOUT = (
    "An open field: there is no map, the fence says where the vehicle may be. Read the corners and",
    "places off any map (WGS 84).",
)
_MOVE = (
    "# What the vehicle can do: when, what it takes for granted, what is true afterwards.",
    "skills:",
    "  move:",
    "    parameters: {from: Place, to: Place}",
    "    precondition: at(from)",
    "    assumes: trans_ok(from, to)     # no longer believed where the way is blocked",
    "    effect: at(to) & !at(from)",
    "    cost: flight_time",
    "    execute: fly(to)",
    "    tries: 3",
)


def _comment(*lines: str) -> list[str]:
    return [f"# {line}" for line in lines]


def _map(layout: _Layout) -> list[str]:
    if layout.walls is None:
        return []
    east, north = zip(*layout.fence, strict=True)
    lines = [
        "map:",
        f"  east_m: [{min(east) - 1:g}, {max(east) + 1:g}]",
        f"  north_m: [{min(north) - 1:g}, {max(north) + 1:g}]",
        "  walls:",
    ]
    return [*lines, *(f"    - {wall}" for wall in layout.walls), ""]


def _degrees(at: tuple[float, float], earth: GlobalOrigin) -> tuple[float, float]:
    east_m, north_m = at
    latitude_deg, longitude_deg, _ = earth.to_global((north_m, east_m, 0.0))
    return latitude_deg, longitude_deg


def _corner(at: tuple[float, float], earth: GlobalOrigin | None) -> str:
    if earth is None:
        return f"[{at[0]:g}, {at[1]:g}]"
    latitude_deg, longitude_deg = _degrees(at, earth)
    return f"[{latitude_deg:.6f}, {longitude_deg:.6f}]"


def _place(at: tuple[float, float], up_m: float, earth: GlobalOrigin | None) -> str:
    if earth is None:
        return f"{{east_m: {at[0]:g}, north_m: {at[1]:g}, up_m: {up_m:g}}}"
    latitude_deg, longitude_deg = _degrees(at, earth)
    where = f"lat_deg: {latitude_deg:.6f}, lon_deg: {longitude_deg:.6f}"
    return f"{{{where}, up_m: {up_m:g}, radius_m: 1.5}}"
