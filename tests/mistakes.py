"""What strangers write in their first missions and worlds, and what the answer has to say.

Each row: what is right in a starter, what is written instead, which line of the file the answer
has to name, and words of its remedy. Those who know PX4 stumble over the logic, those who know the
logic over coordinates and MAVLink, and all of them over YAML.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.plans.starter import StarterSpace, starter
from companion.plans.starter_tasks import TaskName


class Mistake(NamedTuple):
    """A mistake in a file.

    Attributes:
        right: what the file has.
        wrong: what stands there instead.
        line: begins the line that is named; empty for the first line.
        words: of the answer.
    """

    right: str
    wrong: str
    line: str
    words: str


Table = dict[str, Mistake]

_INSPECTION = starter("first", StarterSpace.FIELD, TaskName.INSPECTION)
_RESPONSE = starter("first", StarterSpace.FIELD, TaskName.RESPONSE)
FIELD, ALARMED = _INSPECTION.mission, _RESPONSE.mission
HALL = starter("first", StarterSpace.HALL, TaskName.RESPONSE).mission
EARTH = starter("first", StarterSpace.EARTH, TaskName.INSPECTION).mission
WORLD = _RESPONSE.world
CHARGED = FIELD.replace("\nplaces:", "\nbattery: {reserve: 20}\n\nplaces:", 1).replace(
    "    execute: photo(camera)          # done when the photo is there",
    "    charge_rate: [[0, 1], [100, 0.1]]\n    execute: [land(), charge(auto), take_off()]",
)

_HOME = "  home: F G at(Home)"
_ALARM = '"EVENT[alarm] > 0"'


def _task(formula: str, words: str) -> Mistake:
    return Mistake(_HOME, f"  home: {formula}", "  home:", words)


def _event(when: str, words: str) -> Mistake:
    return Mistake(f"when: {_ALARM}", f"when: {when}", "  alarm:", words)


LOGIC: Table = {
    "or": _task("F at(A) or F at(B)", "write |"),
    "AND": _task("F at(A) AND F at(B)", "write &"),
    "not": _task("G not at(B)", "write !"),
    "a tilde": _task("G ~at(B)", "write !"),
    "two equal signs": _task("at(A) == at(B)", "write <->"),
    "an arrow of programs": _task("G (at(A) => F at(B))", "write ->"),
    "an arrow of books": _task("G (at(A) → F at(B))", "write ->"),
    "a box": _task("□ at(Home)", "write G"),
    "a diamond": _task("◇ at(Home)", "write F"),
    "a box of ASCII": _task("'[] at(Home)'", "write G"),
    "a diamond of ASCII": _task("'<> at(Home)'", "write F"),
    "a word for F": _task("eventually at(Home)", "write F"),
    "a word for G": _task("always at(Home)", "write G"),
    "a word for U": _task("at(Home) until at(A)", "write U"),
    "operators glued": _task("GF at(Home)", "did you mean 'G F'?"),
    "a bracket too few": _task("F (at(Home)", "ends too early"),
    "goals with a comma": _task("F at(A), F at(B)", "expected an operator (& |"),
    "for all": _task("forall p in Site. F at(p)", "at(A) & at(B), or a pattern"),
    "a bound in words": _task("F at(A) within 60 s", "write F[<=60s] at(A)"),
    "a bound as in MTL": _task("F[0,60] at(A)", "write F[<=60s] at(A)"),
    "a bound without a unit": _task("F[<=60] at(A)", "write F[<=60s] at(A)"),
    "a bound in another unit": _task("F[<=60sec] at(A)", "s and min are known"),
    "a bound at G": _task("G[<=60s] at(A)", "write F[<=60s] at(A)"),
    "a bound too short": _task("F[<=1s] at(A)", "a bound is 3 s to"),
    "a formula with !": _task("!at(A)", "put quotes around"),
    "a place misspelt": _task("F at(Hmoe)", "Did you mean at(Home)?"),
    "a place without at": _task("F G Home", "Did you mean at(Home)?"),
    "a place without brackets": _task("F at A", "write at(A)"),
    "a place in lower case": _task("F at(a)", "Did you mean at(A)?"),
    "an unknown fact": _task("F landed", "facts are at(Home)"),
    "a skill in the task": _task("F shoot(A)", "write what it makes true"),
    "a number compared": _task("F (battery < 30)", "make an event of it"),
    "a pattern misspelt": _task("patroling(A, B)", "mean patrolling(A, B)?"),
    "a pattern with too little": _task("delayed_reaction(at(A))", "write delayed_reaction("),
    "quotes of books": _task("\u201cF at(Home)\u201d", "is made of names"),
    "priority as a word": _task("{formula: F at(A), priority: high}", "expected a whole number"),
    "an arrow of others": _task("at(A) --> F at(B)", "write ->"),
    "a power of X": _task("X^2 at(A)", "write X X at(A)"),
    "since": _task("at(A) S at(B)", "formulas look forwards"),
    "once": _task("O at(A)", "formulas look forwards"),
    "paths": _task("EF at(Home)", "a plan is one path"),
    "two places at once": _task("F at(A, B)", "write at(A) | at(B)"),
    "a bound below": _task("F_[0,60] at(A)", "write F[<=60s] at(A)"),
    "a bound in braces": _task("'F_{<=60} at(A)'", "write F[<=60s] at(A)"),
    "every so often": _task("revisit(A) every 5 min", "write revisit(A) <= 5 min"),
    "a list for a pattern": _task("patrolling([A, B])", "write e.g. patrolling(A, B)"),
    "a landing": _task("F land", "The vehicle lands where the task is done"),
    "a goal in time": Mistake("task:", "goal: F at(A)\ntask:", "goal", "stand in the task alone"),
    "no line has a name": Mistake(
        FIELD[FIELD.index("task:") : FIELD.index("\n\n# What is done")],
        "task: F at(A) & F at(B)",
        "task:",
        "task: Name: formula",
    ),
}
"""In the task; in the FIELD."""

IN_WORDS: Table = {
    "at two places at once": _task("F (at(A) & at(B))", "F at(A) & F at(B) goes to each"),
    "always, from the start": _task("G at(A)", "F G at(A) asks for it from some time on"),
    "until, from the start": _task("at(A) U at(B)", "at(A) is false now"),
}
"""Lines that can be read, and never hold."""

SKILLS: Table = {
    "an unknown component": Mistake("photo(camera)", "photo(kamera)", "    exec", "mean camera?"),
    "no components": Mistake("components: {", "# {", "    exec", "add components: {camera: 100}"),
    "a component by its name": Mistake("100}", "MAV_COMP_ID_CAMERA}", "components", "(1 to 255)"),
    "the companion as a component": Mistake("100}", "191}", "components", "give camera another id"),
    "an unknown command": Mistake(
        "photo(camera)", "command(camera, MAV_CMD_TAKE_PHOTO)", "    exec", "common.xml lists them"
    ),
    "a command by its number": Mistake(
        "photo(camera)", "command(camera, 2000)", "    exec", "write MAV_CMD_IMAGE_START_CAPTURE"
    ),
    "a command that flies": Mistake(
        "photo(camera)", "command(camera, MAV_CMD_NAV_TAKEOFF)", "    exec", "take_off() move the"
    ),
    "another word for fly": Mistake("fly(to)", "goto(to)", "    exec", "Did you mean fly?"),
    "coordinates to fly to": Mistake("fly(to)", "fly(40, 0, 6)", "    exec", "fly(parameter)"),
    "a script": Mistake("photo(camera)", "photo.py", "    exec", "python(name, arguments)"),
    "a mode": Mistake("photo(camera)", "rtl()", "    exec", "a line of the task: F G at(Home)"),
    "a component that has no name": Mistake(
        "photo(camera)", "command(1, MAV_CMD_USER_1)", "    exec", "add others there, {NAME: ID}"
    ),
    "a place to fly to": Mistake("fly(to)", "fly(A)", "    exec", "A plan says which place"),
    "a step without brackets": Mistake("photo(camera)", "photo", "    exec", "write photo(camera)"),
    "two steps": Mistake("fly(to)", "fly(to), wait(2)", "    exec", "[fly(to), wait(2)]"),
    "what does not hold": Mistake("[at(Home)]", "[at(Home), '!at(A)']", "initially", "leave it"),
    "half a fact": Mistake("[at(Home)]", "[at(Home), x(A, B)]", "initially", "put quotes around"),
    "a wait with its unit": Mistake("photo(camera)", "wait(5s)", "    exec", "number alone: 5"),
    "no execute": Mistake(
        "    execute: photo(camera)", "    #", "  shoot:", "execute: What the vehicle does"
    ),
    "no effect": Mistake("    effect: shot(site)\n", "", "  shoot:", "add effect: FACTS"),
    "still at where it came from": Mistake(
        "at(to) & !at(from)", "at(to)", "    effect", "add !at(from) to its effect"
    ),
    "or in a precondition": Mistake(
        "precondition: at(site)", "precondition: at(site) | at(A)", "    prec", "joined by &"
    ),
    "a parameter that is missing": Mistake(
        "at(site)\n", "at(spot)\n", "    prec", "parameters and places are"
    ),
    "parameters as a list": Mistake("{site: Site}", "[site]", "    param", "e.g. {to: Place}"),
    "an unknown set": Mistake("{site: Site}", "{site: Sites}", "    param", "Did you mean Site?"),
    "a member that is none": Mistake("[A, B, C]", "[A, B, D]", "  Site:", "places are Home, A"),
    "members without brackets": Mistake("[A, B, C]", "A, B, C", "  Site:", "Name: [members]"),
    "another word for tries": Mistake("tries: 2", "retries: 2", "    retries", "mean tries?"),
    "no start": Mistake("[at(Home)]", "[]", "initially", "e.g. at(Home)"),
    "a place as a fact": Mistake("[at(Home)]", "[Home]", "initially", "Did you mean at(Home)?"),
    "PX4's name of a mode": Mistake("return_home\n", "RTL\n", "otherwise", "return_home, land"),
}
"""Of skills, and what else is in a mission; in the FIELD."""

EVENTS: Table = {
    "an event by its source": Mistake("F alarm", "F EVENT[alarm]", "  patrol", "under events"),
    "an event misspelt": Mistake("(alarm ->", "(alam ->", "  answer", "Did you mean alarm?"),
    "an event set by a skill": Mistake(
        "effect: looked", "effect: looked & !alarm", "    effect", "an event is read off MAVLink"
    ),
    "a condition without quotes": _event("EVENT[alarm] > 0", "put quotes around"),
    "one equal sign": _event('"EVENT[alarm] = 1"', "write =="),
    "nothing compared": _event('"EVENT[alarm]"', "add a comparison"),
    "two conditions": _event('"EVENT[a] > 0 and EVENT[b] > 0"', "make an event of each"),
    "a message misspelt": _event("BATERY_STATUS.battery_remaining < 3", "mean BATTERY_STATUS?"),
    "a field misspelt": _event("BATTERY_STATUS.remaining < 30", "fields are id"),
    "a number with its unit": _event(
        '"BATTERY_STATUS.battery_remaining < 30%"', "number alone: 30"
    ),
    "a command alone": _event("MAV_CMD_USER_1", "write COMMAND.MAV_CMD_USER_1"),
    "a share": _event("BATTERY_STATUS.battery_remaining < 0.3", "write percent: 30"),
    "true": _event('"EVENT[alarm] == true"', "> 0 for true"),
    "a value by its name": _event("HEARTBEAT.custom_mode == RTL", "compare with a NUMBER"),
    "a topic of uORB": _event("vehicle_status.failsafe > 0", "uORB topics are not among them"),
    "a topic": _event("/alarm", "write MESSAGE.field > NUMBER"),
    "yes": Mistake("latch: true", "latch: yes", "  alarm:", "expected true or false"),
    "a time without its unit": Mistake("latch: true", "for: 5", "  alarm:", "mean for_s?"),
}
"""Of events; ALARMED."""

PLACES: Table = {
    "a unit": Mistake("speed_mps: 5", "speed_mps: 5 m/s", "  speed", "the number alone: 5."),
    "another unit": Mistake("speed_mps: 5", "speed_mps: 30 km/h", "  speed", "second: 8.33."),
    "feet": Mistake("up_m: 6}", "up_m: 20 ft}", "  Home:", "write metres: 6.1."),
    "no speed at all": Mistake("speed_mps: 5", "speed_mps: 1e-9", "  speed", "m/s"),
    "a unit of something else": Mistake(
        "speed_mps: 5", "speed_mps: 5 min", "  speed", "a number of metres per second."
    ),
    "a comment at once": Mistake("speed_mps: 5", "speed_mps: 5#m/s", "  speed", "space before #"),
    "PX4's name of a zone": Mistake(
        "  fence:", "  no_fly: {a: [[0, 0], [1, 0], [1, 1]]}\n  fence:", "  no_fly", "keep_out?"
    ),
    "a decimal comma": Mistake("speed_mps: 5", "speed_mps: 2,5", "  speed", "a point: 2.5"),
    "a decimal comma in braces": Mistake(
        "A: {east_m: 40,", "A: {east_m: 40,5,", "  A:", "ends an entry: write 40.5"
    ),
    "a number in quotes": Mistake("speed_mps: 5", "speed_mps: '5'", "  speed", "without quotes: 5"),
    "km/h": Mistake("speed_mps: 5", "speed_kmh: 18", "  speed", "Did you mean speed_mps?"),
    "a key misspelt": Mistake("speed_mps: 5", "sped_mps: 5", "  sped", "mean speed_mps?"),
    "heights reversed": Mistake("[1, 10]", "[10, 1]", "  up_m", "lowest first"),
    "one height": Mistake("[1, 10]", "10", "  up_m", "[0.5, 4.0]"),
    "a fence of two corners": Mistake(
        "[[-20, -20], [60, -20], [60, 50], [-20, 50]]", "[[-20, -20], [60, 50]]", "  fence", "at"
    ),
    "a fence of numbers": Mistake(
        "[[-20, -20], [60, -20], [60, 50], [-20, 50]]", "[-20, -20, 60, 50]", "  fence", "[[east"
    ),
    "a fence that crosses itself": Mistake(
        "[60, -20], [60, 50]", "[60, 50], [60, -20]", "  fence", "go round it once"
    ),
    "no fence": Mistake("  fence:", "  # fence:", "  speed_mps", "fence: [[east, north], ...]"),
    "x, y and z": Mistake("A: {east_m: 40", "A: {x: 40", "  A:", "Did you mean east_m?"),
    "an altitude": Mistake("A: {east_m: 40, north_m: 0, up", "A: {east_m: 40, north_m: 0, alt",
                           "  A:", "Did you mean up_m?"),
    "down is positive": Mistake("0, up_m: 6}\n  B", "0, up_m: -6}\n  B", "  A:", "limits.up_m"),
    "a place as a list": Mistake(
        "A: {east_m: 40, north_m: 0, up_m: 6}", "A: [40, 0, 6]", "  A:", "keys are east_m, north_m"
    ),
    "a place outside the fence": Mistake("A: {east_m: 40", "A: {east_m: 400", "  A:", "fence"),
    "a place without its height": Mistake(", up_m: 6}", "}", "  Home:", "up_m"),
    "degrees among metres": Mistake(
        "A: {east_m: 40, north_m: 0", "A: {lat_deg: 47, lon_deg: 8", "  A:", "add frame: wgs84"
    ),
    "a map that is not there": Mistake(
        "limits:", "map: maps/my.png\nlimits:", "map:", "YAML file beside the map's image"
    ),
    "a name of two words": Mistake("  A: {", "  Site A: {", "  Site A:", "write Site_A"),
}  # fmt: skip
"""Of places and limits; in the FIELD."""

DEGREES: Table = {
    "latitude and longitude exchanged": Mistake(
        "lat_deg: 47.397742, lon_deg: 8.546125", "lat_deg: 8.546125, lon_deg: 47.397742",
        "  A:", "are exchanged",
    ),
    "the fence exchanged": Mistake(
        "[47.397562, 8.545328]", "[8.545328, 47.397562]", "  fence", "are exchanged"
    ),
    "metres among degrees": Mistake(
        "lat_deg: 47.397742, lon_deg: 8.546125", "east_m: 40, north_m: 0", "  A:", "write lat_deg"
    ),
    "degrees times 1e7": Mistake(
        "lon_deg: 8.546125", "lon_deg: 85461250", "  A:", "Degrees east"
    ),
    "a hemisphere": Mistake("47.397742, lon_deg: 8.546125", "47.397742N, lon_deg: 8.546125",
                            "  A:", "the number alone: 47.397742"),
    "the south": Mistake("47.397742, lon_deg: 8.546125", "47.397742 S, lon_deg: 8.546125",
                         "  A:", "the number alone: -47.397742"),
    "lat": Mistake("lat_deg: 47.397742, lon", "lat: 47.397742, lon", "  Home:", "mean lat_deg?"),
    "WGS84": Mistake("frame: wgs84", "frame: WGS84", "frame", "Did you mean wgs84?"),
}  # fmt: skip
"""On the EARTH."""

WALLS: Table = {
    "a wall as a list": Mistake(
        "{east_m: [6.8, 7.2], north_m: [-2, 5]}", "[6.8, 7.2, -2, 5]", "    - ", "keys are east_m"
    ),
    "a wall reversed": Mistake("[6.8, 7.2]", "[7.2, 6.8]", "  east_m", "write [6.8, 7.2]"),
    "a place in a wall": Mistake(
        "A: {east_m: 14, north_m: 8", "A: {east_m: 7, north_m: 2", "  A:", "nearest point"
    ),
    "a place off the map": Mistake("Gate: {east_m: 14", "Gate: {east_m: 24", "  Gate:", "spans"),
}
"""In the HALL."""

BATTERY: Table = {
    "a percent sign": Mistake("reserve: 20", "reserve: 20%", "battery", "the number alone: 20"),
    "a share": Mistake("reserve: 20", "reserve: 0.2", "battery", "write 20 for 20 %"),
    "mAh": Mistake("reserve: 20", "capacity_mah: 5200", "battery", "Did you mean capacity_wh?"),
    "no rate": Mistake("    charge_rate", "    # ", "    execute", "add charge_rate: [["),
    "a charge in the air": Mistake(
        "[land(), charge(auto), take_off()]", "charge(auto)", "    exec", "charged on the ground"
    ),
    "a charge as a share": Mistake("charge(auto)", "charge(0.8)", "    exec", "write percent: 80"),
    "no battery": Mistake("battery: {", "# {", "    exec", "add battery: {reserve: 20}"),
}
"""Of charging; CHARGED."""

YAML: Table = {
    "no version": Mistake("version: 1\n", "", "", "Version of this format: 1"),
    "a name with spaces": Mistake("name: first", "name: my first!", "name", "letters, digits"),
    "a number for a name": Mistake("name: first", "name: 2024", "name", 'around it: "2024"'),
    "an equals sign": Mistake("speed_mps: 5", "speed_mps = 5", "  up_m", "write speed_mps: 5"),
    "a dash of books": Mistake("sets:", "sets:\n  \u2013 x", "  Place", "dash of a word processor"),
    "! in brackets": Mistake(
        "at(to) & !at(from)", "[at(to), !at(from)]", "    cost", "begins with !: put quotes"
    ),
    "a tab": Mistake("  speed_mps", "\tspeed_mps", "\tspeed_mps", "indent with spaces"),
    "a minus of books": Mistake("[[-20", "[[\u221220", "  fence", "of the keyboard: -20."),
    "no space after a colon": Mistake(
        "speed_mps: 5", "speed_mps:5", "  up_m:", "lacks a space after the colon: write speed_mps"
    ),
    "a space that cannot be broken": Mistake(
        "  speed_mps",
        "\u00a0 speed_mps",
        "  up_m:",
        "line 13 has U+00A0, which only looks like a space",
    ),
    "a brace that is not closed": Mistake(
        "north_m: 0, up_m: 6}", "north_m: 0, up_m: 6", "  A:", "opened in line 19 is not closed"
    ),
    "a quote that is not closed": Mistake("name: first", "name: 'first", "name:", "never closed"),
    "a key twice": Mistake("otherwise: return_home", "name: two", "name: two", "keep one of them"),
    "one space too many": Mistake("  B: {", "   B: {", "   B:", "check the indentation"),
    "a skill without its indent": Mistake("  shoot:\n", "shoot:\n", "shoot", "known keys are"),
    "a plan of QGroundControl": Mistake(FIELD, '{"fileType": "Plan"}', "", "companion import"),
    "a list of waypoints": Mistake(FIELD, "QGC WPL 110\n0\t1", "", "companion import"),
    "a map": Mistake(
        FIELD, "image: hall.png\nresolution: 0.1\norigin: [0, 0, 0]", "", "name it in a mission"
    ),
    "a drawing": Mistake(FIELD, "<?xml version='1.0'?>\n<kml/>", "", "companion import"),
}
"""Of YAML, and files that are none; in the FIELD."""

WORLDS: Table = {
    "a charge in percent": Mistake(
        "wind:", "battery: {charge: 50%}\nwind:", "battery", "write a share: 0.5"
    ),
    "a button": Mistake("report: {alarm: 1}", "operator: RTL", "  - ", "MAV_CMD_NAV_RETURN_TO"),
    "another distribution": Mistake(
        "wind:",
        "vary: {wind.east_mps: {uniform: [0, 5]}}\nwind:",
        "vary",
        "or [least, greatest] alone.",
    ),
    "a report as a text": Mistake(
        "report: {alarm: 1}", "report: alarm", "  - ", "{NAME: NUMBER}: a program"
    ),
    "a condition for a time": Mistake("at_s: 40", "when: 40", "  - ", "Did you mean at_s?"),
    "a wind with its unit": Mistake("east_mps: 3", "east_mps: 3 m/s", "wind", "alone: 3."),
    "a wind in another unit": Mistake("east_mps: 3", "east_mps: 18 km/h", "wind", "second: 5."),
    "a wind of one number": Mistake("wind: {", "wind: 5\n# {", "wind", "keys are east_mps"),
    "a time without its unit": Mistake("at_s: 40", "at: 40", "  - ", "Did you mean at_s?"),
    "another word for report": Mistake("report: {", "event: {", "  - ", "Did you mean report?"),
    "one that happens": Mistake("  - {at_s: 40", "  {at_s: 40", "  {", "what happens, and when"),
    "a map that is not there": Mistake("map: {", "map: my.png  # {", "map", "YAML file beside"),
    "an unknown parameter": Mistake(
        "happens:", "parameters: {MPC_XY_VEL: 5}\nhappens:", "param", "mean MPC_XY_VEL_ALL?"
    ),
    "an obstacle that is none": Mistake(
        "report: {alarm: 1}", "obstacle: {name: box, present: true}", "  - ", "under obstacles"
    ),
    "a mission": Mistake(WORLD, FIELD, "", "MISSION.sim.yaml"),
}
"""Of scenarios; of ALARMED."""

MISSIONS: dict[str, tuple[str, Table]] = {
    "task": (FIELD, LOGIC),
    "skills": (FIELD, SKILLS),
    "events": (ALARMED, EVENTS),
    "places": (FIELD, PLACES),
    "degrees": (EARTH, DEGREES),
    "walls": (HALL, WALLS),
    "battery": (CHARGED, BATTERY),
    "YAML": (FIELD, YAML),
}
"""Kind -> the file that is right, and the mistakes."""
