"""What the host of sorties does beside the loop: preparing a mission, in a thread."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from scripted_functions import ScriptedFunctions
from synthetic import mission

from companion.errors import CompanionError
from companion.flights.sortie_host import SortieHost

PREPARE = "companion.flights.sortie_host.prepare"
ENGINE: Any = object()
NOTHING: Any = None  # no run begins
FUNCTIONS: Any = ScriptedFunctions()


@pytest.fixture
def host() -> SortieHost:
    return SortieHost(NOTHING, NOTHING, None, FUNCTIONS, ENGINE)


def test_a_mission_is_prepared_in_another_thread(
    host: SortieHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(PREPARE, lambda *asked, **how: (asked, how, threading.get_ident()))
    flown = mission("F at(A)")
    prepared: Any = host.prepare(flown, 2.0, 488.0).result()
    asked, how, thread = prepared
    told = {"engine": ENGINE, "ground_amsl_m": 488.0, "functions": FUNCTIONS}
    assert asked == (flown, 2.0) and how == told
    assert thread != threading.get_ident()


def test_what_is_wrong_is_raised_where_the_result_is_asked_for(
    host: SortieHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: Any, **__: Any) -> Any:
        raise CompanionError("no such action")

    monkeypatch.setattr(PREPARE, fails)
    prepared = host.prepare(mission("F at(A)"), 2.0, None)
    with pytest.raises(CompanionError, match="no such action"):
        prepared.result()
    assert prepared.done()


def test_the_end_waits_for_no_preparation(
    host: SortieHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither the host's nor the program's: a thread that is no daemon would hold that up."""
    may_end, threads = threading.Event(), []

    def takes_long(*_: Any, **__: Any) -> None:
        threads.append(threading.current_thread())
        may_end.wait()

    monkeypatch.setattr(PREPARE, takes_long)
    prepared = host.prepare(mission("F at(A)"), 2.0, None)
    host.close()
    assert not prepared.done()
    may_end.set()
    prepared.result()
    assert [thread.daemon for thread in threads] == [True]
