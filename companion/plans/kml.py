"""KML and KMZ as a flight plan: the points, lines and polygons of placemarks.

1. The text goes directly through expat, which gives line and column of a syntax error.
2. A document type is refused as soon as it begins. Entities are declared nowhere else, so none is
   ever expanded, and nothing is fetched. Depth, elements and characters are limited.
3. Heights count only if altitudeMode is absolute (above sea level, as QGroundControl assumes). By
   default a shape is clamped to the ground and has no height. A number that is given nevertheless,
   or that is relative to the ground, is not used, and a note says so.
4. The altitude of home is that of the ground there. A placemark's `kind` may be in its
   ExtendedData.

Source: OGC 12-007r2 (KML 2.3), sections 9 to 11.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from xml.parsers import expat

from companion.plans.route_plan import (
    Height,
    ItemRefused,
    LatLon,
    RoutePlan,
    UnusedHeight,
    check_degrees,
    check_points,
)
from companion.plans.shapes import DrawnHeight, Line, Point, Polygon, Shape, plan_of, word

MAX_DEPTH = 60
MAX_ELEMENTS = 100_000
MAX_BYTES = 4_000_000
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
UNREADABLE = (
    zipfile.BadZipFile,
    zlib.error,
    NotImplementedError,
    RuntimeError,
    OSError,
    EOFError,
    ValueError,
)
"""The exceptions that reading an archive may raise."""
ABSOLUTE, CLAMPED = "absolute", frozenset({"clampToGround", "clampToSeaFloor"})
ABOVE = {
    "relativeToGround": " above the ground",
    "relativeToSeaFloor": " above the sea floor",
    "clampToGround": ", clamped to the ground",
    "clampToSeaFloor": ", clamped to the sea floor",
}


@dataclass
class Element:
    """An element without its namespace."""

    tag: str
    attributes: dict[str, str]
    texts: list[str] = field(default_factory=list)
    children: list[Element] = field(default_factory=list)

    @property
    def text(self) -> str:
        """Its text content."""
        return "".join(self.texts).strip()

    def child(self, *tags: str) -> Element | None:
        """The first element at a path of tags."""
        found: Element | None = self
        for tag in tags:
            found = next((c for c in found.children if c.tag == tag), None) if found else None
        return found

    def all(self, *tags: str) -> Iterator[Element]:
        """The elements with one of the tags, itself included; not those inside another match."""
        if self.tag in tags:
            yield self
            return
        for child in self.children:
            yield from child.all(*tags)


def read_kml(data: bytes) -> RoutePlan:
    """The plan of a KML file.

    Raises:
        ItemRefused: it is not well formed, or a mission cannot express it.
    """
    root = _Builder().read(data)
    if root.tag != "kml":
        raise ItemRefused("", f"is XML, but no KML: it begins with {root.tag[:40]}")
    shapes: list[Shape] = []
    for index, placemark in enumerate(root.all("Placemark"), 1):
        shapes.extend(_shapes(placemark, index))
    if not shapes:
        raise ItemRefused("", "has no placemark with a Point, LineString or Polygon", "draw one")
    return _on_the_ground(plan_of("KML", shapes))


def _on_the_ground(plan: RoutePlan) -> RoutePlan:
    """The plan; if its home is drawn with an altitude, this is that of the ground there."""
    drawn = plan.takeoff
    if drawn is None:
        return plan
    told = f"home lies {drawn.metres:g} m above the sea, as {plan.takeoff_item} has it"
    note = f"{plan.home_note}; {told}" if plan.home_note else told
    return replace(plan, home_amsl_m=drawn.metres, home_note=note, takeoff=None, takeoff_item="")


def read_kmz(data: bytes) -> RoutePlan:
    """The plan of a KMZ file, from the first KML file in the archive.

    Raises:
        ItemRefused: as `read_kml`, or it is no such archive.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            name = next((n for n in archive.namelist() if n.lower().endswith(".kml")), None)
            if name is None:
                raise ItemRefused("", "is an archive without a .kml file")
            if archive.getinfo(name).compress_type not in PACKED:
                raise ItemRefused("", "is packed in a way that KMZ does not know", "zip it again")
            with archive.open(name) as stream:
                text = stream.read(MAX_BYTES + 1)  # the archive may state a false size
    except UNREADABLE as error:
        raise ItemRefused("", f"is not a readable archive: {error}", "zip it again") from None
    if len(text) > MAX_BYTES:
        raise ItemRefused("", f"has a KML file of more than {MAX_BYTES} bytes")
    return read_kml(text)


