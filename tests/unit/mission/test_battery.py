"""The battery of a mission, and skills that charge: what is read, and what is refused where."""

from __future__ import annotations

import pytest

from companion.errors import CompanionError, MissionError
from companion.mission.loader import load_mission
from companion.planning.planner import Planner

TEXT = """\
version: 1
name: patrol
limits: {speed_mps: 3, up_m: [1, 8], fence: [[-5, -5], [30, -5], [30, 30], [-5, 30]]}
battery:
  reserve: 20
  capacity_wh: 40
  curve: [[0, 0], [50, 45], [100, 100]]
  power_w:
    level: [[0, 190], [5, 192], [8, 198]]
    climb: [[-1, 180], [0, 190], [2, 212]]
  wind: {east_mps: 2, north_mps: -1}
places:
  Home: {east_m: 0, north_m: 0, up_m: 3}
  A: {east_m: 20, north_m: 10, up_m: 3}
  Dock: {east_m: 10, north_m: 0, up_m: 2}
sets: {Place: [Home, A, Dock], Pad: [Dock]}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    effect: at(to) & !at(from)
    execute: fly(to)
    energy_wh: 0.5
  recharge:
    parameters: {pad: Pad}
    precondition: at(pad)
    effect: at(pad)
    charge_rate: [[0, 2.0], [80, 2.0], [100, 0.1]]
    execute: [land(), charge(auto), take_off()]
initially: [at(Home)]
task: {patrol: "patrolling(A, Home)"}
otherwise: {land_at: [Home]}
"""


def test_what_is_written_is_what_plans_reckon_with() -> None:
    mission = load_mission(TEXT)
    battery = mission.battery
    assert battery is not None and battery.reserve == 0.2 and battery.wind == (-1.0, 2.0)
    assert battery.profile.capacity_wh == 40
    assert battery.profile.energy_wh(0.5) == pytest.approx(18.0)
    assert battery.profile.power_w(5.0, 2.0) == pytest.approx(192 + 22)
    assert mission.skills["move"].energy_wh == 0.5
    assert mission.skills["recharge"].charge_rate == ((0, 0.02), (0.8, 0.02), (1, 0.001))
    assert "recharge(Dock)" in str(Planner(mission).plan())


def test_flight_times_alone_make_no_plans_for_a_battery() -> None:
    with pytest.raises(CompanionError, match="flight times say nothing of energy"):
        Planner(load_mission(TEXT), lambda origin, goal: 5.0)


def test_what_is_left_out_is_the_default_vehicles_or_linear() -> None:
    default = load_mission(TEXT.replace("  capacity_wh: 40\n", "").replace("  curve", "  # curve"))
    assert default.battery is not None
    assert default.battery.profile.capacity_wh == 75.5
    assert default.battery.profile.energy_wh(0.1) == pytest.approx(75.5 * 0.091)
    own = load_mission(TEXT.replace("  curve", "  # curve"))
    assert own.battery is not None and own.battery.profile.energy_wh(0.1) == pytest.approx(4.0)


REFUSED = [
    ("reserve: 20", "reserve: 95", "5:12", "reserve is 95, expected at most 90"),
    ("reserve: 20", "reserve: -1", "5:12", "reserve is -1, expected at least 0"),
    ("  reserve: 20\n", "", "4:1", "the key reserve is missing in battery"),
    ("capacity_wh: 40", "capacity_wh: 0", "6:16", "expected more than 0"),
    ("capacity_wh: 40", "capacity_wh: lots", "6:16", "expected a number"),
    ("capacity_wh: 40", "capacity_wh:", "6:3", "has no value"),
    ("[[0, 0], [50, 45], [100, 100]]", "[[0, 0], [50, 45]]", "7:10", "does not rise from [0, 0]"),
    ("[50, 45]", "[50, 100]", "7:10", "does not rise"),
    ("[50, 45]", "[50]", "7:19", "entry 2 in battery.curve"),
    ("[[0, 190], [5, 192]", "[[1, 190], [5, 192]", "9:13", "the power of a hover is missing"),
    ("[5, 192], [8", "[9, 192], [8", "9:33", "the speeds do not rise"),
    ("[5, 192]", "[5, 0]", "9:23", "0 W fly no vehicle"),
    ("[0, 190], [2, 212]", "[3, 190], [2, 212]", "10:34", "the speeds do not rise"),
    ("wind: {east_mps: 2", "wind: {east_mps: 50", "11:20", "expected at most 30"),
    ("  wind:", "  winds:", "11:3", "winds"),
    ("energy_wh: 0.5", "energy_wh: -2", "23:16", "expected at least 0"),
    ("[[0, 2.0], [80, 2.0], [100, 0.1]]", "[[0, 2.0]]", "28:18", "charge_rate"),
    ("[[0, 2.0]", "[[1, 2.0]", "28:18", "does not fall from [0, RATE]"),
    ("[80, 2.0]", "[80, 3.0]", "28:18", "does not fall from [0, RATE]"),
    ("[[0, 2.0], [80, 2.0], [100, 0.1]]", "[[0, 0], [100, 0]]", "28:18", "does not fall"),
    ("[100, 0.1]", "[100, -1]", "28:18", "does not fall from [0, RATE]"),
    ("    charge_rate: [[0, 2.0], [80, 2.0], [100, 0.1]]\n", "", "28:23", "not known how fast"),
    ("charge(auto)", "charge(80)", "28:5", "has a charge_rate and no charge(auto)"),
    ("charge(auto)", "charge(0)", "29:", "charge"),
    ("    precondition: at(pad)\n", "", "24:3", "not known where recharge charges"),
]


@pytest.mark.parametrize(("before", "after", "place", "words"), REFUSED)
def test_a_mistake_is_told_with_its_place(before: str, after: str, place: str, words: str) -> None:
    assert before in TEXT
    with pytest.raises(MissionError) as refused:
        load_mission(TEXT.replace(before, after, 1))
    told = str(refused.value)
    assert place in told.splitlines()[0] and words in told, told


def test_charge_auto_without_a_battery_is_refused_where_it_is_written() -> None:
    start, end = TEXT.index("battery:"), TEXT.index("places:")
    with pytest.raises(MissionError) as refused:
        load_mission(TEXT[:start] + TEXT[end:])
    told = str(refused.value)
    assert "plans know of no energy" in told and "battery: {reserve: 20}" in told
    assert ":21:23: " in told, told
