"""What the gate holds, by an estimate that wanders as a PX4's, stays where the hold began."""

from __future__ import annotations

from dataclasses import replace

import pytest
from lockstep import Lockstep
from meadow import mission

from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import SetpointRefused
from companion.flights.simulated_world import world_of
from companion.geometry import horizontal_distance
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.setpoint_stream import SetpointStream
from sitl.flight.estimate import Wander

STOPS_S, HELD_S = 5.0, 15.0


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
def test_a_hold_does_not_drift_away(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A PX4 whose setpoint was where it had come to by then went 2.6 m in 6 s."""
    asked = mission()
    scenario, grid = world_of(asked, None)
    scenario = replace(scenario, airframe="px4_sih", wander=Wander(0.25, 0.3))
    flight = Lockstep(asked, (scenario, grid), seed=seed)
    flight.until_reported(PlaceReached, place="A").run(3.0)
    fly = SetpointStream.fly

    def outside(stream: SetpointStream, setpoint: Setpoint, **purpose: bool) -> None:
        fly(stream, replace(setpoint, position=(100.0, 100.0, -3.0)), **purpose)

    monkeypatch.setattr(SetpointStream, "fly", outside)
    flight.until_reported(SetpointRefused, reason="outside the fence").run(STOPS_S)
    before = len(flight.setpoints)
    flight.run(HELD_S)
    held = {(sent.message.x, sent.message.y, sent.message.z) for sent in flight.setpoints[before:]}
    assert len(held) == 1
    (there,) = held
    assert horizontal_distance(flight.simulation.flight.position, there) < 1.5
