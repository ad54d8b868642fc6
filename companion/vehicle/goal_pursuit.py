"""Pursues the vehicle's goals one after the other (`goals.py`), by commands to its autopilot.

1. If a failsafe holds the vehicle where a climb ends, or where OFFBOARD is entered, the goal is not
   pursued further: the failsafe may be the fence's. But a failsafe that follows an interruption
   (`heard_time.py`), after OFFBOARD was requested, is the loss of our own stream.
2. A command that was accepted without effect is sent again after a pause.
3. While the autopilot is not heard, no command is sent, and no time of a goal passes.
"""

from __future__ import annotations

from companion.mavlink.commands import CommandSender
from companion.mavlink.framing import Message
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.control_watch import ControlWatch
from companion.vehicle.gimbals import MavlinkGimbals
from companion.vehicle.goals import APPROACHES, Pursuit
from companion.vehicle.heard_time import Interruption
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Heartbeat, Mode, VehicleState
from companion.vehicle.services import Moment
from companion.vehicle.setpoint_stream import SetpointStream
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, COMPONENT, Wire

ASK_AGAIN_S = 2.0
"""Pause before a command that was accepted without effect is sent again."""
ROOF_M = 1.0
"""A vehicle that stands higher than this above home stands on something; less may be an altitude
error."""
SHORT_M = 1.5
"""A take-off that ends by itself ends at most this far below its altitude: PX4 ends it within
NAV_MC_ALT_RAD, 0.8 m; up to 0.9 m of its own estimate were observed."""


