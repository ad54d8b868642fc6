"""The SVG frame, with a white background, of the pictures that scripts draw for the docs."""

from __future__ import annotations

from collections.abc import Sequence


def svg_picture(
    parts: Sequence[str], width: float, height: float, *, style: str, definitions: str
) -> str:
    """The text of a picture.

    Args:
        parts: elements, in drawing order.
        width: in pixels.
        height: in pixels.
        style: CSS of the elements.
        definitions: elements to which others refer, such as markers.
    """
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style}</style>'
        f'<defs>{definitions}</defs><rect width="100%" height="100%" fill="#fff"/>\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )
