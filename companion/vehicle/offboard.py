"""A vehicle over MAVLink: messages in, state and signals out; goals and setpoints in, messages out.

No I/O: everything leaves from one loop. So the setpoints stop when the program hangs, and the
autopilot's own offboard-loss failsafe takes over. What ground stations say to this component is
not for here (`ground/component.py`).

Rules:
1. Other systems than the vehicle's are ignored.
2. Every setpoint passes the gate (`gate.py`); nothing repeats a setpoint by itself.
3. What else is spoken is spoken by services, each in a file of its own (`services.py`): payloads'
   commands (`payload_commands.py`), our own goals' (`goal_pursuit.py`), the autopilot's fence
   and rally points (`fence_service.py`, `rally_service.py`).
4. A goal is pursued until it is observed (`goals.py`). While nothing is heard of the autopilot no
   command is sent, and no goal's or command's time passes (`heard_time.py`).
5. A mode that our goal does not pass through was chosen by somebody else, on the ground as in the
   air. From the first heartbeat of it on nothing is streamed or commanded; once it is certain
   (`control_watch.py`), not before an operator gives control back (`regain`).
6. A mode that was heard too long ago is not known. Until the next heartbeat no goal is reached, and
   nothing is asked for.

Source: https://mavlink.io/en/services/command.html, PX4's offboard mode.
"""

from __future__ import annotations

from companion.geofence import KeptFence
from companion.geometry import GlobalOrigin, Ned
from companion.mavlink.framing import Message, dialect, source
from companion.mission.signals import Signal
from companion.motion.range_scan import RangeScan
from companion.outcomes import Refusal
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
from companion.vehicle.port import (
    Anchoring,
    Failed,
    FrameLocation,
    Goal,
    Outcome,
    Progress,
    Setpoint,
    Takeover,
    VehicleState,
)
from companion.vehicle.pose_messages import POSES, keep_pose
from companion.vehicle.poses import PoseHistory
from companion.vehicle.rally_service import RallyService
from companion.vehicle.ranging import Ranging
from companion.vehicle.services import Moment, Service
from companion.vehicle.setpoint_stream import SetpointStream
from companion.vehicle.signals import SignalReader, SignalReading
from companion.vehicle.telemetry import TELEMETRY, Telemetry, heartbeat_of
from companion.vehicle.wire import AUTOPILOT, Wire

SCANNER = dialect.MAV_COMP_ID_OBSTACLE_AVOIDANCE
SCAN = "OBSTACLE_DISTANCE"
PROTOCOL = frozenset({"PARAM_VALUE", SCAN})
"""Messages that are read here, beside those of telemetry and services."""

CONTINUAL = frozenset({"ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"})
"""Of those that arrive together only the newest is looked at."""


