"""All classes of events, in the order in which docs/run-folder.md lists them.

Where classes share a kind, and the keys of their lines are the same, a line is one of the first of
them whose text it has; so those whose text may be anything come last.
"""

from __future__ import annotations

from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import (
    BeliefRestored,
    BeliefWithdrawn,
    MissionEventChanged,
    PlaceLost,
    PlacesConnected,
    PlacesCutOff,
)
from companion.flight_events.hosting import (
    DatagramsDropped,
    FramesRefused,
    MissionReady,
    MissionUnreadable,
    PortLost,
    PortRestored,
    RecordingFailed,
    RunNotBegun,
    TerminalHungUp,
    UploadChecked,
)
from companion.flight_events.plans import (
    EngineFailed,
    LapCompleted,
    LineDropped,
    LineTakenUp,
    NoPlanFound,
    PlanAwaited,
    PlanMade,
    PlanReplaced,
    WrittenTreeAdopted,
)
from companion.flight_events.skills import (
    ClearanceChanged,
    OutcomeUnknown,
    PlaceReached,
    RouteBlocked,
    SkillCompleted,
    SkillFailed,
    SymbolMoved,
    WrittenTreeFailed,
)
from companion.flight_events.sortie import (
    BatteryCharged,
    ControlRegained,
    ControlTakenBack,
    ControlYielded,
    EndedAtLimit,
    FlightFoundAgain,
    FlightLimitReached,
    GoalFailed,
    LinkBack,
    LinkSilent,
    PhaseEntered,
    ReturnBegun,
    ReturnedAsAsked,
    ReturnFailed,
    RunFailed,
    SetpointRefused,
    StoppedAsAsked,
    StopRequested,
    TaskSatisfied,
    VehicleAirborne,
    VehicleCrashed,
    VehicleLanded,
    WeakFailsafeAccepted,
)
from companion.flight_events.tree import NodesChanged, TreeBuilt, TreeStopped
from companion.flight_events.word import ConjunctViolated, PositionLeft

EVENTS: tuple[type[FlightEvent], ...] = (
    PlanMade,
    WrittenTreeAdopted,
    PlanReplaced,
    LineDropped,
    LineTakenUp,
    NoPlanFound,
    PlanAwaited,
    EngineFailed,
    LapCompleted,
    PlaceReached,
    SkillCompleted,
    SkillFailed,
    OutcomeUnknown,
    WrittenTreeFailed,
    RouteBlocked,
    ClearanceChanged,
    SymbolMoved,
    MissionEventChanged,
    PlaceLost,
    BeliefWithdrawn,
    BeliefRestored,
    PlacesCutOff,
    PlacesConnected,
    PositionLeft,
    ConjunctViolated,
    PhaseEntered,
    WeakFailsafeAccepted,
    ControlYielded,
    ControlRegained,
    ControlTakenBack,
    LinkSilent,
    LinkBack,
    FlightFoundAgain,
    StopRequested,
    FlightLimitReached,
    ReturnBegun,
    ReturnFailed,
    VehicleLanded,
    VehicleAirborne,
    BatteryCharged,
    GoalFailed,
    SetpointRefused,
    VehicleCrashed,
    UploadChecked,
    MissionReady,
    MissionUnreadable,
    RunNotBegun,
    TerminalHungUp,
    DatagramsDropped,
    FramesRefused,
    PortLost,
    PortRestored,
    RecordingFailed,
    TreeBuilt,
    NodesChanged,
    TreeStopped,
    TaskSatisfied,
    EndedAtLimit,
    ReturnedAsAsked,
    StoppedAsAsked,
    RunFailed,
)

RECORDED = tuple(event for event in EVENTS if event.is_recorded)
"""Those that events.jsonl keeps."""
FOR_PROGRAMS = frozenset(event.kind for event in EVENTS if not event.is_told)
"""Kinds that are no news for people."""
