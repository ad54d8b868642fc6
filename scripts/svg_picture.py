"""An SVG picture on white, of the pictures that scripts draw for the documentation."""

from __future__ import annotations

from collections.abc import Sequence


def svg_picture(
    parts: Sequence[str], width: float, height: float, *, style: str, definitions: str
) -> str:
    """The text of a picture.

    Args:
        parts: elements, in the order in which they are drawn.
        width: in pixels.
        height: in pixels.
        style: CSS of the elements.
        definitions: elements that others refer to, such as markers.
    """
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style}</style>'
        f'<defs>{definitions}</defs><rect width="100%" height="100%" fill="#fff"/>\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )
