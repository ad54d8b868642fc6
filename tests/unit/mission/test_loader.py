"""A good mission means what it says; a spoilt one is refused at the right line and column.

Each row of SPOILT replaces one piece of the good mission. The mark § in the replacement is
where the error must point; it is taken out before the mission is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import FormulaError, Location, MissionError
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace, Otherwise
from companion.mission.skill_numbers import MAX_INSTANCES, MAX_STEPS
from companion.vehicle_profile import VehicleProfile

QUAD = VehicleProfile()

Load = Callable[[str | bytes], Mission]

SPOILT: list[tuple[str, str, str, str]] = [
    # keys and values
    ("version: 1", "version: §2", "version is 2, expected 1", "Version of this format"),
    ("name: patrol", "name: §7", "name is 7, expected a text", "Letters"),
    ("name: patrol", "name: §a/b", "name is 'a/b'", "Letters"),
    ("name: patrol\n", "", "the key name is missing", "Letters"),
    ("frame: enu", "frame: §ned", "frame is 'ned', expected enu or wgs84", "metres east"),
    ("frame: enu", "frame: §nu", "frame is 'nu', expected enu or wgs84", "Did you mean enu?"),
    ("places:", "§palces:", "unknown key 'palces'", "Did you mean places?"),
    ("speed_mps: 2.0", "speed_mps: §fast", "speed_mps is 'fast', expected a number", "m/s"),
    ("speed_mps: 2.0", "speed_mps: §'2.0'", "speed_mps is '2.0', expected a number", "m/s"),
    ("speed_mps: 2.0", "speed_mps: §.nan", ".nan is not a finite number", ""),
    ("speed_mps: 2.0", "speed_mps: §-1", "speed_mps is -1, expected at least 0.1", "m/s"),
    ("speed_mps: 2.0", "speed_mps: §21", "speed_mps is 21, expected at most 20", "m/s"),
    ("up_m: [0.5, 4.0]", "up_m: [0.5, §4.0e+5]", "is 400000.0, expected at most 10000", ""),
    ("[10, 8.5]", "[§10000.5, 8.5]", "entry 1 in limits.fence.2 is 10000.5, expected at most", ""),
    (
        "  A: {east_m: 5",
        "  A: {east_m: §1.0e+308",
        "east_m is 1e+308, expected at most 10000",
        "home",
    ),
    ("radius_m: 0.4", "radius_m: §1.0e+9", "expected at most 1000", "at(place)"),
    ("for_s: 2", "for_s: §1.0e+9", "expected at most 86400", "Seconds"),
    ("timeout_s: 15", "timeout_s: §1.0e+9", "expected at most 86400", "Longest"),
    ("  speed_mps: 2.0", "  §speed: 2.0", "unknown key 'speed' in limits", "mean speed_mps?"),
    ("up_m: [0.5, 4.0]", "up_m: §[0.5]", "up_m is a list, expected more entries", "Lowest"),
    ("up_m: [0.5, 4.0]", "up_m: §[4, 0.5]", "altitudes 4 to 0.5 m", "lowest first"),
    ("up_m: [0.5, 4.0]", "up_m: §[0.5, 4000]", "up_m reaches 4000 m", "add unusual: true"),
    (
        "fence: [[0, 0], [10, 0], [10,",
        "fence: §[[0, 0], [9000, 0], [9000,",
        "reaches 9000 m",
        "unusual",
    ),
    ("[10, 8.5]", "[10, §true]", "entry 2 in limits.fence.2 is true", ""),
    ("[[0, 0], [10, 0], [10, 8.5], [0, 8.5]]", "§[[0, 0], [1, 0]]", "at least 3", "Corners"),
    ("radius_m: 0.4", "radius_m: §0", "radius_m is 0, expected more than 0", "at(place)"),
    ("radius_m: 0.4", "§raduis_m: 0.4", "unknown key 'raduis_m' in places.no", "mean radius_m?"),
    ("  A: {east_m: 5, ", "  §A: {", "the key east_m is missing in places.A", "Metres east"),
    ("  A: {", "  §A-1: {", "'A-1' is not a name", "no digit first: write A_1"),
    ("latch: true", "latch: §yes", "latch is 'yes', expected true or false", "for ever"),
    ("for_s: 2", "for_s: §-1", "for_s is -1, expected at least 0", "Seconds"),
    ("tries: 3", "tries: §2.5", "tries is 2.5, expected a whole number", "How often"),
    ("tries: 3", "tries: §0", "tries is 0, expected at least 1", "How often"),
    ("tries: 3", "§tries:", "tries is empty, expected a whole number", "How often"),
    ("timeout_s: 15", "§timeout_s:", "timeout_s: has no value", ""),
    ("precondition: at(from)", "§precondition:", "precondition: has no value", ""),
    ("cost: 10", "cost: §null", "cost: has no value", ""),
    ("    until: BATTERY_STATUS.battery_remaining > 80", "    §until:", "has no value", ""),
    ("cost: 10", "cost: §flighttime", "expected flight_time or a number", "mean flight_time?"),
    ("timeout_s: 15", "timeout_s: §0", "timeout_s is 0, expected more than 0", "Longest"),
    ("payload: 25", "payload: §256", "payload is 256, expected at most 255", ""),
    ("effect: reported", "effect: §[a]", "effect is a list, expected a text", "Facts"),
    ("otherwise: land", "otherwise: §lande", "expected return_home, land or hold", "mean land?"),
    ("otherwise: land", "otherwise: {§land_on: [A]}", "unknown key 'land_on'", "mean land_at?"),
    ("otherwise: land", "otherwise: {land_at: §A}", "land_at is 'A', expected a list", "Places"),
    ("otherwise: land", "otherwise: {land_at: §[]}", "expected at least 1 entries", "Places"),
    ("otherwise: land", "§otherwise: {}", "the key land_at is missing in otherwise", "Places"),
    ("otherwise: land", "otherwise: §[A, no]", "expected return_home, land or hold", "land_at"),
    ("otherwise: land", "otherwise: {land_at: [A, §B]}", "unknown place B in land_at", "Home, A"),
    ("otherwise: land", "otherwise: {land_at: [A, §hom]}", "place hom in land_at", "mean Home?"),
    ("otherwise: land", "otherwise: {land_at: [A, §A]}", "A is twice in land_at", "remove"),
    ("otherwise: land", "otherwise: {land_at: [§3]}", "is 3, expected a text", ""),
    ("Site: [A, no]", "Site: §[]", "Site is a list, expected at least 1 entries", ""),
    ("initially: [at(Home)]", "initially: §at(Home)", "expected a list", "Facts"),
    # names
    ("Site: [A, no]", "Site: [§Hom, no]", "unknown place Hom in the set Site", "mean Home?"),
    ("Site: [A, no]", "Site: [A, no, §A]", "A is twice in the set Site", "remove"),
    ("  A: {", "  §here: {", "a place cannot be called here", "present position"),
    ("  low:", "  §G:", "an event cannot be called G", "meaning of its own"),
    ("  low:", "  §at:", "an event cannot be called at", "meaning of its own"),
    ("{r: Site}", "{r: §Sites}", "unknown set Sites", "Did you mean Site?"),
    ("{r: Site}", "{r: Site, §q: Site}", "the parameter q of upload is not used", "remove"),
    ("{r: Site}", "{r: Site, §A: Site}", "the parameter A has the name of a place", "two"),
    ("  upload:\n    para", "  §wait:\n    para", "a skill cannot be called wait", "resting"),
    # events
    ("[target].value", "[target].§valeu", "NAMED_VALUE_INT has no field valeu", "mean value?"),
    ("    until:", "    latch: true\n    §until:", "low has both latch and until", "remove one"),
    # skills
    ("effect: reported", "effect: §found", "found is an event", "remove the event in line 18"),
    ("[canUpload(r)]", "[§found]", "found is an event", "another fact"),
    ("assumes: [canUpload(r)]", "assumes: [§canUpload(q)]", "q in canUpload(q)", "parameters"),
    ("assumes: trans_ok(from, to)", "assumes: [trans_ok§(from, to)]", "half a fact", "quotes"),
    ("effect: at(to) &", "effect: §at(to, to) &", "at has 1 argument", "write at(to) | at(to)"),
    ("effect: reported", "effect: §reported | done", "neither a fact", "joined by &"),
    ("at(r) & found &", "at(r) & §found(r) &", "found has no arguments", "write found"),
    ("at(r) & found", "§at(r) & founded", "nothing ever makes founded true", "mean found?"),
    ("fly(to)", "fly(§too)", "too is not a parameter of this skill", "Did you mean to?"),
    ("fly(to)", "§fli(to)", "unknown primitive fli", "Did you mean fly?"),
    ("fly(to)", "§fly to", "not something to execute", "fly(parameter)"),
    ("fly(to)", "§fly()", "fly has 0 arguments", "fly(parameter)"),
    ("fly(to)", "wait(§-1)", "a time cannot be negative", "seconds"),
    ("fly(to)", "§land(to)", "land has 1 arguments", "land()"),
    ("fly(to)", "charge(§0)", "a battery has 0 to 100 percent", "90"),
    ("fly(to)", "[fly(to), §upload()]", "upload is called with 0 arguments", "upload(r)"),
    ("fly(to)", "[fly(to), §upload(D)]", "D is not a parameter of move", ""),
    ("fly(to)", "[fly(to), §'move(from, to)']", "move is refined into itself", "primitives"),
    ("fly(to)", "§[]", "execute is a list, expected at least 1 entries", ""),
    ("    until:", "    restores: [§canUplod]\n    until:", "restores canUplod", "mean canUpload?"),
    ("command(payload", "command(§paylaod", "unknown component paylaod", "mean payload?"),
    ("MAV_CMD_USER_1", "§MAV_CMD_USR_1", "unknown command MAV_CMD_USR_1", "MAV_CMD_USER_1?"),
    ("MAV_CMD_USER_1", "§MAV_CMD_COMPONENT_ARM_DISARM", "is not a command for payloads", "land()"),
    ("1.5, -2", "1.5, §nan", "nan is not a number", "1.5"),
    ("1.5, -2", "1.5, §1e39", "1e39 is not a number", "1.5"),
    ("cost: 10", "cost: §flight_time", "upload does not fly", "write seconds"),
    ("cost: 10", "cost: §0", "cost is 0", "more than 0"),
    # places on the map
    ("  A: {east_m: 5,", "  §A: {east_m: 0.2,", "place A is in a wall", "east_m: 1.75"),
    ("  A: {east_m: 5,", "  §A: {east_m: 0.8,", "only 0.30 m from a wall", "east_m: 1.75"),
    ("  A: {east_m: 5,", "  §A: {east_m: 1.2,", "its cell of the map, 0.5 m wide, comes", "1.75"),
    ("  A: {east_m: 5,", "  §A: {east_m: -5,", "outside the map", "east_m 0 to 10"),
    (
        "  A: {east_m: 5, north_m: 7",
        "  §A: {east_m: 5, north_m: 8.8",
        "outside the fence",
        "[10, 8.5]",
    ),
    (
        "  A: {east_m: 5, north_m: 7",
        "  §A: {east_m: 5, north_m: 8.45",
        "place A is only 0.05 m from the fence, 0.1 m are needed",
        "widen limits.fence",
    ),
    (
        "  A: {east_m: 5, north_m: 7, up_m: 1.5",
        "  §A: {east_m: 5, north_m: 7, up_m: 4.5",
        "place A is at 4.5 m, outside 0.5 to 4 m",
        "limits.up_m",
    ),
    # facts of initially and task
    ("[at(Home)]", "§[reported]", "no fact says where the vehicle is", "at(Home)"),
    ("[at(Home)]", "[at(Home), §at(A)]", "cannot be at two places", "keep one"),
    ("[at(Home)]", "[§at(Hom)]", "unknown fact at(Hom)", "Did you mean at(Home)?"),
    ("[at(Home)]", "[at(Home), '§!low']", "not a fact", "leave it out"),
    ("F at(A) |", "F §at(D) |", "unknown fact at(D)", "places are Home, A, no. Did you mean"),
    ("F at(A) |", "F §canUpload(Home) |", "unknown fact canUpload(Home)", "one of A, no"),
    ("| found)", "| §foundd)", "unknown fact foundd", "Did you mean found?"),
    ("| found)", "| §trans_ok(A))", "trans_ok has 2 arguments", "trans_ok(Home, Home)"),
    ("F at(A) |", "F at(A) §found |", "unexpected 'found'", ""),
    ("| found)", "| found§", "ends too early", ""),
    ("       F reported)", "       F §reportd)", "unknown fact reportd", "mean reported?"),
    ("G !(at(no)", "G !(at§[no)", "has no meaning in a formula", ""),
    ("(at(no) & low)", "(§at(on) & low)", "unknown fact at(on)", "Did you mean at(no)?"),
    # YAML
    ("F at(A) |", "F at(A)§: |", "mapping values are not allowed", "quotes"),
    ("'G !(at(no) & low)'", "§!at(no)", "YAML tag !at(no) is not allowed", "quotes"),
    ("'G !(at(no) & low)'", "§&at(no)", "YAML anchor &at(no) is not allowed", "quotes"),
    ("'G !(at(no) & low)'", "§*at", "YAML alias *at is not allowed", "quotes"),
    ("  avoid: ", "  §search: ", "the key search is given twice", "first given in line"),
    ("version: 1", "§%YAML 1.2\n---\nversion: 1", "directives are not allowed", "%"),
    ("otherwise: land", "otherwise: land\n§---\na: 1", "second YAML document", "---"),
    ("map: room.yaml", "map: §hall.yaml", "hall.yaml cannot be read", ""),
    ("map: room.yaml", "map: §.", "cannot be read", ""),
]


def spoil(good: str, old: str, new: str) -> tuple[str, str]:
    """The spoilt text and line:column of the mark."""
    assert good.count(old) >= 1, old
    marked = good.replace(old, new, 1)
    before, _, after = marked.partition("§")
    if "§" not in marked:  # a missing key is told at the parent: here the file's first key
        return marked, "1:1"
    return before + after, f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


@pytest.mark.parametrize(
    ("old", "new", "what", "hint"), SPOILT, ids=[f"{w} {n[:30]}" for _, n, w, _ in SPOILT]
)
def test_error_says_what_where_and_what_to_do(
    load: Load, good: str, old: str, new: str, what: str, hint: str
) -> None:
    text, place = spoil(good, old, new)
    with pytest.raises(MissionError) as caught:
        load(text)
    message = str(caught.value)
    head, *rest = message.splitlines()
    assert re.match(rf".*/mission\.yaml:{place}: ", head), message
    assert what in head
    assert hint in "\n".join(rest)


def test_safe_places_are_at_most_as_many_as_a_px4_has_rally_points(load: Load, good: str) -> None:
    names = ", ".join(["Home"] * 33)
    with pytest.raises(MissionError, match="land_at is a list, expected at most 32 entries"):
        load(good.replace("otherwise: land", f"otherwise: {{land_at: [{names}]}}"))


@pytest.mark.parametrize(
    ("written", "meant", "places"),
    [
        ("land", Otherwise.LAND, ()),
        ("hold", Otherwise.HOLD, ()),
        ("return_home", Otherwise.RETURN_HOME, ("Home",)),
        ("{land_at: [A, Home]}", LandAtSafePlace(("A", "Home")), ("A", "Home")),
    ],
)
def test_what_is_done_without_a_plan(
    load: Load, good: str, written: str, meant: Otherwise | LandAtSafePlace, places: tuple[str, ...]
) -> None:
    mission = load(good.replace("otherwise: land", f"otherwise: {written}"))
    assert (mission.otherwise, mission.safe_places) == (meant, places)


def test_the_formula_is_shown_with_a_caret(load: Load, good: str) -> None:
    with pytest.raises(FormulaError) as caught:
        load(good.replace("F at(A)", "F at(D)"))
    assert str(caught.value).split("mission.yaml:")[1] == (
        "44:16: unknown fact at(D)\n"
        "    G (F at(D) | found)\n"
        "         ^^^^^  places are Home, A, no. Did you mean at(A)?"
    )


def test_unknown_keys_are_told_before_the_keys_that_they_leave_missing(
    load: Load, good: str
) -> None:
    with pytest.raises(MissionError, match=r":38:5: unknown key 'efect' in skills\.upload"):
        load(
            good.replace("effect: reported", "efect: reported").replace("version: 1", "version: 2")
        )


def test_windows_line_ends_and_byte_order_mark_change_nothing(load: Load, good: str) -> None:
    assert load("\ufeff" + good.replace("\n", "\r\n")).task == load(good).task
    with pytest.raises(MissionError, match=r":44:16: unknown fact"):
        load(("\ufeff" + good.replace("F at(A)", "F at(D)")).replace("\n", "\r\n"))


def test_missing_file_is_a_mission_error(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"none\.yaml cannot be read: No such file"):
        load_mission(tmp_path / "none.yaml")
    with pytest.raises(MissionError, match="cannot be read: Is a directory"):
        load_mission(tmp_path)


def test_bytes_that_are_no_text_are_located(load: Load, good: str) -> None:
    with pytest.raises(MissionError, match=r":2:8: the file is not UTF-8 text"):
        load(good.replace("patrol", "p§").encode("latin-1"))


def test_too_many_instances_are_refused(load: Load, good: str) -> None:
    count = int(MAX_INSTANCES ** (1 / 3)) + 1
    names = [f"p{i}" for i in range(count)]
    places = "".join(f"  {n}: {{east_m: 5, north_m: 5, up_m: 1}}\n" for n in names)
    text = (
        good.replace("sets:\n", f"{places}sets:\n  Many: [{', '.join(names)}]\n")
        .replace("{from: Place, to: Place}", "{from: Many, to: Many, via: Many}")
        .replace("trans_ok(from, to)", "trans_ok(from, to, via)")
    )
    with pytest.raises(MissionError, match=f"instances, at most {MAX_INSTANCES}"):
        load(text)


@pytest.mark.parametrize("length", [10, 30])
def test_refinements_that_multiply_are_refused(load: Load, good: str, length: int) -> None:
    """In a chain of skills, each done by the next one twice, the first has 2 ** length ends."""
    chain = "".join(
        f"  s{i}: {{effect: done, execute: ['s{i + 1}()', 's{i + 1}()']}}\n" for i in range(length)
    )
    last = f"  s{length}: {{effect: done, execute: wait(1)}}\n"
    text = good.replace("skills:\n", f"skills:\n{chain}{last}")
    if 2**length > MAX_STEPS:
        with pytest.raises(MissionError, match=f"with s0 the actions have .* at most {MAX_STEPS}"):
            load(text)
    else:
        load(text)


def test_clearance_decides_to_the_cell(load: Load, good: str) -> None:
    """A is accepted from the first cell on that has the clearance."""
    accepted = []
    for column in range(20):
        east_m = 0.25 + 0.5 * column
        try:
            load(good.replace("A: {east_m: 5,", f"A: {{east_m: {east_m},"))
        except MissionError as error:
            assert "place A is" in str(error)
        else:
            accepted.append(east_m)
    assert accepted == [
        x
        for x in (0.25 + 0.5 * c for c in range(20))
        if min(x - 0.75, 9.25 - x) >= QUAD.clearance_m  # its cell's edges, to those of the walls
    ]


EDITS = st.lists(
    st.tuples(
        st.integers(0, 2000),
        st.integers(0, 12),
        st.one_of(
            st.sampled_from(
                ["", "[", "{", "}", "]", ":", ": ", "- ", "!", "&a ", "*a", "|", ">", "#", "'", '"',
                 "\\", "\n", "\t", "%", "0", "1e9", ".inf", "null", "(", ")", ",", "at(", "\x00"]
            ),
            st.text(max_size=6),
        ),
    ),
    min_size=1,
    max_size=4,
)  # fmt: skip


@pytest.mark.slow
@given(edits=EDITS)
@drawn(250)
def test_edits_raise_nothing_but_mission_errors(
    load: Load, good: str, edits: list[tuple[int, int, str]]
) -> None:
    text = good
    for start, length, inserted in edits:
        position = start % (len(text) + 1)
        text = text[:position] + inserted + text[position + length :]
    try:
        mission = load(text.encode("utf-8", "surrogatepass"))
    except MissionError as error:
        assert isinstance(error.where, Location)
        assert error.where.line <= text.count("\n") + text.count("\r") + 2
    else:
        assert mission.task


def test_unusual_limits_may_be_meant(load: Load, good: str) -> None:
    high = good.replace("up_m: [0.5, 4.0]", "up_m: [0.5, 4000]\n  unusual: true")
    assert load(high).limits.up_m == (0.5, 4000.0)
