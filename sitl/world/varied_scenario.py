"""A scenario file with varied keys, in a form that can be sent to another process or machine.

The map and the vehicle profile that the file names are already read, so any row of a campaign can
be made from this without a disk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from companion.documents import Source, validate
from companion.drawn_maps import MapEntry
from companion.geometry import GlobalOrigin
from companion.motion.grid import OccupancyGrid
from sitl.world.distributions import Chance
from sitl.world.scenario import PX4_HOME, Scenario, read_scenario
from sitl.world.schema import ScenarioModel
from sitl.world.vary import Factor, Values, with_values


@dataclass(frozen=True)
class VariedScenario:
    """A scenario and its factors.

    Attributes:
        data: the content of the file.
        portable: the same with the content of its other files filled in, except the map.
        grid: its map; None without walls.
        home: home, if the scenario does not say it.
        factors: what varies, in the order of the file.
        folder: where it was read, to which its file names are relative.
    """

    data: Mapping[str, Any]
    portable: Mapping[str, Any]
    grid: OccupancyGrid | None
    home: GlobalOrigin
    factors: tuple[Factor, ...]
    folder: Path

    def world(self, values: Values) -> tuple[Scenario, OccupancyGrid | None]:
        """The scenario and map of a row.

        Args:
            values: the values of factors by path; the others keep the file's values.

        Raises:
            MissionError: the row is invalid, such as a start inside an obstacle.
        """
        data = with_values(self.portable, self.factors, values)
        return read_scenario(Source(data, "scenario", Path(), None), self.home, self.grid)

    def data_with(self, values: Values) -> dict[str, Any]:
        """The data of a scenario file for a row, to be stored beside the same files.

        The vehicle is written out in full, because its profile may not be there for another file.
        """
        data = with_values(self.data, self.factors, values)
        if "vehicle" in data:
            data["vehicle"] = with_values(self.portable, self.factors, values)["vehicle"]
        return data

    def moved_obstacles(self, values: Values) -> frozenset[str]:
        """The names of the obstacles that these values move or resize."""
        return frozenset(
            self.data["obstacles"][factor.keys[1]]["name"]
            for factor in self.factors
            if factor.path in values
            and factor.keys[0] == "obstacles"
            and factor.keys[2:3] in (("circle",), ("box",))
        )

    def with_optional_events(self) -> VariedScenario:
        """The same scenario, in which each entry of `happens` may also be absent."""
        varied = {factor.path for factor in self.factors}
        numbers = range(len(self.data.get("happens") or ()))
        entries = {f"happens.{i}": ("happens", i) for i in numbers}
        optional = tuple(
            Factor(path, keys, Chance(1.0), None, is_entry=True)
            for path, keys in entries.items()
            if path not in varied
        )
        return replace(self, factors=self.factors + optional)


def read_varied(
    source: Source,
    default_home: GlobalOrigin = PX4_HOME,
    default_map: OccupancyGrid | None = None,
) -> VariedScenario:
    """Reads a scenario and its factors; arguments and errors are those of `read_scenario`."""
    scenario, grid = read_scenario(source, default_home, default_map)
    _, document = validate(source.content, source.name, ScenarioModel)
    data = document.data()
    assert isinstance(data, dict)
    vehicle = {key: value for key, value in asdict(scenario.vehicle).items() if key != "name"}
    portable = {**data, "vehicle": vehicle}
    if isinstance(data.get("map"), str):
        del portable["map"]
    elif data.get("map") is None and isinstance(scenario.map, MapEntry):
        portable["map"] = {}  # each row draws it anew, around its own obstacles
    return VariedScenario(data, portable, grid, default_home, scenario.factors, source.folder)
