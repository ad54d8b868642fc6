"""Which labels of a drawing touch an edge, a state or another label."""

from __future__ import annotations

from playwright.sync_api import Page

MEETINGS = """selector => [...document.querySelectorAll(selector)].flatMap((drawing) => {
  const shown = (each) => each.getClientRects().length && each.getBoundingClientRect().width;
  const texts = [...drawing.querySelectorAll('text')].filter((each) => shown(each));
  const isLabel = (each) => !/^\\d+$/.test(each.textContent) && !each.classList.contains('t');
  const points = [...drawing.querySelectorAll('path, circle')]
    .filter((each) => !each.closest('marker, defs')).flatMap((each) => {
      const matrix = each.getScreenCTM(), length = each.getTotalLength();
      return Array.from({ length: Math.ceil(length) + 1 },
        (_, i) => each.getPointAtLength(i).matrixTransform(matrix));
    });
  return texts.filter(isLabel).flatMap((text) => {
    const { left, right, top, bottom } = text.getBoundingClientRect(), trim = (bottom - top) / 5;
    const inside = ({ x, y }) => x > left && x < right && y > top + trim && y < bottom - trim;
    const others = texts.filter((other) => other !== text).map((o) => o.getBoundingClientRect());
    const meets = others.some((o) => o.left < right && o.right > left
      && o.top + trim < bottom - trim && o.bottom - trim > top + trim);
    return points.some(inside) || meets ? [text.textContent] : [];
  });
})"""
"""The height of a line of text has room above and below its letters: a fifth is left out."""


def touched_labels(page: Page, selector: str) -> list[str]:
    """The labels of the drawings that a selector names."""
    return [str(label) for label in page.evaluate(MEETINGS, selector)]
