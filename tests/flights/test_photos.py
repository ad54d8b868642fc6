"""Photos in the simulator: each is made once, whatever is lost, interrupted or begun anew."""

from __future__ import annotations

import math
from typing import Any

import pytest
from lockstep import COMPANION, Deaf, Lossy
from photo_missions import SHOOT, PhotoFlight, photo_mission

from companion.flight_events.skills import OutcomeUnknown, PhotoTaken, SkillFailed
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.mavlink.framing import dialect

PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
IMAGES, ACKS = 263, 77
SLOW = {"after_s": 3.0}


def flown(flight: PhotoFlight) -> PhotoFlight:
    flight.until(lambda: flight.companion.has_ended, 300.0)
    return flight


def is_whole(flight: PhotoFlight, sites: str = "ABC") -> bool:
    """A photo of each site, made once and told, and the mission flown well."""
    is_told = "".join(place for _, place in flight.told) == sites
    return is_told and flight.made == len(sites) and flight.exit_code == 0


def test_each_photo_is_made_once_and_told() -> None:
    flight = flown(PhotoFlight(photo_mission(), {"images": 4}, has_station=True))
    assert is_whole(flight)
    assert flight.told == [(5, "A"), (6, "B"), (7, "C")]
    assert flight.sequences == [5, 6, 7] and len(flight.asked) == 3
    texts = [said.message.text for said in flight.heard if said.message.get_type() == "STATUSTEXT"]
    assert "photo 5 of camera at A" in texts


@pytest.mark.long
@pytest.mark.parametrize(("share", "seed"), [(0.1, 0), *((0.3, seed) for seed in range(1, 40))])
def test_whatever_is_lost_each_photo_is_made_once(share: float, seed: int) -> None:
    up, down = Lossy(share, seed), Lossy(share, seed + 1000)
    flight = flown(PhotoFlight(photo_mission(), {"after_s": 0.8}, seed=seed, up=up, down=down))
    assert is_whole(flight), (flight.made, flight.told, flight.failures)


@pytest.mark.parametrize(
    "lost", [{"lost": 1.0}, pytest.param({"lost": 0.5}, marks=pytest.mark.long)]
)
def test_a_camera_that_does_not_tell_of_its_images(lost: dict[str, float]) -> None:
    flight = flown(PhotoFlight(photo_mission("A"), lost))
    assert is_whole(flight, "A") and len(flight.asked) == 1


def test_answers_that_never_arrive() -> None:
    deaf = Deaf(ACKS)
    flight = PhotoFlight(photo_mission("A"), SLOW, up=deaf)
    flight.until(lambda: flight.camera.is_shooting)
    deaf.is_deaf = True
    flight.until_reported(PhotoTaken)
    assert len(flight.asked) == flight.made == 1


def test_a_camera_in_the_air_is_told_to_be_offline() -> None:
    happens = [{"at_s": 6, "camera": {"silent": True}}]
    belief = {"photo": {"assumes": "ready(s)"}}
    flight = flown(PhotoFlight(photo_mission("A", **belief), SLOW, happens))
    assert flight.exit_code == 3
    (why,) = flight.failures
    assert why.startswith("the camera (component 100) is offline: nothing heard for")
    assert flight.asked == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"full": True}, "the camera has answered: denied; its storage is full"),
        pytest.param(
            *({"fails": True}, "the camera says that the photo has failed"), marks=pytest.mark.long
        ),
        pytest.param(
            *({"busy": True}, "the camera (component 100) is busy"), marks=pytest.mark.long
        ),
    ],
)
def test_a_photo_that_is_not_made_fails_its_skill(change: dict[str, bool], words: str) -> None:
    belief = {"photo": {"assumes": "ready(s)", "timeout_s": 6}}
    happens = [{"at_s": 0, "camera": change}]
    flight = flown(PhotoFlight(photo_mission("A", **belief), {}, happens))
    assert flight.exit_code == 3
    assert flight.failures == [words] and flight.made == 0


