"""Converts the coordinates of a mission file to local NED; no other module does.

    frame: enu      metres east, north and up from home
    frame: wgs84    degrees north and east, metres above home or above the sea

Degrees become metres by PX4's own projection, centred at the place where the mission begins. So all
planning is in metres and needs no vehicle. Where that place lies in the local frame of an autopilot
is found out at the start (vehicle/mission_frame.py).

Before the start nobody knows how high above the sea home lies. Places given above the sea are
planned as if they lay in the middle of the altitudes that the mission allows; if any height of home
fits them all, this one does. Later altitudes.py moves them to where they are.
"""

from __future__ import annotations

from typing import Protocol

from companion.documents import Document
from companion.errors import FormulaError, KeyPath, Location, MissionError
from companion.geometry import (
    FAR_M,
    GlobalOrigin,
    Ned,
    NorthEast,
    horizontal_distance,
    ned_from_enu,
)
from companion.mission.facts import AT
from companion.mission.literals import parse_fact
from companion.mission.schema import MissionFile
from companion.mission.world_schema import PlaceEntry, PointEntry

METRES, DEGREES = ("east_m", "north_m"), ("lat_deg", "lon_deg")
USUAL_HOME_AMSL_M = 488.0
"""Height of home if the file tells nothing about it; no flight relies on it."""


class Coordinates(Protocol):
    """What the coordinates of one file mean. `keys` are the path to a coordinate in the file."""

    @property
    def anchor(self) -> GlobalOrigin | None:
        """Where north 0, east 0 and up 0 (as assumed) lie on the earth; None in metres."""

    def corner(self, corner: tuple[float, float], *keys: str | int) -> NorthEast:
        """A corner of a polygon, from how the file lists it."""

    def point(self, entry: PointEntry, *keys: str | int) -> NorthEast:
        """A point on the ground plan."""

    def place(self, entry: PlaceEntry, *keys: str | int) -> Ned:
        """A point in the air."""

    def in_words(self, point: NorthEast) -> str:
        """A point in words, with the keys that the file uses."""

    def as_corner(self, point: NorthEast) -> str:
        """A point as a corner is written in the file."""


def coordinates_of(file: MissionFile, document: Document) -> Coordinates:
    """What the coordinates of a file mean.

    Raises:
        MissionError: the place where the mission begins has no coordinates, or its altitudes fit no
            home.
    """
    return LatLon(file, document) if file.frame == "wgs84" else EastNorth(document)


class EastNorth:
    """Coordinates in metres from home."""

    anchor: GlobalOrigin | None = None

    def __init__(self, document: Document) -> None:
        self._document = document

    def corner(self, corner: tuple[float, float], *keys: str | int) -> NorthEast:
        """[east, north]."""
        east_m, north_m = corner
        return (north_m, east_m)

    def point(self, entry: PointEntry, *keys: str | int) -> NorthEast:
        """{east_m, north_m}."""
        east_m, north_m = _pair(entry, METRES, self._document, keys)
        return (north_m, east_m)

    def place(self, entry: PlaceEntry, *keys: str | int) -> Ned:
        """{east_m, north_m, up_m}."""
        north_m, east_m = self.point(entry, *keys)
        if entry.amsl_m is not None:
            what, where = f"{keys[-1]} has amsl_m", self._document.key_at(*keys, "amsl_m")
            raise MissionError(
                f"{what}, and the frame is enu", where, "write up_m, or add frame: wgs84"
            )
        return ned_from_enu(east_m, north_m, _needed(entry, "up_m", self._document, keys))

    def in_words(self, point: NorthEast) -> str:
        """East and north."""
        return f"east_m: {point[1]:.2f}, north_m: {point[0]:.2f}"

    def as_corner(self, point: NorthEast) -> str:
        """[east, north]."""
        return f"[{point[1]:g}, {point[0]:g}]"


