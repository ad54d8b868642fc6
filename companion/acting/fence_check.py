"""The autopilot's fence, before arming: it is the mission's, and it is in force.

The companion's gate keeps to the mission's fence and zones as long as the companion lives. The
autopilot's fence, along the same edges, is the net behind it: it holds the vehicle whoever flies.

1. What the mission writes under `limits`, a fence and zones, is put into an autopilot that has no
   fence. One that is this companion's own, of another mission, gives way to it, which is told.
2. A fence that somebody else has put there stays. The mission is refused, unless the operator has
   said which of the two is to be kept.
3. One that has just been written is read back and compared. Then what the autopilot says is
   listened to for LISTEN_S: PX4 takes a fence, reads it back whole, and leaves out an area that
   does not hold its home.
4. One that is there already is written again, once in each program: PX4 does not say whether a
   fence that it has is in force.
5. Whatever fence it is: the autopilot's home, the vehicle and each place of the mission lie in
   every area of it, or the mission is refused. What follows from one that is kept is for
   kept_fence.py.
6. An autopilot that does not know where on the earth it is has no fence. That is told, and the
   mission begins: the gate is there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum

from companion.acting.arming_terms import FencePolicy
from companion.acting.flight import Flight
from companion.flight_events.fence import FenceKept, FenceMissing, FenceReplaced, FenceWritten
from companion.geofence import FenceArea, FencePolygon, StoredFence, are_alike
from companion.geometry import NorthEast
from companion.mission.model import Limits, Place
from companion.transitions import StateTransition, TransitionTable
from companion.vehicle.port import Failed, Outcome, Progress

ALIKE_M = 0.2
"""Corners that are nearer to each other are the same; the protocol rounds to a centimetre."""
LISTEN_S = 2.0


class FenceStage(Enum):
    """How far the check has come."""

    LOCATING = "asking where the autopilot's frame lies"
    READING = "reading the autopilot's fence"
    WRITING = "writing the mission's"
    READING_BACK = "reading it back"
    LISTENING = "listening to what the autopilot says of it"
    DONE = "done"


class FenceStep(Enum):
    """What happens in a check."""

    LOCATED = "it is known where the frame lies"
    NOWHERE = "the autopilot has no position on the earth"
    KEPT = "the fence that is there may stay"
    UNFIT = "the mission's fence has to be written"
    WRITTEN = "the autopilot has taken it"
    READ_BACK = "it is what was written"
    UNOPPOSED = "nothing was said against it"


_S, _T = FenceStage, FenceStep

TRANSITIONS = TransitionTable(
    StateTransition(_S.LOCATING, _T.LOCATED, _S.READING, "the fence is asked for"),
    StateTransition(_S.LOCATING, _T.NOWHERE, _S.DONE, "the gate alone holds, which is told"),
    StateTransition(_S.READING, _T.KEPT, _S.DONE, "home, vehicle and places lie inside"),
    StateTransition(_S.READING, _T.UNFIT, _S.WRITING, "home, vehicle and places lie inside"),
    StateTransition(_S.WRITING, _T.WRITTEN, _S.READING_BACK, "the fence is asked for"),
    StateTransition(_S.READING_BACK, _T.READ_BACK, _S.LISTENING, "time passes"),
    StateTransition(_S.LISTENING, _T.UNOPPOSED, _S.DONE, "it is in force, which is told"),
)
"""How a check goes on; it ends anywhere with why the mission is refused."""


class FenceCheck:
    """One check.

    Args:
        flight: whose autopilot is asked.
        policy: what the operator has said.
        places: of the mission.

    Attributes:
        kept: the fence of somebody else that stays; None without one.
    """

    def __init__(self, flight: Flight, policy: FencePolicy, places: Sequence[Place]) -> None:
        self._flight = flight
        self._policy = policy
        self._places = places
        self._wanted = areas_of(flight.limits)
        is_left_alone = policy is FencePolicy.NONE
        self._stage = FenceStage.DONE if is_left_alone else FenceStage.LOCATING
        self.kept: StoredFence | None = None
        self._replaced: StoredFence | None = None
        self._silent_from_s = 0.0

    def tick(self) -> Outcome:
        """DONE when the fence is in force, or there is none to be; or why it is not."""
        if self._stage is FenceStage.DONE:
            return Progress.DONE
        step = _WORK[self._stage](self)
        if isinstance(step, Failed):
            return step
        if step is not None:
            self._stage = TRANSITIONS.next(self._stage, step)
        return Progress.DONE if self._stage is FenceStage.DONE else Progress.RUNNING

    def _locate(self) -> FenceStep | Failed | None:
        fence = self._flight.vehicle.fence
        outcome = fence.locate()
        if isinstance(outcome, Failed):
            self._flight.report(FenceMissing(outcome.reason))
            return FenceStep.NOWHERE
        if outcome is Progress.RUNNING:
            return None
        fence.read()
        return FenceStep.LOCATED

    def _judge(self) -> FenceStep | Failed | None:
        """What is there is kept, or what is wanted is written; rules 1, 2 and 4."""
        stored = self._read()
        if not isinstance(stored, StoredFence):
            return stored
        fence = self._flight.vehicle.fence
        if self._policy is FencePolicy.KEEP or not self._wanted:
            return self._keep(stored)
        is_ours = stored.flaw is None and are_alike(stored.areas, self._wanted, ALIKE_M)
        if is_ours and fence.is_vouched_for():
            return self._keep(stored)
        if stored.points and not is_ours:
            if self._policy is not FencePolicy.REPLACE and not fence.is_own():
                return Failed(_another(stored))
            self._replaced = stored
        if why_not := self._outside(self._wanted, "the mission's fence"):
            return why_not
        fence.write(self._wanted)
        return FenceStep.UNFIT

    def _write(self) -> FenceStep | Failed | None:
        fence = self._flight.vehicle.fence
        if isinstance(outcome := fence.outcome, Failed):
            return _advised(outcome)
        if outcome is Progress.RUNNING:
            return None
        fence.read()
        return FenceStep.WRITTEN

    def _read_back(self) -> FenceStep | Failed | None:
        stored = self._read()
        if not isinstance(stored, StoredFence):
            return stored
        if stored.flaw is not None or not are_alike(stored.areas, self._wanted, ALIKE_M):
            return Failed(
                f"the autopilot has taken the mission's fence, and tells another one ({stored})"
            )
        self._silent_from_s = self._flight.now_s
        return FenceStep.READ_BACK

    def _listen(self) -> FenceStep | Failed | None:
        """Rules 3 and 5; the autopilot's home may have come meanwhile."""
        fence, now_s = self._flight.vehicle.fence, self._flight.now_s
        if objections := fence.objections:
            return Failed(
                f"the autopilot has taken the mission's fence, and leaves a part of it out: "
                f"{'; '.join(objections)}\n    set its home where the vehicle stands"
            )
        if now_s - self._silent_from_s < LISTEN_S:
            return None
        if why_not := self._outside(self._wanted, "the mission's fence"):
            return why_not
        fence.vouch()
        words = str(fence.stored)
        if self._replaced is not None:
            self._flight.report(FenceReplaced(words, str(self._replaced)))
        else:
            self._flight.report(FenceWritten(words))
        return FenceStep.UNOPPOSED

    def _read(self) -> StoredFence | Failed | None:
        """What was asked for; None until it has come."""
        fence = self._flight.vehicle.fence
        if isinstance(outcome := fence.outcome, Failed):
            return _advised(outcome)
        return fence.stored if outcome is Progress.DONE else None

    def _keep(self, stored: StoredFence) -> FenceStep | Failed:
        """The fence that is there stays, if the mission can be flown in it."""
        if stored.flaw is not None:
            return Failed(f"the vehicle's fence ({stored}) is not as it was meant: {stored.flaw}")
        if why_not := self._outside(stored.areas, "the vehicle's own fence"):
            return why_not
        if stored.points:
            is_ours = are_alike(stored.areas, self._wanted, ALIKE_M)
            self.kept = None if is_ours else stored
            self._flight.report(FenceKept(str(stored)))
        else:
            self._flight.report(FenceMissing("it has none, and none is asked for"))
        return FenceStep.KEPT

    def _outside(self, areas: Sequence[FenceArea], whose: str) -> Failed | None:
        """Why the mission cannot be flown in a fence; rule 5."""
        state, home = self._flight.vehicle.state, self._flight.vehicle.fence.home
        points: list[tuple[str, NorthEast]] = []
        if home is not None:
            points.append(("the autopilot's home", home))
        if state is not None:
            points.append(("the vehicle", state.position[:2]))
        points += [(place.name, place.position[:2]) for place in self._places]
        for name, point in points:
            for number, area in enumerate(areas, 1):
                if not area.allows(point):
                    where = "outside" if area.is_inclusion else "inside a zone of"
                    return Failed(f"{name} lies {where} {whose} (area {number} of {len(areas)})")
        return None


