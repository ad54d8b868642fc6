"""The ground station of `companion upload` and `companion watch`, built on MAVSDK.

A door: MAVSDK opens the link, in threads of its own. The companion is component 191 of the
vehicle's system. MAVSDK's FTP accepts it as its target (`set_target_compid`). MAVSDK's plugins for
commands and texts either address only the autopilot or do not say who sent a text. So these go
through `mavlink_direct`, where messages name their target and answers their sender.

A file is sent in pieces, each after the answer to the previous one: in flight, at the companion's
20 ticks a second, 4.7 KiB/s. So a file that is on board already, by its checksum, is not sent
again.
"""

from __future__ import annotations

import asyncio
import json
import logging
import tempfile
import time
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from mavsdk import log_subscribe
from mavsdk.asyncio import ComponentType, Configuration, Mavsdk, System
from mavsdk.asyncio.plugins.ftp import FtpAsync
from mavsdk.asyncio.plugins.mavlink_direct import MavlinkDirectAsync
from mavsdk.exceptions import MavsdkError
from mavsdk.plugins.ftp import FtpError, FtpResult
from mavsdk.plugins.mavlink_direct import MavlinkMessage

from companion.errors import LinkError, LinkTimeout

COMPANION = 191  # MAV_COMP_ID_ONBOARD_COMPUTER
VERDICT = "verdict.json"
PAUSE_S = 0.5
"""Between two requests for the verdict."""
OTHERS_S = 1.5
"""How long to wait, after the first vehicle, for the heartbeat of a second; one comes each
second."""
LOOK_AGAIN_S = 0.1

ProgressCallback = Callable[[int, int], None]
"""Called with the number of bytes sent and the number in all."""

log = logging.getLogger(__name__)


class Heard(NamedTuple):
    """A message from a component of the vehicle."""

    component: int
    name: str
    fields: dict[str, Any]


@asynccontextmanager
async def connected(url: str, number: int | None, timeout_s: float) -> AsyncIterator[Station]:
    """Opens a station, and waits for a vehicle with a companion on board.

    Args:
        url: that of the link.
        number: the vehicle's system id; None if there is only one.
        timeout_s: time for the vehicle to be heard, and again for its companion.

    Raises:
        LinkError: the link cannot be opened, or several vehicles are heard and `number` is None.
        LinkTimeout: no autopilot or no companion was heard in time.
    """
    log_subscribe(lambda *_: True)  # its log goes to standard output otherwise
    kind = ComponentType.GROUND_STATION
    async with Mavsdk(Configuration.create_with_component_type(kind)) as client:
        try:
            await client.add_any_connection(url)
        except MavsdkError as error:
            raise LinkError(f"cannot connect to {url}: {error}") from error
        number, system = await _vehicle(client, url, number, timeout_s)
        station = Station(system, number)
        await station.meet(timeout_s)
        yield station


async def _vehicle(
    client: Mavsdk, url: str, number: int | None, timeout_s: float
) -> tuple[int, System]:
    """The vehicle with a number, or the only one: its system id, and MAVSDK's system."""
    vehicles: dict[int, System] = {}
    end_s, is_one_heard = time.monotonic() + timeout_s, False
    while (now_s := time.monotonic()) < end_s:
        for system in await client.get_systems():
            if await system.has_autopilot():
                vehicles[await system.get_system_id()] = system
        if number in vehicles:
            return number, vehicles[number]
        if number is None and vehicles and not is_one_heard:
            end_s, is_one_heard = now_s + OTHERS_S, True
        await asyncio.sleep(LOOK_AGAIN_S)
    heard = ", ".join(map(str, sorted(vehicles)))
    if number is not None:
        others = f"; heard: system {heard}" if heard else ""
        raise LinkTimeout(f"no vehicle with system id {number} on {url}{others}")
    if not vehicles:
        raise LinkTimeout(
            f"no vehicle on {url} after {timeout_s:.0f} s\n"
            "    is `companion run` or `companion sim` running? does QGroundControl have the port?"
        )
    if len(vehicles) > 1:
        raise LinkError(
            f"several vehicles on {url}: systems {heard}\n    name one of them with --system"
        )
    return vehicles.popitem()


