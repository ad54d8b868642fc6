#!/usr/bin/env python3
"""Flies every shipped mission in rough worlds, one campaign each, and sums up the outcomes.

The scenario of each mission gets wind with gusts, noise of GPS and lidar, an old battery, a lossy
link, lost answers of payloads, and times that come earlier or later. After 200 s an operator calls
the vehicle home, three times, because many missions have no end.

Usage: .venv/bin/python scripts/rough_missions.py DIR [--rows N] [--seed S] [--only NAME ...]

    DIR       for worlds, tables and reports; a campaign that is there is continued
    --rows    of all missions together (2000); long missions have fewer
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from companion.errors import TaskViolated

MISSIONS = Path(__file__).parents[1] / "missions"
LONG = {
    "endless_patrol": 0.3,
    "persistent_patrol": 0.3,
    "hall_of_20": 0.4,
    "orchard": 0.4,
    "night_watch": 0.5,
}
"""The share of rows of long missions, compared with the others."""
CALLED_HOME_S, CALLS = 200.0, 3
LIMIT_S = 600.0
ROUGH = {
    "wind.east_mps": [-4, 4],
    "wind.north_mps": [-4, 4],
    "wind.turbulence_mps": {"normal": [0.2, 0.15], "within": [0, 0.6]},
    "battery.resistance": [1, 1.5],
    "lidar.noise_m": [0, 0.1],
}


def rough_world(mission: Path) -> dict[str, Any]:
    """The scenario of a mission, with its factors."""
    path = mission.with_suffix(".sim.yaml")
    world: dict[str, Any] = {"version": 1}
    if path.exists():
        world = YAML(typ="safe").load(path.read_text(encoding="utf-8"))
    if isinstance(world.get("map"), str):
        world["map"] = str(MISSIONS / world["map"])
    vary: dict[str, Any] = dict(ROUGH)
    capacity = world.get("battery", {}).get("capacity", 1)
    vary["battery.capacity"] = [0.85 * capacity, capacity]
    happens = world.setdefault("happens", [])
    for number, entry in enumerate(happens):
        if "at_s" in entry:
            vary[f"happens.{number}.at_s"] = [0.5 * entry["at_s"], 1.5 * entry["at_s"]]
        else:
            vary[f"happens.{number}.after_s"] = [0, 2 * entry.get("after_s", 0) + 2]
    for number, _ in enumerate(world.get("payload", {}).get("answers", [])):
        vary[f"payload.answers.{number}.lost"] = {"chance": 0.1}
    vary[f"happens.{len(happens)}.link.loss"] = [0, 0.2]
    happens.append({"at_s": 0.5, "link": {"port": "companion", "loss": 0}})
    vary[f"happens.{len(happens)}.gps.noise_m"] = [0, 0.3]
    happens.append({"at_s": 0.5, "gps": {"noise_m": 0.1}})
    for again_s in range(CALLS):  # one may be lost on the link
        at_s = CALLED_HOME_S + 2 * again_s
        happens.append({"at_s": at_s, "operator": "MAV_CMD_NAV_RETURN_TO_LAUNCH"})
    return world | {"vary": vary}


def shares(names: list[str], rows: int) -> dict[str, int]:
    """The number of rows of each mission."""
    weights = {name: LONG.get(name, 1.0) for name in names}
    return {name: max(1, round(rows * w / sum(weights.values()))) for name, w in weights.items()}


def fly(mission: Path, rows: int, seed: int, out: Path) -> Counter[str]:
    """Flies a mission's rows; returns their outcomes. Table and report are written to `out`."""
    if (out / "rows.jsonl").exists():
        options = ["--resume", str(out)]
    else:
        scenario = out.parent / f"{mission.stem}.sim.yaml"
        with scenario.open("w", encoding="utf-8") as stream:
            YAML().dump(rough_world(mission), stream)
        options = ["--scenario", str(scenario), "--runs", str(rows), "--seed", str(seed)]
        options += ["--limit-s", str(LIMIT_S), "--out", str(out)]
    command = [sys.executable, "-m", "companion", "campaign", str(mission), *options]
    if (code := subprocess.run(command, check=False).returncode) not in (0, TaskViolated.exit_code):
        sys.exit(code)
    with (out / "table.csv").open(encoding="utf-8", newline="") as stream:
        rows_read = csv.DictReader(line for line in stream if not line.startswith("#"))
        return Counter(row["outcome"] for row in rows_read)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("directory", type=Path)
    parser.add_argument("--rows", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=[])
    arguments = parser.parse_args()
    arguments.directory.mkdir(parents=True, exist_ok=True)
    missions = [p for p in sorted(MISSIONS.glob("*.yaml")) if not p.name.endswith(".sim.yaml")]
    counts = shares([mission.stem for mission in missions], arguments.rows)
    for mission in missions:
        if not arguments.only or mission.stem in arguments.only:
            out = arguments.directory / mission.stem
            ended = fly(mission, counts[mission.stem], arguments.seed, out)
            kinds = ", ".join(f"{count} {kind}" for kind, count in ended.most_common())
            print(f"{mission.stem}: {kinds}", flush=True)


if __name__ == "__main__":
    main()
