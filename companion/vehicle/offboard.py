"""A vehicle over MAVLink: messages in, state and signals out; goals and setpoints in, messages out.

No I/O: one loop sends everything. So if the program hangs, the setpoints stop, and the autopilot's
own offboard-loss failsafe acts. Messages of ground stations to this component are handled elsewhere
(`ground/component.py`).

Rules:
1. Systems other than the vehicle's are ignored.
2. Every setpoint passes the gate (`gate.py`). Nothing repeats a setpoint by itself.
3. Everything else is spoken by services, each in its own file (`services.py`): payloads' commands
   (`payload_commands.py`), our own goals' (`goal_pursuit.py`), the autopilot's fence and rally
   points (`fence_service.py`, `rally_service.py`).
4. A goal is pursued until it is observed (`goals.py`). While the autopilot is not heard, no command
   is sent, and no time of a goal or a command passes (`heard_time.py`).
5. A mode that our goal does not pass through was chosen by somebody else, on the ground as in the
   air. From its first heartbeat on nothing is streamed or commanded. Once it is certain
   (`control_watch.py`), this holds until an operator gives control back (`regain`).
6. A mode that was heard too long ago counts as unknown. Until the next heartbeat no goal is reached
   and nothing is requested.

Source: https://mavlink.io/en/services/command.html, PX4's offboard mode.
"""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect, source
from companion.mission.signals import Signal
from companion.motion.range_scan import RangeScan
from companion.vehicle.cameras import MavlinkCameras
from companion.vehicle.control_watch import ControlState, ControlWatch
from companion.vehicle.fence_service import FenceService
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.gate import Envelope
from companion.vehicle.gimbals import MavlinkGimbals
from companion.vehicle.goal_pursuit import GoalPursuit
from companion.vehicle.heard_time import HeardTime
from companion.vehicle.marker_sightings import MarkerSightings
from companion.vehicle.parameters import ParameterReader
from companion.vehicle.payload_commands import PayloadCommands
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import VehicleState
from companion.vehicle.pose_messages import keep_pose
from companion.vehicle.poses import PoseHistory
from companion.vehicle.rally_service import RallyService
from companion.vehicle.ranging import Ranging
from companion.vehicle.services import Moment, Service
from companion.vehicle.setpoint_stream import SetpointStream
from companion.vehicle.signals import SignalReader, SignalReading
from companion.vehicle.telemetry import Telemetry, heartbeat_of
from companion.vehicle.wire import AUTOPILOT, Wire

SCANNER = dialect.MAV_COMP_ID_OBSTACLE_AVOIDANCE
SCAN = "OBSTACLE_DISTANCE"
PROTOCOL = frozenset({"PARAM_VALUE", SCAN})
"""Messages that are read here, besides those of telemetry and services."""

CONTINUAL = frozenset({"ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"})
"""If several of one kind arrive together, only the newest is read."""


