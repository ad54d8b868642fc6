"""KML and KMZ as missions; and what a hostile file of them does: nothing."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
from plan_files import HOME, at, imported, square

from companion import load_mission
from companion.errors import MissionError
from companion.plans.draft_places import Given
from companion.plans.kml import MAX_BYTES, MAX_DEPTH, MAX_ELEMENTS

UP = Given(up_m=20.0)


def coordinates(*points: tuple[float, float], up_m: float | None = None) -> str:
    third = "" if up_m is None else f",{up_m}"
    listed = (f"{east!r},{north!r}{third}" for north, east in points)
    return f"<coordinates>\n {' '.join(listed)} </coordinates>"


def placemark(geometry: str, name: str = "", kind: str = "") -> str:
    said = f'<ExtendedData><Data name="kind"><value>{kind}</value></Data></ExtendedData>'
    return f"<Placemark><name>{name}</name>{said if kind else ''}{geometry}</Placemark>"


def kml(*placemarks: str) -> str:
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">'
        f"<Document><Folder>{''.join(placemarks)}</Folder></Document></kml>"
    )


def ring(reach_m: float) -> str:
    corners = [(north, east) for north, east in square(reach_m)]
    return f"<LinearRing>{coordinates(*corners, corners[0])}</LinearRing>"


def polygon(reach_m: float, hole_m: float = 0.0) -> str:
    hole = f"<innerBoundaryIs>{ring(hole_m)}</innerBoundaryIs>" if hole_m else ""
    return f"<Polygon><outerBoundaryIs>{ring(reach_m)}</outerBoundaryIs>{hole}</Polygon>"


PATH = placemark(f"<LineString>{coordinates(HOME, at(30, 0), at(30, 40))}</LineString>", "Path")
GATE = placemark(f"<Point>{coordinates(at(30, 0), up_m=7)}</Point>", "North gate")


def refusal(folder: Path, content: str | bytes, name: str = "map.kml", given: Given = UP) -> str:
    with pytest.raises(MissionError) as error:
        imported(folder, content, name, given)
    return str(error.value).removeprefix(f"{folder}/{name}: ")


def test_a_path_is_an_order_of_places_and_a_point_on_it_gives_its_name(tmp_path: Path) -> None:
    text, draft = imported(tmp_path, kml(PATH, GATE, placemark(polygon(90))), "map.kml", UP)
    mission = load_mission(text)
    assert mission.places["North_gate"].position == pytest.approx((30, 0, -20), abs=0.001)
    assert list(mission.places) == ["Home", "North_gate", "W3"]
    assert draft.data["task"]["route"] == "ordered_visit(North_gate, W3)"
    assert len(mission.limits.fence) == 4


def test_a_placemark_named_home_is_where_the_mission_begins(tmp_path: Path) -> None:
    path = placemark(f"<LineString>{coordinates(at(30, 0), at(30, 40))}</LineString>", "Path")
    home = placemark(f"<Point>{coordinates(HOME)}</Point>", "HOME")
    text, draft = imported(tmp_path, kml(path, home), "map.kml", UP)
    assert list(load_mission(text).places) == ["Home", "W1", "W2"]
    assert load_mission(text).places["W1"].position == pytest.approx((30, 0, -20), abs=0.001)
    assert "home is placemark 2 (HOME), by its name" in draft.notes


@pytest.mark.parametrize("kind", ["", "home"])
def test_the_altitude_of_home_is_how_high_it_lies(kind: str, tmp_path: Path) -> None:
    mode = "<altitudeMode>absolute</altitudeMode>"
    home = placemark(f"<Point>{mode}{coordinates(HOME, up_m=488)}</Point>", "Home", kind)
    corners = coordinates(at(30, 0), at(30, 40), up_m=510)
    path = placemark(f"<LineString>{mode}{corners}</LineString>")
    text, draft = imported(tmp_path, kml(home, path), "map.kml", Given())
    assert {place.amsl_m for place in load_mission(text).places.values()} == {510.0}
    assert draft.data["limits"]["up_m"] == [7.0, 37.0]
    said = "home lies 488 m above the sea, as placemark 1 (Home) has it"
    assert any(line.endswith(said) for line in draft.notes)
    high = Given(home=at(-5, 0), home_amsl_m=480.0)
    draft = imported(tmp_path, kml(home, path), "map.kml", high)[1]
    assert draft.data["limits"]["up_m"] == [15.0, 45.0]


def test_points_without_a_path_are_visited_in_any_order(tmp_path: Path) -> None:
    points = [placemark(f"<Point>{coordinates(at(n, 9))}</Point>") for n in (20, -20)]
    given = Given(home=HOME, up_m=20.0)
    _, draft = imported(tmp_path, kml(*points), "map.kml", given)
    assert draft.data["task"]["route"] == "F at(P1) & F at(P2)"


def test_holes_and_kinds_are_keep_out_zones(tmp_path: Path) -> None:
    wood = placemark(polygon(3).replace("coordinates>\n", "coordinates>"), "Wood", "keep_out")
    path = f"<LineString>{coordinates(at(20, 0), at(20, 40))}</LineString>"
    drawn = kml(placemark(path), placemark(polygon(90, hole_m=8), "Farm"), wood)
    found = load_mission(imported(tmp_path, drawn, "map.kml", UP)[0]).limits.keep_out
    assert list(found) == ["Farm_hole_1", "Wood"]


def test_heights_count_where_they_are_above_the_sea(tmp_path: Path) -> None:
    mode = "<altitudeMode>absolute</altitudeMode>"
    path = f"<LineString>{mode}{coordinates(HOME, at(30, 0), up_m=510)}</LineString>"
    given = Given(home=HOME, home_amsl_m=488.0, up_m=20.0)
    mission = load_mission(imported(tmp_path, kml(placemark(path)), "map.kml", given)[0])
    assert mission.places["W2"].amsl_m == 510.0
    assert "no altitude" in refusal(tmp_path, kml(PATH), given=Given())


def moded(mode: str, *heights_m: float) -> str:
    """A path whose corners have these heights."""
    corners = [(*at(30 * nth, 0), up_m) for nth, up_m in enumerate(heights_m)]
    listed = " ".join(f"{east!r},{north!r},{up_m}" for north, east, up_m in corners)
    said = f"<altitudeMode>{mode}</altitudeMode>" if mode else ""
    return placemark(f"<LineString>{said}<coordinates>{listed}</coordinates></LineString>", "Path")


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        ("relativeToGround", "12 to 25 m above the ground (altitudeMode relativeToGround)"),
        ("relativeToSeaFloor", "12 to 25 m above the sea floor (altitudeMode relativeToSeaFloor)"),
        ("clampToGround", "12 to 25 m, clamped to the ground (altitudeMode clampToGround)"),
        ("", "12 to 25 m, clamped to the ground (altitudeMode clampToGround)"),
        ("other", "12 to 25 m above something else (altitudeMode other)"),
    ],
)
def test_heights_that_a_mission_cannot_have_are_told(mode: str, words: str, tmp_path: Path) -> None:
    drawn = kml(moded(mode, 12, 18, 25), placemark(polygon(90)))
    text, draft = imported(tmp_path, drawn, "map.kml", Given(up_m=30.0))
    assert {place.position[2] for place in load_mission(text).places.values()} == {-30.0}
    instead = "in place of that 30 m above home, by --up-m"
    told = f"not used: 3 altitudes of the file, {words}; {instead}"
    assert told in draft.notes and told in text
    said = refusal(tmp_path, drawn, given=Given())
    assert f"its altitude is {words.replace(' to 25', '')}, and a mission knows" in said
    assert "--up-m 20" in said


def test_no_height_is_none_that_is_not_used(tmp_path: Path) -> None:
    for path in (PATH, moded("", 0, 0), moded("clampToGround", 0, 0)):
        told = imported(tmp_path, kml(path), "map.kml", UP)[1].notes
        assert not any("not used" in line for line in told)
    said = refusal(tmp_path, kml(moded("", 0, 0)), given=Given())
    assert "has no altitude above home or above the sea" in said


def test_up_m_is_for_points_that_nothing_flies_to_as_well(tmp_path: Path) -> None:
    mode = "<altitudeMode>absolute</altitudeMode>"
    path = f"<LineString>{mode}{coordinates(HOME, at(30, 0), up_m=510)}</LineString>"
    points = [placemark(f"<Point>{coordinates(at(0, 30))}</Point>", "Tree")]
    points += [placemark(f"<Point>{coordinates(at(30, 30), up_m=7)}</Point>", "Base", "rally")]
    drawn = kml(placemark(path), *points)
    for up_m, instead in ((None, "the height of Home"), (9.0, "9 m above home, by --up-m")):
        given = Given(home=HOME, home_amsl_m=488.0, up_m=up_m)
        text, draft = imported(tmp_path, drawn, "map.kml", given)
        places = load_mission(text).places
        heights = {places["Tree"].amsl_m, places["Base"].amsl_m}
        assert heights == ({510.0} if up_m is None else {None})
        assert any(line.endswith(f"in place of that {instead}") for line in draft.notes)


def test_an_archive_is_its_first_kml_file(tmp_path: Path) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("files/pin.png", b"no map")
        archive.writestr("doc.kml", kml(PATH))
    text, _ = imported(tmp_path, packed.getvalue(), "map.kmz", UP)
    assert list(load_mission(text).places) == ["Home", "W2", "W3"]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("<kml><Document></kml>", "is not well-formed XML: mismatched tag, line 1, column 18"),
        ("", "is not well-formed XML: no element found"),
        ("<html></html>", "is XML, but no KML: it begins with html"),
        (kml(), "has no placemark with a Point"),
        (kml(placemark("<Polygon></Polygon>")), "placemark 1: is a polygon without a LinearRing"),
        (kml(placemark("<Point></Point>", "A")), "placemark 1 (A): its Point has no coordinates"),
        (
            kml(placemark("<Point><coordinates>8.5;47</coordinates></Point>")),
            "placemark 1: '8.5;47' is not a position",
        ),
        (
            kml(placemark("<Point><coordinates>47,190</coordinates></Point>")),
            "placemark 1: latitude 190, longitude 47 is nowhere on the earth",
        ),
        (kml(placemark("<Model></Model>")), "placemark 1: is a Model"),
        (
            kml(PATH, placemark(polygon(90)), placemark(polygon(80), "B")),
            "placemark 3 (B): is one of several polygons",
        ),
        (kml(placemark(polygon(90), "A", "zone")), "placemark 1 (A): is of the kind 'zone'"),
        (kml(PATH, PATH), "placemark 2 (Path): is a second route"),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, what: str, tmp_path: Path) -> None:
    assert what in refusal(tmp_path, text)


LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))
BOMB = f'<?xml version="1.0"?><!DOCTYPE kml [<!ENTITY l0 "ha">{LAUGHS}]><kml>&l9;</kml>'
OUTSIDE = '<?xml version="1.0"?><!DOCTYPE kml SYSTEM "file:///etc/passwd"><kml/>'


@pytest.mark.parametrize("text", [BOMB, OUTSIDE, "<!DOCTYPE kml><kml/>"])
def test_a_document_type_is_refused_before_anything_is_expanded(text: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, text).startswith("has a document type")


def test_depth_elements_and_the_size_of_archives_are_limited(tmp_path: Path) -> None:
    deep = "<kml>" + "<a>" * MAX_DEPTH
    many = "<kml>" + "<a/>" * MAX_ELEMENTS
    for text in (deep, many):
        assert refusal(tmp_path, text).startswith("is larger than it may be")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", b" " * (MAX_BYTES + 1))
    data = packed.getvalue()
    assert refusal(tmp_path, data, "map.kmz").startswith("has a KML file of more than")
    assert refusal(tmp_path, data[:-30], "map.kmz").startswith("is not a readable archive")
    assert refusal(tmp_path, b"PK", "map.kmz").startswith("is not a readable archive")


@pytest.mark.parametrize("method", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_an_archive_is_packed_as_kmz_is(method: int, tmp_path: Path) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        archive.writestr("doc.kml", kml(PATH))
    assert "is packed in a way that KMZ does not know" in refusal(
        tmp_path, packed.getvalue(), "map.kmz"
    )


def test_a_broken_archive_is_refused(tmp_path: Path) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", kml(PATH))
    whole = packed.getvalue()
    for place in range(40, whole.index(b"PK\x01\x02") - 2, 7):  # in what is packed
        broken = whole[:place] + b"\xff\xff" + whole[place + 2 :]
        assert refusal(tmp_path, broken, "map.kmz")
