"""Each shipped mission does what its story says, whatever the gusts; surveillance has its own test.

The story of a flight is what was reported, without times and plans. With other seeds the wind is
another and so are all times; the story is the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from re import sub

import pytest
from shipped import Replanned, ShippedFlight, Story, distance_from_home_m

from companion.acting.behaviour_tree import landing
from companion.flight_events.facts import BeliefWithdrawn, MissionEventChanged
from companion.flight_events.plans import LineDropped, LineTakenUp
from companion.flight_events.skills import (
    RouteBlocked,
    RouteResponse,
    SkillCompleted,
    SkillFailed,
)
from companion.flight_events.sortie import RunFailed, TaskSatisfied
from companion.planning.optional_lines import NO_PLAN as NO_PLAN_KEEPS_IT
from companion.vehicle_profile import VehicleProfile

QUAD = VehicleProfile()

NO_PLAN = """\
no plan: upload cannot hold from here.
  upload: G(targetFound | targetReported -> F targetReported)
  targetReported can never become true: that needs canUpload(r1) or canUpload(r2) or canUpload(r3)
  withdrawn: canUpload(r1), canUpload(r2), canUpload(r3)
  with canUpload(r1) or canUpload(r2) or canUpload(r3) there would be a plan"""


@dataclass(frozen=True)
class Shipped:
    """What a mission is expected to come to.

    Attributes:
        broken: lines of the task that cannot be kept in this world.
        limit_s: what the flight takes at most.
    """

    mission: str
    scenario: str
    story: Story
    broken: tuple[str, ...] = ()
    limit_s: float = 150.0


def refused(site: str) -> Story:
    failed = SkillFailed(f"upload({site})", "denied")
    return [site, failed, BeliefWithdrawn(f"canUpload({site})"), Replanned(failed.text)]


def delivered(parcel: str, customer: str) -> Story:
    return [
        *("Depot", SkillCompleted(f"pick_up({parcel}, Depot)")),
        *(customer, SkillCompleted(f"hand_over({parcel}, {customer})")),
    ]


NO_CHARGE = SkillFailed("recharge(East)", "the battery does not charge, it is at N %")
PHOTO_FAILED = "the camera says that the photo has failed"
NO_PHOTO = SkillFailed("shoot(T7)", PHOTO_FAILED)


def photo(tree: int) -> Story:
    return [f"T{tree}", SkillCompleted(f"shoot(T{tree})")]


def noticed(event: str, reason: str) -> Story:
    return [MissionEventChanged(event, holds=True), Replanned(reason)]


SHIPPED = (
    Shipped(
        "surveillance",
        "surveillance_all_uploads_fail",
        [
            *("A", "B", "C", "A", *noticed("targetFound", "target found")),
            *(*refused("r1"), *refused("r2"), *refused("r3")),
            *("Home", RunFailed(NO_PLAN, 3)),
        ],
        broken=("upload",),
    ),
    Shipped(
        "delivery",
        "delivery",
        [
            *(*delivered("p1", "North"), *delivered("p3", "East"), *delivered("p2", "North")),
            *("Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "return_home",
        "return_home",
        [
            *("Gate", "Store", "Dock", "Gate"),
            *(*noticed("calledHome", "called home"), "Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "night_watch",
        "night_watch",
        [
            *("Gate", "Dock", "Store", "Gate"),
            *(MissionEventChanged("dockInUse", holds=True), LineDropped("dock", NO_PLAN_KEEPS_IT)),
            *(Replanned("dock in use"), "Store"),
            MissionEventChanged("alarm", holds=True),
            MissionEventChanged("alarm", holds=False),
            *("Gate", "Store"),
            *(MissionEventChanged("dockInUse", holds=False), "Gate"),
            *(LineTakenUp("dock", anew=False), Replanned("dock has a plan again"), "Dock"),
            *(*noticed("calledHome", "called home"), "Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "corridor",
        "corridor",
        [
            *("Shelf", "Bench"),
            *(RouteBlocked("Shelf", RouteResponse.ANOTHER_ROUTE), "Shelf"),
            *noticed("corridorClear", "corridor clear"),
            *("Bench", "Corridor", "Shelf"),
            *(*noticed("calledHome", "called home"), "Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "field",
        "field",
        [
            *("Barn", SkillCompleted("look(Barn)"), "Pond", SkillCompleted("look(Pond)")),
            *("Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "rooftop",
        "rooftop",
        [
            *("Workshop", SkillFailed("deliver(Workshop)", "its marker is not seen")),
            *(BeliefWithdrawn("canLand(Workshop)"),),
            Replanned("deliver(Workshop) failed: its marker is not seen"),
            *("Office", SkillCompleted("deliver(Office)"), "Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "orchard",
        "orchard",
        [
            *(*photo(1), *photo(5), *photo(9), *photo(10), *photo(6), "T7"),
            *(NO_PHOTO, BeliefWithdrawn("works(T7)"), Replanned(NO_PHOTO.text)),
            *(*photo(11), *photo(12), *photo(8), *photo(4), *photo(3), *photo(2)),
            *("Home", TaskSatisfied()),
        ],
    ),
    Shipped(
        "endless_patrol",
        "endless_patrol",
        [
            *("Well", "Pond", "Barn", "Mill", "Weir", "Ford", "East"),
            *(NO_CHARGE, BeliefWithdrawn("works(East)"), Replanned(NO_CHARGE.text)),
            *("West", SkillCompleted("recharge(West)")),
            Replanned("flights take N % less energy than the mission says"),
            *("Shed", "Oak", "Gate"),  # what this lap has not met yet
            *(*noticed("calledHome", "called home"), "Home", TaskSatisfied()),
        ],
        limit_s=800,
    ),
    Shipped(
        "hall_of_20",
        "hall_of_20",
        [
            *("s2", "s6", "s11"),
            *(*noticed("targetFound", "target found"), *refused("r2")),
            *("r1", SkillCompleted("upload(r1)"), "Home", TaskSatisfied()),
        ],
    ),
)


WAYS = {"corridor": (-0.6, 1.4), "doorway": (7.6, 9.4), "passage": (10.4, 13.8)}
"""The ways from one room of the corridor mission to the other, metres north."""
BETWEEN_THE_ROOMS = [
    *("doorway", "passage"),  # the door closes before the vehicle comes back through it
    "doorway",  # it is seen open again; halfway through the corridor is clear
    *("corridor", "corridor", "corridor"),
]


def ways_between_the_rooms(flight: ShippedFlight) -> list[str]:
    return [
        next(way for way, (south_m, north_m) in WAYS.items() if south_m < north < north_m)
        for north in flight.crossings(east_m=6.0)
    ]


def without_chance(story: Story) -> Story:
    """A story without what the gauge said, and whether a photo's failure or nothing was heard."""
    found: Story = []
    for event in story:
        if isinstance(event, SkillFailed):
            event = replace(event, reason=reason_without_chance(event.reason))
        elif isinstance(event, Replanned):
            event = Replanned(reason_without_chance(event.reason))
        found.append(event)
    return found


