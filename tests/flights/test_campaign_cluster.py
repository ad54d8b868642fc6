"""The same table on a Dask cluster whose worker, nanny or scheduler is killed."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import pytest
from varied import ThisProcess, short_kit, table_by

from companion.campaigns.dask_cluster import DaskCluster
from companion.campaigns.outcomes import FlownRow
from companion.campaigns.row_file import NAME
from companion.errors import LinkError
from companion.python_child import python_module

pytest.importorskip("distributed")
pytestmark = pytest.mark.long

WAITS_S = 600.0


@dataclass
class Cluster:
    """A scheduler and two workers, each in a process of its own, with a nanny.

    Attributes:
        address: of the scheduler.
        scheduler, nannies: their processes.
    """

    address: str
    scheduler: psutil.Process
    nannies: list[psutil.Process] = field(default_factory=list)

    @property
    def workers(self) -> list[psutil.Process]:
        """The processes that fly; multiprocessing's own helpers are none."""
        children = [child for nanny in self.nannies for child in nanny.children()]
        return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    contact = tmp_path / "scheduler.json"
    options = ("--host", "127.0.0.1", "--scheduler-file", str(contact), "--no-dashboard")
    with ExitStack() as running:

        def begin(module: str, *more: str) -> psutil.Process:
            command = python_module(f"distributed.cli.{module}", *options, *more)
            process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
            running.callback(end, psutil.Process(process.pid), process)
            return psutil.Process(process.pid)

        scheduler = begin("dask_scheduler", "--port", "0")
        wait_for(lambda: contact.exists() and contact.stat().st_size > 0)
        made = Cluster(json.loads(contact.read_text())["address"], scheduler)
        made.nannies += [begin("dask_worker", "--nthreads", "1") for _ in range(2)]
        yield made


def end(process: psutil.Process, child: subprocess.Popen[bytes]) -> None:
    """Ends a process and its children."""
    children = process.children(recursive=True) if process.is_running() else []
    child.kill()
    child.wait(WAITS_S)
    for each in children:
        if each.is_running():
            each.kill()


def wait_for(is_so: Callable[[], bool]) -> None:
    end_s = time.monotonic() + WAITS_S
    while not is_so():
        assert time.monotonic() < end_s
        time.sleep(0.1)


def of_two_threads(cluster: Cluster) -> DaskCluster:
    engine = DaskCluster(short_kit().packed, cluster.address)
    wait_for(lambda: engine.threads == 2)
    assert engine.busiest == 1
    return engine


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The table as this process alone has it."""
    return table_by(ThisProcess(short_kit()), tmp_path_factory.mktemp("here"))


@pytest.mark.parametrize("who", ["workers", "nannies"])
def test_the_table_is_the_same_though_one_dies(
    who: str, cluster: Cluster, here: bytes, tmp_path: Path
) -> None:
    killed: list[int] = []

    def kill(flown: FlownRow) -> None:
        if not killed:
            process: psutil.Process = getattr(cluster, who)[0]
            killed.append(process.pid)
            process.send_signal(signal.SIGKILL)

    assert table_by(of_two_threads(cluster), tmp_path / "there", kill) == here
    assert killed


def test_the_rows_are_kept_when_the_scheduler_dies(
    cluster: Cluster, here: bytes, tmp_path: Path
) -> None:
    """The campaign ends with an error; without the rows that are there it goes on anywhere."""

    def kill(flown: FlownRow) -> None:
        cluster.scheduler.send_signal(signal.SIGKILL)

    with pytest.raises(LinkError, match=r"the Dask scheduler at tcp://127.* is gone"):
        table_by(of_two_threads(cluster), tmp_path, kill)
    kept = len((tmp_path / NAME).read_bytes().splitlines()) - 1
    engine = ThisProcess(short_kit())
    assert table_by(engine, tmp_path) == here
    assert kept > 0 and len(engine.flown) == len(here.splitlines()) - kept - header_lines(here)


def header_lines(table: bytes) -> int:
    """The lines of a table that are no rows."""
    return sum(line.startswith(b"# ") for line in table.splitlines()) + 1


def test_a_scheduler_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.campaigns.dask_cluster.CONNECT_S", 0.5)
    with pytest.raises(LinkError, match=r"no Dask scheduler answers at tcp://127"):
        DaskCluster(b"", "tcp://127.0.0.1:9")
