"""The number of flights per second in a campaign, and the memory that its processes keep."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from importlib.util import find_spec
from time import perf_counter

import psutil

from benches import ROOT, Row
from companion.campaigns.campaign import random_rows
from companion.campaigns.dask_cluster import DaskCluster
from companion.campaigns.kit import Kit
from companion.campaigns.processes import LocalProcesses, RowEngine
from companion.campaigns.rows import Row as Flight
from companion.flights.simulated_world import varied_world_of
from companion.mission.loader import load_mission

MISSIONS = ROOT / "missions"
SCENARIO = f"""
version: 1
map: {MISSIONS / "maps/hall.yaml"}
wind: {{east_mps: 0.5, north_mps: 0.3, turbulence_mps: 0.1}}
happens: [{{at_s: 2, operator: MAV_CMD_NAV_RETURN_TO_LAUNCH}}]
vary: {{"wind.east_mps": [-4, 4], "wind.north_mps": [-4, 4]}}
"""
"""The mission return_home, called home during the take-off: 9 s of flight."""
LIMIT_S = 60.0
PROCESSES = 2
ALONE = "one process"


def throughput(runs: int) -> Iterator[Row]:
    """Flights per second in running processes; the peer is a single process."""
    mission = load_mission(MISSIONS / "return_home.yaml")
    kit = Kit.of(mission, varied_world_of(mission, SCENARIO), LIMIT_S)
    flights = random_rows(kit, 1, 4 * runs)
    memory_mb: list[float] = []
    with closing(LocalProcesses(kit.packed, 1)) as engine:

        def look() -> None:
            memory_mb.append(psutil.Process(engine.pids[0]).memory_info().rss / 1e6)

        alone = _rate(engine, flights, look)
    yield Row("campaign, 1 process", alone, "flights/s")
    with closing(LocalProcesses(kit.packed, PROCESSES)) as local:
        rate = _rate(local, flights)
    yield Row(f"campaign, {PROCESSES} processes", rate, "flights/s", ALONE, alone)
    if find_spec("distributed"):
        rate = _rate_on_dask(kit, flights)
        yield Row(f"campaign, {PROCESSES} workers of Dask", rate, "flights/s", ALONE, alone)
    name, peer = (f"after {count} flights" for count in (len(flights), len(flights) // 4))
    yield Row(f"memory {name}", memory_mb[-1], "MB", peer, memory_mb[len(flights) // 4 - 1])


def _rate_on_dask(kit: Kit, flights: Sequence[Flight]) -> float:
    from distributed import LocalCluster

    about = {"n_workers": PROCESSES, "threads_per_worker": 1, "dashboard_address": None}
    with (
        LocalCluster(**about) as cluster,
        closing(DaskCluster(kit.packed, cluster.scheduler_address)) as engine,
    ):
        return _rate(engine, flights)


def _rate(
    engine: RowEngine, flights: Sequence[Flight], look: Callable[[], None] = lambda: None
) -> float:
    """Flights per second, after each process has flown once; calls `look` after each of them."""
    for _ in engine.fly(flights[:PROCESSES]):
        pass
    start_s = perf_counter()
    for _ in engine.fly(flights):
        look()
    return len(flights) / (perf_counter() - start_s)