def test_another_try_shoots_where_the_first_one_has_made_no_photo() -> None:
    happens = [
        {"at_s": 0, "camera": {"fails": True}},
        {"command": "MAV_CMD_IMAGE_START_CAPTURE", "nth": 2, "camera": {"fails": False}},
    ]
    flight = flown(PhotoFlight(photo_mission("A", photo={"tries": 3}), {}, happens))
    assert is_whole(flight, "A") and flight.failures == []
    assert flight.sequences == [1, 2]


def test_another_try_does_not_shoot_where_the_first_one_was_only_late() -> None:
    """Each try is shorter than a photo of this camera takes."""
    skill = {"photo": {"tries": 3, "timeout_s": 2}}
    flight = flown(PhotoFlight(photo_mission("A", **skill), SLOW))
    assert is_whole(flight, "A") and len(flight.asked) == 1


def test_a_skill_of_two_photos_makes_two_and_one_that_fails_after_them_no_more() -> None:
    steps = {"photo": {"execute": ["photo(camera)", "photo(camera)"], "tries": 2}}
    flight = flown(PhotoFlight(photo_mission("A", **steps), {}))
    assert flight.made == 2 and flight.exit_code == 0
    steps = {"photo": {"execute": ["photo(camera)", "command(winch, MAV_CMD_USER_1)"], "tries": 3}}
    components = {"components": {"camera": 100, "winch": 33}}
    flight = PhotoFlight(photo_mission("A", **components, **steps), {})
    flight.until_reported(SkillFailed)
    assert flight.made == len(flight.told) == 1


def test_a_pause_in_mid_photo() -> None:
    flight = PhotoFlight(photo_mission("A"), SLOW, has_station=True)
    flight.until(lambda: flight.camera.is_shooting)
    flight.station_commands(PAUSE, 0.0, component=COMPANION)
    flight.run(6.0)
    assert flight.of(PhaseEntered, phase=Phase.PAUSED) and flight.made == 1 and not flight.told
    flight.station_commands(PAUSE, 1.0, component=COMPANION)
    assert is_whole(flown(flight), "A") and len(flight.asked) == 1


@pytest.mark.parametrize("is_killed", [pytest.param(False, marks=pytest.mark.long), True])
def test_a_photo_is_told_once_although_its_skill_begins_again(is_killed: bool) -> None:
    skill = {"execute": ["photo(camera)", "wait(5)"]}
    flight = PhotoFlight(photo_mission("A", photo=skill), {}, has_station=True, resumes=True)
    flight.until_reported(PhotoTaken).run(1.0)
    if is_killed:
        flight.kill()
        flight.run(3.0)
        flight.restart()
    else:
        flight.station_commands(PAUSE, 0.0, component=COMPANION)
        flight.run(2.0)
        flight.station_commands(PAUSE, 1.0, component=COMPANION)
    assert is_whole(flown(flight), "A") and not flight.of(OutcomeUnknown)


def test_a_pilot_in_mid_photo_and_no_photo_for_him() -> None:
    flight = PhotoFlight(photo_mission("A"), SLOW, has_station=True)
    flight.until(lambda: flight.camera.is_shooting)
    flight.station_chooses("AUTO.LOITER")
    flown(flight).run(4.0)
    assert flight.exit_code == 5
    assert len(flight.asked) == 1 and not flight.told


@pytest.mark.long
def test_another_plan_in_mid_photo() -> None:
    """A line begins anew while the photo is under way; it was made, and is not made again."""
    events = {"called": {"when": "COMMAND.MAV_CMD_USER_3", "latch": True}}
    task = {"photos": "F seen(A)", "home": "G(called -> F at(Home))"}
    flight = PhotoFlight(photo_mission("A", events=events, task=task), SLOW, has_station=True)
    flight.until(lambda: flight.camera.is_shooting)
    flight.station_commands(dialect.MAV_CMD_USER_3, component=COMPANION)
    flown(flight)
    assert is_whole(flight, "A") and len(flight.asked) == 1


