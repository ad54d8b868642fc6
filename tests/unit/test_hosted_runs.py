"""What a host flies first: a run that was cut off, before anything that is started."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from notes import Notes
from synthetic import mission

from companion.flights.sortie_host import SortieHost
from companion.run_sources.hosted_runs import HostedRuns
from companion.run_sources.only_run import OnlyRun
from companion.skills.runner import FunctionRunner
from companion.vehicle.telemetry import Telemetry


def test_a_start_while_a_run_that_was_cut_off_waits_begins_no_second_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It waits to hear how high the ground is; nothing takes off once more after its end."""
    flown = mission("F at(A)")
    above_sea = replace(flown.places["A"], amsl_m=490.0)
    flown = replace(flown, places={**flown.places, "A": above_sea})
    never: Any = pytest.fail
    host = SortieHost(never, never, None, FunctionRunner())
    monkeypatch.setattr(host, "prepare", pytest.fail)
    runs, telemetry = HostedRuns(host, flown, OnlyRun(flown, Notes())), Telemetry()
    assert runs.next(telemetry, 0.0) is None and not runs.awaits_start
    assert runs.start(telemetry, 0.0, 3.0) is None
