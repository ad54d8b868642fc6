"""The report of a campaign: DIR/report.html, a self-contained page.

It has no script, no external font or picture, no date and no machine name: like the table, it
follows from the rows alone. Parts that open are `details` elements, so a keyboard is enough.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from companion.campaigns.campaign import Campaign
from companion.campaigns.cases import write_worst
from companion.campaigns.charts import histogram, rate_bar, scatter
from companion.campaigns.factor_effects import FactorEffect, effects
from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.pictures import Pictures
from companion.campaigns.statistics import Rate
from companion.campaigns.summary import summary
from companion.campaigns.table import write_whole

NAME = "report.html"
WORST = 10
MOST_LISTED = 12
STYLES = (
    Path(__file__).parents[1] / "monitor" / "static" / "palette.css",  # the monitor page's
    Path(__file__).parent / "static" / "report.css",
)


@dataclass(frozen=True)
class ReportSource:
    """The input of a report.

    Attributes:
        kit: mission and scenario.
        header: the header of the table.
        flown: all rows.
        command: makes the table again.
        repeating: row -> the command that flies it again.
        is_search: whether a search chose the rows, so that their shares are no rates.
    """

    kit: Kit
    header: Mapping[str, str]
    flown: Sequence[FlownRow]
    command: str
    repeating: Mapping[int, str]
    is_search: bool = False

    @property
    def valid(self) -> list[FlownRow]:
        """The rows that count."""
        return [each for each in self.flown if each.outcome.is_valid]

    @property
    def worst(self) -> list[FlownRow]:
        """The rows with the least score."""
        return worst_of(self.flown)


def worst_of(flown: Iterable[FlownRow]) -> list[FlownRow]:
    """The rows with the least score, the worst first."""
    valid = (each for each in flown if each.outcome.is_valid)
    return sorted(valid, key=lambda each: (each.score, each.row.index))[:WORST]


def write_report(campaign: Campaign, mission: Path, command: str, is_search: bool = False) -> Path:
    """Writes the report of a campaign and the scenarios of its worst rows; returns its path.

    Args:
        campaign: with all its rows flown.
        mission: its file, as the user named it.
        command: makes the table again.
        is_search: whether a search chose the rows.
    """
    kit, rows = campaign.kit, campaign.rows
    worst = write_worst(kit, mission, campaign.folder, worst_of(rows))
    repeating = {case.flown.row.index: case.line for case in worst}
    source = ReportSource(kit, campaign.header, rows, command, repeating, is_search)
    write_whole(path := campaign.folder / NAME, report_html(source))
    return path


def report_html(source: ReportSource) -> str:
    """The page."""
    name = escape(source.kit.mission.name)
    found = effects(source.kit.factors, source.valid)
    pictures = Pictures(source.kit)
    sections = (
        _section("How the rows ended", _verdicts(source)),
        _section(f"The worst {len(source.worst)}", _worst(source, pictures)),
        _section("Failures", _failures(source)),
        _section("What matters most", _what_matters(found, source)),
        _section("Margins and durations", _distributions(source)),
        _section("What was sampled", _sampled(source)),
        _section("To repeat it", _repeating(source)),
    )
    style = "".join(path.read_text(encoding="utf-8") for path in STYLES)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{name}: campaign</title><style>{style}</style></head>"
        f"<body>{pictures.symbol}<header><h1>{name}: {_flights(source)}</h1>"
        f'<p class="quiet">{_headline(source)}</p></header><main>{"".join(sections)}</main>'
        "</body></html>\n"
    )


def _flights(source: ReportSource) -> str:
    count = len(source.flown)
    return f"{count} flight{'s' * (count != 1)}"


def _headline(source: ReportSource) -> str:
    failed = sum(each.is_failure for each in source.valid)
    invalid = len(source.flown) - len(source.valid)
    unfair = f"; unfair, and not counted: {invalid} more" if invalid else ""
    return f"{failed} of {len(source.valid)} failed{unfair}."


def _verdicts(source: ReportSource) -> str:
    rows = []
    for name, count, is_failure in summary(source.flown):
        shown = ["", ""]
        if name != RowOutcome.INVALID.value and not source.is_search:
            rate = Rate.of(count, len(source.valid))
            shown = [f"{rate}", rate_bar(rate)]
        label = f'<span class="failed">{escape(name)}</span>' if is_failure else escape(name)
        rows.append([label, str(count), *shown])
    note = (
        "A search has chosen the rows: their shares say nothing of how often the mission fails."
        if source.is_search
        else "Shares of the rows that count, with exact 95 % intervals (Clopper and Pearson)."
    )
    heads = ["outcome", "rows", "share", "interval"]
    return _table(heads, rows, numbers={1}, label="outcomes") + f'<p class="quiet">{note}</p>'


def _worst(source: ReportSource, pictures: Pictures) -> str:
    if not source.valid:
        return "<p>No row counts.</p>"
    return "".join(
        f"<details{' open' if i == 0 else ''}><summary>Row {each.row.index}: {_verdict(each)}, "
        f"score {each.score:g}</summary>{pictures.picture(each)}{_about(each, source)}</details>"
        for i, each in enumerate(source.worst)
    )


def _verdict(flown: FlownRow) -> str:
    if flown.kind:
        return f'<span class="failed">{escape(flown.kind)}</span>'
    return escape(flown.outcome.value)


def _about(flown: FlownRow, source: ReportSource) -> str:
    where = f"{flown.phase}, near {flown.place}" if flown.place else "not flown"
    told = [f"<p>{escape(flown.reason)}</p>"] if flown.reason else []
    told.append(f'<p class="quiet">{escape(where)}; {flown.duration_s:g} s, {_margins(flown)}</p>')
    values = ", ".join(f"{path} = {value}" for path, value in flown.row.values.items())
    told.append(f"<p><code>{escape(values or 'the scenario as it stands')}</code></p>")
    if line := source.repeating.get(flown.row.index):
        told.append(f"<p>To fly it again: <code>{escape(line)}</code></p>")
    return "".join(told)


def _margins(flown: FlownRow) -> str:
    left = {
        "clearance": flown.margins.clearance_m,
        "fence": flown.margins.fence_m,
        "altitude": flown.margins.altitude_m,
    }
    told = [f"{name} {metres:.2f} m" for name, metres in left.items() if metres is not None]
    charge = flown.margins.charge
    return ", ".join([*told, f"charge {charge:.0%}"] if charge is not None else told)


def _failures(source: ReportSource) -> str:
    failed = [each for each in source.valid if each.is_failure]
    if not failed:
        return "<p>None.</p>"
    by: dict[str, Callable[[FlownRow], str]] = {
        "kind": lambda each: each.kind,
        "phase": lambda each: each.phase or "not flown",
        "place": lambda each: each.place or "not flown",
    }
    tables = []
    for name, key in by.items():
        counts = Counter(map(key, failed)).most_common()
        rows = [[escape(what), str(count)] for what, count in sorted(counts, key=_by_count)]
        tables.append(_table([name, "failures"], rows, numbers={1}, label=f"failures by {name}"))
    return f'<div class="side">{"".join(tables)}</div>'


def _by_count(entry: tuple[str, int]) -> tuple[int, str]:
    return -entry[1], entry[0]


def _what_matters(found: Sequence[FactorEffect], source: ReportSource) -> str:
    if not found:
        return "<p>Nothing but the seed varies.</p>"
    rows = []
    for each in found[:MOST_LISTED]:
        correlation = "" if each.correlation is None else f"{each.correlation:+.2f}"
        groups = (f"{escape(name)}: {failed} of {total}" for name, failed, total in each.groups)
        rows.append([f"<code>{escape(each.path)}</code>", correlation, "; ".join(groups)])
    heads = ["factor", "rank correlation", "failures in each quarter, or for each value"]
    table = _table(heads, rows, numbers={1}, label="what matters most")
    numeric = [each for each in found if each.correlation is not None][:2]
    if len(numeric) < 2:
        return table + _NOTE
    one, other = (each.path for each in numeric)
    points = [
        (float(r.row.values[one]), float(r.row.values[other]), r.is_failure) for r in source.valid
    ]
    return table + _NOTE + scatter(points, (one, other))


_NOTE = (
    '<p class="quiet">Rank correlation (Spearman) of a factor with the score: below 0, the more of '
    "it, the less margin.</p>"
)


def _distributions(source: ReportSource) -> str:
    clearances = [c for r in source.valid if (c := r.margins.clearance_m) is not None]
    durations = [each.duration_s for each in source.valid if each.duration_s]
    charts = []
    if clearances:
        title = "least clearance of a flight; left of the line it has hit something"
        charts.append(histogram(clearances, "m", title, limit=0.0))
    if durations:
        charts.append(histogram(durations, "s", "duration of a flight, simulated"))
    return f'<div class="side">{"".join(charts)}</div>' if charts else "<p>Nothing was flown.</p>"


def _sampled(source: ReportSource) -> str:
    rows = []
    for factor in source.kit.factors:
        values = [each.row.values[factor.path] for each in source.flown]
        numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
        span = f"{min(numbers):g} to {max(numbers):g}" if numbers else ""
        rows.append([f"<code>{escape(factor.path)}</code>", escape(str(factor.distribution)), span])
    if not rows:
        return "<p>The seed of wind, sensors and links.</p>"
    return _table(["factor", "distribution", "sampled"], rows, label="ranges")


def _repeating(source: ReportSource) -> str:
    rows = [[escape(key), f"<code>{escape(value)}</code>"] for key, value in source.header.items()]
    return (
        f"<p><code>{escape(source.command)}</code></p><details><summary>What the rows depend on"
        f"</summary>{_table(['line', 'value'], rows, label='header')}</details>"
    )


def _section(title: str, inside: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{inside}</section>"


def _table(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    numbers: Iterable[int] = (),
    label: str = "",
) -> str:
    """A table of HTML cells, which scrolls if it is too wide."""
    right = set(numbers)

    def line(tag: str, cells: Sequence[str]) -> str:
        made = (
            f'<{tag} class="number">{cell}</{tag}>' if i in right else f"<{tag}>{cell}</{tag}>"
            for i, cell in enumerate(cells)
        )
        return f"<tr>{''.join(made)}</tr>"

    body = "".join(line("td", cells) for cells in rows)
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(label)}"><table>'
        f"<thead>{line('th', heads)}</thead><tbody>{body}</tbody></table></div>"
    )
