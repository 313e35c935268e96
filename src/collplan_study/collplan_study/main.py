"""Runs a study from the command line: checks everything, runs the trials that are missing, writes the tables."""

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from tqdm import tqdm

from collplan_study.errors import StudyError, WorkersLost
from collplan_study.question.grid import Grid
from collplan_study.question.options import Options, parse
from collplan_study.run.pools import Pool, open_pool
from collplan_study.run.preparation import prepare
from collplan_study.run.provenance import Provenance, ended, new_session
from collplan_study.run.runner import run_tasks
from collplan_study.run.store import RowFile
from collplan_study.run.study_folder import ROWS, make_folder, write_provenance
from collplan_study.tables.tables import write_tables

INCOMPLETE, REFUSED, INTERRUPTED = 1, 2, 130


def main(args: Sequence[str] | None = None) -> int:
    """Exit code 0 when every trial that was to be run has its row."""
    try:
        return _run(parse(args))
    except StudyError as error:
        return _stopped(REFUSED, error)


def _run(options: Options) -> int:
    study = prepare(options)
    with open_pool(options.jobs, options.dask) as pool:
        folder = study.folder or make_folder(options.out, study.provenance, study.sources)
        with RowFile(folder / ROWS, study.grid) as rows:
            return _complete(options, folder, study.provenance, study.grid, rows, pool)


def _complete(options: Options, folder: Path, provenance: Provenance, grid: Grid, rows: RowFile, pool: Pool) -> int:
    advice = f"complete it with: study --resume {folder}"
    try:
        _run_missing(options, folder, provenance, grid, rows, pool)
        write_tables(folder, grid, rows)
        if options.report:
            _write_report(folder)
    except (WorkersLost, OSError) as error:
        return _stopped(INCOMPLETE, f"{error}; {advice}")
    except KeyboardInterrupt:
        return _stopped(INTERRUPTED, f"interrupted; {advice}")
    _print_outcomes(folder, rows)
    if len(rows) < len(grid):
        print(f"{len(grid) - len(rows)} trials were not run; {advice}")
    return 0


def _run_missing(options: Options, folder: Path, provenance: Provenance, grid: Grid, rows: RowFile, pool: Pool) -> None:
    earlier, session = provenance["sessions"], new_session(options, len(rows))
    write_provenance(folder, {**provenance, "sessions": [*earlier, session]})
    begun = perf_counter()
    missing = (task for task in grid if task.index not in rows and options.runs(task))
    with tqdm(total=len(grid), initial=len(rows), unit="trial", mininterval=0.5) as bar:
        for records in run_tasks(missing, *pool):
            rows.append(records)
            bar.update(len(records))
    session = ended(session, len(rows) - session["done_before"], perf_counter() - begun)
    write_provenance(folder, {**provenance, "sessions": [*earlier, session]})


def _write_report(folder: Path) -> None:
    # takes a second to import, and no worker needs it
    from collplan_study.report.report import write_report

    write_report(folder)


def _stopped(code: int, why: object) -> int:
    print(f"study: {' '.join(str(why).split())}", file=sys.stderr)
    return code


def _print_outcomes(folder: Path, rows: RowFile) -> None:
    outcomes = Counter(record["row"]["outcome"] for record in rows)
    counts = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
    print(f"{folder}: {len(rows)} trials (simulated): {counts}")
