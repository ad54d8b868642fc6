"""What a fake vehicle has besides flying: payloads, cameras, gimbal, markers, fence, rally points.

Each answers as its test says, after a delay; time is an argument.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.geofence import FenceArea, StoredFence
from companion.geometry import NorthEast
from companion.outcomes import Failed, Outcome, Progress, Refusal
from companion.rally_points import RallyPoint, StoredRally
from companion.vehicle.ports.cameras import (
    IntendedShot,
    PhotoMade,
    ShotOutcome,
    ShotOwner,
    ShotReady,
)
from companion.vehicle.ports.gimbals import Aim
from companion.vehicle.ports.markers import MarkerSighting


class FakePayloads:
    """Answers commands as it was told.

    Attributes:
        answers: seconds and outcome for each command, in the order they are sent; then DONE.
        sent: every command, as (component, command, parameters).
        patience: how long the answer of each is waited for.
        left: the tickets of those that were left, and that nobody has come back to.
        forgotten: the tickets of those that were forgotten.
    """

    def __init__(self) -> None:
        self.answers: list[tuple[float, Outcome]] = []
        self.sent: list[tuple[int, int, tuple[float, ...]]] = []
        self.patience: list[float | None] = []
        self.left: list[int] = []
        self.forgotten: list[int] = []
        self._now_s = 0.0
        self._due: dict[int, tuple[float, Outcome]] = {}

    def number(self, command: str) -> int | None:
        return {"MAV_CMD_DO_GRIPPER": 211}.get(command)

    def step(self, now_s: float) -> None:
        """Time passes."""
        self._now_s = now_s

    def send(
        self, component: int, command: int, parameters: tuple[float, ...], timeout_s: float | None
    ) -> int:
        self.sent.append((component, command, parameters))
        self.patience.append(timeout_s)
        delay_s, outcome = self.answers.pop(0) if self.answers else (0.0, Progress.DONE)
        is_final = outcome is not Progress.RUNNING
        if timeout_s is not None and not (is_final and delay_s <= timeout_s):
            delay_s, outcome = timeout_s, Failed(f"no final answer in {timeout_s:g} s")
        self._due[len(self.sent)] = (self._now_s + delay_s, outcome)
        return len(self.sent)

    def outcome(self, ticket: int) -> Outcome:
        due_s, outcome = self._due[ticket]
        return outcome if self._now_s >= due_s else Progress.RUNNING

    def leave(self, ticket: int) -> None:
        self.left.append(ticket)

    def come_back(self, ticket: int) -> None:
        self.left.remove(ticket)

    def forget(self, ticket: int) -> None:
        self.forgotten.append(ticket)
        del self._due[ticket]


class FakeMarkers:
    """Sees what a test says.

    Attributes:
        seen, refused: since the tick before.
    """

    def __init__(self) -> None:
        self.seen: list[MarkerSighting] = []
        self.refused: list[Refusal] = []


class FakeFence:
    """The fence of an autopilot, which at first does not know where on the earth it is.

    Attributes:
        nowhere: why it does not; None where it does.
        stored: what it has.
        home: that of the autopilot.
        taken: what becomes of a fence that is written.
        objections: what is said when one is written.
        written: all that were written.
        is_mine: whether what it has was written by this companion, in another flight.
        is_as_sent: whether it tells what was written, wherever the frame is by now.
        number: differs for another fence.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self.is_as_sent = False
        self.nowhere: str | None = "the autopilot reports no position on the earth"
        self.stored: StoredFence | None = StoredFence((), 0)
        self.home: NorthEast | None = None
        self.outcome: Outcome = Progress.DONE
        self.taken: Outcome = Progress.DONE
        self.said: list[str] = []
        self.objections: list[str] = []
        self.written: list[tuple[FenceArea, ...]] = []
        self.is_mine = False
        self._vouched: object = None

    def locate(self) -> Outcome:
        return Progress.DONE if self.nowhere is None else Failed(self.nowhere)

    def read(self) -> None:
        """It is told at once."""

    def write(self, areas: Sequence[FenceArea]) -> None:
        self.written.append(tuple(areas))
        self.objections = list(self.said)
        if self.taken is Progress.DONE:
            self.stored = StoredFence(tuple(areas), 4 * len(areas))
        else:
            self.outcome = self.taken

    def is_own(self) -> bool:
        return self.is_mine

    def is_as_written(self) -> bool:
        return self.is_as_sent

    def is_vouched_for(self) -> bool:
        return self._vouched is self.stored

    def vouch(self) -> None:
        self._vouched = self.stored


