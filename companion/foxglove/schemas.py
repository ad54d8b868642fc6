"""The Foxglove schemas of a run's messages, as JSON Schema.

Foxglove chooses the panel for a message by the name of its schema, and reads the documented fields.
Only the fields that we write are here. All of them are required, except those of LocationFix that
may be unknown.

Source: https://docs.foxglove.dev/docs/sdk/schemas, field by field.
"""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]

NUMBER: Schema = {"type": "number"}
INTEGER: Schema = {"type": "integer"}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}


def _object(**fields: Schema) -> Schema:
    """An object in which each of these fields is required."""
    return {"type": "object", "properties": fields, "required": list(fields)}


def _list(of: Schema) -> Schema:
    return {"type": "array", "items": of}


def _choice(*names: str) -> Schema:
    """One of the numbers of an enumeration, from 0."""
    return {
        "type": "integer",
        "oneOf": [{"const": number, "title": name} for number, name in enumerate(names)],
    }


TIME = _object(
    sec={"type": "integer", "minimum": 0},
    nsec={"type": "integer", "minimum": 0, "maximum": 999_999_999},
)
VECTOR = _object(x=NUMBER, y=NUMBER, z=NUMBER)
QUATERNION = _object(x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
COLOR = _object(r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
POSE = _object(position=VECTOR, orientation=QUATERNION)

_ARROW = _object(
    pose=POSE,
    shaft_length=NUMBER,
    shaft_diameter=NUMBER,
    head_length=NUMBER,
    head_diameter=NUMBER,
    color=COLOR,
)
_SOLID = _object(pose=POSE, size=VECTOR, color=COLOR)
_CYLINDER = _object(pose=POSE, size=VECTOR, bottom_scale=NUMBER, top_scale=NUMBER, color=COLOR)
_LINE = _object(
    type=_choice("LINE_STRIP", "LINE_LOOP", "LINE_LIST"),
    pose=POSE,
    thickness=NUMBER,
    scale_invariant=FLAG,
    points=_list(VECTOR),
    color=COLOR,
    colors=_list(COLOR),
    indices=_list(INTEGER),
)
_TRIANGLES = _object(
    pose=POSE, points=_list(VECTOR), color=COLOR, colors=_list(COLOR), indices=_list(INTEGER)
)
_LABEL = _object(
    pose=POSE, billboard=FLAG, font_size=NUMBER, scale_invariant=FLAG, color=COLOR, text=TEXT
)
_MODEL = _object(
    pose=POSE,
    scale=VECTOR,
    color=COLOR,
    override_color=FLAG,
    url=TEXT,
    media_type=TEXT,
    data={"type": "string", "contentEncoding": "base64"},
)
_ENTITY = _object(
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=TIME,
    frame_locked=FLAG,
    metadata=_list(_object(key=TEXT, value=TEXT)),
    arrows=_list(_ARROW),
    cubes=_list(_SOLID),
    spheres=_list(_SOLID),
    cylinders=_list(_CYLINDER),
    lines=_list(_LINE),
    triangles=_list(_TRIANGLES),
    texts=_list(_LABEL),
    models=_list(_MODEL),
)
_DELETION = _object(timestamp=TIME, type=_choice("MATCHING_ID", "ALL"), id=TEXT)

SCHEMAS: dict[str, Schema] = {
    "foxglove.FrameTransform": _object(
        timestamp=TIME,
        parent_frame_id=TEXT,
        child_frame_id=TEXT,
        translation=VECTOR,
        rotation=QUATERNION,
    ),
    "foxglove.GeoJSON": _object(geojson=TEXT),
    "foxglove.LocationFix": _object(
        timestamp=TIME,
        frame_id=TEXT,
        latitude=NUMBER,
        longitude=NUMBER,
        altitude=NUMBER,
        position_covariance={**_list(NUMBER), "minItems": 9, "maxItems": 9},
        position_covariance_type=_choice("UNKNOWN", "APPROXIMATED", "DIAGONAL_KNOWN", "KNOWN"),
    ),
    "foxglove.Log": _object(
        timestamp=TIME,
        level=_choice("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"),
        message=TEXT,
        name=TEXT,
        file=TEXT,
        line={"type": "integer", "minimum": 0},
    ),
    "foxglove.PoseInFrame": _object(timestamp=TIME, frame_id=TEXT, pose=POSE),
    "foxglove.PosesInFrame": _object(timestamp=TIME, frame_id=TEXT, poses=_list(POSE)),
    "foxglove.SceneUpdate": _object(deletions=_list(_DELETION), entities=_list(_ENTITY)),
}
"""Name -> schema."""
