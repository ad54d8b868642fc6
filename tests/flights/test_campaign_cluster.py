"""The same table on a Dask cluster, a worker of which is killed."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from varied import ThisProcess, short_kit, table_by

from companion.campaigns.dask_cluster import DaskCluster
from companion.campaigns.outcomes import FlownRow
from companion.errors import LinkError

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.long


@pytest.fixture
def address() -> Iterator[str]:
    """The scheduler of two workers, each in a process of its own, with a nanny."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True
    ) as cluster:
        yield cluster.scheduler_address


def test_the_table_is_the_same_though_workers_die(address: str, tmp_path: Path) -> None:
    engine = DaskCluster(short_kit().packed, address)
    assert (engine.threads, engine.busiest) == (2, 1)
    killed: list[int] = []

    def kill(flown: FlownRow) -> None:
        if not killed:
            with distributed.Client(address, set_as_default=False) as client:
                killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    there = table_by(engine, tmp_path / "cluster", kill)
    assert killed and there == table_by(ThisProcess(short_kit()), tmp_path / "here")


def test_a_scheduler_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.campaigns.dask_cluster.CONNECT_S", 0.5)
    with pytest.raises(LinkError, match=r"no Dask scheduler answers at tcp://127"):
        DaskCluster(b"", "tcp://127.0.0.1:9")