class Station:
    """One vehicle, as seen from the ground.

    Args:
        system: MAVSDK's system, with an autopilot.
        number: the vehicle's system id.

    Attributes:
        system: the vehicle's system id.
    """

    def __init__(self, system: Any, number: int) -> None:
        self.system = number
        self._ftp = FtpAsync(system)
        self._direct = MavlinkDirectAsync(system)

    async def meet(self, timeout_s: float) -> None:
        """Waits until the companion is heard.

        Raises:
            LinkTimeout: it was not heard.
        """
        try:
            async with asyncio.timeout(timeout_s):
                messages = self.messages(["HEARTBEAT"])
                while (await anext(messages)).component != COMPANION:
                    continue
                await messages.aclose()
        except TimeoutError:
            raise LinkTimeout(
                f"no companion (component {COMPANION}) on system {self.system}\n"
                "    `companion run --connect URL` has to run on board"
            ) from None
        log.debug("heard component %d of system %d", COMPANION, self.system)
        await self._ftp.set_target_compid(COMPANION)

    async def messages(self, names: Iterable[str]) -> AsyncGenerator[Heard]:
        """Yields messages with these names, from any component of the vehicle, as they arrive."""
        queue: asyncio.Queue[Heard] = asyncio.Queue()

        async def pump(name: str) -> None:
            async for message in self._direct.subscribe_message(name):
                fields = json.loads(message.fields_json)
                queue.put_nowait(Heard(message.component_id, name, fields))

        tasks = [asyncio.create_task(pump(name)) for name in names]
        try:
            while True:
                yield await queue.get()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def has(self, local: Path, remote: PurePosixPath) -> bool:
        """Whether a file is on board already, with the same content."""
        try:
            return bool(await self._ftp.are_files_identical(str(local), str(remote)))
        except FtpError as error:
            _check_answered(error)
            return False

    async def put(self, local: Path, remote: PurePosixPath, progress: ProgressCallback) -> None:
        """Sends a file; creates the folders on its path.

        Raises:
            LinkError: the companion refuses it.
            LinkTimeout: there was no answer.
        """
        log.debug("sending %s as %s", local, remote)
        for folder in reversed(remote.parents[:-1]):
            try:
                await self._ftp.create_directory(str(folder))
            except FtpError as error:
                _check_answered(error)  # it is there already, or the file is refused next
        with tempfile.TemporaryDirectory() as copy:  # MAVSDK keeps the local name
            named = Path(copy) / remote.name
            named.write_bytes(local.read_bytes())
            try:
                async for _, data in self._ftp.upload(str(named), str(remote.parent)):
                    if data is not None and data.total_bytes:
                        progress(data.bytes_transferred, data.total_bytes)
            except FtpError as error:
                _check_answered(error)
                reason = FtpResult(error.result).name
                raise LinkError(f"the companion does not take {remote}: {reason}") from error

    async def verdict(self) -> dict[str, Any] | None:
        """Returns the verdict on the mission uploaded last; None if there is none."""
        with tempfile.TemporaryDirectory() as folder:
            try:
                async for _ in self._ftp.download(f"/{VERDICT}", folder, False):
                    pass
                return dict(json.loads((Path(folder) / VERDICT).read_bytes()))
            except FtpError as error:
                _check_answered(error)
                return None
            except (OSError, ValueError):  # it was replaced while we read it
                return None

    async def new_verdict(self, after: int, checksum: int, timeout_s: float) -> dict[str, Any]:
        """Waits for the verdict on a file and returns it.

        Args:
            after: number of the last verdict before the file was sent.
            checksum: of the file's content.

        Raises:
            LinkTimeout: it did not come in time.
        """
        try:
            async with asyncio.timeout(timeout_s):
                while True:
                    verdict = await self.verdict()
                    log.debug("verdict %s", verdict and verdict["number"])
                    if verdict and verdict["number"] > after and verdict["crc32"] == checksum:
                        return verdict
                    await asyncio.sleep(PAUSE_S)
        except TimeoutError:
            raise LinkTimeout(f"no verdict on the mission after {timeout_s:.0f} s") from None

    async def command(self, number: int) -> int:
        """Sends a command without parameters to the companion and returns the MAV_RESULT.

        Raises:
            LinkTimeout: there was no answer.
        """
        fields = {"target_system": self.system, "target_component": COMPANION, "command": number}
        message = MavlinkMessage("COMMAND_LONG", 0, 0, self.system, COMPANION, json.dumps(fields))
        try:
            ack = await self._direct.send_command(message)
        except MavsdkError as error:
            raise LinkTimeout(f"the companion does not answer command {number}") from error
        log.debug("command %d: %s", number, ack.fields_json)
        return int(json.loads(ack.fields_json)["result"])


def _check_answered(error: FtpError) -> None:
    """Raises LinkTimeout unless the failure was an answer."""
    if error.result == FtpResult.TIMEOUT:
        raise LinkTimeout("the companion does not answer any more") from error
