"""The camera that looks for landing markers: what it sees, and what it tells."""

from __future__ import annotations

import math

import pytest
from wire import Wire

from companion.errors import MissionError
from companion.mavlink.framing import dialect
from sitl.world.scenario import read_scenario

WORLD = """\
version: 1
wander: {{}}
marker_camera:
  noise_deg: 0
  {}
  markers: [{{name: pad, number: 7, east_m: 1, north_m: 0.5, up_m: 0}}]
happens:
  - {{at_s: 14, marker: {{name: pad, east_mps: 0.5}}}}
  - {{at_s: 16, marker: {{name: pad, present: false}}}}
"""
UP_M, CLIMBED_S = 4.0, 6.0


def hovering(**camera: object) -> Wire:
    keys = "\n  ".join(f"{key}: {value}" for key, value in camera.items()) or "component: 40"
    wire = Wire(*read_scenario(WORLD.format(keys)))
    wire.fly_offboard(0.0, 0.0, -UP_M)
    assert wire.now_s < 13.0
    wire.run(13.0 - wire.now_s, send=lambda: wire.setpoint(0.0, 0.0, -UP_M))
    return wire


def test_a_marker_below_is_told_where_it_lies() -> None:
    wire = hovering()
    told = wire.last("LANDING_TARGET")
    truth, believed = (
        wire.simulation.flight.position,
        wire.simulation._vehicle.state.position,
    )
    assert (told.get_srcComponent(), told.target_num, told.position_valid) == (40, 7, 1)
    assert told.frame == dialect.MAV_FRAME_LOCAL_NED
    off = [b - t for b, t in zip(believed, truth, strict=True)]  # of the estimate
    assert (told.x - off[0], told.y - off[1], told.z) == pytest.approx((0.5, 1.0, 0.0), abs=0.05)
    assert abs(told.time_usec / 1e6 - wire.now_s) < 0.06
    recent = [h for h in wire.named("LANDING_TARGET") if wire.now_s - h.time_s < 2.0]
    assert len(recent) == pytest.approx(40, abs=2)


@pytest.mark.parametrize(
    "form",
    [
        pytest.param("BODY_FRD", marks=pytest.mark.long),
        pytest.param("LOCAL_FRD", marks=pytest.mark.long),
        "angles",
    ],
)
def test_the_other_forms_say_the_same(form: str) -> None:
    told = hovering(reports=form).last("LANDING_TARGET")
    offset = math.hypot(0.5, 1.0, UP_M)
    assert told.distance == pytest.approx(offset, abs=0.6)
    if form == "angles":
        assert (told.position_valid, told.frame) == (0, dialect.MAV_FRAME_BODY_FRD)
        ahead = (-math.tan(told.angle_y), math.tan(told.angle_x), 1.0)
        x, y, z = (told.distance * each / math.hypot(*ahead) for each in ahead)
    else:
        x, y, z = told.x, told.y, told.z
    assert (x, y, z) == pytest.approx((0.5, 1.0, UP_M), abs=0.7)  # it hovers as it wanders


def test_a_marker_moves_and_disappears() -> None:
    wire = hovering()
    wire.run(2.9, send=lambda: wire.setpoint(0.0, 0.0, -UP_M))
    told = wire.last("LANDING_TARGET")
    assert told.y == pytest.approx(2.0, abs=0.7)
    before = len(wire.named("LANDING_TARGET"))
    wire.run(1.0, send=lambda: wire.setpoint(0.0, 0.0, -UP_M))
    assert len(wire.named("LANDING_TARGET")) - before < 3


@pytest.mark.parametrize(
    "camera",
    [
        pytest.param({"range_m": 3}, marks=pytest.mark.long),
        {"view_deg": 10},
        pytest.param({"nearest_m": 6}, marks=pytest.mark.long),
        pytest.param({"misses": 1}, marks=pytest.mark.long),
    ],
)
def test_what_is_out_of_sight_is_not_told(camera: dict[str, object]) -> None:
    told = hovering(**camera).named("LANDING_TARGET")
    assert [heard for heard in told if heard.time_s > CLIMBED_S] == []


@pytest.mark.parametrize(
    ("event", "what"),
    [
        ("{name: pod, present: false}", "there is no marker pod"),
        ("{name: pad}", "nothing becomes of the marker pad"),
        ("{name: pad, east_m: 3}", "at east_m and north_m, both"),
    ],
)
def test_an_event_about_a_marker_says_what_it_means(event: str, what: str) -> None:
    text = WORLD.format("component: 40") + f"  - {{at_s: 20, marker: {event}}}\n"
    with pytest.raises(MissionError, match=what):
        read_scenario(text)


def test_a_camera_has_an_id_of_its_own() -> None:
    with pytest.raises(MissionError, match="same component id 26"):
        read_scenario(WORLD.format("component: 26") + "target: {}\n")
