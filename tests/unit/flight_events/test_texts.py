"""The texts that people read: of every class of events, in the terminal, on the page and by radio.

All other tests assert fields of events. tests/data/surveillance.events.txt has the texts of a whole
flight.
"""

from __future__ import annotations

import pytest

from companion.flight_events.catalogue import EVENTS
from companion.flight_events.charge import ChargeMeasured, ChargePlanned, PlannedCharge
from companion.flight_events.energy import EnergyUsed, GaugeJumped, ReserveUsed
from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import (
    BeliefRestored,
    BeliefWithdrawn,
    MissionEventChanged,
    PlaceLost,
    PlacesConnected,
    PlacesCutOff,
)
from companion.flight_events.fence import (
    FenceChange,
    FenceChanged,
    FenceKept,
    FenceMissing,
    FenceNear,
    FenceReplaced,
    FenceWritten,
)
from companion.flight_events.frames import (
    FrameDoubted,
    FrameLocated,
    FrameTrusted,
    HomeMeasured,
    HomeRecalled,
    OriginMoved,
)
from companion.flight_events.hosting import (
    ClockFollowed,
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
from companion.flight_events.landing import (
    DockMayBeMissed,
    LandedOnMarker,
    MarkerAbandoned,
    MarkerLost,
    MarkerSeen,
    SightingsRefused,
)
from companion.flight_events.plans import (
    EngineFailed,
    LapCompleted,
    LineDropped,
    LineTakenUp,
    NoPlanFound,
    PlanAwaited,
    PlanMade,
    PlannedAction,
    PlannedLasso,
    PlanReplaced,
    TaskRecalled,
    WrittenTreeAdopted,
)
from companion.flight_events.rally import (
    RallyKept,
    RallyMissing,
    RallyRemoved,
    RallyReplaced,
    RallyUnused,
    RallyWritten,
)
from companion.flight_events.reports import (
    ReportRefused,
    ReportUnknown,
    SignalHeard,
    SignalOfAnother,
    SignalSilent,
)
from companion.flight_events.skills import (
    ClearanceChanged,
    FunctionsAwaited,
    GroundNear,
    LowPlacesFlown,
    OutcomeUnknown,
    PhotoTaken,
    PlaceFunctionFailed,
    PlaceReached,
    RouteBlocked,
    RouteResponse,
    SkillCompleted,
    SkillFailed,
    SkillProgressed,
    SpeedLimitedBySight,
    SymbolMoved,
    WallNear,
    WrittenTreeFailed,
)
from companion.flight_events.sortie import (
    AutopilotSaid,
    BatteryCharged,
    BatteryLow,
    ChargeAwaited,
    ChargeCutShort,
    ChargeSufficient,
    ControlRegained,
    ControlTakenBack,
    ControlYielded,
    EndedAtLimit,
    FlightFoundAgain,
    FlightLimitReached,
    GoalFailed,
    LinkBack,
    LinkSilent,
    PauseEnded,
    Phase,
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
from companion.flight_events.tree import (
    NodesChanged,
    NodeStatus,
    NodeType,
    TreeBuilt,
    TreeNode,
    TreeStopped,
)
from companion.flight_events.word import ConjunctViolated, PositionLeft, ViolatedBefore

MOVE = PlannedAction("move(Home, A)", "move", ("Home", "A"), 5.8)
WAIT = PlannedAction("wait", "wait", (), 0.1)
LASSO = PlannedLasso((MOVE,), (WAIT,), 5.8, 0.1)
LOST = "the pilot has control, in POSCTL"

TEXTS: list[tuple[FlightEvent, str]] = [
    (PlanMade({"visit": "F at(A)"}, LASSO), "plan: move(Home, A), (wait)^w"),
    (WrittenTreeAdopted({}), "flying the mission's own tree"),
    (TaskRecalled({}), "the task as it is flown; the beginning of this record was lost"),
    (
        PlanReplaced(2, "target found", PlannedLasso((), (MOVE, WAIT), 0.0, 5.9)),
        "replan 2: target found -> (move(Home, A), wait)^w",
    ),
    (LineDropped("far", "no plan keeps it"), "far dropped: no plan keeps it"),
    (LineTakenUp("far", anew=False), "far taken up again"),
    (LineTakenUp("far", anew=True), "far begins anew"),
    (NoPlanFound(3, "low battery", "no plan: why"), "replan 3: low battery: no plan: why"),
    (
        PlanAwaited("no plan: visit cannot hold from here.", 60.0, ("covered",)),
        "no plan: visit cannot hold from here. Holding for up to 60 s for a change of covered",
    ),
    (
        EngineFailed("the engine lpg did not answer in 10 s"),
        "the engine lpg did not answer in 10 s; the built-in search plans instead",
    ),
    (LapCompleted(1), "lap 1 done"),
    (PlaceReached("A", "move(Home, A)"), "at A"),
    (SkillCompleted("upload(r1)"), "upload(r1) done"),
    (SkillFailed("upload(r1)", "denied"), "upload(r1) failed: denied"),
    (PhotoTaken(13, "camera", "A", 12, (1.0, 2.0, -3.0)), "photo 13 of camera at A"),
    (SkillProgressed("weigh(A)", 40, "settling"), "weigh(A): 40 %, settling"),
    (SkillProgressed("weigh(A)", None, ""), "weigh(A): under way"),
    (
        OutcomeUnknown("upload(r1)", "it counts as failed"),
        "upload(r1): it is unknown whether this was done; it counts as failed",
    ),
    (
        WrittenTreeFailed("upload(r1) failed: denied"),
        "the tree has failed: upload(r1) failed: denied",
    ),
    (FunctionsAwaited(("weigh",)), "waiting until these functions are loaded: weigh"),
    (PlaceFunctionFailed("A", "near", "no answer"), "near failed for A: no answer"),
    (RouteBlocked("A", RouteResponse.ANOTHER_ROUTE), "the route to A is not clear: another route"),
    (RouteBlocked("A", RouteResponse.STOPPING), "the route to A is not clear: stopping"),
    (RouteBlocked("A", RouteResponse.NO_ROUTE), "the route to A is not clear: no route"),
    (
        WallNear(0.05),
        "the vehicle is off its route, 0.05 m from an obstacle: its setpoint is moved away from it",
    ),
    (
        GroundNear(0.31, 2.0),
        "the vehicle is 0.31 m above what is below it by its range finder, and 2.00 m up by its "
        "altitude: it climbs, as far as limits.up_m allows",
    ),
    (
        ClearanceChanged(1.2, 0.254, 0.31),
        "routes keep 1.2 m from obstacles where there is room: the position is accurate to 0.25 "
        "m, the vehicle is up to 0.31 m off its route",
    ),
    (
        LowPlacesFlown(("A", "Pond"), 1.5, 1.4),
        "heights may be wrong by 1.4 m, as the position is not exact; in the mission, put these "
        "places 1.5 m or more above what is below them: A, Pond",
    ),
    (
        SpeedLimitedBySight(4.57, 8.0, 8.0),
        "speed limited to 4.57 m/s instead of 8.00: obstacles that no map shows are seen only "
        "8.0 m ahead (limits.beyond_sight)",
    ),
    (
        SymbolMoved("A", (10.758, 3.337, -2.0), "samples of the region"),
        "A is now 3.3 m east, 10.8 m north (samples of the region)",
    ),
    (MissionEventChanged("targetFound", holds=True), "target found"),
    (MissionEventChanged("lowBattery", holds=False), "no longer low battery"),
    (MissionEventChanged("siteIsWet", holds=True), "site is wet"),
    (MissionEventChanged("site_is_wet", holds=True), "site is wet"),
    (PlaceLost("r1", 2.4), "no longer at r1: 2.4 m away"),
    (BeliefWithdrawn("canUpload(r1)"), "belief canUpload(r1) withdrawn"),
    (BeliefRestored("canUpload(r1)"), "belief canUpload(r1) restored"),
    (
        PlacesCutOff("trans_ok(*, B)", ("trans_ok(A, B)",)),
        "no route on the map as sensed: trans_ok(*, B) withdrawn",
    ),
    (
        PlacesConnected("trans_ok(*, B)", ("trans_ok(A, B)",)),
        "there is a route again: trans_ok(*, B) restored",
    ),
    (
        PositionLeft(4, ("at(A)", "low"), ("low",), 0.0, (), (), for_ever=False),
        "position 4: at(A), low",
    ),
    (
        ConjunctViolated("calm", "G !low", position=4, facts=("at(A)", "low")),
        "calm violated at position 4: G !low",
    ),
    (ViolatedBefore(("calm", "quick")), "violated before the interruption: calm, quick"),
    *((PhaseEntered(phase), phase.value) for phase in Phase),
    (WeakFailsafeAccepted("COM_LOW_BAT_ACT is 0"), "weak failsafe accepted: COM_LOW_BAT_ACT is 0"),
    (
        FenceWritten("4 points, 1 area"),
        "the autopilot has the mission's fence (4 points, 1 area), and keeps it after the flight",
    ),
    (
        FenceReplaced("4 points, 1 area", "9 points, 2 areas"),
        "the mission's fence (4 points, 1 area) has replaced the autopilot's (9 points, 2 areas)",
    ),
    (FenceKept("12 points, 2 areas"), "the autopilot keeps its fence (12 points, 2 areas)"),
    (FenceMissing("it tells no position"), "no fence in the autopilot: it tells no position"),
    (
        FenceNear(0.8),
        "the fence is nearer than the possible error of the position, 0.8 m: the autopilot may "
        "end the flight during the climb",
    ),
    (
        FenceChanged(FenceChange.REMOVED),
        "somebody has removed the autopilot's fence; the flight keeps to the limits it had",
    ),
    (
        RallyWritten("East, North"),
        "the autopilot's Return may land at East, North from now on, also after the flight",
    ),
    (
        RallyReplaced("East", "2 rally points"),
        "the autopilot's Return may land at East from now on, no longer at 2 rally points",
    ),
    (RallyKept("2 rally points"), "the autopilot keeps 2 rally points"),
    (RallyRemoved("1 rally point"), "1 rally point removed: the autopilot's Return goes home"),
    (
        RallyMissing("it tells no position"),
        "no rally points for the autopilot: it tells no position",
    ),
    (
        RallyUnused("East", "RTL_TYPE is 2"),
        "the autopilot's Return does not land at East: RTL_TYPE is 2",
    ),
    (ControlYielded(LOST), f"{LOST}; hold, then continue, to give control back"),
    (ControlRegained(), "control given back by the operator"),
    (
        ControlTakenBack(),
        "the autopilot held because it no longer heard the companion; the flight continues",
    ),
    (LinkSilent(), "the vehicle is not heard; waiting for it"),
    (LinkBack(), "the vehicle is heard again; the flight continues"),
    (
        FlightFoundAgain(12.5, Phase.TASK, "hold, then continue, to give control back"),
        "the companion was away for 12.5 s, while flying the task; "
        "hold, then continue, to give control back",
    ),
    (
        FrameLocated("Home", 47.41, 8.53, 1984.94, 488.0, 0.005),
        "Home is 1984.94 m from the autopilot's origin 47.41, 8.53, and 488.0 m above sea level; "
        "the autopilot's local and global positions agree to 0.005 m",
    ),
    (
        HomeMeasured("Home", 10.0, 0.28),
        "measuring for 10 s where Home is: the vehicle's position is accurate to 0.28 m",
    ),
    (
        HomeRecalled("Home", 0.9),
        "Home and the map are where an earlier flight had them, 0.9 m from the vehicle",
    ),
    (
        OriginMoved(2581.09),
        "the autopilot's origin has moved by 2581.09 m; the flight continues in the new frame",
    ),
    (FrameTrusted(), "the position is certain again; the flight continues"),
    (FrameDoubted("two positions"), "waiting: two positions"),
    (StopRequested(), "stopping as asked"),
    (
        BatteryLow("North"),
        "the battery is low, and the mission has no rule for this: returning to North",
    ),
    (FlightLimitReached("3 laps"), "3 laps flown: returning"),
    (PauseEnded(), "the pause is over: the charge is needed to land at a safe place"),
    (ReturnBegun("Home"), "returning to Home"),
    (ReturnFailed("Home", "no clear route"), "cannot return to Home: no clear route"),
    (MarkerSeen("Roof", 0.42), "the marker of Roof is seen, 0.4 m from the middle of the place"),
    (
        MarkerLost("Roof", 3.14),
        "the marker of Roof is not seen any more; the vehicle is 3.1 m above it",
    ),
    (
        SightingsRefused("Roof", 4, "it moves"),
        "sightings of the marker of Roof refused: 4; the last one: it moves",
    ),
    (MarkerAbandoned("Roof", "it moves"), "no landing on the marker of Roof: it moves"),
    (LandedOnMarker("Roof", 0.086), "landed 0.09 m from the marker of Roof"),
    (
        DockMayBeMissed(1.2),
        "the vehicle may land 1.2 m beside a dock, as its position is not exact: the dock has to "
        "be that wide, or have a marker (land_on)",
    ),
    (VehicleLanded(), "landed as planned"),
    (VehicleAirborne(), "in the air again"),
    (BatteryCharged(90), "charged to 90 %"),
    (
        ChargeAwaited(22, patience_s=900),
        "the battery does not charge, it is at 22 %: the vehicle waits on the ground for up to "
        "900 s",
    ),
    (ChargeCutShort(41), "charging ends at 41 %, to answer an event"),
    (
        ChargeSufficient(88, enough=85),
        "no landing to charge: the battery has 88 %, and 85 % are enough",
    ),
    (ChargeMeasured(62), "the battery is at 62 %"),
    (ChargeMeasured(None), "the battery is at an unknown charge"),
    (
        ChargePlanned(61.5, 40.0, 20.0, (PlannedCharge("move(A, B)", 9.5, 58.0, 37.0),)),
        "at least 61.5 % are expected, 40.0 % are required",
    ),
    (
        EnergyUsed(61.0, 3.214, 3.1, 1.037),
        "3.21 Wh used in 61 s, 3.10 Wh expected; flights take 1.04 times the energy that the "
        "mission says",
    ),
    (ReserveUsed(0.4), "the way to the next landing uses 0.40 Wh of the reserve"),
    (GaugeJumped(50, 90, 50), "the battery's gauge jumped from 50 % to 90 %: 50 % is assumed"),
    (AutopilotSaid("Low battery"), "the autopilot says: Low battery"),
    (GoalFailed("not armed: denied"), "not armed: denied"),
    (SetpointRefused("outside the fence"), "setpoint refused, holding: outside the fence"),
    (VehicleCrashed("the vehicle fell"), "the vehicle fell"),
    (UploadChecked("a.yaml accepted", is_refused=False), "a.yaml accepted"),
    (MissionReady("hop"), "hop is ready; MISSION_START flies it"),
    (MissionUnreadable("no such file"), "the mission cannot be read: no such file"),
    (RunNotBegun("disk full"), "the flight does not begin: disk full"),
    (TerminalHungUp(), "the terminal has hung up (SIGHUP); the flight continues"),
    (
        ClockFollowed(0.5),
        "the autopilot's clock runs 0.5 times as fast as this computer's, like a simulator's: "
        "the flight follows it",
    ),
    (DatagramsDropped(8), "datagrams dropped: 8; too long, or too many from one sender"),
    (FramesRefused(3, 1, 0), "frames refused: 3 unsigned, 1 with another key, 0 too old"),
    (
        PortLost("serial:///dev/ttyTHS1:921600", "no such file"),
        "serial:///dev/ttyTHS1:921600 is lost; trying to open it each second: no such file",
    ),
    (PortRestored("tcpout://10.0.0.1:5760"), "tcpout://10.0.0.1:5760 works again"),
    (
        SignalSilent("personSeen", "EVENT[persons]"),
        "personSeen keeps its last value: EVENT[persons] is silent",
    ),
    (
        SignalHeard("personSeen", "EVENT[persons]"),
        "personSeen is up to date again: EVENT[persons] is heard",
    ),
    (ReportRefused("no JSON: x", 3), "reports refused: 3; the last one: no JSON: x"),
    (
        ReportUnknown("dogs", ("persons",)),
        "a program reports dogs, which the mission does not use; it uses persons",
    ),
    (
        SignalOfAnother("NAMED_VALUE_INT[target].value", 1, 3),
        "NAMED_VALUE_INT[target].value of system 1 is ignored: the vehicle is system 3",
    ),
    (
        RecordingFailed("No space left on device"),
        "the run folder cannot be written; the flight continues: No space left on device",
    ),
    (TreeBuilt((TreeNode(0, NodeType.SEQUENCE, "root"),)), "a tree of 1 nodes"),
    (NodesChanged("move_cmd A", NodeStatus.RUNNING, ()), "move_cmd A: RUNNING"),
    (TreeStopped(()), "nothing runs"),
    (TaskSatisfied(), "task satisfied, landed"),
    (
        EndedAtLimit("600 s", "the task holds so far"),
        "600 s flown, landed; the task holds so far",
    ),
    (ReturnedAsAsked(), "returned as asked, landed"),
    (StoppedAsAsked(), "stopped as asked"),
    (RunFailed(LOST, exit_code=5), LOST),
]


@pytest.mark.parametrize(("event", "text"), TEXTS, ids=lambda value: type(value).__name__)
def test_the_text_of_an_event(event: FlightEvent, text: str) -> None:
    assert event.text == text


def test_every_class_of_events_has_its_text_here() -> None:
    assert {type(event) for event, _ in TEXTS} == set(EVENTS)


def test_phases_are_named_as_people_read_them() -> None:
    assert [phase.value for phase in Phase] == [
        "waiting for the vehicle",
        "checking the autopilot's failsafes",
        "arming",
        "taking off",
        "entering OFFBOARD",
        "flying the task",
        "paused",
        "returning",
        "yielded",
        "holding",
        "leaving the vehicle on hold",
        "landing",
        "ended",
    ]
