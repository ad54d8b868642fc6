"""Writes rows as scenario files, each with the command that repeats it.

A case is the scenario without `vary`, with the values of a row, so `companion sim` flies it like
any other scenario.
"""

from __future__ import annotations

import io
import os
import re
import shlex
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap

from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.table import write_whole
from companion.flights.simulated_world import world_alone

if TYPE_CHECKING:
    from companion.flights.simulated_world import VariedScenario

FAILURES, WORST = "failures", "worst"
BLOCK_DEPTH = 2
"""From this depth on, a mapping is written on one line."""


@dataclass(frozen=True, slots=True)
class Case:
    """A row as a scenario file.

    Attributes:
        flown: the row.
        file: its scenario.
        line: the command that repeats it.
    """

    flown: FlownRow
    file: Path
    line: str


def simplifiable(kit: Kit) -> Kit:
    """The same kit, in whose rows any entry of `happens` may be left out."""
    return replace(kit, scenario=kit.scenario.with_optional_events())


def write_cases(
    kit: Kit, mission: Path, folder: Path, failures: Iterable[FlownRow]
) -> tuple[Case, ...]:
    """Writes the scenario of each failure of a search to DIR/failures/N-KIND.sim.yaml.

    Args:
        kit: mission and scenario of the rows.
        mission: its file, as the user named it.
        folder: the folder of the campaign.
        failures: after minimising.
    """
    return tuple(
        write_case(kit, mission, folder / FAILURES / f"{number}-{_name(flown.kind)}", flown)
        for number, flown in enumerate(failures, 1)
    )


def write_worst(
    kit: Kit, mission: Path, folder: Path, flown: Iterable[FlownRow]
) -> tuple[Case, ...]:
    """Writes the scenarios of some rows to DIR/worst/INDEX.sim.yaml; see `write_cases`."""
    return tuple(
        write_case(kit, mission, folder / WORST / str(each.row.index), each) for each in flown
    )


def write_case(kit: Kit, mission: Path, name: Path, flown: FlownRow) -> Case:
    """Writes the scenario of a row, as NAME.sim.yaml."""
    file = name.with_name(f"{name.name}.sim.yaml")
    options = ["--scenario", file, "--seed", flown.row.seed, "--speed", "max"]
    line = shlex.join(map(str, ["companion", "sim", mission, *options]))
    write_whole(file, _text(kit, flown, file, line))
    return Case(flown, file, line)


def _name(kind: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", kind.lower()).strip("-")


def _text(kit: Kit, flown: FlownRow, file: Path, line: str) -> str:
    data = CommentedMap()
    for key, value in scenario_data(kit, flown, file.parent).items():
        data[key] = _styled(value)
    where = f", while {flown.phase}, near {flown.place}" if flown.place else ""
    told = f"{flown.kind or flown.outcome.value}{where}\n{flown.reason}\n\n    {line}\n"
    if flown.outcome is RowOutcome.LIMIT:
        told += f"\nIt is cut off after {kit.limit_s:g} s in the campaign; that command flies on.\n"
    data.yaml_set_start_comment(told)
    writer = YAML()
    writer.width = 4096
    text = io.StringIO()
    writer.dump(data, text)
    return text.getvalue()


def scenario_data(kit: Kit, flown: FlownRow, folder: Path) -> dict[str, Any]:
    """The scenario of a row, as the content of a file in a folder."""
    scenario: VariedScenario = kit.scenario
    data = scenario.data_with(flown.row.values)
    if data.get("map") is None:
        data = {**world_alone(kit.mission), **{k: v for k, v in data.items() if k != "map"}}
    if isinstance(data.get("map"), str):
        map_file = (scenario.folder / data["map"]).resolve()
        data["map"] = os.path.relpath(map_file, folder.resolve())
    return data


def _styled(value: Any, depth: int = 1) -> Any:
    """A value, with its inner mappings set to be written on one line each."""
    if isinstance(value, list) and depth < BLOCK_DEPTH:
        return [_styled(item, depth + 1) for item in value]
    if isinstance(value, dict):
        made = CommentedMap((k, _styled(v, depth + 1)) for k, v in value.items())
        made.fa.set_flow_style()
        return made
    return value
