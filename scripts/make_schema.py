"""Writes what is generated from models: missions/*.schema.json and tables of docs/run-folder.md.

With the schemas, editors with a YAML language server complete and check mission, scenario and
vehicle files. events.schema.json describes the lines of events.jsonl. Run it after a change of
companion/mission/schema.py, companion/vehicle_files.py, sitl/world/schema.py or
companion/flight_events; tests compare the files with the models.

Usage: python scripts/make_schema.py
"""

from __future__ import annotations

import json
from pathlib import Path

from companion import vehicle_files as vehicle
from companion.flight_events import description as events
from companion.mission import schema as mission
from sitl.world import schema as scenario

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "missions"
SCHEMAS = {
    "mission.schema.json": mission.json_schema,
    "scenario.schema.json": scenario.json_schema,
    "vehicle.schema.json": vehicle.json_schema,
    "events.schema.json": events.json_schema,
}
PAGE = ROOT / "docs" / "run-folder.md"


if __name__ == "__main__":
    for name, schema in SCHEMAS.items():
        (FOLDER / name).write_text(json.dumps(schema(), indent=2) + "\n", encoding="utf-8")
        print(f"wrote {FOLDER / name}")
    PAGE.write_text(events.with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"wrote the tables of {PAGE}")
