"""Routing of messages between the links.

Like PX4, it forwards between the links by the rules of the MAVLink routing guide
(https://mavlink.io/en/guide/routing.html):

1. A message never goes back to the link it came from.
2. A message only for this vehicle's autopilot, or for another component on board, stays here.
3. A broadcast (target system 0, or no target at all) goes to every other link.
4. A message for another system or component goes to the links where that was heard.
5. SETUP_SIGNING is never forwarded: it contains a key.

STATUSTEXT of our own components goes only where a ground station's heartbeat has passed, in either
direction (as in PX4).
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

from companion.mavlink.framing import Message, source

MAV_TYPE_GCS = 6


class LinkName(StrEnum):
    """PX4's two UDP links: to the ground station (14550) and to the companion (14540)."""

    GCS = "gcs"
    OFFBOARD = "offboard"


def target(message: Message) -> tuple[int, int]:
    """Target system and component, 0 where the message has none."""
    return (
        getattr(message, "target_system", 0) or 0,
        getattr(message, "target_component", 0) or 0,
    )


def is_for(address: tuple[int, int], message: Message) -> bool:
    """True if a component should handle a message: its own, or a broadcast."""
    return all(wanted in (0, own) for wanted, own in zip(target(message), address, strict=True))


class Router:
    """The routing table: where each component was heard, and component 0 for its whole system.

    Args:
        links: those with somebody at the other end.
        local: addresses of the components on board.
    """

    def __init__(self, links: Iterable[LinkName], local: Iterable[tuple[int, int]]) -> None:
        self._heard: dict[LinkName, set[tuple[int, int]]] = {link: set() for link in links}
        self._local = frozenset(local)
        self._with_gcs: set[LinkName] = set()

    def learn(self, origin: LinkName, message: Message) -> None:
        """Learns the sender's link from a message that came in."""
        system, component = source(message)
        self._heard.setdefault(origin, set()).update([(system, component), (system, 0)])
        if message.get_type() == "HEARTBEAT" and message.type == MAV_TYPE_GCS:
            self._with_gcs |= {origin, *self._heard}

    def has_ground_station(self, link: LinkName) -> bool:
        """True if a ground station's heartbeat has passed on a link."""
        return link in self._with_gcs

    def destinations(self, message: Message, origin: LinkName | None) -> list[LinkName]:
        """The links for a message from outside, or from on board if `origin` is None."""
        if target(message) in self._local or message.get_type() == "SETUP_SIGNING":
            return []
        return [
            link
            for link in self._heard
            if link is not origin and self._leads_to(link, target(message))
        ]

    def _leads_to(self, link: LinkName, wanted: tuple[int, int]) -> bool:
        system, _ = wanted
        return system == 0 or wanted in self._heard[link]
