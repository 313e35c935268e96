"""Style that all figures of a report share, and saving them in the study's folder."""

import re
from base64 import b64encode
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.figure import Figure

OTHER_COLOURS = ("#882255", "#8f5a00", "#332288", "#555555")
COLOURS = ("#0072b2", "#d55e00", "#009e73", *OTHER_COLOURS)
"""Those of Okabe and Ito, which the colour-blind can distinguish, and others dark enough for thin lines on white."""
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
    return Figure(figsize=(width, height), layout="constrained")


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
    file = "figures/" + re.sub(r"[^\w.-]+", "-", name).strip("-")
    (folder / "figures").mkdir(exist_ok=True)
    figure.savefig(folder / f"{file}.png", dpi=150)
    figure.savefig(folder / f"{file}.svg", metadata={"Date": None})
    return Picture(b64encode((folder / f"{file}.svg").read_bytes()).decode(), words, file)
