"""What does the autopilot do with the vehicle? Armed or not, which mode, which motor commands.

In: the vehicle's state each step, and what the link asks for (arm, change the mode, a setpoint).
Out: a target for the motors (motor_control.py), and notices for people. Its rules are PX4's:

1. The intended mode is what was asked for; a failsafe flies another mode while it lasts.
2. Disarmed, every mode may be chosen; arming is refused where the mode lacks what it needs.
3. In the air, a mode that lacks what it needs is refused and the present one is kept.
4. COM_DISARM_LAND after a landing, or COM_DISARM_PRFLT after arming without a take-off, it
   disarms by itself; a finished take-off, return or landing then leaves AUTO.LOITER.

Source: PX4 1.16, src/modules/commander, and what a PX4 was seen to do. Time is the state's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.geometry import Ned
from sitl.autopilot.arming import Readiness, objection
from sitl.autopilot.basic_modes import Hold
from sitl.autopilot.failsafe_state import FailsafeState
from sitl.autopilot.failsafes import Conditions, battery_level
from sitl.autopilot.flights import Flights
from sitl.autopilot.geofence import Area, Geofence
from sitl.autopilot.mission import Mission
from sitl.autopilot.mission_items import Item
from sitl.autopilot.modes import FLIGHT_MODES, Need
from sitl.autopilot.motor_control import MotorControl
from sitl.autopilot.notices import BATTERY_NOTICES, Notice, Severity, failsafe_notices
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.situation import FlightMode, Situation
from sitl.flight.controllers import Target
from sitl.flight.mixer import Motors
from sitl.flight.physics import FlightState

COMMANDER_STEPS = 5  # modes, failsafes and targets are decided every 5th step, 50 Hz at 4 ms
_DONE_WHEN_DISARMED = ("AUTO.TAKEOFF", "AUTO.RTL", "AUTO.LAND")


class Autopilot:
    """One vehicle's autopilot.

    Args:
        parameters: shared with the parameter protocol.
        state: at the start, on the ground.

    Attributes:
        is_armed: the motors turn.
        is_crashed: the vehicle has hit something and will not fly again.
        mode: flown now; differs from `intended_mode` during a failsafe.
        home: where the vehicle was armed last, or what was set since; before, where it started.
        cruise_mps: speed of automatic modes, if MAV_CMD_DO_CHANGE_SPEED has set one.
        position_age_s: time since the position was last measured.
        control: of the motors.
        flights: how often and when it was armed.
        mission: what AUTO.MISSION flies.
        fence: where the vehicle may be.
        notices: for people, oldest first; whoever sends them empties the list.
    """

    def __init__(self, parameters: Parameters, state: FlightState) -> None:
        self.parameters = parameters
        self.is_armed = False
        self.is_crashed = False
        self.mode = self.intended_mode = "AUTO.LOITER"
        self.home: Ned = state.position
        self.position_age_s = 0.0
        self.cruise_mps: float | None = None
        self.control = MotorControl(parameters)
        self.battery = battery_level(state.charge, parameters)
        self.notices: list[Notice] = []
        self.flights = Flights()
        self.mission = Mission()
        self.fence = Geofence()
        self._state = state
        self._failsafe = FailsafeState()
        self._setpoint: Target | None = None
        self._setpoint_s = self._ground_station_s = -math.inf
        self._refusal: str | None = None
        self._takeoff_down_m = self._lowest_takeoff()
        self._flying: FlightMode = Hold.start(self._situation())
        self._until_commander = 0

    # What can be read.

    @property
    def is_landed(self) -> bool:
        """The vehicle rests on the ground."""
        return self.control.is_landed

    @property
    def is_failsafe(self) -> bool:
        """A failsafe acts."""
        return self._failsafe.mode is not None or self._failsafe.stops_motors

    @property
    def is_position_lost(self) -> bool:
        """There has been no position for too long."""
        return self._conditions().is_position_lost

    @property
    def is_fence_breached(self) -> bool:
        """The vehicle is where its geofence does not allow it to be."""
        return self.fence.is_breached(self._state.position, self.home, self.parameters)

    def objection(self) -> str | None:
        """Why arming would be refused now, None if it would not."""
        mode = self.intended_mode
        return objection(
            Readiness(mode, self._missing(mode), self._conditions(), self.is_crashed, self._refusal)
        )

    # What can be asked for. Each answers whether it was granted; a refusal leaves a notice.

    def arm(self, *, is_forced: bool = False) -> bool:
        """Start the motors; by force without any check."""
        if self.is_armed:
            return True
        reason = self.objection()
        if reason is not None and not is_forced:
            self._tell(Severity.CRITICAL, f"Arming denied: {reason}")
            return False
        now_s = self._state.time_s
        self.is_armed = True
        self.flights.begin(now_s)
        self.parameters.set("COM_FLIGHT_UUID", self.flights.count)
        self.home = self._state.position
        self.control.arm(self._state)
        self._failsafe = FailsafeState()
        self._takeoff_down_m = min(self._takeoff_down_m, self._lowest_takeoff())
        self._until_commander = 0
        self._enter(self.intended_mode)
        self._tell(Severity.INFO, "Armed by external command")
        return True

    def disarm(self, *, is_forced: bool = False) -> bool:
        """Stop the motors; in the air by force alone."""
        if self.is_armed and not self.is_landed and not is_forced:
            self._tell(Severity.CRITICAL, "Disarming denied: not landed")
            return False
        if self.is_armed:
            self._stop("Disarmed by external command")
        return True

    def set_mode(self, mode: str) -> bool:
        """Intend a mode of `FLIGHT_MODES`; during a failsafe this takes the vehicle over."""
        missing = self._missing(mode)
        if self.is_armed and missing:
            self._tell(Severity.CRITICAL, f"{mode} refused: {missing}")
            return False
        if mode == "AUTO.TAKEOFF":
            self._takeoff_down_m = self._lowest_takeoff()
        self._failsafe.take_over()
        self.intended_mode = mode
        if mode != self.mode:
            self._enter(mode)
        return True

    def take_off(self, down_m: float | None = None) -> bool:
        """Climb to a height (local NED down), at least MIS_TAKEOFF_ALT above home."""
        lowest = self._lowest_takeoff()
        if down_m is not None and down_m > lowest:
            self._tell(Severity.CRITICAL, "Using minimum takeoff altitude")
        granted = self.set_mode("AUTO.TAKEOFF")
        self._takeoff_down_m = lowest if down_m is None else min(down_m, lowest)
        self._enter(self.intended_mode)
        return granted

    def hold_at(
        self,
        north_m: float | None,
        east_m: float | None,
        down_m: float | None,
        yaw_rad: float | None,
    ) -> bool:
        """Fly to a point and hold there; None keeps what the vehicle would hold now."""
        granted = self.set_mode("AUTO.LOITER")
        here = Hold.start(self._situation())
        point = (
            here.point[0] if north_m is None else north_m,
            here.point[1] if east_m is None else east_m,
            here.point[2] if down_m is None else down_m,
        )
        self._flying = Hold(point, here.yaw_rad if yaw_rad is None else yaw_rad)
        return granted

    def accept_setpoint(self, setpoint: Target) -> None:
        """Take a valid offboard setpoint; it counts for COM_OF_LOSS_T."""
        self._setpoint = setpoint
        self._setpoint_s = self._state.time_s

    def hear_ground_station(self) -> None:
        """A heartbeat of a ground station has come in."""
        self._ground_station_s = self._state.time_s

    def load_mission(self, items: Sequence[Item], current: int | None) -> None:
        """Replace the mission; `current` is the item to begin with, None keeps the index."""
        self.mission.load(items, current, self._state.time_s)

    def load_fence(self, areas: Sequence[Area]) -> None:
        """Replace the geofence; an area that is violated already is left out."""
        kept_to = {"Home position": self.home}
        if self.parameters["GF_ACTION"] and not self.is_landed:
            kept_to["current vehicle position"] = self._state.position
        for name in self.fence.load(areas, kept_to):
            self._tell(Severity.CRITICAL, f"Geofence invalid, doesn't contain {name}")

    def start_mission(self, index: int | None) -> bool:
        """Fly the mission, from an item if one is given; arms."""
        if not self.set_mode("AUTO.MISSION") or not self.arm():
            return False
        if index is not None:
            self.mission.set_current(index)
        return True

    def refuse_arming(self, reason: str | None) -> None:
        """From now on arming is refused for a reason; None allows it again."""
        self._refusal = reason

    def tell_objection(self) -> None:
        """Tell people why arming would be refused."""
        reason = self.objection()
        if reason is not None:
            self._tell(Severity.WARNING, f"Preflight Fail: {reason}")

    def terminate(self) -> None:
        """Stop the motors wherever the vehicle is (MAV_CMD_DO_FLIGHTTERMINATION)."""
        if self.is_armed:
            self._stop("Flight termination active")

    def crash(self, text: str) -> None:
        """The vehicle has hit something: stop for good."""
        if self.is_crashed:
            return
        self.is_crashed = True
        self._tell(Severity.CRITICAL, text)
        if self.is_armed:
            self._stop("Disarmed by failure detector")

    # What happens by itself.

    def step(self, state: FlightState, dt_s: float) -> Motors:
        """Motor commands for the next step.

        Args:
            state: the newest, `dt_s` after the one before.
            dt_s: length of a step.
        """
        self._state = state
        if self._until_commander == 0:
            self._until_commander = COMMANDER_STEPS
            self._command()
            target = self._flying.target(self._situation()) if self.is_armed else None
            self.control.aim(target, state)
        self._until_commander -= 1
        was_landed = self.is_landed
        motors = self.control.step(state, dt_s)
        if was_landed != self.is_landed:
            self._note_landing(was_landed)
        return motors

    def _note_landing(self, was_landed: bool) -> None:
        if was_landed:
            self.flights.take_off(self._state.time_s)
            self._tell(Severity.INFO, "Takeoff detected")
        else:
            self.flights.land(self._state.time_s)
            self._tell(Severity.INFO, "Landing detected")

    def _command(self) -> None:
        """Decide on failsafes, modes and disarming."""
        self._watch_battery()
        if not self.is_armed:
            return
        now_s = self._state.time_s
        before = self._failsafe.active, self._failsafe.is_waiting
        self._failsafe.update(self._conditions(), now_s)
        active = self._failsafe.active, self._failsafe.is_waiting
        if active != before:
            self.notices += failsafe_notices(self._failsafe, self.parameters)
        if self._failsafe.stops_motors:
            self._stop("Disarmed by failsafe")
            return
        mode = self._failsafe.mode or self.intended_mode
        if mode != self.mode:
            self._enter(mode)
        elif follower := self._flying.successor(self._situation()):
            self.mode = self.intended_mode = follower.mode
            self._flying = follower.flying
            if follower.text:
                self._tell(Severity.INFO, follower.text)
        if self.is_landed and (text := self.flights.over(now_s, self.parameters)):
            self._stop(text)

    def _conditions(self) -> Conditions:
        now_s = self._state.time_s
        return Conditions(
            self.intended_mode,
            now_s - self._setpoint_s,
            self.battery,
            self.parameters,
            now_s - self._ground_station_s,
            self.position_age_s,
            self.is_fence_breached,
        )

    def _watch_battery(self) -> None:
        level = battery_level(self._state.charge, self.parameters)
        if level > self.battery:
            self.notices.append(BATTERY_NOTICES[level])
        self.battery = level

    def _stop(self, text: str) -> None:
        self.is_armed = False
        self.control.aim(None, self._state)
        self._failsafe = FailsafeState()
        if self.intended_mode in _DONE_WHEN_DISARMED:
            self.intended_mode = "AUTO.LOITER"
        self.mission.disarmed()
        self._enter(self.intended_mode)
        self._tell(Severity.INFO, text)

    def _enter(self, mode: str) -> None:
        self.mode = mode
        self._flying = FLIGHT_MODES[mode].start(self._situation())

    def _missing(self, mode: str) -> str:
        """What a mode needs and lacks; empty if nothing."""
        age_s = self._state.time_s - self._setpoint_s
        has_setpoints = age_s <= self.parameters["COM_OF_LOSS_T"]
        need = FLIGHT_MODES[mode].need
        is_met = {
            Need.NOTHING: True,
            Need.SETPOINTS: has_setpoints,
            Need.MISSION: self.mission.is_ready(self._state.time_s),
            Need.PILOT: False,
        }
        if not is_met[need]:
            return str(need.value)
        return "GPS fix too low" if self._conditions().is_position_lost else ""

    def _lowest_takeoff(self) -> float:
        home = self.home if self.is_armed else self._state.position
        return home[2] - self.parameters["MIS_TAKEOFF_ALT"]

    def _situation(self) -> Situation:
        return Situation(
            self._state,
            self.home,
            self._setpoint,
            self._takeoff_down_m,
            self.cruise_mps or self.parameters["MPC_XY_CRUISE"],
            self.is_landed,
            self.mission,
            self.parameters,
        )

    def _tell(self, severity: Severity, text: str) -> None:
        self.notices.append(Notice(severity, text))