def areas_of(limits: Limits) -> tuple[FenceArea, ...]:
    """The areas that a mission writes; none where its map alone says how far it may fly."""
    zones = (FenceArea(FencePolygon(corners), False) for corners in limits.keep_out.values())
    fence = (FenceArea(FencePolygon(limits.fence), True),) if limits.is_fence_written else ()
    return (*fence, *zones)


def _another(stored: StoredFence) -> str:
    replaced = "\n    --autopilot-fence replace puts the mission's in its place"
    if stored.flaw is not None:
        return f"the vehicle has another fence ({stored}): {stored.flaw}{replaced}"
    kept = "\n    --autopilot-fence keep flies within it, beside the mission's own"
    return f"the vehicle has another fence ({stored}){kept}{replaced}"


def _advised(failed: Failed) -> Failed:
    return Failed(f"{failed.reason}\n    --autopilot-fence none leaves it alone")


_WORK: dict[FenceStage, Callable[[FenceCheck], FenceStep | Failed | None]] = {
    FenceStage.LOCATING: FenceCheck._locate,
    FenceStage.READING: FenceCheck._judge,
    FenceStage.WRITING: FenceCheck._write,
    FenceStage.READING_BACK: FenceCheck._read_back,
    FenceStage.LISTENING: FenceCheck._listen,
}
"""What each stage does in a tick; DONE does nothing."""
