"""Two vehicles on one machine: two simulators, two companions, two missions, one ground station.

As docs/simulator.md has it, on ports that are free:

    sitl -i 0 --scenario missions/surveillance.sim.yaml
    sitl -i 1 --scenario missions/surveillance.sim.yaml
    companion run --connect udpin://0.0.0.0:14540 --log-dir runs/first
    companion run --connect udpin://0.0.0.0:14541 --log-dir runs/second
    companion upload missions/surveillance.yaml --system 1 --start
    companion upload missions/surveillance.yaml --system 2 --start
    companion watch --system 2
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from ports import free_instance, own_ports
from test_sockets import COMPANION, GROUND_STATION, START_S, Run, run
from test_uploads import ANSWER_S, MISSION, like_the_papers

__all__ = ["run"]
pytestmark = pytest.mark.sockets


def test_each_flies_its_own_mission(run: Run, tmp_path: Path) -> None:
    first = free_instance()
    ports = own_ports(first)
    _, _, *shared_port = ports
    second = free_instance(besides=first)
    ground = f"udpin://127.0.0.1:{GROUND_STATION + first}"
    scenario = MISSION.with_suffix(".sim.yaml")
    run("sitl", *ports, "--scenario", scenario).until_printed("companion on", START_S)
    other = run("sitl", "-i", second, *shared_port, "--scenario", scenario)
    other.until_printed("companion on", START_S)
    on_board = {}
    for instance in (first, second):
        connect = f"udpin://127.0.0.1:{COMPANION + instance}"
        options = ("--log-dir", tmp_path / str(instance), "--monitor", "off")
        on_board[instance] = run("companion", "run", "--connect", connect, *options)
        on_board[instance].until_printed("hosting", START_S)
    sites = {first: "A", second: "r2"}
    missions = {
        instance: like_the_papers(tmp_path, f"to_{site}", f"F at({site}) & F G at(Home)")
        for instance, site in sites.items()
    }
    upload = ("companion", "upload", missions[first], "--connect", ground, "--start")
    unclear = run(*upload)
    assert unclear.exit_code(ANSWER_S) == 4
    numbers = ", ".join(str(1 + instance) for instance in sorted(sites))
    assert f"several vehicles on {ground}: systems {numbers}" in unclear.printed
    for instance in sites:
        upload = ("companion", "upload", missions[instance], "--connect", ground, "--start")
        sent = run(*upload, "--system", 1 + instance)
        assert sent.exit_code(ANSWER_S) == 0, sent.printed + on_board[instance].printed
    watch = run("companion", "watch", "--connect", ground, "--system", 1 + second)
    assert watch.exit_code(ANSWER_S) == 0, watch.printed
    assert f"of system {1 + second}" in watch.printed
    for instance, site in sites.items():
        on_board[instance].until_printed("task satisfied", ANSWER_S)
        reached = re.findall(r" at (\w+)$", on_board[instance].printed, re.MULTILINE)
        assert reached == [site, "Home"], on_board[instance].printed