def reason_without_chance(reason: str) -> str:
    """One reason of them."""
    return sub("no photo in .* is not known", PHOTO_FAILED, sub(r"\d+ %", "N %", reason))


def flies_as_told(shipped: Shipped, seed: int) -> None:
    flight = ShippedFlight(shipped.mission, shipped.scenario, seed, shipped.limit_s)
    assert without_chance(flight.story) == shipped.story
    assert flight.simulation.collisions == 0
    assert flight.clearance_m >= QUAD.radius_m + QUAD.margin_m
    assert distance_from_home_m(flight) < 0.5
    assert flight.speed_mps <= 1.05 * flight.mission.limits.speed_mps
    assert flight.acceleration_mps2 <= 1.25 * QUAD.acceleration_mps2
    assert not flight.simulation.is_armed
    kept = [line for line in flight.mission.task if line not in shipped.broken]
    assert flight.lines_that_hold() == kept
    if shipped.mission == "corridor":
        assert ways_between_the_rooms(flight) == BETWEEN_THE_ROOMS


ENDLESS = next(shipped for shipped in SHIPPED if shipped.mission == "endless_patrol")
ELSEWHERE = {
    "endless_patrol",  # eleven minutes; tests/flights/test_energy.py flies between two docks
    "field",  # tests/flights/test_open_field.py
    "hall_of_20",  # surveillance among twenty sites
    "night_watch",  # a line is dropped and taken up: tests/flights/test_time_bounds.py
    "orchard",  # tests/flights/test_photos.py
    "return_home",  # tests/flights/test_operator.py
    "rooftop",  # tests/flights/test_land_on_marker.py
    "surveillance",  # without any upload site: tests/flights/test_safety.py
}
"""Missions that are flown with the sweeps, and by other tests in every run."""


@pytest.mark.parametrize(
    "shipped",
    [
        pytest.param(shipped, marks=[pytest.mark.long] if shipped.mission in ELSEWHERE else [])
        for shipped in SHIPPED
    ],
    ids=lambda shipped: shipped.scenario,
)
def test_a_mission_flies_as_told(shipped: Shipped) -> None:
    flies_as_told(shipped, seed=2)


@pytest.mark.long
def test_endless_patrol_leaves_the_dock_that_fails_for_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its story up to there; it waits for one more percent for half a minute, and not for two."""
    monkeypatch.setattr(landing, "NO_CHARGE_S", 30.0)
    flight = ShippedFlight(ENDLESS.mission, ENDLESS.scenario, 2, ENDLESS.limit_s, until="West")
    story = without_chance(flight.story)
    assert story == ENDLESS.story[: ENDLESS.story.index("West") + 1]
    assert flight.simulation.collisions == 0
    assert flight.clearance_m >= QUAD.radius_m + QUAD.margin_m


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3, 12))
@pytest.mark.parametrize("shipped", SHIPPED, ids=lambda shipped: shipped.scenario)
def test_other_gusts_change_nothing_but_times(shipped: Shipped, seed: int) -> None:
    flies_as_told(shipped, seed)
