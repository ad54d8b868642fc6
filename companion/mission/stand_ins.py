"""The values that replace unreadable parts of a mission, so that the reader can continue.

They keep names known and the model complete, so that the other parts can be checked. No error is
reported about them, and a mission with a mistake is never passed on.
"""

from __future__ import annotations

from companion.documents.readable import StandIns

UNREAD = "unread"
_PLACE = {"east_m": 0, "north_m": 0, "up_m": 1}
_SKILL = {"execute": "wait(0)", "planned": False}

STAND_INS: StandIns = {
    ("version",): 1,
    ("name",): UNREAD,
    ("limits",): {"speed_mps": 1, "up_m": [0, 2]},
    ("limits", "speed_mps"): 1,
    ("limits", "up_m"): [0, 2],
    ("limits", "keep_out", "*"): [],
    ("places",): {UNREAD: _PLACE},
    ("places", "*"): _PLACE,
    ("sets", "*"): [UNREAD],
    ("components", "*"): 1,
    ("events", "*"): {"when": "HEARTBEAT.type > 0"},
    ("skills",): {UNREAD: _SKILL},
    ("skills", "*"): _SKILL,
    ("skills", "*", "execute"): "wait(0)",
    ("task", "*"): "true",
    ("subtrees", "*"): [],
}
