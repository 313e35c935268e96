"""Style that all figures of a report share, and saving them in the study's folder."""

import re
from base64 import b64encode
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

FIGURES = "figures"
"""Folder of the figures in that of the study."""
OTHER_COLOURS = ("#882255", "#8f5a00", "#332288", "#555555")
"""Dark enough for thin lines on white."""
COLOURS = ("#0072b2", "#d55e00", "#009e73", *OTHER_COLOURS)
"""Those of Okabe and Ito first, which the colour-blind can distinguish."""
MARKS = "os^Dv*P"
SOLID = "#5b6472"
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e7eb",
    "axes.axisbelow": True,
    "legend.frameon": False,
    "svg.hashsalt": "study",
}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def add_caption(figure: Figure, text: str) -> None:
    """Adds a line below the figure that marks it as simulated."""
    figure.supxlabel(f"simulated; {text}", fontsize=8, color=SOLID)


class Picture(NamedTuple):
    """A figure as SVG in base64, its description, and its path in the study's folder, without .png or .svg."""

    svg: str
    words: str
    file: str


@rc_context(STYLE)
def saved_picture(folder: Path, name: str, figure: Figure, words: str) -> Picture:
    """Saves a figure as figures/NAME.png and .svg in a study's folder."""
    # only characters that every file system takes
    file = FIGURES + "/" + re.sub(r"[^\w.-]+", "-", name).strip("-")
    (folder / FIGURES).mkdir(exist_ok=True)
    figure.savefig(folder / f"{file}.png", dpi=150)
    figure.savefig(folder / f"{file}.svg", metadata={"Date": None})
    return Picture(b64encode((folder / f"{file}.svg").read_bytes()).decode(), words, file)
