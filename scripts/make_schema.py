"""Writes missions/*.schema.json from the models of mission, scenario and vehicle files.

Editors with a YAML language server complete and check the files from them. Run it after a change
of companion/mission/schema.py, companion/vehicle_files.py or sitl/world/schema.py; tests compare
the files with the models.

Usage: python scripts/make_schema.py
"""

from __future__ import annotations

import json
from pathlib import Path

from companion import vehicle_files as vehicle
from companion.mission import schema as mission
from sitl.world import schema as scenario

FOLDER = Path(__file__).parent.parent / "missions"
SCHEMAS = {
    "mission.schema.json": mission.json_schema,
    "scenario.schema.json": scenario.json_schema,
    "vehicle.schema.json": vehicle.json_schema,
}


if __name__ == "__main__":
    for name, schema in SCHEMAS.items():
        (FOLDER / name).write_text(json.dumps(schema(), indent=2) + "\n", encoding="utf-8")
        print(f"wrote {FOLDER / name}")
