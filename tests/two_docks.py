"""A patrol of two sites between two docks, on a battery that is too small, and its world."""

from __future__ import annotations

from typing import Any

from benches.docks import patrol_between_docks
from lockstep import Lockstep

PAD = {"radius_m": 1.5, "current_a": 100}
PADS: list[dict[str, Any]] = [
    {"name": "W", "east_m": 10, "north_m": 8} | PAD,
    {"name": "E", "east_m": 20, "north_m": 20} | PAD,
]
RESERVE = 20


def two_docks(**changes: Any) -> dict[str, Any]:
    """The mission as data, with some of its sections changed."""
    mission = patrol_between_docks(
        "two_docks",
        places={
            "Home": {"east_m": 0, "north_m": 0, "up_m": 3, "radius_m": 2},
            "A": {"east_m": 30, "north_m": 0, "up_m": 3},
            "B": {"east_m": 30, "north_m": 25, "up_m": 3},
            "W": {"east_m": 10, "north_m": 8, "up_m": 2},
            "E": {"east_m": 20, "north_m": 20, "up_m": 2},
        },
        docks=["W", "E"],
        fence=[[-10, -10], [50, -10], [50, 40], [-10, 40]],
        battery={"reserve": RESERVE},
        charge_rate=[[0, 0.35], [80, 0.3], [100, 0.01]],
        up_m=(1, 12),
    )
    return mission | changes


def between_docks(
    *happens: dict[str, Any], charge: float = 0.27, pads: list[dict[str, Any]] = PADS
) -> dict[str, Any]:
    """A scenario: what the battery has at first, the pads, and what happens."""
    return {"version": 1, "battery": {"charge": charge}, "pads": pads, "happens": [*happens]}


def text(flight: Lockstep) -> str:
    """What people were told, a line each."""
    return "\n".join(event.text for event in flight.events)


def lowest(flight: Lockstep, seconds: float) -> float:
    """The least true charge at which it flies, in some time or to its end, percent."""
    least = 100.0
    for _ in range(round(seconds)):
        flight.run(1.0)
        if flight.simulation.is_armed:
            least = min(least, 100 * flight.simulation.flight.charge)
        if flight.companion.has_ended:
            break
    return least
