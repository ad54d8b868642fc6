"""Flights within a fence of somebody else that stays in the autopilot, beside the mission's own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from lockstep import Cut, Lockstep
from meadow import CIRCLE, MEADOW, POLYGON, armed, push_out, refused, start, station_uploads

from companion.acting.sortie.preflight.arming_terms import UploadPolicy
from companion.flight_events.fence import FenceKept
from companion.flight_events.sortie import (
    ControlTakenBack,
    ControlYielded,
    FlightFoundAgain,
    Phase,
    PhaseEntered,
    SetpointRefused,
    TaskSatisfied,
)
from companion.geometry import NorthEast, is_in_polygon
from companion.mavlink.framing import dialect
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.setpoint_stream import SetpointStream

BED = ((-9.0, 8.0), (-9.0, 12.0), (4.0, 12.0), (4.0, 8.0))
"""Across the way from Home to A; north of it is no way between it and the pond."""
HEDGE = ((-40.0, 9.0), (-40.0, 11.0), (40.0, 11.0), (40.0, 9.0))
"""Across the whole of the mission's fence."""
EXCLUSION = dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION


def kept(corners: tuple[NorthEast, ...], command: int = EXCLUSION, **options: Any) -> Lockstep:
    """Beside a fence of an area and a circle of 400 m, which is to be kept."""
    flight = start(policy=UploadPolicy.KEEP, **options)
    items = [(command, float(len(corners)), (n, e, 0.0)) for n, e in corners]
    station_uploads(flight, *items, (CIRCLE, 400.0, (0.0, 0.0, 0.0)))
    return flight


def flown(flight: Lockstep, phase: Phase = Phase.ENDED) -> list[NorthEast]:
    """Where the vehicle was until a phase, or the end."""
    was: list[NorthEast] = []

    def is_over() -> bool:
        was.append(flight.simulation.flight.position[:2])
        return flight.companion.has_ended or bool(flight.of(PhaseEntered, phase=phase))

    flight.until(is_over)
    return was


def test_it_is_flown_around_what_the_mission_does_not_know_of() -> None:
    flight = kept(BED)
    was = flown(flight)
    assert flight.ending == TaskSatisfied() and flight.of(SetpointRefused) == []
    assert flight.one(FenceKept).fence == "5 points, 2 areas"
    assert min(north for north, _ in was) < -9.0 - MEADOW.vehicle.clearance_m + 0.2
    assert not any(is_in_polygon(point, BED) for point in was)
    modes = [mode for _, mode in flight.modes]
    held = modes[modes.index("OFFBOARD") :].count("AUTO.LOITER")
    assert not held, "the autopilot has held it at its fence"


def test_it_is_refused_by_the_leg_where_no_way_is_left() -> None:
    flight = kept(HEDGE)
    reason = refused(flight)
    assert reason.startswith(
        "no plan within the vehicle's own fence (5 points, 2 areas): "
        "the way from Home to A crosses area 1 of 2\nno plan: "
    )


def test_the_gate_lets_no_setpoint_out_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    corners = ((-6.0, -10.0), (-6.0, 30.0), (6.0, 30.0), (6.0, -10.0))
    flight = kept(corners, POLYGON).until_reported(PhaseEntered, phase=Phase.TASK)
    fly = SetpointStream.fly

    def aside(stream: SetpointStream, setpoint: Setpoint, **purpose: bool) -> None:
        state = flight.companion.telemetry.state
        assert state is not None
        north, _, _ = state.motion.position
        position = (north + 0.9, *setpoint.position[1:])
        fly(stream, replace(setpoint, position=position), **purpose)

    monkeypatch.setattr(SetpointStream, "fly", aside)
    flight.run(8.0)
    reasons = {event.reason for event in flight.of(SetpointRefused)}
    assert "outside the autopilot's own fence" in reasons
    margin_m = MEADOW.vehicle.margin_m
    assert max(sent.message.x for sent in flight.setpoints) <= 6.0 - margin_m + 0.05
    assert flight.simulation.mode == "OFFBOARD"


@pytest.mark.long
def test_whoever_goes_on_after_a_kill_still_keeps_to_it() -> None:
    """In the air the autopilot is not asked: the journal has its fence."""
    flight = kept(BED, resumes=True).until_reported(PhaseEntered, phase=Phase.TASK)
    flight.until(lambda: flight.simulation.flight.position[1] > 3.0)
    flight.kill()
    flight.run(3.0)
    flight.restart()
    was = flown(flight)
    assert flight.of(FlightFoundAgain)
    assert flight.of(ControlTakenBack)
    assert flight.ending == TaskSatisfied() and flight.armings == 1
    assert len(flight.of(FenceKept)) == 1
    assert not any(is_in_polygon(point, BED) for point in was)


def test_resume_does_not_go_on_from_its_breach_that_follows_a_short_silence() -> None:
    link = Cut()
    corners = ((-6.0, -10.0), (-6.0, 30.0), (6.0, 30.0), (6.0, -10.0))
    flight = kept(corners, POLYGON, resumes=True, up=link)
    flight.until_reported(PhaseEntered, phase=Phase.TASK)

    def is_pushed_out() -> bool:
        push_out(flight)
        link.is_cut = -5.7 < flight.simulation.flight.position[0] < -2.0
        return flight.of(ControlYielded) != []

    flight.until(is_pushed_out, 60.0)
    flight.run(20.0)
    assert flight.of(ControlTakenBack) == [] and flight.simulation.mode == "AUTO.LOITER"


@pytest.mark.parametrize("policy", [UploadPolicy.KEEP, UploadPolicy.UPLOAD])
def test_killed_before_arming_another_begins_anew_and_asks_again(policy: UploadPolicy) -> None:
    flight = start(policy=policy, resumes=True)
    station_uploads(flight, (CIRCLE, 400.0, (0.0, 0.0, 0.0)))
    flight.until_reported(PhaseEntered, phase=Phase.CHECKING).run(0.3)
    flight.kill()
    flight.run(3.0)
    flight.restart()
    if policy is UploadPolicy.UPLOAD:
        assert refused(flight).startswith("the vehicle has another fence (1 point, 1 area)\n")
    else:
        armed(flight)
        assert len(flight.of(FenceKept)) >= 1


@pytest.mark.long
def test_a_fence_drawn_while_the_companion_was_away_is_the_autopilots_alone() -> None:
    """Nothing is asked in the air, so it goes on. Where it leads out the autopilot holds it."""
    flight = start(policy=UploadPolicy.UPLOAD, resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    flight.until(lambda: flight.simulation.flight.position[1] > 3.0)
    flight.kill()
    flight.run(3.0)
    corners = ((-9.0, -9.0), (-9.0, 12.0), (9.0, 12.0), (9.0, -9.0))
    station_uploads(flight, *((POLYGON, 4.0, (n, e, 0.0)) for n, e in corners))
    flight.restart()
    yielded = flight.until_reported(ControlYielded).one(ControlYielded)
    assert "a failsafe of the autopilot has control, in AUTO.LOITER" in yielded.text
    yielded_s = flight.now_s
    flight.run(20.0)
    assert len(flight.of(ControlTakenBack)) == 1, "it has gone on from its fence as well"
    assert flight.simulation.mode == "AUTO.LOITER"
    assert max(sent.time_s for sent in flight.setpoints) <= yielded_s
