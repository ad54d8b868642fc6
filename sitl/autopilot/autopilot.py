"""The autopilot: arming, modes, failsafes and the setpoint of the motors.

In: the vehicle's state at 50 Hz, and commands from the link (arm, change the mode, a setpoint).
Out: a setpoint for the motors (motor_control.py), and status texts for people. Its rules are PX4's:

1. The intended mode is the one that was commanded; a failsafe flies another mode while it lasts.
2. Disarmed, every mode may be chosen; arming is refused while the mode lacks its requirement.
3. In the air, a mode that lacks its requirement is refused and the present one is kept.
4. The vehicle disarms by itself COM_DISARM_LAND after a landing, or COM_DISARM_PRFLT after arming
   without a take-off. Then the intended mode is the last one in which arming is allowed: after a
   landing commanded in OFFBOARD it is OFFBOARD, where arming requires setpoints.

Source: PX4 1.16, src/modules/commander, and observation of PX4. Time comes with each state.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.geofence import FenceArea
from companion.geometry import Ned
from sitl.autopilot.arming import PreflightState, arming_denials
from sitl.autopilot.basic_modes import HoldMode
from sitl.autopilot.failsafe_state import FailsafeState
from sitl.autopilot.failsafes import FailsafeInputs
from sitl.autopilot.flight_record import FlightRecord
from sitl.autopilot.geofence import Geofence
from sitl.autopilot.health import Health
from sitl.autopilot.mission_plan import MissionPlan
from sitl.autopilot.modes import FLIGHT_MODES, missing_requirement
from sitl.autopilot.motor_control import MotorControl
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.return_destination import SafePoint
from sitl.autopilot.situation import FlightMode, Situation
from sitl.autopilot.status_texts import BATTERY_TEXTS, Severity, StatusText, failsafe_texts, told
from sitl.flight.controllers import OWN_GAINS, HorizontalGains, Maybe, TrajectorySetpoint
from sitl.flight.physics import FlightState, RateSetpoint
from sitl.flight.rotors import Motors


class Autopilot:
    """One vehicle's autopilot.

    Args:
        parameters: shared with the parameter protocol.
        state: the estimate at the start, on the ground.
        gains: the gains of the horizontal position loops.

    Attributes:
        is_armed: whether the motors turn.
        is_crashed: the vehicle has hit something and will not fly again.
        mode: flown now; differs from `intended_mode` during a failsafe.
        home: where the vehicle was last armed, or what was set since; at first, where it starts.
        cruise_mps: speed of automatic modes, if MAV_CMD_DO_CHANGE_SPEED has set one.
        setpoint: the newest offboard setpoint.
        health: ages of the inputs, and the battery's warning level.
        control: controls the motors.
        flights: the record of armings and take-offs.
        mission: flown by AUTO.MISSION.
        fence: the geofence.
        safe_points: rally points, where a return may land besides home.
        arming_refusal: a reason that refuses arming in any case; None if there is none.
        status_texts: for people, oldest first; their sender empties the list.
    """

    def __init__(
        self,
        parameters: Parameters,
        state: FlightState,
        gains: HorizontalGains = OWN_GAINS,
    ) -> None:
        self.parameters = parameters
        self.is_armed = False
        self.is_crashed = False
        self.mode = self.intended_mode = self._mode_when_disarmed = "AUTO.LOITER"
        self.home: Ned = state.position
        self.cruise_mps: float | None = None
        self.health = Health(parameters, state.charge)
        self.control = MotorControl(parameters, gains)
        self.status_texts: list[StatusText] = []
        self.flights = FlightRecord()
        self.mission = MissionPlan()
        self.fence = Geofence()
        self.safe_points: tuple[SafePoint, ...] = ()
        self._state = state
        self._failsafe = FailsafeState()
        self.setpoint: TrajectorySetpoint | None = None
        self.arming_refusal: str | None = None
        self._takeoff_down_m = self._lowest_takeoff()
        self._active_mode: FlightMode = HoldMode.start(self._situation())

    # Queries.

    @property
    def is_landed(self) -> bool:
        """Whether the vehicle rests on the ground."""
        return self.control.land_detector.is_landed

    @property
    def is_failsafe(self) -> bool:
        """Whether a failsafe acts."""
        return self._failsafe.mode is not None or self._failsafe.stops_motors

    @property
    def is_fence_breached(self) -> bool:
        """Whether the vehicle is where its geofence does not allow it."""
        return self.fence.is_breached(self._state.position, self.home, self.parameters)

    def arming_denials(self) -> tuple[str, ...]:
        """The reasons why arming would be denied now."""
        mode, inputs = self.intended_mode, self._failsafe_inputs()
        return arming_denials(
            PreflightState(mode, self._missing(mode), inputs, self.is_crashed, self.arming_refusal)
        )

    # Commands. Each returns whether it was granted; a refusal leaves a status text.

    def arm(self, *, is_forced: bool = False) -> bool:
        """Starts the motors; by force, without any check."""
        if self.is_armed:
            return True
        reasons = self.arming_denials()
        if reasons and not is_forced:
            self.status_texts.append(told(Severity.CRITICAL, "Arming denied: {1}", reasons[0]))
            return False
        self.is_armed = True
        self.flights.arm(self._state.time_s)
        self.parameters.set("COM_FLIGHT_UUID", self.flights.count)
        self.home = self._state.position
        self.control.arm(self._state)
        self._failsafe = FailsafeState()
        self._takeoff_down_m = min(self._takeoff_down_m, self._lowest_takeoff())
        self._enter(self.intended_mode)
        self._tell(Severity.INFO, "Armed by external command")
        return True

    def disarm(self, *, is_forced: bool = False) -> bool:
        """Stops the motors; in the air only by force."""
        if self.is_armed and not self.is_landed and not is_forced:
            self._tell(Severity.CRITICAL, "Disarming denied: not landed")
            return False
        if self.is_armed:
            self._stop("Disarmed by external command")
        return True

    def set_mode(self, mode: str) -> bool:
        """Makes a mode of `FLIGHT_MODES` the intended one; during a failsafe, this overrides it."""
        missing = self._missing(mode)
        if self.is_armed and missing is not None:
            self._tell(Severity.CRITICAL, f"{mode} refused: {missing}")
            return False
        if mode == "AUTO.TAKEOFF":
            self._takeoff_down_m = self._lowest_takeoff()
        self._failsafe.take_over()
        self._intend(mode)
        if mode != self.mode:
            self._enter(mode)
        return True

    def take_off(self, down_m: float | None = None) -> bool:
        """Climbs to a height (local NED down), at least MIS_TAKEOFF_ALT above home."""
        lowest = self._lowest_takeoff()
        if down_m is not None and down_m > lowest:
            self._tell(Severity.CRITICAL, "Using minimum takeoff altitude")
        granted = self.set_mode("AUTO.TAKEOFF")
        self._takeoff_down_m = lowest if down_m is None else min(down_m, lowest)
        self._enter(self.intended_mode)
        return granted

    def hold_at(self, point: Maybe, yaw_rad: float | None) -> bool:
        """Flies to a point and holds there; None keeps the present value."""
        granted = self.set_mode("AUTO.LOITER")
        here = HoldMode.start(self._situation())
        north_m, east_m, down_m = (
            now if wanted is None else wanted for now, wanted in zip(here.point, point, strict=True)
        )
        yaw_rad = here.yaw_rad if yaw_rad is None else yaw_rad
        self._active_mode = HoldMode((north_m, east_m, down_m), yaw_rad)
        return granted

    def accept_setpoint(self, setpoint: TrajectorySetpoint) -> None:
        """Takes a valid offboard setpoint, which restarts the time of COM_OF_LOSS_T."""
        self.setpoint = setpoint
        self.health.note_setpoint(self._state.time_s)

    def note_ground_station(self) -> None:
        """Notes a heartbeat of a ground station."""
        self.health.note_ground_station(self._state.time_s)

    def load_fence(self, areas: Sequence[FenceArea]) -> None:
        """Replaces the geofence; an area that is already violated is left out."""
        kept_to = {"Home position": self.home}
        if self.parameters["GF_ACTION"] and not self.is_landed:
            kept_to["current vehicle position"] = self._state.position
        for name in self.fence.load(areas, kept_to):
            text = f"Geofence invalid, doesn't contain {name}"
            self.status_texts.append(told(Severity.CRITICAL, text))

    def start_mission(self, index: int | None) -> bool:
        """Flies the mission, from an item if one is given; arms if necessary."""
        if not self.set_mode("AUTO.MISSION") or not self.arm():
            return False
        if index is not None:
            self.mission.set_current(index)
        return True

    def refuse_arming(self, reason: str | None) -> None:
        """Refuses arming for a reason; None allows it again."""
        self.arming_refusal = reason

    def report_arming_denial(self) -> None:
        """Tells people why arming would be denied."""
        for reason in self.arming_denials()[:1]:
            self._tell(Severity.WARNING, f"Preflight Fail: {reason}")

    def terminate(self) -> None:
        """Stops the motors wherever the vehicle is (MAV_CMD_DO_FLIGHTTERMINATION)."""
        if self.is_armed:
            self._stop("Flight termination active")

    def crash(self, text: str) -> None:
        """Notes that the vehicle has hit something: it stops for good."""
        if self.is_crashed:
            return
        self.is_crashed = True
        self._tell(Severity.CRITICAL, text)
        if self.is_armed:
            self._stop("Disarmed by failure detector")

    # The step.

    def step(self, state: FlightState, dt_s: float) -> RateSetpoint | Motors:
        """What drives the motors in the next `dt_s`.

        Args:
            state: the newest, `dt_s` after the one before.
            dt_s: time between two calls.
        """
        self._state = state
        self._run_commander()
        setpoint = self._active_mode.setpoint(self._situation()) if self.is_armed else None
        self.control.follow(setpoint, state)
        detector = self.control.land_detector
        was_landed = detector.is_landed
        command = self.control.step(state, dt_s)
        if detector.is_landed != was_landed:
            self._note_landing(was_landed)
        return command

    def _note_landing(self, was_landed: bool) -> None:
        if was_landed:
            self.flights.take_off(self._state.time_s)
            self._tell(Severity.INFO, "Takeoff detected")
        else:
            self.flights.land(self._state.time_s)
            self._tell(Severity.INFO, "Landing detected")

    def _run_commander(self) -> None:
        """Decides on failsafes, modes and disarming."""
        if (level := self.health.update_battery(self._state.charge)) is not None:
            self.status_texts.append(BATTERY_TEXTS[level])
        if not self.is_armed:
            return
        self._update_failsafe()
        if self._failsafe.stops_motors:
            self._stop("Disarmed by failsafe")
            return
        mode = self._failsafe.mode or self.intended_mode
        if mode != self.mode:
            self._enter(mode)
        elif change := self._active_mode.mode_change(self._situation()):
            self._intend(change.mode)
            self.mode = change.mode
            self._active_mode = change.flying
            if change.text is not None:
                self._tell(Severity.INFO, change.text)
        if self.is_landed and (
            reason := self.flights.disarming_reason(self._state.time_s, self.parameters)
        ):
            self._stop(reason)

    def _update_failsafe(self) -> None:
        failsafe = self._failsafe
        before = failsafe.selected, failsafe.stage
        failsafe.update(self._failsafe_inputs(), self._state.time_s)
        if (failsafe.selected, failsafe.stage) != before:
            self.status_texts += failsafe_texts(failsafe, self.parameters)

    def _failsafe_inputs(self) -> FailsafeInputs:
        return self.health.inputs(self.intended_mode, self.is_fence_breached, self._state.time_s)

    def _stop(self, text: str) -> None:
        self.is_armed = False
        self.control.follow(None, self._state)
        self._failsafe = FailsafeState()
        self.intended_mode = self._mode_when_disarmed
        self.mission.note_disarming()
        self._enter(self.intended_mode)
        self._tell(Severity.INFO, text)

    def _intend(self, mode: str) -> None:
        """Sets the intended mode, by rules 1 and 4."""
        self.intended_mode = mode
        if FLIGHT_MODES[mode].may_arm:
            self._mode_when_disarmed = mode

    def _enter(self, mode: str) -> None:
        self.mode = mode
        self._active_mode = FLIGHT_MODES[mode].start(self._situation())

    def _missing(self, mode: str) -> str | None:
        now_s = self._state.time_s
        return missing_requirement(
            mode,
            has_setpoints=self.health.has_setpoints(now_s),
            has_mission=self.mission.is_ready(now_s),
            has_position=not self.health.is_position_lost,
        )

    def _lowest_takeoff(self) -> float:
        home = self.home if self.is_armed else self._state.position
        return home[2] - self.parameters["MIS_TAKEOFF_ALT"]

    def _situation(self) -> Situation:
        return Situation(
            self._state,
            self.home,
            self.setpoint,
            self._takeoff_down_m,
            self.cruise_mps or self.parameters["MPC_XY_CRUISE"],
            self.is_landed,
            self.mission,
            self.parameters,
            self.safe_points,
        )

    def _tell(self, severity: Severity, text: str) -> None:
        self.status_texts.append(StatusText(severity, text))
