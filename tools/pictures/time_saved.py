"""time_saved.png: time that `bounce` saves against the other strategies, by family of worlds, from docs/results.md."""

import re
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer

from drawing import CHOICE, DPI, FAINT, OBSTACLE, TEXT, new_figure, save

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results.md"
HEADING = "Deliberate bounces"
OTHERS = {"tolerate": "#2f7fc1", "avoid": CHOICE, "stop_guarantee": "#8e3fa8"}
"""The strategies compared with, and their colors."""
MARKS = {"tolerate": "s", "avoid": "o", "stop_guarantee": "D"}
APART = 0.22
"""Between the strategies of one family [rows]."""

ESTIMATE = re.compile(r"(-?\d+(?:\.\d+)?) \[(-?\d+(?:\.\d+)?), (-?\d+(?:\.\d+)?)\]")
"""A value and its interval, as in 5.5 [4.5, 6.5]."""


def time_saved(text: str) -> dict[str, list[tuple[float, ...]]]:
    """Time saved in each family against each of the other strategies in turn, value and interval [%].

    Raises:
        ValueError: `text`, that of docs/results.md, has no such table.
    """
    section = text.partition(f"\n## {HEADING}\n")[2].partition("\n## ")[0]
    table = section.partition(" | ".join(f"against `{name}`" for name in OTHERS))[2].partition("\n\n")[0]
    rows = {line.split("|")[1].strip(): ESTIMATE.findall(line) for line in table.splitlines()[2:]}
    if not rows or any(len(found) != len(OTHERS) for found in rows.values()):
        raise ValueError(f"section {HEADING!r}: expected a table of the time saved against {', '.join(OTHERS)}")
    return {worlds: [tuple(map(float, each)) for each in found] for worlds, found in rows.items()}


def draw(path: Path, dpi: int = DPI, results: Path = RESULTS) -> dict[str, ErrorbarContainer]:
    """Writes the picture; what is drawn, by the strategy compared with."""
    saved = time_saved(results.read_text(encoding="utf-8"))
    figure = new_figure(4.6)
    axes = figure.subplots()
    places = -np.arange(len(saved), dtype=float)
    drawn = {
        name: _draw_column(axes, places + (1 - k) * APART, [row[k] for row in saved.values()], name)
        for k, name in enumerate(OTHERS)
    }
    _label(axes, places, list(saved))
    save(figure, path, dpi)
    return drawn


def _draw_column(axes: Axes, places: np.ndarray, column: list[tuple[float, ...]], name: str) -> ErrorbarContainer:
    values, low, high = np.array(column).T
    return axes.errorbar(
        values,
        places,
        xerr=np.stack([values - low, high - values]),
        fmt=MARKS[name],
        color=OTHERS[name],
        markersize=5.0,
        elinewidth=1.8,
        capsize=2.5,
        label=f"against {name}",
        zorder=3,
    )


def _label(axes: Axes, places: np.ndarray, worlds: list[str]) -> None:
    axes.axvline(0.0, color=TEXT, linewidth=1.0, zorder=2)
    for place in places[:-1]:
        axes.axhline(place - 0.5, color=OBSTACLE, linewidth=0.8, zorder=1)
    axes.axhspan(0.5, -0.5, color="#f4f5f7", zorder=0)
    axes.set_yticks(places, [name.replace(" together ", "\ntogether ") for name in worlds])
    axes.set_ylim(places[-1] - 0.5, 0.5)
    axes.tick_params(axis="y", length=0, labelcolor=TEXT)
    axes.grid(axis="x", color=OBSTACLE, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.set_xlabel("time saved by bounce [%], with 95 % intervals;   slower  ←  0  →  faster")
    axes.set_title("Time to the goal saved by deliberate bounces, by family of worlds (simulated)")
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(FAINT)
    axes.legend(loc="upper right", frameon=True, facecolor="white", edgecolor="none")