@pytest.mark.parametrize(
    ("at_s", "away_s", "is_made"),
    [
        *((0.2, 6.0, True), (1.5, 1.0, True), (0.2, 6.0, False)),
        pytest.param(1.5, 1.0, False, marks=pytest.mark.long),
    ],
)
def test_killed_in_mid_photo_another_process_asks_the_camera(
    at_s: float, away_s: float, is_made: bool
) -> None:
    flight = PhotoFlight(photo_mission("A"), SLOW, resumes=True)
    flight.until(lambda: bool(flight.asked))
    if is_made:
        flight.until(lambda: flight.camera.is_shooting).run(at_s)
    else:
        flight._to_vehicle.clear()  # it never arrives
    flight.kill()
    flight.run(away_s)
    flight.restart()
    flown(flight)
    unknown = "the camera is asked how many photos it has taken"
    assert [e.action for e in flight.of(OutcomeUnknown, consequence=unknown)] == ["photo(A)"]
    assert is_whole(flight, "A")
    assert flight.sequences == ([1] if is_made else [1, 2])


def test_a_camera_that_begins_to_count_anew_is_not_trusted() -> None:
    mission = photo_mission("A", photo={"assumes": "ready(s)"})
    flight = PhotoFlight(mission, {**SLOW, "images": 9}, resumes=True)
    flight.until(lambda: flight.camera.is_shooting)
    flight.kill()
    flight.run(5.0)
    flight.camera.images = 0
    flight.restart()
    flight.until(lambda: bool(flight.failures), 60.0)
    assert flight.failures[0].startswith("whether the photo was made is not known: it has counted")


@pytest.mark.long
def test_two_cameras() -> None:
    mission = photo_mission(
        "AB",
        components={"camera": 100, "infrared": 101},
        photo={"execute": ["photo(camera)", "photo(infrared)"]},
    )
    flight = flown(PhotoFlight(mission, {}, others=[{"component": 101, "images": 5}]))
    told = [(event.camera, event.number) for event in flight.of(PhotoTaken)]
    assert told == [("camera", 1), ("infrared", 6), ("camera", 2), ("infrared", 7)]


@pytest.mark.long
def test_a_tree_by_hand_and_a_refinement() -> None:
    mission = photo_mission(
        "A", tree=["move(Home, A)", {"repeat": ["see(A)"], "times": 3}, "move(A, Home)"]
    )
    skills = mission["skills"]
    skills["see"] = {**skills.pop("photo"), "execute": "shoot()"}
    skills["shoot"] = {"execute": "photo(camera)", "planned": False}
    del mission["task"]
    flight = flown(PhotoFlight(mission, {}))
    assert flight.told == [(1, "A"), (2, "A"), (3, "A")] and flight.made == 3
    assert flight.exit_code == 0


@pytest.mark.long
def test_equal_flights_are_equal() -> None:
    def sent() -> list[Any]:
        up, down = Lossy(0.3, 5), Lossy(0.3, 6)
        flight = flown(PhotoFlight(photo_mission("A"), {"lost": 0.3}, up=up, down=down))
        return [
            (said.time_s, said.message.param4)
            for said in flight.commands
            if said.message.command == SHOOT
        ]

    assert sent() == sent()


def test_a_photo_of_a_skill_that_flies_there_itself_is_told_where_it_was_made() -> None:
    """The place at which the flight began is still the vehicle's, as far as the task knows."""
    skill = {
        "parameters": {"from": "Place", "s": "Site"},
        "precondition": "at(from)",
        "effect": "seen(s) & at(s) & !at(from)",
        "execute": ["fly(s)", "photo(camera)"],
    }
    flight = flown(PhotoFlight(photo_mission("A", photo=skill), {}))
    taken = flight.one(PhotoTaken)
    north_m, east_m, _ = taken.position
    assert math.hypot(north_m, east_m) > 1.0 and flight.exit_code == 0
    assert taken.place == f"{east_m:.1f} m east, {north_m:.1f} m north"
