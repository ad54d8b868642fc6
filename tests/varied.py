"""A short mission in a world that varies, and engines that need no processes of their own."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

from companion.campaigns.campaign import Campaign, random_rows
from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.processes import RowEngine, accepted
from companion.campaigns.rows import Row
from companion.campaigns.worker import WorkerRefused, fly_row
from companion.flights.simulated_world import varied_world_of
from companion.mission.loader import load_mission

MISSION = Path(__file__).parents[1] / "missions" / "return_home.yaml"
SEED, RUNS = 3, 4
DEADLY = 666
SCENARIO = f"""
version: 1
map: {MISSION.parent / "maps/hall.yaml"}
wind: {{east_mps: 0.5, north_mps: 0.3, turbulence_mps: 0.1}}
obstacles:
  - {{name: crate, circle: {{east_m: 6, north_m: 6, radius_m: 0.5}}}}
happens:
  - {{at_s: 2, operator: MAV_CMD_NAV_RETURN_TO_LAUNCH}}
  - {{at_s: 1, gps: {{noise_m: 0.2}}}}
vary:
  wind.east_mps: [-4, 4]
  wind.north_mps: {{normal: [0, 1]}}
  happens.0.at_s: [1, 3]
  happens.1: {{chance: 0.5}}
  obstacles.crate.circle.east_m: [1, 17]
"""
"""The vehicle is called home while it takes off: 9 s of flight."""


@cache
def short_kit() -> Kit:
    """The kit of the short mission."""
    mission = load_mission(MISSION)
    return Kit.of(mission, varied_world_of(mission, SCENARIO), 60.0)


def fly_but_die(packed: bytes, row: Row) -> FlownRow | WorkerRefused:
    """Flies a row, unless its seed is deadly: then its process is gone."""
    if row.seed == DEADLY:
        os._exit(1)
    return fly_row(packed, row)


def tell_process(packed: bytes, row: Row) -> FlownRow | WorkerRefused:
    """Flies nothing; the reason is the number of the process."""
    return FlownRow(row, RowOutcome.SATISFIED, reason=str(os.getpid()))


class ThisProcess:
    """An engine that flies in the process of the test."""

    def __init__(self, kit: Kit) -> None:
        self._packed = kit.packed
        self.flown: list[int] = []

    def fly(self, rows: Iterable[Row]) -> Iterator[FlownRow]:
        for row in rows:
            self.flown.append(row.index)
            yield accepted(fly_row(self._packed, row))

    def finish(self) -> Iterator[FlownRow]:
        yield from ()

    def close(self) -> None:
        """Nothing is under way."""


def table_by(
    engine: RowEngine,
    folder: Path,
    on_row: Callable[[FlownRow], None] = lambda flown: None,
    kit: Kit | None = None,
) -> bytes:
    """The table of a campaign, by default of the short one, flown by an engine."""
    kit = kit or short_kit()
    campaign = Campaign(kit, engine, folder, kit.header(SEED, runs=RUNS), on_row)
    try:
        campaign.flown(random_rows(kit, SEED, RUNS))
        return campaign.write_table().read_bytes()
    finally:
        campaign.close()
        engine.close()
