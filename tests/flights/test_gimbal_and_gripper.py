"""A gimbal that has to turn and a gripper that may miss, in the simulator."""

from __future__ import annotations

import math
from typing import Any

import pytest
from lockstep import Lockstep, Lossy
from photo_missions import AREA, photo_mission

from companion.flight_events.skills import PhotoTaken, SkillCompleted, SkillFailed
from companion.geometry import wrap_angle
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from sitl.world.gimbal import NOBODY, Gimbal
from sitl.world.scenario import read_scenario

CONFIGURE = dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE
REACHED_RAD = math.radians(2.2)
NAMES = {"camera": 100, "gimbal": 154, "gripper": 27}


class DeviceFlight(Lockstep):
    """Flies with a camera, a gimbal and a gripper."""

    def __init__(
        self,
        photo: dict[str, Any],
        happens: list[dict[str, Any]] | None = None,
        gripper: dict[str, Any] | None = None,
        gimbal: dict[str, Any] | None = None,
        **options: Any,
    ) -> None:
        mission = load_mission(photo_mission("A", photo=photo, components=NAMES))
        world = {
            "version": 1,
            "map": AREA,
            "happens": happens or [],
            "cameras": [{"after_s": 0.5}],
            "gimbal": gimbal or {},
            "gripper": gripper or {},
        }
        super().__init__(mission, read_scenario(world), **options)

    @property
    def gimbal(self) -> Gimbal:
        gimbal = self.simulation._world.gimbal
        assert gimbal is not None
        return gimbal

    @property
    def has_load(self) -> bool:
        gripper = self.simulation._world.gripper
        return gripper is not None and gripper.has_load

    @property
    def failures(self) -> list[str]:
        return [event.reason for event in self.of(SkillFailed)]

    def off_rad(self, point: tuple[float, float, float]) -> tuple[float, float]:
        """How far the gimbal truly points past a point (north, east, up): pitch and yaw."""
        state = self.simulation.flight
        north, east, up = (
            p - q for p, q in zip(point, (*state.position[:2], -state.position[2]), strict=True)
        )
        pitch = math.atan2(up, math.hypot(north, east))
        yaw = math.atan2(east, north)
        return (
            abs(self.gimbal.pitch_rad - pitch),
            abs(wrap_angle(state.euler[2] + self.gimbal.yaw_rad - yaw)),
        )


def test_a_photo_is_made_when_the_gimbal_looks_at_its_object() -> None:
    """4 m ahead of the place and below it: the vehicle turns, and the gimbal looks down."""
    look = {"look_at": {"north_m": 5, "east_m": 3, "up_m": 0.5}, "gimbal": "gimbal"}
    flight = DeviceFlight({"execute": "photo(camera)", **look}, gimbal={"rate_dps": 20})
    flight.until(lambda: flight.simulation._world.cameras[0].is_shooting)
    pitch_off, yaw_off = flight.off_rad((5.0, 3.0, 0.5))
    assert pitch_off <= 2 * REACHED_RAD and yaw_off <= 2 * REACHED_RAD
    flight.until_the_end()
    assert flight.exit_code == 0 and len(flight.of(PhotoTaken)) == 1
    assert flight.gimbal.control == NOBODY
    configured = [said.message for said in flight.commands if said.message.command == CONFIGURE]
    assert [(m.param1, m.param2) for m in configured] == [(1.0, 191.0), (-3.0, -3.0)]


def test_straight_down_needs_no_direction() -> None:
    look = {"look_at": "s", "gimbal": "gimbal", "execute": "photo(camera)"}
    flight = DeviceFlight(look)
    flight.until(lambda: flight.simulation._world.cameras[0].is_shooting)
    assert abs(flight.gimbal.pitch_rad + math.pi / 2) < math.radians(15)
    assert flight.until_the_end().exit_code == 0


def test_angles_are_from_the_vehicles_heading() -> None:
    steps = {"execute": ["gimbal(gimbal, -30, 90)", "photo(camera)"]}
    flight = DeviceFlight(steps, up=Lossy(0.3, 1), down=Lossy(0.3, 2))
    flight.until(lambda: flight.simulation._world.cameras[0].is_shooting)
    assert abs(flight.gimbal.pitch_rad + math.radians(30)) <= REACHED_RAD
    assert abs(flight.gimbal.yaw_rad - math.radians(90)) <= REACHED_RAD
    assert flight.until_the_end().exit_code == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"stuck": True}, "the gimbal (component 154) is 30 degrees off after 5 s"),
        pytest.param(
            *({"silent": True}, "the gimbal (component 154) has not answered after 5 s"),
            marks=pytest.mark.long,
        ),
    ],
)
def test_a_gimbal_that_does_not_turn(change: dict[str, bool], words: str) -> None:
    step = {"execute": "gimbal(gimbal, -30, 0)", "timeout_s": 5, "assumes": "turns(s)"}
    flight = DeviceFlight(step, [{"at_s": 0, "gimbal": change}])
    flight.until_the_end()
    assert flight.failures == [words] and flight.exit_code == 3


LOADED = {"confirmed_by": "NAMED_VALUE_INT[load].value > 0", "timeout_s": 8}


def test_a_grip_that_is_confirmed() -> None:
    flight = DeviceFlight({"execute": "grip(gripper)", **LOADED})
    flight.until_reported(SkillCompleted)
    assert flight.has_load
    assert flight.until_the_end().exit_code == 0


def test_a_grip_that_holds_nothing_is_tried_again_and_fails() -> None:
    grip = {"execute": ["release(gripper)", "grip(gripper)"], "tries": 2, **LOADED}
    flight = DeviceFlight({**grip, "assumes": "loose(s)"}, gripper={"loads": []})
    flight.until_the_end()
    condition = "NAMED_VALUE_INT[load].value > 0"
    assert flight.failures == [f"not done after 8 s: not confirmed by {condition}: it says 0"]
    sent = [s.message for s in flight.commands if s.message.command == dialect.MAV_CMD_DO_GRIPPER]
    assert [message.param2 for message in sent] == [0.0, 1.0] * 2
    assert flight.exit_code == 3


def test_without_a_reading_an_accepted_grip_is_done() -> None:
    flight = DeviceFlight({"execute": "grip(gripper)"}, gripper={"loads": []})
    flight.until_reported(SkillCompleted)
    assert not flight.has_load


def test_a_gripper_that_is_not_there() -> None:
    grip = {"execute": "grip(gripper)", "timeout_s": 3, "assumes": "loose(s)"}
    flight = DeviceFlight(grip, [{"at_s": 0, "gripper": {"silent": True}}])
    flight.until_the_end()
    assert flight.failures == ["no answer in 3 s, and no heartbeat of component 27"]