class FakeRally:
    """The rally points of an autopilot, which knows where on the earth it is.

    Attributes:
        nowhere: why it does not; None where it does.
        stored: those that it has.
        taken: what becomes of those that are written.
        written: all that were written.
        is_mine: whether those that it has were written by this companion, in another flight.
        has_written: whether it has ever written some.
        reads: how often it was asked.
    """

    def __init__(self) -> None:
        self.nowhere: str | None = None
        self.stored: StoredRally | None = StoredRally(())
        self.outcome: Outcome = Progress.DONE
        self.taken: Outcome = Progress.DONE
        self.written: list[tuple[RallyPoint, ...]] = []
        self.is_mine = self.has_written = False
        self.reads = 0

    def locate(self) -> Outcome:
        return Progress.DONE if self.nowhere is None else Failed(self.nowhere)

    def read(self) -> None:
        """They are told at once."""
        self.reads += 1

    def write(self, points: Sequence[RallyPoint]) -> None:
        self.written.append(tuple(points))
        if self.taken is Progress.DONE:
            self.stored = StoredRally(tuple(points))
        else:
            self.outcome = self.taken

    def is_own(self) -> bool:
        return self.is_mine

    def is_as_written(self) -> bool:
        return False


class FakeCameras:
    """Makes every photo at once, unless it was told otherwise.

    Attributes:
        answers: seconds and outcome for each photo, in the order they are asked for; then made.
        prepared: whom each photo is for.
        shot: those that were asked for.
        recalled: photos of another process.
    """

    def __init__(self) -> None:
        self.answers: list[tuple[float, PhotoMade | Failed]] = []
        self.prepared: list[tuple[int, ShotOwner]] = []
        self.shot: list[int] = []
        self.recalled: list[IntendedShot] = []
        self._now_s = 0.0
        self._due: dict[int, tuple[float, PhotoMade | Failed]] = {}

    def step(self, now_s: float) -> None:
        """Time passes."""
        self._now_s = now_s

    def prepare(
        self, component: int, owner: ShotOwner, timeout_s: float | None, may_repeat: bool = False
    ) -> int:
        self.prepared.append((component, owner))
        return len(self.prepared)

    def shoot(self, ticket: int) -> None:
        self.shot.append(ticket)
        made = PhotoMade(len(self.shot), len(self.shot) - 1)
        delay_s, outcome = self.answers.pop(0) if self.answers else (0.0, made)
        self._due[ticket] = (self._now_s + delay_s, outcome)

    def outcome(self, ticket: int) -> ShotOutcome:
        if ticket not in self._due:
            return ShotReady(ticket, len(self.shot))
        due_s, outcome = self._due[ticket]
        return outcome if self._now_s >= due_s else None

    def forget(self, ticket: int) -> None:
        self._due.pop(ticket, None)

    def recall(self, shot: IntendedShot) -> None:
        self.recalled.append(shot)


class FakeGimbals:
    """Points wherever it is told to, at once.

    Attributes:
        outcomes: of each pointing, in order; then it points there.
        pointed: component and aim of each.
    """

    def __init__(self) -> None:
        self.outcomes: list[Outcome] = []
        self.pointed: list[tuple[int, Aim]] = []
        self._current: dict[int, Outcome] = {}

    def point(self, component: int, aim: Aim, timeout_s: float | None) -> int:
        self.pointed.append((component, aim))
        ticket = len(self.pointed)
        self._current[ticket] = self.outcomes.pop(0) if self.outcomes else Progress.DONE
        return ticket

    def outcome(self, ticket: int) -> Outcome:
        return self._current[ticket]

    def forget(self, ticket: int) -> None:
        del self._current[ticket]
