"""Flies rows on a Dask cluster: any number of machines with the same release installed.

1. Rows are pure, so it is harmless if Dask flies one twice.
2. For each thread, a few rows are under way.
3. A row whose worker dies is submitted again, as in a local pool. Dask counts the death of a worker
   for all rows that it was given, so a row may be given up without having been flown that often.

A door: it connects to a scheduler. The extra `cluster` installs Dask, in the release that the
cluster has.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from companion.campaigns.outcomes import FlownRow
from companion.campaigns.processes import Deaths, accepted, died
from companion.campaigns.rows import Row
from companion.campaigns.worker import fly_row
from companion.errors import AddressError, CompanionError, LibraryMissing, LinkError

if TYPE_CHECKING:
    from distributed import Client

WINDOW = 3
"""Rows under way for each thread, so that no thread waits for the client."""
CONNECT_S = 30.0


class DaskCluster:
    """Flies rows on a cluster.

    Args:
        packed: the kit.
        address: the scheduler's address, such as tcp://10.0.0.1:8786; for tls://, Dask's own
            configuration names the certificates.

    Raises:
        LibraryMissing: Dask is not installed.
        AddressError: this is no address of a scheduler.
        LinkError: no scheduler answers.
    """

    def __init__(self, packed: bytes, address: str) -> None:
        if find_spec("distributed") is None:
            remedy = "pip install 'mav-companion[cluster]', in the release of the cluster"
            raise LibraryMissing("--dask needs Dask, which is not installed", remedy)
        from distributed import Client
        from distributed.comm import get_address_host_port

        try:
            get_address_host_port(address)
        except ValueError as error:
            raise AddressError(f"--dask {address}: {error}\n    write tcp://HOST:8786") from error
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # we report it ourselves
        try:
            self._client: Client = Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise LinkError(f"no Dask scheduler answers at {address}: {error}") from error
        self._packed, self._address = packed, address
        self._under_way: dict[Any, Row] = {}
        self._deaths = Deaths()

    @property
    def threads(self) -> int:
        """The number of threads of all workers; each flies one row at a time."""
        counts: dict[str, int] = self._client.nthreads()
        return sum(counts.values())

    @property
    def busiest(self) -> int:
        """The most threads of any worker; flights of one process do not run in parallel."""
        counts: dict[str, int] = self._client.nthreads()
        return max(counts.values(), default=0)

    def fly(self, rows: Iterable[Row]) -> Iterator[FlownRow]:
        """The rows, in the order in which they finish.

        Raises:
            LinkError: the scheduler does not answer any more.
            CompanionError: a worker has another environment, so its flights would differ.
        """
        try:
            yield from self._flown(iter(rows))
        except (CancelledError, OSError) as error:
            raise LinkError(f"the Dask scheduler at {self._address} is gone") from error

    def finish(self) -> Iterator[FlownRow]:
        """The rows under way, in the order in which they finish; submits no more."""
        while self._under_way:
            yield from self._returned()

    def close(self) -> None:
        """Disconnects from the cluster; rows under way are given up."""
        self._client.cancel(list(self._under_way), force=True)
        self._client.close()

    def _flown(self, waiting: Iterator[Row]) -> Iterator[FlownRow]:
        while True:
            for _ in range(max(1, WINDOW * self.threads) - len(self._under_way)):
                if (row := next(waiting, None)) is None:
                    break
                self._submit(row)
            if not self._under_way:
                return
            yield from self._returned()

    def _submit(self, row: Row) -> None:
        future = self._client.submit(fly_row, self._packed, row, pure=False, retries=0)
        self._under_way[future] = row

    def _returned(self) -> Iterator[FlownRow]:
        from distributed import KilledWorker, wait

        with self._client.as_current():
            done, _ = wait(list(self._under_way), return_when="FIRST_COMPLETED")
        for future in done:
            row = self._under_way.pop(future)
            error = future.exception()
            if error is None:
                yield accepted(future.result())
                continue
            if not isinstance(error, KilledWorker):
                raise CompanionError(f"the cluster cannot fly rows: {error!r}")
            if self._deaths.is_last(row):
                yield died(row)
            else:
                self._submit(row)
