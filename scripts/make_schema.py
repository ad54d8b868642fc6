"""Writes missions/mission.schema.json from the model of a mission file.

Editors with a YAML language server complete and check missions from it. Run it after a change of
companion/mission/schema.py; a test compares the file with the model.

Usage: python scripts/make_schema.py
"""

from __future__ import annotations

import json
from pathlib import Path

from companion.mission.schema import json_schema

TARGET = Path(__file__).parent.parent / "missions" / "mission.schema.json"


def schema_text() -> str:
    """The file's content."""
    return json.dumps(json_schema(), indent=2) + "\n"


if __name__ == "__main__":
    TARGET.write_text(schema_text(), encoding="utf-8")
    print(f"wrote {TARGET}")