class MavlinkVehicle:
    """Fulfils `port.Vehicle` over MAVLink 2, for one flight.

    Args:
        wire: whose system it is.
        telemetry: what its autopilot says; it may have been heard before this flight.
        envelope: limits of the gate.
        signals: what to hand on from the wire besides the state.
        takeoff_up_m: altitude above home to take off to.
        marker_components: who is believed to see landing markers.
        memory: of earlier flights; None for nothing yet.

    Attributes:
        scans: what was heard of the surroundings since the tick before, in order.
        payloads: what skills have to do with payloads.
        markers: what is seen of landing markers.
        fence, rally: of the autopilot.
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
        self._stream = SetpointStream(telemetry, envelope)
        self._control = ControlWatch()
        self._signals = SignalReader(signals)
        self._poses = PoseHistory()
        self._ranging = Ranging(self._poses)
        self._parameters = ParameterReader()
        self._readings: list[SignalReading] = []
        self._time = HeardTime()
        self._restarts_before: int | None = None  # its first goal
        self._moment = Moment(0.0, 0.0, is_quiet=True)
        self._goals = GoalPursuit(wire, telemetry, takeoff_up_m, envelope.up_m[1])
        self.payloads = PayloadCommands(wire)
        self.markers = MarkerSightings(telemetry, marker_components, self._poses)
        known = memory or FlightMemory()
        self.fence = FenceService(wire, telemetry, known.fences)
        self.rally = RallyService(wire, telemetry, known.rally_points)
        self.cameras = MavlinkCameras(wire)
        self.gimbals = MavlinkGimbals(wire, telemetry)
        devices: list[Service] = [self.payloads, self.cameras, self.gimbals]
        services: list[Service] = [self._goals, *devices, self.fence, self.rally]
        self._services = (*services, self.markers) if marker_components else tuple(services)
        kinds = frozenset[str]().union(*(service.wanted for service in self._services))
        self._takers = {
            kind: tuple(service for service in self._services if kind in service.wanted)
            for kind in kinds
        }

    # -- messages ------------------------------------------------------------------------------

    @property
    def wanted(self) -> frozenset[str]:
        """Names of the messages that are read here."""
        return PROTOCOL.union(TELEMETRY, self.telling, self._takers)

    @property
    def continual(self) -> frozenset[str]:
        """Of these, those of which only the newest counts."""
        return CONTINUAL - self.telling

    @property
    def telling(self) -> frozenset[str]:
        """Of these, those with signals."""
        return self._signals.messages

    def receive(self, now_s: float, messages: list[Message]) -> list[SignalReading]:
        """Takes what arrived; returns the signals in it, in order."""
        self._control.step(now_s)
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
        """The signals in messages that are not taken yet."""
        ours = [message for message in messages if source(message)[0] == self._wire.system]
        return [reading for message in ours for reading in self._signals.read(message)]

    def transmit(self, now_s: float) -> list[Message]:
        """What has to leave now: commands, questions, and at most one setpoint."""
        moment = self._set_moment(now_s)
        is_ours = self._control.state is ControlState.OURS
        speaking = [s for s in self._services if is_ours or not s.needs_control]
        said = [message for service in speaking for message in service.due(moment)]
        if not is_ours:
            return said
        system, goal = self._wire.system, self._goals.goal
        return [
            *said,
            *self._telemetry.clock.due(now_s),
            *self._telemetry.questions(now_s, (system, AUTOPILOT), goal is not None),
            *self._parameters.due(now_s, (system, AUTOPILOT)),
            *self._stream.due(now_s, system, is_entering=goal is Goal.OFFBOARD),
        ]

    # -- port.Vehicle --------------------------------------------------------------------------

    @property
    def state(self) -> VehicleState | None:
        """The newest state, None until one has been heard."""
        return self._telemetry.state

    @property
    def takeover(self) -> Takeover | None:
        """Who has taken control; None while it is ours."""
        return self._control.takeover

    @property
    def is_doubted(self) -> bool:
        """Whether control may be somebody else's, by the newest heartbeat; nothing is sent."""
        return self._control.state is ControlState.DOUBTED

    @property
    def has_restarted(self) -> bool:
        """Whether the autopilot has restarted since its first goal."""
        before = self._restarts_before
        return before is not None and self._telemetry.boots.restarts > before

    @property
    def frame_doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is not known or not certain; None if it is."""
        return self._telemetry.frame_doubt

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame lies on the earth; None where frames are not known."""
        return self._telemetry.origin

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames lie on the earth; None where that is not known."""
        return self._telemetry.location

    @property
    def refusal(self) -> Refusal | None:
        """Why a hold is sent in place of the setpoint; None while it is not."""
        return self._stream.refusal

    def fly(self, setpoint: Setpoint, is_for_task: bool = False, is_landing: bool = False) -> None:
        """Streams a setpoint from now on; it has to be renewed before its lease is over."""
        self._stream.fly(setpoint, self._moment.now_s, is_for_task, is_landing)

    def set_speed_limit(self, speed_mps: float) -> None:
        """The gate admits no faster setpoint from now on."""
        self._stream.set_speed_limit(speed_mps)

    def keep_within(self, fence: KeptFence) -> None:
        """The gate admits no setpoint outside a fence of the autopilot's from now on."""
        self._stream.keep_within(fence)

    def set_violated(self, is_violated: bool) -> None:
        """The gate admits no setpoint of the task's plan while the task is violated."""
        self._stream.set_violated(is_violated)

    def release(self) -> None:
        """Streams nothing and asks for nothing any longer."""
        self._stream.end()
        for service in self._services:
            service.release()
        self._control.settle()

    def regain(self) -> None:
        """Takes back control that was lost; the operator has given it."""
        self._control.regain()

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        """Works towards a goal; the caller asks in every tick until it is reached or has failed."""
        if self.takeover is not None:
            return Failed(str(self.takeover))
        if self.state is None or self.is_doubted:
            return Progress.RUNNING
        if self._restarts_before is None:
            self._restarts_before = self._telemetry.boots.restarts
        if goal is Goal.LANDED:
            self.gimbals.give_back()
        outcome = self._goals.pursue(goal, self.state, self._moment, takeoff_up_m)
        if outcome is Progress.DONE and goal is Goal.LANDED:
            self._stream.end()  # OFFBOARD on the ground is not ours to stream in
        return outcome

    @property
    def anchoring(self) -> Anchoring:
        """What decides where home lies."""
        frame = self._telemetry.frame
        if frame.is_recalled:
            return Anchoring.RECALLED
        return Anchoring.FIXED if frame.is_fixed else Anchoring.BY_VEHICLE

    def gap_m(self, place: Ned) -> float | None:
        """How far from a place the vehicle stands; None until that is certain."""
        return self._telemetry.frame.gap_m(place, self._telemetry.accuracy_m)

    @property
    def is_settling(self) -> bool:
        """Whether it is measured where the vehicle stands."""
        return self._telemetry.frame.is_known and self._telemetry.frame.is_settling

    def stand_at(self, place: Ned) -> None:
        """Lays the mission's frame, before the first sortie."""
        self._telemetry.stand_at(place)

    def parameter(self, name: str) -> float | None:
        """A parameter of the autopilot; asks for it, and is None until it was answered."""
        return self._parameters.read(name)

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
                self._parameters.take(message)
            now_s = self._moment.now_s
            is_news = self._telemetry.is_news(now_s, message)
            if is_news and (kind != "HEARTBEAT" or self._is_believed(message)):
                self._telemetry.take(now_s, message)
                if kind in POSES and self.frame_doubt is None:
                    keep_pose(self._poses, message, self._telemetry.frame)
        elif kind == SCAN and component == SCANNER:
            self._ranging.take_scan(message)
        self._readings += self._signals.read(message)

    def _is_believed(self, message: Message) -> bool:
        """Rule 5, from the first goal on; what begins a doubt is not believed yet.

        Before it no mode is another one: a pause of ours is over with the next heartbeat.
        """
        heartbeat = heartbeat_of(message)
        if self._goals.goal is None:
            self._control.settle()
        else:
            is_ours = self._goals.admits(heartbeat)
            self._control.take(self._moment.now_s, heartbeat, is_ours)
        return not self.is_doubted

    def _set_moment(self, now_s: float) -> Moment:
        self._moment = Moment(now_s, self._time.seconds, self._time.is_quiet)
        return self._moment
