"""QGroundControl connects, sets up, plans and flies without one complaint."""

import pytest
from qgroundcontrol import QGroundControl

from companion.mavlink.framing import dialect
from companion.mavlink.parameters import INT32, REAL32

HOME = (47.397742, 8.545594, 488.0)


@pytest.fixture
def qgc() -> QGroundControl:
    station = QGroundControl()
    station.connect()
    return station


def height_m(qgc: QGroundControl) -> float:
    return float(qgc.wire.last("GLOBAL_POSITION_INT").relative_alt / 1e3)


def until_disarmed(qgc: QGroundControl, limit_s: int) -> None:
    for _ in range(limit_s):
        if not qgc.wire.last("HEARTBEAT").base_mode & 0x80:
            break
        qgc.run(1.0)
    assert not qgc.wire.last("HEARTBEAT").base_mode & 0x80


def test_it_connects_and_finds_nothing_missing(qgc: QGroundControl) -> None:
    assert qgc.complaints() == []
    assert qgc.lost_messages() == 0
    assert len(qgc.parameters) >= 120
    assert qgc.load_plan(0) == []


def test_gaps_in_the_list_are_read_again(qgc: QGroundControl) -> None:
    names = sorted(qgc.parameters)
    for index in (0, 17, len(names) - 1):
        told = qgc.reread(index)
        assert told is not None and told.param_id == names[index]


def test_parameters_are_written(qgc: QGroundControl) -> None:
    qgc.set_parameter("RTL_RETURN_ALT", 12.0, REAL32)
    qgc.set_parameter("NAV_DLL_ACT", 2, INT32)


def test_a_guided_flight(qgc: QGroundControl) -> None:
    """Take off, go to a point, pause, go on, return and land by the buttons."""
    qgc.take_off(10.0)
    qgc.run(14.0)
    assert height_m(qgc) == pytest.approx(10.0, abs=0.5)
    qgc.go_to(HOME[0] + 0.0004, HOME[1], HOME[2] + 8.0)
    qgc.run(4.0)
    qgc.pause()
    qgc.run(4.0)
    paused = qgc.wire.last("GLOBAL_POSITION_INT").lat / 1e7
    assert HOME[0] + 0.00005 < paused < HOME[0] + 0.0004
    qgc.go_to(HOME[0] + 0.0004, HOME[1], HOME[2] + 8.0)
    qgc.run(15.0)
    assert qgc.wire.last("GLOBAL_POSITION_INT").lat / 1e7 == pytest.approx(
        HOME[0] + 0.0004, abs=3e-6
    )
    assert height_m(qgc) == pytest.approx(8.0, abs=0.5)
    qgc.set_mode("AUTO.RTL")
    until_disarmed(qgc, limit_s=75)
    assert qgc.wire.last("EXTENDED_SYS_STATE").landed_state == 1
    assert qgc.lost_messages() == 0
    assert "Disarmed by landing" in qgc.wire.texts()


@pytest.mark.parametrize(
    "mode",
    [
        *("AUTO.LOITER", "POSCTL"),
        *(pytest.param(m, marks=pytest.mark.long) for m in ("AUTO.LAND", "AUTO.RTL", "OFFBOARD")),
    ],
)
def test_modes_on_the_ground(qgc: QGroundControl, mode: str) -> None:
    qgc.set_mode(mode)


def test_a_mission_is_planned_uploaded_loaded_and_flown(qgc: QGroundControl) -> None:
    latitude, longitude, _ = HOME
    takeoff, waypoint, home = (
        dialect.MAV_CMD_NAV_TAKEOFF,
        dialect.MAV_CMD_NAV_WAYPOINT,
        dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    )
    items = [
        (takeoff, 3, (0.0, 0.0, 0.0, float("nan"), latitude, longitude, 5.0)),
        (waypoint, 3, (0.0, 0.0, 0.0, float("nan"), latitude + 0.0001, longitude, 5.0)),
        (waypoint, 3, (0.0, 0.0, 0.0, float("nan"), latitude, longitude + 0.0001, 6.0)),
        (home, 2, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
    ]
    qgc.save_plan(0, items)
    loaded = qgc.load_plan(0)
    assert [m.command for m in loaded] == [command for command, _, _ in items]
    assert [m.x for m in loaded[:3]] == [round(p[4] * 1e7) for _, _, p in items[:3]]
    qgc.set_mode("AUTO.MISSION")
    qgc.arm()
    until_disarmed(qgc, limit_s=120)
    reached = [h.message.seq for h in qgc.wire.named("MISSION_ITEM_REACHED")]
    assert list(dict.fromkeys(reached))[:3] == [0, 1, 2]


def test_fence_and_rally_points_are_uploaded_and_loaded(qgc: QGroundControl) -> None:
    latitude, longitude, _ = HOME
    corners = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
    fence = [
        (5001, 0, (4.0, 0.0, 0.0, 0.0, latitude + n * 1e-3, longitude + e * 1e-3, 0.0))
        for n, e in corners
    ]
    qgc.save_plan(1, fence)
    assert [m.command for m in qgc.load_plan(1)] == [5001] * 4
    qgc.save_plan(2, [(5100, 3, (0.0, 0.0, 0.0, 0.0, latitude, longitude, 10.0))])
    assert [m.command for m in qgc.load_plan(2)] == [5100]
