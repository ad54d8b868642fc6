"""What the schemas do not say about keys: units that no name ends with, and examples."""

from __future__ import annotations

from typing import Any

_ENDINGS = {
    "_mps3": "m/s³",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_radps": "rad/s",
    "_dps": "°/s",
    "_deg": "°",
    "_wh": "Wh",
    "_ah": "Ah",
    "_hz": "Hz",
    "_m": "m",
    "_s": "s",
    "_a": "A",
    "_w": "W",
}


def unit_of(key: str) -> str:
    """The unit that a key's name ends with; empty if it ends with none."""
    return next((unit for ending, unit in _ENDINGS.items() if key.endswith(ending)), "")


UNITS: dict[tuple[str, str], str] = {
    ("LimitsEntry", "fence"): "m or °",
    ("LimitsEntry", "keep_out"): "m or °",
    ("PlaceEntry", "corners"): "m or °",
    ("WallEntry", "corners"): "m or °",
    ("BatteryEntry", "reserve"): "%",
    ("BatteryEntry", "curve"): "%, %",
    ("PowerEntry", "level"): "m/s, W",
    ("PowerEntry", "climb"): "m/s, W",
    ("SkillEntry", "cost"): "s",
    ("SkillEntry", "charge_rate"): "%, %/s",
}
"""Model and key -> unit."""

EXAMPLES: dict[tuple[str, str], Any] = {
    ("Mission", "objects"): ["p1", "p2"],
    ("Mission", "tree"): ["move(Home, A)", "move(A, Home)"],
    ("Mission", "subtrees"): {"look": ["move(*, A)", "wait(5)"]},
    ("MapEntry", "east_m"): [-2, 12],
    ("MapEntry", "north_m"): [-2, 12],
    ("MapEntry", "cell_m"): 0.2,
    ("VehicleEntry", "radius_m"): 0.4,
    ("VehicleEntry", "feed_forward"): 1.1,
    ("PlaceEntry", "heading_deg"): 270,
    ("PlaceEntry", "suggesters"): ["python(beside)"],
    ("PlaceEntry", "tests"): ["python(is_in_the_shade)"],
    ("EventEntry", "stale_s"): 2,
    ("EventEntry", "restores"): ["canUpload"],
    ("SkillEntry", "distinct"): [["from", "to"]],
    ("SkillEntry", "confirmed_by"): "NAMED_VALUE_INT[load].value > 0",
    ("ScenarioModel", "parameters"): {"BAT_LOW_THR": 0.25},
    ("PadModel", "swap_s"): 20,
    ("ScenarioEventModel", "command"): "MAV_CMD_USER_1",
    ("ScenarioEventModel", "nth"): 2,
    ("ScenarioEventModel", "component"): 25,
    ("BatteryEventModel", "capacity"): 0.8,
    ("BatteryEventModel", "resistance"): 1.5,
    ("ArmingEventModel", "refused"): "Preflight Fail: compass",
    ("ArmingEventModel", "allowed"): True,
    ("AnswerEventModel", "command"): "MAV_CMD_DO_SET_MODE",
    ("MarkerEventModel", "name"): "roof",
    ("CameraEventModel", "component"): 100,
    ("CameraEventModel", "lost"): 0.2,
    ("GimbalEventModel", "taken"): True,
    ("GripperEventModel", "drops"): True,
}
"""Model and key -> example, for keys that no shipped file has."""
