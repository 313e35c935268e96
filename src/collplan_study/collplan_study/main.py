"""The command `study`: checks the options, runs the trials that are missing, writes tables and report."""

import os
import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from datetime import datetime, timezone
from pathlib import Path

from collplan_core.command_line import as_called
from collplan_study.errors import StudyError, WorkersLost
from collplan_study.question.question import PARTS, StudyOptions, parse
from collplan_study.run.pools import Pool, open_pool, progress_bar, run_tasks
from collplan_study.run.row_file import RowFile
from collplan_study.run.rows import ERROR, write_tables
from collplan_study.run.study_folder import PROVENANCE, REPORT, ROWS, Study, make_folder, prepare, replace_file

INCOMPLETE, REFUSED, INTERRUPTED = 1, 2, 130


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of `study`; exit code 0 when every trial that was to be run has its row, and none is an error."""
    try:
        options = parse(args)
        study = prepare(options)
        with open_pool(options.jobs, options.dask) as pool:
            folder = study.folder or make_folder(options.out, study.provenance, study.sources)
            with closing(RowFile(folder / ROWS, study.grid, study.provenance["code"]["trial"])) as rows:
                return _complete(options, study, folder, rows, pool)
    except (StudyError, OSError) as error:
        return _stopped(REFUSED, error)


def _complete(options: StudyOptions, study: Study, folder: Path, rows: RowFile, pool: Pool) -> int:
    advice = f"complete it with: {shlex.join([as_called('study'), '--resume', str(folder)])}"
    try:
        _run_missing(options, study, folder, rows, pool)
        write_tables(folder, study.grid, rows)
        if options.report:
            # imported late: it takes a second, and no worker needs it
            from collplan_study.report.write_report import write_report

            write_report(folder)
    except (WorkersLost, OSError) as error:
        return _stopped(INCOMPLETE, f"{error}; {advice}")
    except KeyboardInterrupt:
        return _stopped(INTERRUPTED, f"interrupted; {advice}")
    found = [record["row"] for record in rows]
    counts = ", ".join(f"{n} {outcome}" for outcome, n in Counter(row["outcome"] for row in found).most_common())
    print(f"{folder}: {len(found)} trials (simulated): {counts}")
    if options.report:
        print(f"report: {folder / REPORT}")
    if len(rows) < len(study.grid):
        print(f"{len(study.grid) - len(rows)} trials were not run; {advice}")
    errors = Counter(row["error"] for row in found if row["outcome"] == ERROR)
    for message, count in errors.most_common():
        print(f"study: {count} trials were not run to their end: {message}", file=sys.stderr)
    return INCOMPLETE if errors else 0


def _run_missing(options: StudyOptions, study: Study, folder: Path, rows: RowFile, pool: Pool) -> None:
    command = shlex.join([os.path.basename(sys.argv[0]), *sys.argv[1:]])
    where = {"jobs": options.jobs} if options.dask is None else {"dask": options.dask}
    begun = datetime.now(timezone.utc).isoformat(timespec="seconds")
    session = {"command": command, **where, "begun": begun, "done_before": len(rows)}
    sessions = [*study.provenance["sessions"], session]
    replace_file(folder / PROVENANCE, {**study.provenance, "sessions": sessions})
    wanted = (task for task in study.grid if bool(task.labels["ablation"]) in PARTS[options.run])
    missing = (task for task in wanted if task.index not in rows)
    with progress_bar(len(study.grid), len(rows), "trial") as bar:
        for records in run_tasks(missing, pool, study.provenance["code"]["trial"]):
            rows.append(*records)
            bar.update(len(records))


def _stopped(code: int, reason: object) -> int:
    print(f"study: {' '.join(str(reason).split())}", file=sys.stderr)
    return code