class _Builder:
    """Builds elements from expat's events."""

    def __init__(self) -> None:
        self._root = Element("", {})
        self._open = [self._root]
        self._elements = 0

    def read(self, data: bytes) -> Element:
        parser = expat.ParserCreate()
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            where = f"line {error.lineno}, column {error.offset + 1}"
            what = f"is not well-formed XML: {expat.ErrorString(error.code)}, {where}"
            raise ItemRefused("", what, "save the file again") from None
        except (ValueError, LookupError) as error:  # an encoding that Python does not know
            raise ItemRefused("", f"cannot be read as XML: {error}", "save it as UTF-8") from None
        return self._root.children[0]

    def _doctype(self, *declared: object) -> None:
        raise ItemRefused("", "has a document type, which KML does not need", "remove <!DOCTYPE")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._elements += 1
        if self._elements > MAX_ELEMENTS or len(self._open) > MAX_DEPTH:
            limits = f"{MAX_ELEMENTS} elements, {MAX_DEPTH} levels"
            raise ItemRefused("", f"is larger than it may be ({limits})", "is this the right file?")
        element = Element(tag.rpartition(":")[2], attributes)
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, tag: str) -> None:
        self._open.pop()

    def _text(self, text: str) -> None:
        self._open[-1].texts.append(text)


def _shapes(placemark: Element, index: int) -> Iterator[Shape]:
    """The shapes of a placemark."""
    name = placemark.child("name")
    spelt = word(name.text) if name else ""
    kind = next((d for d in placemark.all("Data") if d.attributes.get("name") == "kind"), None)
    value = kind.child("value") if kind else None
    said = value.text if value else ""
    item = f"placemark {index}" + (f" ({spelt})" if spelt else "")
    found = list(placemark.all("Point", "LineString", "Polygon", "LinearRing", "Model", "Track"))
    for geometry in found:
        corners = _Corners(item, geometry)
        if geometry.tag == "Point":
            ((position, height),) = corners.of(geometry)[:1]
            yield Point(item, spelt or f"P{index}", said, position, height)
        elif geometry.tag == "LineString":
            yield Line(item, spelt, said, tuple(corners.of(geometry)))
        elif geometry.tag == "Polygon":
            outer = corners.ring(geometry.child("outerBoundaryIs", "LinearRing"))
            inner = [c for c in geometry.children if c.tag == "innerBoundaryIs"]
            holes = tuple(corners.ring(each.child("LinearRing")) for each in inner)
            yield Polygon(item, spelt, said, outer, holes)
        else:
            raise ItemRefused(item, f"is a {geometry.tag}", "draw a point, a path or a polygon")


class _Corners:
    """The coordinates of a geometry."""

    def __init__(self, item: str, geometry: Element) -> None:
        self._item = item
        mode = geometry.child("altitudeMode")
        self._mode = mode.text if mode else "clampToGround"

    def ring(self, ring: Element | None) -> tuple[LatLon, ...]:
        if ring is None:
            raise ItemRefused(self._item, "is a polygon without a LinearRing", "draw it anew")
        return tuple(position for position, _ in self.of(ring))

    def of(self, element: Element) -> list[tuple[LatLon, DrawnHeight]]:
        coordinates = element.child("coordinates")
        if coordinates is None or not coordinates.text:
            raise ItemRefused(self._item, f"its {element.tag} has no coordinates", "draw it anew")
        corners = coordinates.text.split()
        check_points(len(corners))
        return [self._corner(text) for text in corners]

    def _corner(self, text: str) -> tuple[LatLon, DrawnHeight]:
        try:
            longitude, latitude, *rest = map(float, text.split(","))
        except ValueError:
            what = f"{text[:40]!r} is not a position"
            raise ItemRefused(self._item, what, "KML has lon,lat[,alt] between blanks") from None
        position = check_degrees(self._item, latitude, longitude)
        return position, self._height(rest[0]) if rest else None

    def _height(self, metres: float) -> DrawnHeight:
        if self._mode in CLAMPED and metres == 0:
            return None
        if not abs(metres) < 100_000:
            raise ItemRefused(self._item, f"the altitude {metres:g} is nowhere")
        if self._mode == ABSOLUTE:
            return Height(metres, True)
        above = ABOVE.get(self._mode, " above something else")
        return UnusedHeight(metres, f"{above} (altitudeMode {self._mode[:40]})")
