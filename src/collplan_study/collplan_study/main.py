"""The command `study`: checks the options, runs the trials that are missing, writes tables and report."""

import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from collplan_core.command_line import as_called
from collplan_study.errors import StudyError, WorkersLost
from collplan_study.question.options import StudyOptions, parse
from collplan_study.run.pools import Pool, open_pool
from collplan_study.run.preparation import Study, prepare
from collplan_study.run.provenance import finished_session, new_session
from collplan_study.run.row_file import RowFile
from collplan_study.run.runner import progress_bar, run_tasks
from collplan_study.run.study_folder import REPORT, ROWS, make_folder, write_provenance
from collplan_study.tables.rows import ERROR
from collplan_study.tables.table_files import write_tables

INCOMPLETE, REFUSED, INTERRUPTED = 1, 2, 130


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of `study`; exit code 0 when every trial that was to be run has its row, and none is an error."""
    try:
        return _run(parse(args))
    except StudyError as error:
        return _stopped(REFUSED, error)


def _run(options: StudyOptions) -> int:
    study = prepare(options)
    with open_pool(options.jobs, options.dask) as pool:
        folder = study.folder or make_folder(options.out, study.provenance, study.sources)
        with RowFile(folder / ROWS, study.grid, study.code) as rows:
            return _complete(options, study, folder, rows, pool)


def _complete(options: StudyOptions, study: Study, folder: Path, rows: RowFile, pool: Pool) -> int:
    advice = f"complete it with: {shlex.join([as_called('study'), '--resume', str(folder)])}"
    try:
        _run_missing(options, study, folder, rows, pool)
        write_tables(folder, study.grid, rows)
        if options.report:
            _write_report(folder)
    except (WorkersLost, OSError) as error:
        return _stopped(INCOMPLETE, f"{error}; {advice}")
    except KeyboardInterrupt:
        return _stopped(INTERRUPTED, f"interrupted; {advice}")
    errors = _print_outcomes(folder, rows)
    if options.report:
        print(f"report: {folder / REPORT}")
    if len(rows) < len(study.grid):
        print(f"{len(study.grid) - len(rows)} trials were not run; {advice}")
    for message, count in errors.most_common():
        print(f"study: {count} trials were not run to their end: {message}", file=sys.stderr)
    return INCOMPLETE if errors else 0


def _run_missing(options: StudyOptions, study: Study, folder: Path, rows: RowFile, pool: Pool) -> None:
    earlier, session = study.provenance["sessions"], new_session(options, len(rows))
    write_provenance(folder, {**study.provenance, "sessions": [*earlier, session]})
    started_at = perf_counter()
    missing = (task for task in study.grid if task.index not in rows and options.selects(task))
    with progress_bar(len(study.grid), len(rows), "trial") as bar:
        for records in run_tasks(missing, *pool, study.code):
            rows.append(records)
            bar.update(len(records))
    session = finished_session(session, len(rows) - session["done_before"], perf_counter() - started_at)
    write_provenance(folder, {**study.provenance, "sessions": [*earlier, session]})


def _write_report(folder: Path) -> None:
    # imported late: it takes a second, and no worker needs it
    from collplan_study.report.write_report import write_report

    write_report(folder)


def _stopped(code: int, reason: object) -> int:
    print(f"study: {' '.join(str(reason).split())}", file=sys.stderr)
    return code


def _print_outcomes(folder: Path, rows: RowFile) -> Counter[str]:
    """Prints how the trials ended; returns how often each error ended one."""
    found = [record["row"] for record in rows]
    counts = ", ".join(f"{n} {outcome}" for outcome, n in Counter(row["outcome"] for row in found).most_common())
    print(f"{folder}: {len(found)} trials (simulated): {counts}")
    return Counter(row["error"] for row in found if row["outcome"] == ERROR)
