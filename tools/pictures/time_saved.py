"""time_saved.png: time that `bounce` saves against the other strategies, by family of worlds, from docs/results.md."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer

from drawing import CHOICE, DPI, FAINT, OBSTACLE, TEXT, new_figure, save
from results_tables import Estimate, estimate, read_table

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results.md"
HEADING = "Deliberate bounces"
OTHERS = {"tolerate": "#2f7fc1", "avoid": CHOICE, "stop_guarantee": "#8e3fa8"}
"""The strategies compared with, and their colors."""
MARKS = {"tolerate": "s", "avoid": "o", "stop_guarantee": "D"}
APART = 0.22
"""Between the strategies of one family [rows]."""

Saved = dict[str, list[Estimate]]


def time_saved(text: str) -> Saved:
    """Time saved in each family, against each of the other strategies in turn [%], from the text of docs/results.md.

    Raises:
        TableError: the table is not there, or a cell holds no interval.
    """
    rows = read_table(text, HEADING, ("worlds", *(f"against `{name}`" for name in OTHERS)))
    return {worlds: [estimate(cell) for cell in cells] for worlds, cells in rows.items()}


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


def _draw_column(axes: Axes, places: np.ndarray, column: list[Estimate], name: str) -> ErrorbarContainer:
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
