"""The tables of the ablations: one for each case."""

from collections.abc import Iterator, Sequence

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.cells import Cell
from collplan_study.analysis.paper_results import AblationResults
from collplan_study.analysis.statistics import Estimate
from collplan_study.report.content import Row, Table, number, with_interval

METHOD = (
    "One change from the defaults at a time. For each strategy: runs that arrive, mean arrival time (a run that "
    "does not arrive counts with the time limit), how much longer that is than as shipped in the same runs, in "
    "percent, and deliberate impacts of all impacts a run. Then the improvement of mean arrival time, in percent."
)


def ablation_tables(found: Sequence[AblationResults]) -> Iterator[Table]:
    """A table for each case that ablations were run in."""
    for case in dict.fromkeys(each.case for each in found):
        results = [each for each in found if each.case == case]
        yield Table(case, head=_head(results[0]), rows=[_row(each) for each in results])


def _head(first: AblationResults) -> Row:
    gains = (f"{each.ours} against {each.other}" for each in first.gains)
    return "change", *(cell.strategy for cell in first.cells), *gains


def _row(found: AblationResults) -> Row:
    cells = (_cell_text(cell, longer) for cell, longer in zip(found.cells, found.longer, strict=True))
    return found.ablation, *cells, *(with_interval(each.estimate, 1, " %") for each in found.gains)


def _cell_text(cell: Cell, longer: Estimate) -> str:
    time, means = cell.levels[0].value, cell.means
    impacts = f"{number(means['deliberate_impacts'], 2)} of {number(means['impacts'], 2)} deliberate"
    lines = (f"{cell.outcomes[REACHED]}/{cell.runs}, {number(time, 2)} s", with_interval(longer, 1, " %"), impacts)
    return "\n".join(lines)