class MavlinkVehicle:
    """Implements `ports.vehicle.Vehicle` over MAVLink 2, for one flight.

    Args:
        wire: of the vehicle's system.
        telemetry: of its autopilot; it may have been heard before this flight.
        envelope: limits of the gate.
        signals: signals to extract from messages, besides the state.
        takeoff_up_m: altitude above home to take off to.
        marker_components: components whose sightings of landing markers are accepted.
        memory: of earlier flights; None if there is none.

    Attributes:
        scans: range scans heard since the previous tick, in order.
        control: who has control.
        goals: what it is brought to do by commands.
        setpoints: its setpoints.
        frame: where the frame of the mission is.
        parameters: those of the autopilot.
        payloads: the payloads that skills command.
        markers: sightings of landing markers.
        fence, rally: those of the autopilot.
        cameras: its cameras.
        gimbals: its gimbals.
    """

    def __init__(
        self,
        wire: Wire,
        telemetry: Telemetry,
        envelope: Envelope,
        signals: frozenset[Signal],
        takeoff_up_m: float,
        marker_components: frozenset[int] = frozenset(),
        memory: FlightMemory | None = None,
    ) -> None:
        self.scans: list[RangeScan] = []
        self._wire = wire
        self._telemetry = telemetry
        self.setpoints = SetpointStream(telemetry, envelope)
        self.control = ControlWatch()
        self.frame = telemetry.placed
        self.parameters = ParameterReader()
        self._signals = SignalReader(signals)
        self._poses = PoseHistory()
        self._ranging = Ranging(self._poses)
        self._readings: list[SignalReading] = []
        self._time = HeardTime()
        self._moment = Moment(0.0, 0.0, is_quiet=True)
        self.payloads = PayloadCommands(wire)
        self.markers = MarkerSightings(telemetry, marker_components, self._poses)
        known = memory or FlightMemory()
        self.fence = FenceService(wire, telemetry, known.fences)
        self.rally = RallyService(wire, telemetry, known.rally_points)
        self.cameras = MavlinkCameras(wire)
        self.gimbals = MavlinkGimbals(wire, telemetry)
        self.goals = GoalPursuit(
            wire,
            telemetry,
            self.control,
            self.setpoints,
            self.gimbals,
            takeoff_up_m,
            ceiling_up_m=envelope.up_m[1],
        )
        devices: list[Service] = [self.payloads, self.cameras, self.gimbals]
        services: list[Service] = [self.goals, *devices, self.fence, self.rally]
        self._services = (*services, self.markers) if marker_components else tuple(services)
        kinds = frozenset[str]().union(*(service.wanted for service in self._services))
        self._takers = {
            kind: tuple(service for service in self._services if kind in service.wanted)
            for kind in kinds
        }

    # -- messages ------------------------------------------------------------------------------

    @property
    def wanted(self) -> frozenset[str]:
        """Names of the messages that are read."""
        return PROTOCOL.union(self._telemetry.wanted, self.telling, self._takers)

    @property
    def continual(self) -> frozenset[str]:
        """Those of which only the newest counts."""
        return CONTINUAL - self.telling

    @property
    def telling(self) -> frozenset[str]:
        """Those that contain signals."""
        return self._signals.messages

    def receive(self, now_s: float, messages: list[Message]) -> list[SignalReading]:
        """Takes what has arrived; returns the signals in it, in order."""
        self.control.step(now_s)
        self._readings = []
        autopilot = (self._wire.system, AUTOPILOT)
        self._time.step(now_s, any(source(message) == autopilot for message in messages))
        moment = self._set_moment(now_s)
        for service in self._services:
            service.step(moment)
        for message in messages:
            self._take(message)
        accuracy_m, below_m = self._telemetry.accuracy_m, self._telemetry.below_m(now_s)
        self.scans = self._ranging.scans(now_s, accuracy_m, below_m)
        return self._readings

    def foresee(self, messages: list[Message]) -> list[SignalReading]:
        """The signals in messages that have not been taken yet."""
        ours = [message for message in messages if source(message)[0] == self._wire.system]
        return [reading for message in ours for reading in self._signals.read(message)]

    def transmit(self, now_s: float) -> list[Message]:
        """What to send now: commands, questions, and at most one setpoint."""
        moment = self._set_moment(now_s)
        is_ours = self.control.state is ControlState.OURS
        speaking = [s for s in self._services if is_ours or not s.needs_control]
        said = [message for service in speaking for message in service.due(moment)]
        if not is_ours:
            return said
        system, goal = self._wire.system, self.goals.goal
        return [
            *said,
            *self._telemetry.clock.due(now_s),
            *self._telemetry.questions(now_s, (system, AUTOPILOT), goal is not None),
            *self.parameters.due(now_s, (system, AUTOPILOT)),
            *self.setpoints.due(now_s, system, is_entering=goal is Goal.OFFBOARD),
        ]

    # -- ports.vehicle -------------------------------------------------------------------------

    @property
    def state(self) -> VehicleState | None:
        """The newest state; None until one has been heard."""
        return self._telemetry.state

    def release(self) -> None:
        """Stops streaming, and stops all requests."""
        self.setpoints.end()
        for service in self._services:
            service.release()
        self.control.settle()

    # -- in ------------------------------------------------------------------------------------

    def _take(self, message: Message) -> None:
        kind = message.get_type()
        system, component = source(message)
        if system != self._wire.system:
            return
        for service in self._takers.get(kind, ()):
            service.take(self._moment, message)
        if component == AUTOPILOT:
            if kind == "PARAM_VALUE":
                self.parameters.take(message)
            now_s = self._moment.now_s
            is_news = self._telemetry.is_news(now_s, message)
            if is_news and (kind != "HEARTBEAT" or self._is_believed(message)):
                self._telemetry.take(now_s, message)
                keep_pose(self._poses, message, self._telemetry)
        elif kind == SCAN and component == SCANNER:
            self._ranging.take_scan(message)
        self._readings += self._signals.read(message)

    def _is_believed(self, message: Message) -> bool:
        """Applies rule 5, from the first goal on; a heartbeat that begins a doubt is not believed
        yet.

        Before the first goal all modes are accepted, and the next heartbeat ends a doubt.
        """
        heartbeat = heartbeat_of(self._moment.now_s, message)
        if self.goals.goal is None:
            self.control.settle()
        else:
            is_ours = self.goals.admits(heartbeat)
            self.control.take(heartbeat, is_ours)
        return not self.control.is_doubted

    def _set_moment(self, now_s: float) -> Moment:
        self._moment = Moment(now_s, self._time.seconds, self._time.is_quiet)
        self.setpoints.step(now_s)
        return self._moment
