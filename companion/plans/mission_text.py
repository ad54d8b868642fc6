"""Writes a drafted mission as YAML to read and edit; comments say where each part comes from."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from companion.errors import printable
from companion.plans.draft import Draft

COMMENTS = {
    "frame": "Positions are degrees (WGS 84); up_m is metres above home, amsl_m above the sea.",
    "limits": "What no setpoint ever leaves. Corners are [lat, lon].",
    "places": "at(X) holds within radius_m of X.",
    "sets": "What the parameters of skills range over.",
    "components": "Names for MAVLink component ids.",
    "skills": "What the vehicle can do.",
    "initially": "Facts that hold at the start.",
    "task": "What must hold: G always, F eventually. All lines hold together.",
    "otherwise": "When the world leaves no plan: return_home, land, hold, or {land_at: [places]}.",
}
FLAT = ("places", "fence", "corners", "keep_out")


def mission_text(draft: Draft, source: str) -> str:
    """The YAML text of a mission.

    Args:
        draft: the mission.
        source: what it was made from, in words.
    """
    root = CommentedMap()
    for key, value in draft.data.items():
        root[key] = _node(value, 1, key)
    lines = [f"Imported from {source}. Read it, and edit it, before it is flown.", ""]
    lines += [f"- {line}" for line in draft.notes]
    root.yaml_set_start_comment(printable("\n".join(lines)) + "\n")
    for key in root:
        if key in COMMENTS:
            root.yaml_set_comment_before_after_key(key, before="\n" + COMMENTS[key])
    places = root["places"]
    for name in places:
        places.yaml_add_eol_comment(printable(draft.items["places", name]), name)
    writer = YAML()
    writer.width = 4096  # keeps flow sequences of corners on one line
    text = io.StringIO()
    writer.dump(root, text)
    return text.getvalue()


def _node(value: Any, depth: int, key: str) -> Any:
    """A value with its style: each point and corner on one line."""
    if isinstance(value, Mapping):
        made = CommentedMap((k, _node(v, depth + 1, str(k))) for k, v in value.items())
        if key == "parameters" or "lat_deg" in value or "land_at" in value:
            made.fa.set_flow_style()
        return made
    if isinstance(value, list):
        listed = CommentedSeq(_node(item, depth + 1, "") for item in value)
        if not (value and isinstance(value[0], list)):
            listed.fa.set_flow_style()
        return listed
    return value
