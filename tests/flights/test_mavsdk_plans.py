"""MAVSDK, as an authority from outside, reads the .plan files that are exported."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from plan_files import RETURN, TAKE_OFF, imported, item, plan, polygon, square, waypoint
from test_mavsdk_client import port, within
from test_mavsdk_missions import Make, connected

from companion import load_mission
from companion.api.drawings import mission_drawing
from companion.plans.qgc_writing import plan_text

from mavsdk.asyncio.plugins.mission_raw import MissionRawAsync  # isort: skip

__all__ = ["port"]

pytestmark = pytest.mark.sockets

WAY = (waypoint(30, 0, hold_s=4), waypoint(30, 40, 35.0), waypoint(0, 40))
FENCE = [polygon(square(90)), polygon(square(6, north_m=-40), inclusion=False)]


@pytest.mark.parametrize("last", [RETURN, item(177, 2, -1, frame=2)])
def test_mavsdk_imports_an_exported_plan(last: dict[str, Any], port: int, tmp_path: Path) -> None:
    way = WAY if last is RETURN else [waypoint(30, 0), *WAY[1:]]
    content = plan(TAKE_OFF, *way, last, polygons=FENCE)
    mission = load_mission(imported(tmp_path, content)[0])
    text = plan_text(mission_drawing(mission, None))
    read: list[Any] = []

    async def read_it(make: Make) -> None:
        raw = make(MissionRawAsync)
        read.append(await within(raw.import_qgroundcontrol_mission_from_string(text)))

    asyncio.run(connected(port, read_it))
    (data,) = read
    commands = [each.command for each in data.mission_items]
    assert commands[:4] == [22, 16, 16, 16]
    wanted = [entry["params"] for entry in way]
    for found, params in zip(data.mission_items[1:4], wanted, strict=True):
        if last is RETURN:
            assert (found.x / 1e7, found.y / 1e7) == pytest.approx(params[4:6], abs=2e-7)
            assert (found.z, found.param1) == pytest.approx((params[6], params[0]))
    assert [each.command for each in data.geofence_items] == [5001] * 4 + [5002] * 4
    assert list(data.rally_items) == []
