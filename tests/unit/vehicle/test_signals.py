"""What other systems than the vehicle's say is no signal of the mission, and is told once."""

from __future__ import annotations

from typing import Any

from autopilot import TARGET, battery, named

from companion.flight_events.reports import SignalOfAnother
from companion.mavlink.framing import MavlinkCodec
from companion.mission.signals import Signal
from companion.vehicle.signals import MOST_TOLD, OtherSystems, SignalReader

OURS, ANOTHER = 3, 1


def said_by(system: int, message: Any) -> Any:
    codec = MavlinkCodec(system, 25)
    (read,) = codec.parse(codec.pack(message))
    return read


def others(*signals: Signal) -> OtherSystems:
    return OtherSystems(SignalReader(signals or (TARGET,)))


def test_another_system_is_told_once_for_each_signal() -> None:
    heard = others()
    found = heard.news(OURS, [said_by(ANOTHER, named("target", 1)) for _ in range(3)])
    assert found == [SignalOfAnother("NAMED_VALUE_INT[target].value", ANOTHER, OURS)]
    assert heard.news(OURS, [said_by(ANOTHER, named("target", 0))]) == []
    assert len(heard.news(OURS, [said_by(7, named("target", 0))])) == 1


def test_what_the_vehicle_says_or_nobody_asks_for_is_no_news() -> None:
    messages = [
        said_by(OURS, named("target", 1)),
        said_by(ANOTHER, named("other", 1)),
        said_by(ANOTHER, battery(50)),
    ]
    assert others().news(OURS, messages) == []


def test_who_speaks_in_many_names_fills_no_log() -> None:
    heard = others()
    messages = [said_by(system, named("target", 1)) for system in range(10, 250)]
    assert len(heard.news(OURS, messages)) == MOST_TOLD