class GoalPursuit:
    """Pursues one goal at a time; a service of the vehicle.

    Implements `ports.goals.VehicleGoals`.

    Args:
        wire: of the vehicle's system.
        telemetry: of its autopilot.
        control: who has control.
        setpoints: its setpoints, which end with a landing.
        gimbals: its gimbals, which are given back before a landing.
        takeoff_up_m: altitude above home to take off to.
        ceiling_up_m: highest altitude above home of a take-off.
    """

    wanted = frozenset({"COMMAND_ACK"})
    needs_control = True

    def __init__(
        self,
        wire: Wire,
        telemetry: Telemetry,
        control: ControlWatch,
        setpoints: SetpointStream,
        gimbals: MavlinkGimbals,
        takeoff_up_m: float,
        ceiling_up_m: float,
    ) -> None:
        self._wire = wire
        self._telemetry = telemetry
        self._control, self._setpoints, self._gimbals = control, setpoints, gimbals
        self._moment = Moment(0.0, 0.0, is_quiet=True)
        self._restarts_before: int | None = None  # its first goal
        self._takeoff_up_m, self._ceiling_up_m = takeoff_up_m, ceiling_up_m
        self._commands = CommandSender()
        self._pursuit: Pursuit | None = None
        self._first_mode: Mode | None = None
        self._interruption = Interruption()

    @property
    def goal(self) -> Goal | None:
        """The goal that is pursued, or was reached last; None before the first one."""
        return self._pursuit.goal if self._pursuit is not None else None

    @property
    def has_restarted(self) -> bool:
        """Whether the autopilot has restarted since the first goal."""
        before = self._restarts_before
        return before is not None and self._telemetry.boots.restarts > before

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        """Works towards a goal; the caller calls it in every tick until the goal is reached or has
        failed.

        Args:
            goal: what to bring about.
            takeoff_up_m: altitude above home to take off to; the mission's own if it is None.
        """
        state = self._telemetry.state
        if self._control.takeover is not None:
            return Failed(str(self._control.takeover))
        if state is None or self._control.is_doubted:
            return Progress.RUNNING
        if self._restarts_before is None:
            self._restarts_before = self._telemetry.boots.restarts
        if goal is Goal.LANDED:
            self._gimbals.give_back()
        outcome = self._work(goal, state, self._moment, takeoff_up_m)
        if outcome is Progress.DONE and goal is Goal.LANDED:
            self._setpoints.end()  # we do not stream to a vehicle in OFFBOARD on the ground
        return outcome

    def _work(
        self, goal: Goal, state: VehicleState, moment: Moment, takeoff_up_m: float | None
    ) -> Outcome:
        """Begins the goal, unless it is pursued already, and sends its command when it is due."""
        approach, pursuit = APPROACHES[goal], self._pursuit
        if pursuit is None or pursuit.goal is not goal or pursuit.has_failed:
            self._end_command()
            allowed = approach.passes | {state.heartbeat.mode}
            self._first_mode = self._first_mode or state.heartbeat.mode
            pursuit = Pursuit(
                goal,
                allowed,
                start_mode=state.heartbeat.mode,
                start_s=moment.heard_s,
                takeoff_up_m=self._takeoff_up(state, takeoff_up_m),
                is_in_failsafe=state.heartbeat.is_failsafe,
            )
            self._pursuit = pursuit
        if self._is_known(state, moment) and approach.is_reached(state):
            self._end_command()
            if approach.keeps is not None:
                pursuit.allowed = approach.keeps
            return Progress.DONE
        failure = self._ask(pursuit, state, moment)
        pursuit.has_failed = failure is not None
        return failure or Progress.RUNNING

    def admits(self, heartbeat: Heartbeat) -> bool:
        """Takes a heartbeat; returns whether control is still ours by its mode."""
        pursuit = self._pursuit
        if pursuit is None:
            return True
        is_asked = pursuit.goal is Goal.OFFBOARD and pursuit.asked is not None
        if heartbeat.is_failsafe and is_asked and self._interruption.is_recent:
            pursuit.is_in_failsafe = True  # by the loss of our stream
        was_silent = self._interruption.is_recent
        is_passed = pursuit.admits(heartbeat.mode, heartbeat.is_armed, self._first_mode, was_silent)
        is_held = heartbeat.mode is Mode.LOITER and (
            self._is_held_low(pursuit) or self._is_held_by_failsafe(pursuit, heartbeat)
        )
        return is_passed and not is_held

    def _is_known(self, state: VehicleState, moment: Moment) -> bool:
        """Whether the mode is known, and how the vehicle came to where it is.

        On the ground it may be because its autopilot has restarted in the air.
        """
        may_have_fallen = state.is_landed and not self._telemetry.boots.is_certain(moment.now_s)
        return state.heartbeat.is_recent(moment.now_s) and not may_have_fallen

    def _is_held_low(self, pursuit: Pursuit) -> bool:
        """Whether a climb ended in a hold so low that somebody must have chosen it."""
        state = self._telemetry.state
        if pursuit.goal is not Goal.AIRBORNE or state is None:
            return False
        up_m = -state.motion.position[2]
        return state.heartbeat.mode is Mode.TAKEOFF and up_m < pursuit.takeoff_up_m - SHORT_M

    def _is_held_by_failsafe(self, pursuit: Pursuit, heartbeat: Heartbeat) -> bool:
        """Whether a failsafe, such as the fence's, holds the vehicle where a climb would end."""
        state, is_rising = self._telemetry.state, pursuit.goal in (Goal.AIRBORNE, Goal.OFFBOARD)
        is_news = heartbeat.is_failsafe and not pursuit.is_in_failsafe
        return is_rising and is_news and state is not None and not state.is_landed

    def _ask(self, pursuit: Pursuit, state: VehicleState, moment: Moment) -> Failed | None:
        """Sends the goal's command when it is due; returns a failure if the goal has failed."""
        approach = APPROACHES[pursuit.goal]
        heard_s = moment.heard_s
        elapsed_s = heard_s - pursuit.start_s
        if overdue_s := pursuit.overdue_s(heard_s, state.heartbeat.mode):
            return self._failed(pursuit.goal, f" after {overdue_s:.0f} s", moment)
        if not self._is_known(state, moment):
            return None
        if approach.needs_arming and not state.heartbeat.is_armed:
            return self._failed(pursuit.goal, ": disarmed", moment)
        if state.heartbeat.mode in approach.underway:
            self._end_command()  # it took effect
            return None
        if elapsed_s < approach.lead_s:
            return None
        asked = APPROACHES[Goal.HOLDING] if state.heartbeat.mode in approach.leaves else approach
        if asked is not pursuit.asked:
            self._end_command()
            pursuit.asked = asked
        if pursuit.ticket is not None:
            exchange = self._commands[pursuit.ticket]
            if exchange.has_failed:
                return self._failed(pursuit.goal, f": {exchange.in_words}", moment)
            if not exchange.result or heard_s < exchange.next_send_s + ASK_AGAIN_S:
                return None
            self._end_command()
        takeoff_altitude_m = self._telemetry.frame.altitude_m + pursuit.takeoff_up_m
        parameters = asked.parameters(takeoff_altitude_m)
        target = (self._wire.system, AUTOPILOT)
        pursuit.ticket = self._commands.start(heard_s, target, asked.command, parameters)
        return None

    def _takeoff_up(self, state: VehicleState, asked_m: float | None) -> float:
        """The altitude above home to take off to; from a roof, at least that much above the roof.

        It is at least the altitude of the place, but never above the mission's ceiling.
        """
        up_m = -state.motion.position[2]
        ground_m = up_m if state.is_landed and up_m > ROOF_M else 0.0
        return min(max(ground_m + self._takeoff_up_m, asked_m or 0.0), self._ceiling_up_m)

    def _failed(self, goal: Goal, why: str, moment: Moment) -> Failed:
        """A failure, with what the autopilot said lately."""
        words = self._telemetry.words
        is_arming = goal is Goal.ARMED
        said = (words.why_not_armed if is_arming else words.lately)(moment.now_s)
        texts = f" (autopilot: {'; '.join(said)})" if said else ""
        return Failed(f"not {goal.value}{why}{texts}")

    def _end_command(self) -> None:
        if self._pursuit is not None and self._pursuit.ticket is not None:
            self._commands.forget(self._pursuit.ticket)
            self._pursuit.ticket = None

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Notes the time and interruptions; `pursue` does the work."""
        self._moment = moment
        self._interruption.step(moment.now_s, moment.is_quiet)

    def take(self, moment: Moment, message: Message) -> None:
        """Takes an answer to our commands."""
        if message.target_component in (0, COMPONENT):
            self._commands.receive(moment.heard_s, message)

    def due(self, moment: Moment) -> list[Message]:
        """The command to send now."""
        return [] if moment.is_quiet else self._commands.due(moment.heard_s)

    def release(self) -> None:
        """Drops the goal and its command."""
        self._pursuit = None
        self._commands = CommandSender()
