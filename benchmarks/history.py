"""Speed over the releases: the line of a release in history.csv, and the picture of all lines."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from report import PANELS

from collplan_study.report.figures import MARKS, OTHER_COLOURS, STYLE, add_caption, new_figure

HISTORY = Path(__file__).with_name("history.csv")
PICTURE = Path(__file__).parents[1] / "docs/pictures/bench_history.png"
FIGURES = [figure for shown in PANELS.values() for figure in shown]
COLUMNS = ("version", "commit", "date", "processor", *(figure.place for figure in FIGURES))

Line = Mapping[str, str]
"""A line of history.csv by column; a figure that was not measured is empty."""


def write_history(figures: Mapping[str, Any], history: Path = HISTORY, picture: Path = PICTURE) -> None:
    """Enters the figures of a `make bench` as the line of their version, and draws the picture anew."""
    line = line_of(figures)
    by_version = {each["version"]: each for each in read_history(history)} | {line["version"]: line}
    lines = list(by_version.values())
    with history.open("w", newline="", encoding="utf-8") as file:
        rows = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        rows.writeheader()
        rows.writerows(lines)
    draw(lines, picture)


def read_history(history: Path) -> list[Line]:
    """The lines of a file, oldest release first; none where there is no file."""
    if not history.exists():
        return []
    with history.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def line_of(figures: Mapping[str, Any]) -> Line:
    """The line of what runs/bench.json holds; what a skipped peer would have given is empty."""
    machine = figures["machine"]
    of_release = [figures["version"], figures["commit"] or "", machine["time"][:10], machine["processor"]]
    values = [figure.of(figures) for figure in FIGURES]
    texts = ["" if each is None else np.format_float_positional(each, 4, fractional=False, trim="-") for each in values]
    return dict(zip(COLUMNS, of_release + texts, strict=True))


@rc_context(STYLE)
def draw(lines: Sequence[Line], picture: Path) -> None:
    """Draws each figure over the releases that have it."""
    figure, releases = new_figure(9.6, 3.8), range(len(lines))
    machines = dict.fromkeys(line["processor"] for line in lines)
    for axes, (title, shown) in zip(figure.subplots(1, len(PANELS)), PANELS.items(), strict=True):
        for number, (column, name, _) in enumerate(shown):
            if any(line[column] for line in lines):
                values = [float(line[column] or "nan") for line in lines]
                colour = OTHER_COLOURS[number % len(OTHER_COLOURS)]
                axes.plot(releases, values, MARKS[number] + "-", color=colour, ms=4, lw=1, label=name)
        axes.set_yscale("log")
        axes.set_xticks(releases, [line["version"] for line in lines])
        axes.set_xlim(-0.5, len(lines) - 0.5)
        axes.set_title(title)
        axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.1))
    add_caption(figure, f"times depend on the machine: {', then '.join(machines)}")
    figure.savefig(picture, dpi=110)
