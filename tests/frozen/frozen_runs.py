"""What is made of four recorded runs: their result files, and the frames of their page."""

import csv
import json
from pathlib import Path
from shutil import copytree
from typing import Any

from collplan_ros.run.page import write_run_page
from collplan_ros.run.recorded_run import SUMMARY, read_run
from collplan_ros.run.result_files import IMPACTS, TRAJECTORY, complete, write_result_files
from fingerprint import fingerprint
from played_folders import recording_in
from record import FOLDERS, keep

WITHOUT_TRUTH = "without_truth"
"""The simulated run as a real robot would leave it."""
NAMES = ("simulated", "emulated", "killed", WITHOUT_TRUTH)


def frozen_run(name: str, scratch: Path) -> dict[str, Any]:
    """Makes the files of a run anew in an empty folder; their content for people and as fingerprints."""
    folder = scratch / name
    if name == WITHOUT_TRUTH:
        keep(FOLDERS / "simulated", folder, left_out=("ground_truth",))
    else:
        copytree(FOLDERS / name, folder)
    if name == "killed":
        complete(folder)
    else:
        run = read_run(folder)
        write_result_files(run, run.log.goal, "reached", {})
    write_run_page(folder)
    summary = json.loads((folder / SUMMARY).read_text())
    files = {file: list(csv.reader((folder / file).open())) for file in (TRAJECTORY, IMPACTS)}
    made = {file: fingerprint([[_number(cell) for cell in row] for row in rows]) for file, rows in files.items()}
    frames = recording_in((folder / "run.html").read_text())["frames"]
    said = {key: summary[key] for key in ("outcome", "arrival_time_s", "path_length_m", "impacts")}
    return said | made | {SUMMARY: fingerprint(summary), "frames": fingerprint(frames)}


def _number(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell
