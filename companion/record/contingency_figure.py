"""The table of contingencies as a picture: a row for each change, a column for each position.

Each verdict has a colour and a letter, so the picture can also be read without colours. The table
comes as letters: this module does not know how it was made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

ROW_INCHES, COLUMN_INCHES = 0.2, 0.32
LABEL_INCHES, FOOT_INCHES = 4.2, 2.0
MOST_INCHES = 200.0
"""Greatest height in inches: more than anybody scrolls, and still a valid image file."""
DPI = 110
COLOURS = ("#c7dcef", "#7fb3d5", "#f4d58d", "#f0a35e", "#d98c8c", "#b9a7c9", "#c22f3d")
"""Colours of the legend's entries, in their order."""


@dataclass(frozen=True)
class ContingencyChart:
    """The content of the picture.

    Attributes:
        title: above the table.
        columns: label of each position.
        rows: label of each change.
        cells: by row and column, a letter; None where there is no contingency.
        legend: what each letter means.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[str]
    cells: Mapping[tuple[int, int], str]
    legend: Mapping[str, str]


def draw_contingencies(chart: ContingencyChart, path: Path) -> None:
    """Draws a table to a PNG file.

    Raises:
        OSError: it cannot be written.
    """
    height = min(MOST_INCHES, FOOT_INCHES + ROW_INCHES * len(chart.rows))
    width = LABEL_INCHES + max(3.0, COLUMN_INCHES * len(chart.columns))
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    letters = list(chart.legend)
    values = np.full((len(chart.rows), len(chart.columns)), np.nan)
    for (row, column), letter in chart.cells.items():
        values[row, column] = letters.index(letter)
        axis.text(column, row, letter, ha="center", va="center", fontsize=7)
    colours = ListedColormap(COLOURS[: len(letters)])
    axis.imshow(values, cmap=colours, vmin=-0.5, vmax=len(letters) - 0.5, aspect="auto")
    axis.set_xticks(range(len(chart.columns)), chart.columns, rotation=90, fontsize=7)
    axis.set_yticks(range(len(chart.rows)), chart.rows, fontsize=7)
    axis.set_xticks(np.arange(-0.5, len(chart.columns)), minor=True)
    axis.set_yticks(np.arange(-0.5, len(chart.rows)), minor=True)
    axis.grid(which="minor", color="white", linewidth=1.0)
    axis.tick_params(which="both", length=0)
    axis.set_title(chart.title, fontsize=9, loc="right")
    patches = [
        Patch(facecolor=colour, label=f"{letter}  {meaning}")
        for colour, (letter, meaning) in zip(COLOURS, chart.legend.items(), strict=False)
    ]
    figure.legend(handles=patches, loc="outside lower left", ncols=2, fontsize=7, frameon=False)
    figure.savefig(path, dpi=DPI)
