"""Draws the curve of make worth: docs/pictures/worth.png."""

from pathlib import Path

from matplotlib import rc_context

from collplan_study.report.figures import OTHER_COLOURS, STYLE, add_caption, new_figure
from worth_curve import families_of, read_curve

PICTURE = Path(__file__).parents[1] / "docs/pictures/worth.png"


@rc_context(STYLE)
def main() -> None:
    figure, cells = new_figure(7.2, 2.9), read_curve()
    shades = dict(zip(sorted({cell.restitution for cell in cells}, reverse=True), OTHER_COLOURS, strict=False))
    shown = families_of(cells)
    for axes, family in zip(figure.subplots(1, len(shown), sharey=True), shown, strict=True):
        for restitution, colour in shades.items():
            line = sorted(cell for cell in cells if (cell.family, cell.restitution) == (family, restitution))
            if line:
                numbers, saved = [cell.number for cell in line], [cell.saved for cell in line]
                axes.plot(numbers, saved, "o-", color=colour, ms=3, label=f"restitution {restitution:g}")
                axes.fill_between(
                    numbers, *zip(*(cell[4:] for cell in line), strict=True), color=colour, alpha=0.15, lw=0
                )
        axes.set_xscale("log")
        axes.set_xticks((3, 4, 6, 8, 11, 16, 24), ("3", "4", "6", "8", "11", "16", "24"))
        axes.minorticks_off()
        axes.set(title=family, xlabel="N = v_max² / (a_max R)")
    figure.axes[0].set_ylabel("time saved [%]")
    figure.axes[0].legend(fontsize=7)
    add_caption(figure, "12 worlds at each point, shaded: 95 % interval")
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
