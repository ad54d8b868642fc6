"""Links that lose, duplicate and delay datagrams, as the scenario says.

All datagrams pass here on their way in and out. Each direction of each link has its own random
numbers, drawn per datagram in order, so equal seeds and equal datagrams give equal results. A
change of the quality does not affect datagrams that are already under way.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from itertools import count
from random import Random

from sitl.link.routing import LinkName
from sitl.world.faults import Direction, LinkQuality, Port

PORTS = {LinkName.GCS: Port.GROUND, LinkName.OFFBOARD: Port.COMPANION}
TIME_ROUNDING_S = 1e-9

Datagrams = list[tuple[LinkName, bytes]]
Qualities = Mapping[tuple[Port, Direction], LinkQuality]


class Disturbance:
    """One direction of all links.

    Args:
        direction: the direction of the datagrams.
        qualities: the qualities of disturbed links, read with every datagram.
        seed: the seed of the random numbers.
    """

    def __init__(self, direction: Direction, qualities: Qualities, seed: int) -> None:
        self._direction = direction
        self._qualities = qualities
        self._chances = {port: Random(f"link {seed} {port} {direction}") for port in Port}
        self._under_way: list[tuple[float, int, LinkName, bytes]] = []
        self._numbers = count()

    def step(self, now_s: float, datagrams: Datagrams) -> Datagrams:
        """Takes the datagrams sent now; returns those that arrive now, in order."""
        if not self._qualities and not self._under_way:
            return datagrams
        for link, datagram in datagrams:
            self._send(now_s, link, datagram)
        arrived: Datagrams = []
        while self._under_way and self._under_way[0][0] <= now_s + TIME_ROUNDING_S:
            _, _, link, datagram = heapq.heappop(self._under_way)
            arrived.append((link, datagram))
        return arrived

    def _send(self, now_s: float, link: LinkName, datagram: bytes) -> None:
        port = PORTS[link]
        quality, chance = (
            self._qualities.get((port, self._direction), LinkQuality()),
            self._chances[port],
        )
        if chance.random() < quality.loss:
            return
        for _ in range(1 + (chance.random() < quality.doubled)):
            arrival_s = now_s + quality.delay_s + chance.uniform(0.0, quality.jitter_s)
            heapq.heappush(self._under_way, (arrival_s, next(self._numbers), link, datagram))
