"""A gripper on board with a load sensor.

It answers as PX4's gripper does: IN_PROGRESS at once, and ACCEPTED after a fixed time, whether it
has gripped something or not.

1. The action that is under way is TEMPORARILY_REJECTED if asked for again; once done, ACCEPTED.
2. The opposite action CANCELS the one under way, then begins.
3. A grab takes a load where there is one; a release drops it.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import Ned
from sitl.results import MavResult
from sitl.world.payload import CommandAck, Requester
from sitl.world.visits import Circle

RELEASE, GRAB = 0, 1


@dataclass(frozen=True, slots=True)
class GripperSpec:
    """The properties of a gripper.

    Attributes:
        after_s: how long an action takes.
        loads: circles in which there is something to grab; None means everywhere.
    """

    component: int
    after_s: float = 1.0
    loads: tuple[Circle, ...] | None = None


@dataclass(frozen=True, slots=True)
class GripperChange:
    """A change of a gripper; None leaves a property as it is.

    Attributes:
        misses: its grabs take no load.
        drops: it loses its load now.
        is_silent: it sends nothing and receives nothing.
    """

    misses: bool | None = None
    drops: bool = False
    is_silent: bool | None = None


@dataclass(frozen=True, slots=True)
class _Moving:
    requester: Requester
    action: int
    end_s: float


class Gripper:
    """One gripper, open at first.

    Attributes:
        has_load: what its sensor reads.
        is_silent: it sends nothing.
    """

    def __init__(self, spec: GripperSpec) -> None:
        self.spec = spec
        self.has_load = self.is_silent = False
        self._misses = False
        self._action = RELEASE
        self._moving: _Moving | None = None

    def change(self, change: GripperChange) -> None:
        """Applies a change of the scenario."""
        if change.misses is not None:
            self._misses = change.misses
        if change.is_silent is not None:
            self.is_silent = change.is_silent
        self.has_load = self.has_load and not change.drops

    def act(self, requester: Requester, action: float, now_s: float) -> list[CommandAck]:
        """The answers to MAV_CMD_DO_GRIPPER."""
        if action not in (RELEASE, GRAB):
            return [CommandAck(requester, MavResult.DENIED)]
        moving, acks = self._moving, []
        if moving is not None:
            if moving.action == action:
                return [CommandAck(requester, MavResult.TEMPORARILY_REJECTED)]
            acks.append(CommandAck(moving.requester, MavResult.CANCELLED))
        elif self._action == action:
            return [CommandAck(requester, MavResult.ACCEPTED)]
        self._moving = _Moving(requester, int(action), now_s + self.spec.after_s)
        return [*acks, CommandAck(requester, MavResult.IN_PROGRESS, progress=255)]

    def step(self, position: Ned, now_s: float) -> CommandAck | None:
        """The final answer to the action under way, if it is due now."""
        moving = self._moving
        if moving is None or now_s < moving.end_s:
            return None
        self._moving, self._action = None, moving.action
        loads = self.spec.loads
        is_there = loads is None or any(circle.contains(position) for circle in loads)
        self.has_load = moving.action == GRAB and is_there and not self._misses
        return CommandAck(moving.requester, MavResult.ACCEPTED)
