"""Files with several mistakes of different stages, and all that the answer has to say of them.

Each row: what is right, what is written in place of what, and what is wrong in the order of the
file. Nothing else may be told: a name that is misspelt once is one mistake.
"""

from __future__ import annotations

from mistakes import ALARMED, CHARGED, EARTH, FIELD, HALL

TOGETHER: dict[str, tuple[str, dict[str, str], list[str]]] = {
    "keys and values": (
        FIELD,
        {
            "speed_mps: 5": "speed_mps: fast",
            "tries: 2": "trys: 2",
            "A: {east_m": "A: {east",
            "version: 1\n": "",
        },
        [
            "the key version is missing",
            "speed_mps is 'fast', expected a number",
            "unknown key 'east' in places.A",
            "unknown key 'trys' in skills.shoot",
        ],
    ),
    "places, events and skills": (
        ALARMED,
        {
            "A: {east_m: 40": "A: {east_m: 400",
            "EVENT[alarm] > 0": "EVENT[alarm] = 0",
            "fly(to)": "goto(to)",
            "wait(5)": "wait(5s)",
        },
        [
            "place A is far outside the fence",
            "not a condition",
            "unknown primitive goto",
            "5s is not a number",
        ],
    ),
    "lines of the task": (
        ALARMED,
        {"F alarm": "F alam", "F looked)": "F loked)"},
        ["unknown fact alam", "unknown fact loked"],
    ),
    "two names in one line": (
        ALARMED,
        {"G (alarm -> F looked)": "G (alam -> F loked)"},
        ["unknown fact alam", "unknown fact loked"],
    ),
    "a value, a place and a formula": (
        ALARMED,
        {
            "speed_mps: 5": "speed_mps: 5 m/s",
            "B: {east_m: 0, north_m: 30": "B: {east_m: 0, north_m: 300",
            "G (alarm -> F looked)": "G (alarm => F looked)",
        },
        [
            "speed_mps is '5 m/s', expected a number",
            "place B is far outside the fence",
            "'=>' is another notation",
        ],
    ),
    "a place that is wrong is declared": (
        FIELD,
        {"A: {east_m: 40": "A: {x: 40", "[at(Home)]": "[at(Hme)]"},
        ["unknown key 'x' in places.A", "unknown fact at(Hme)"],
    ),
    "a text with a comma within { }, and no quotes": (
        FIELD,
        {"initially: [at(Home)]": "subtrees: {look: move(Home, A)}\ninitially: [at(Home)]"},
        ["look is 'move(Home', expected a list", "'A)' is the rest of a text"],
    ),
    "a step with a comma within { }, and no quotes": (
        FIELD,
        {"skills:\n": "skills:\n  ask: {effect: asked, execute: command(box, MAV_CMD_USER_1)}\n"},
        ["not something to execute", "'MAV_CMD_USER_1)' is the rest of a text"],
    ),
    "a place that is misspelt is one mistake": (
        FIELD,
        {"  Home: {": "  Hoem: {"},
        ["unknown place Home in the set Place"],
    ),
    "a place with a name of two words, and the others": (
        ALARMED,
        {
            "  Gate: {": "  Main Gate: {",
            "A: {east_m: 40": "A: {east_m: 400",
            "B: {east_m: 0": "B: {east: 0",
            "F looked)": "F looked",
        },
        [
            "'Main Gate' is not a name",
            "place A is far outside the fence",
            "unknown key 'east' in places.B",
            "the formula ends too early",
        ],
    ),
    "names of an event and a skill": (
        ALARMED,
        {"  alarm: {": "  the alarm: {", "  look:": "  look-out:", "A: {east_m: 40": "A: {x: 40"},
        ["unknown key 'x' in places.A", "'the alarm' is not a name", "'look-out' is not a name"],
    ),
    "a name of two words on the earth": (
        EARTH,
        {"  C: {lat": "  Old C: {lat", "A: {lat_deg: 47.397742": "A: {lat_deg: 47.4"},
        ["place A is far outside the fence", "'Old C' is not a name"],
    ),
    "a beginning with a name of two words on the earth": (
        EARTH,
        {"  Home: {lat": "  The Home: {lat", "execute: fly(to)": "execute: fly(too)"},
        ["'The Home' is not a name", "too is not a parameter of this skill"],
    ),
    "no places at all": (
        FIELD,
        {"places:": "palces:", "tries: 2": "tries: two"},
        ["unknown key 'palces'", "tries is 'two', expected a whole number"],
    ),
    "an event that is wrong is declared": (
        ALARMED,
        {"latch: true": "latch: yes", "EVENT[alarm] > 0": "EVENT[alarm]", "wait(5)": "wait(x)"},
        [
            "EVENT[alarm] is compared with nothing",
            "latch is 'yes', expected true or false",
            "x is not a number",
        ],
    ),
    "a skill whose effect is unread may make anything true": (
        ALARMED,
        {"effect: looked": "effect: looked or seen", "[Home, Gate, A, B]": "[Home, Gate, A, D]"},
        ["unknown place D in the set Place", "'or' is another notation"],
    ),
    "a misspelt key of a skill": (
        FIELD,
        {"effect: shot(site)": "efect: shot(site)", "otherwise: return_home": "otherwise: rtl"},
        ["unknown key 'efect' in skills.shoot", "otherwise is 'rtl', expected return_home, land or "
         "hold or keys with values"],
    ),
    "tags of YAML and a wrong value": (
        FIELD,
        {"  home: F G at(Home)": "  home: !at(A)\n  out: !at(B)", "tries: 2": "tries: 0"},
        [
            "tries is 0, expected at least 1",
            "YAML tag !at(A) is not allowed",
            "YAML tag !at(B) is not allowed",
        ],
    ),
    "a frame that is wrong says nothing of coordinates": (
        EARTH,
        {"frame: wgs84": "frame: WGS84", "execute: fly(to)": "execute: fly(too)"},
        ["frame is 'WGS84', expected enu or wgs84", "too is not a parameter of this skill"],
    ),
    "a map and a place": (
        HALL,
        {"[6.8, 7.2]": "[7.2, 6.8]", "A: {east_m: 14": "A: {east: 14", "F looked)": "F seen)"},
        [
            "a wall of the map: 7.2 to 6.8 is not a range",
            "unknown key 'east' in places.A",
            "unknown fact seen",
        ],
    ),
    "a battery and its charging": (
        CHARGED,
        {"reserve: 20": "reserve: 20%", "cost: flight_time": "cost: slow"},
        ["reserve is '20%', expected a number", "cost is 'slow', expected flight_time or a number"],
    ),
}  # fmt: skip
"""Of missions."""

WORLDS_TOGETHER: dict[str, tuple[dict[str, str], list[str]]] = {
    "keys and a trigger": (
        {"east_mps: 3": "east_mps: 3 m/s", "at_s: 40, report": "report"},
        [
            "east_mps is '3 m/s', expected a number",
            "what happens has 0 triggers instead of one",
        ],
    ),
    "a parameter and a time": (
        {"wind:": "parameters: {MPC_XY_VEL_MX: 3}\nwind:", "at_s: 40": "at_s: soon"},
        ["the autopilot has no parameter MPC_XY_VEL_MX", "at_s is 'soon', expected a number"],
    ),
}
"""Of worlds."""
