"""Missions with docks, as data: a patrol of sites with a battery that is too small for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Position = Mapping[str, float]
"""The keys of a place."""
HOME = "Home"


def patrol_between_docks(
    name: str,
    places: Mapping[str, Position],
    docks: Sequence[str],
    fence: Sequence[Sequence[float]],
    battery: Mapping[str, float],
    charge_rate: Sequence[Sequence[float]],
    up_m: tuple[float, float] = (1, 15),
) -> dict[str, Any]:
    """The data of a mission that visits all places but Home and the docks for ever.

    Args:
        name: the name of the mission.
        places: all of them, Home first.
        docks: places that charge.
        fence: its corners.
        battery: the section of the mission.
        charge_rate: the charge rate of the docks.
        up_m: the altitude band.
    """
    sites = [place for place in places if place not in (HOME, *docks)]
    return {
        "version": 1,
        "name": name,
        "limits": {"speed_mps": 5, "up_m": list(up_m), "fence": fence},
        "battery": dict(battery),
        "places": dict(places),
        "sets": {"Place": list(places), "Pad": list(docks)},
        "skills": {
            "move": {
                "parameters": {"from": "Place", "to": "Place"},
                "precondition": "at(from)",
                "assumes": "trans_ok(from, to)",
                "effect": "at(to) & !at(from)",
                "execute": "fly(to)",
            },
            "recharge": {
                "parameters": {"pad": "Pad"},
                "precondition": "at(pad)",
                "assumes": "canCharge(pad)",
                "effect": "at(pad)",
                "charge_rate": charge_rate,
                "execute": ["land()", "charge(auto)", "take_off()"],
            },
        },
        "initially": [f"at({HOME})"],
        "task": {"patrol": f"patrolling({', '.join(sites)})"},
        "otherwise": {"land_at": [HOME]},
    }
