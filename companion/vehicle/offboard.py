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

from companion.geofence import KeptFence
from companion.geometry import GlobalOrigin, Ned
from companion.mavlink.framing import Message, dialect, source
from companion.mission.signals import Signal
from companion.motion.range_scan import RangeScan
from companion.outcomes import Failed, Outcome, Progress, Refusal
from companion.vehicle.cameras import MavlinkCameras
from companion.vehicle.control_watch import ControlState, ControlWatch
from companion.vehicle.fence_service import FenceService
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.gate import Envelope, Request
from companion.vehicle.gimbals import MavlinkGimbals
from companion.vehicle.goal_pursuit import GoalPursuit
from companion.vehicle.heard_time import HeardTime
from companion.vehicle.marker_sightings import MarkerSightings
from companion.vehicle.parameters import ParameterReader
from companion.vehicle.payload_commands import PayloadCommands
from companion.vehicle.port import Anchoring, FrameLocation, Goal, Setpoint, Takeover, VehicleState
from companion.vehicle.pose_messages import keep_pose
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
"""Messages that are read here, besides those of telemetry and services."""

CONTINUAL = frozenset({"ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"})
"""If several of one kind arrive together, only the newest is read."""


class MavlinkVehicle:
    """Implements `port.Vehicle` over MAVLink 2, for one flight.

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
        """Names of the messages that are read."""
        return PROTOCOL.union(TELEMETRY, self.telling, self._takers)

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
        """The signals in messages that have not been taken yet."""
        ours = [message for message in messages if source(message)[0] == self._wire.system]
        return [reading for message in ours for reading in self._signals.read(message)]

    def transmit(self, now_s: float) -> list[Message]:
        """What to send now: commands, questions, and at most one setpoint."""
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
        """The newest state; None until one has been heard."""
        return self._telemetry.state

    @property
    def takeover(self) -> Takeover | None:
        """Who has taken control; None while it is ours."""
        return self._control.takeover

    @property
    def is_doubted(self) -> bool:
        """Whether, by the newest heartbeat, somebody else may have control; nothing is sent
        meanwhile.
        """
        return self._control.state is ControlState.DOUBTED

    @property
    def has_restarted(self) -> bool:
        """Whether the autopilot has restarted since the first goal."""
        before = self._restarts_before
        return before is not None and self._telemetry.boots.restarts > before

    @property
    def frame_doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is unknown or uncertain; None if it is
        certain."""
        return self._telemetry.frame_doubt

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame is on the earth; None while frames are not known."""
        return self._telemetry.origin

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames are on the earth; None if not known."""
        return self._telemetry.location

    @property
    def refusal(self) -> Refusal | None:
        """Why a hold is sent in place of the setpoint; None if none is."""
        return self._stream.refusal

    def fly(
        self, setpoint: Setpoint, *, is_for_task: bool = False, is_landing: bool = False
    ) -> None:
        """Streams a setpoint; the caller renews it before its lease ends."""
        self._stream.request(Request(setpoint, self._moment.now_s, is_for_task, is_landing))

    def set_speed_limit(self, speed_mps: float) -> None:
        """Sets the gate's speed limit."""
        self._stream.set_speed_limit(speed_mps)

    def keep_within(self, fence: KeptFence) -> None:
        """Lets the gate refuse setpoints outside a fence of the autopilot's from now on."""
        self._stream.keep_within(fence)

    def set_violated(self, is_violated: bool) -> None:
        """While the task is violated, the gate refuses setpoints of its plan."""
        self._stream.set_violated(is_violated)

    def release(self) -> None:
        """Stops streaming, and stops all requests."""
        self._stream.end()
        for service in self._services:
            service.release()
        self._control.settle()

    def regain(self) -> None:
        """Takes back control, which the operator has given back."""
        self._control.regain()

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        """Works towards a goal; the caller calls it in every tick until the goal is reached or has
        failed.
        """
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
            self._stream.end()  # we do not stream to a vehicle in OFFBOARD on the ground
        return outcome

    @property
    def anchoring(self) -> Anchoring:
        """What determines where home is."""
        frame = self._telemetry.frame
        if frame.is_recalled:
            return Anchoring.RECALLED
        return Anchoring.FIXED if frame.is_fixed else Anchoring.BY_VEHICLE

    def gap_m(self, place: Ned) -> float | None:
        """How far from a place the vehicle stands; None until that is certain."""
        return self._telemetry.frame.gap_m(place, self._telemetry.accuracy_m)

    @property
    def is_settling(self) -> bool:
        """Whether the position of the standing vehicle is being averaged."""
        return self._telemetry.frame.is_known and self._telemetry.frame.is_settling

    def stand_at(self, place: Ned) -> None:
        """Lays the mission's frame so that the vehicle stands at a place, before the first
        sortie."""
        self._telemetry.stand_at(place)

    def parameter(self, name: str) -> float | None:
        """A parameter of the autopilot; requests it, and returns None until it was answered."""
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
                keep_pose(self._poses, message, self._telemetry)
        elif kind == SCAN and component == SCANNER:
            self._ranging.take_scan(message)
        self._readings += self._signals.read(message)

    def _is_believed(self, message: Message) -> bool:
        """Applies rule 5, from the first goal on; a heartbeat that begins a doubt is not believed
        yet.

        Before the first goal all modes are accepted, and the next heartbeat ends a doubt.
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