class LatLon:
    """Coordinates in degrees on the earth.

    Args:
        file: the mission.
        document: the YAML that the mission is from.

    Raises:
        MissionError: as `coordinates_of`.
    """

    def __init__(self, file: MissionFile, document: Document) -> None:
        self._document = document
        self._home = home = begins_at(file) or next(iter(file.places))
        keys = ("places", home)
        latitude, longitude = self._degrees(file.places[home], keys)
        for name, entry in file.places.items():
            self._check_altitude(name, entry)
        self.anchor = GlobalOrigin(latitude, longitude, self._home_amsl_m(file))

    def corner(self, corner: tuple[float, float], *keys: str | int) -> NorthEast:
        """[lat, lon]."""
        latitude, longitude = corner
        if abs(latitude) > 90 or abs(longitude) > 180:
            raise MissionError(
                f"[{latitude:g}, {longitude:g}] lies nowhere on the earth",
                self._document.where(*keys),
                "with frame: wgs84 a corner is [lat, lon], in degrees",
            )
        return self._near((latitude, longitude), "a corner", self._document.where(*keys))

    def point(self, entry: PointEntry, *keys: str | int) -> NorthEast:
        """{lat_deg, lon_deg}."""
        degrees = self._degrees(entry, keys)
        name = f"place {keys[-1]}" if keys[0] == "places" else f"{keys[-1]} of {keys[-2]}"
        return self._near(degrees, name, self._document.key_at(*keys))

    def place(self, entry: PlaceEntry, *keys: str | int) -> Ned:
        """{lat_deg, lon_deg, up_m or amsl_m}."""
        up_m = entry.up_m
        if up_m is None:
            assert entry.amsl_m is not None
            up_m = entry.amsl_m - self.anchor.altitude_m
        return (*self.point(entry, *keys), -up_m)

    def in_words(self, point: NorthEast) -> str:
        """Latitude and longitude, to a decimetre."""
        latitude, longitude, _ = self.anchor.to_global((*point, 0.0))
        return f"lat_deg: {latitude:.6f}, lon_deg: {longitude:.6f}"

    def as_corner(self, point: NorthEast) -> str:
        """[lat, lon], to a decimetre."""
        latitude, longitude, _ = self.anchor.to_global((*point, 0.0))
        return f"[{latitude:.6f}, {longitude:.6f}]"

    def _degrees(self, entry: PointEntry, keys: tuple[str | int, ...]) -> tuple[float, float]:
        degrees = _pair(entry, DEGREES, self._document, keys)
        if degrees == (0.0, 0.0):
            raise MissionError(
                f"{keys[-1]} is at latitude 0, longitude 0, where no position was written",
                self._document.key_at(*keys),
                "write where it is, in degrees",
            )
        return degrees

    def _near(
        self, degrees: tuple[float, float], name: str, where: Location | KeyPath
    ) -> NorthEast:
        """A point in metres from the anchor, if it is not too far away."""
        north, east, _ = self.anchor.to_local(*degrees, self.anchor.altitude_m)
        away_m = horizontal_distance((north, east), (0.0, 0.0))
        if away_m <= FAR_M:
            return (north, east)
        swapped = self.anchor.to_local(degrees[1], degrees[0], 0.0)[:2]
        is_swapped = abs(degrees[1]) <= 90 and horizontal_distance(swapped, (0.0, 0.0)) <= FAR_M
        raise MissionError(
            f"{name} is {away_m / 1000:.0f} km from {self._home}",
            where,
            "latitude and longitude are exchanged"
            if is_swapped
            else f"nothing of a mission lies more than {FAR_M // 1000} km from {self._home}, where "
            "it begins",
        )

    def _check_altitude(self, name: str, entry: PlaceEntry) -> None:
        if (entry.up_m is None) is not (entry.amsl_m is None):
            return
        given = "both up_m and amsl_m" if entry.up_m is not None else "no altitude"
        raise MissionError(
            f"place {name} has {given}",
            self._document.key_at("places", name),
            "write up_m (metres above home) or amsl_m (metres above mean sea level)",
        )

    def _home_amsl_m(self, file: MissionFile) -> float:
        """The height of home for which places above the sea are in the middle of the altitudes."""
        heights = [e.amsl_m for e in file.places.values() if e.amsl_m is not None]
        if not heights:
            return USUAL_HOME_AMSL_M
        lowest, highest = file.limits.up_m
        if max(heights) - min(heights) > highest - lowest:
            raise MissionError(
                f"places from {min(heights):g} to {max(heights):g} m above the sea do not fit "
                f"between {lowest:g} and {highest:g} m above any home",
                self._document.where("limits", "up_m"),
                "change their amsl_m, or limits.up_m",
            )
        return (max(heights) + min(heights) - highest - lowest) / 2


def begins_at(file: MissionFile) -> str | None:
    """The place where the mission begins; None if the file names none, or an unknown one."""
    for text in file.initially:
        try:
            fact = parse_fact(text)
        except FormulaError:
            continue  # reported where facts are read
        if fact.predicate == AT and fact.arguments and fact.arguments[0] in file.places:
            return fact.arguments[0]
    return None


def _pair(
    entry: PointEntry, wanted: tuple[str, str], document: Document, keys: tuple[str | int, ...]
) -> tuple[float, float]:
    """The two coordinates of a point; refused unless the entry has exactly these keys."""
    frame, other = ("enu", DEGREES) if wanted == METRES else ("wgs84", METRES)
    for key in other:
        if getattr(entry, key) is not None:
            advice = (
                "add frame: wgs84 to the mission"
                if wanted == METRES
                else "remove frame: wgs84 from the mission"
            )
            raise MissionError(
                f"{keys[-1]} has {key}, and the frame is {frame}",
                document.key_at(*keys, key),
                f"write {' and '.join(wanted)}, or {advice}",
            )
    first, second = (_needed(entry, key, document, keys) for key in wanted)
    return first, second


def _needed(entry: PointEntry, key: str, document: Document, keys: tuple[str | int, ...]) -> float:
    value: float | None = getattr(entry, key)
    if value is None:
        about = type(entry).model_fields[key].description
        path = ".".join(map(str, keys))
        what = f"the key {key} is missing in {path}"
        raise MissionError(what, document.key_at(*keys), f"{key}: {about}")
    return value
