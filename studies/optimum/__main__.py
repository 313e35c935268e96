"""The command `optimum`: runs strategies, finds the optimum without contact in their worlds, and compares."""

import csv
import json
import os
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import asdict, fields
from pathlib import Path

from collplan_core.worlds import World, WorldError
from collplan_study import main as study
from collplan_study.errors import StudyError
from collplan_study.question.grid import make_grid
from collplan_study.question.question import question_from
from collplan_study.run.pools import open_pool, progress_bar
from collplan_study.run.study_folder import RUNS, StudyData, read_study
from markdown_text import Section, markdown
from optimum.best_trajectory import GUESSED_OFFSETS, check_installed
from optimum.comparison import compare, record_of, table_of
from optimum.disc import Disc, disc_of
from optimum.options import FAMILIES, Options, parse
from optimum.world_optimum import WorldOptimum, world_optimum

RATIOS, OPTIMA = "optimum.json", "optimum.csv"
INCOMPLETE, REFUSED, INTERRUPTED = 1, 2, 130


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of `optimum`; exit code 0 when every world has its best trajectory."""
    try:
        options = parse(args)
        check_installed()
        code = 0 if options.study is None else study.main(options.study)
        return code or _compare(options)
    except (StudyError, WorldError, OSError) as error:
        return _stopped(REFUSED, error)


def _compare(options: Options) -> int:
    data = read_study(options.folder)
    worlds, left_out = _worlds(data)
    try:
        optima = _optima(worlds, _discs(data), options.jobs)
    except (BrokenExecutor, KeyboardInterrupt) as error:
        code = INTERRUPTED if isinstance(error, KeyboardInterrupt) else INCOMPLETE
        again = f"make optimum ARGS='--of {options.folder}'"
        return _stopped(code, f"{str(error) or 'interrupted'}; go on with: {again}")
    strategies = data.provenance["question"]["strategies"]
    comparisons = compare(data.runs.filter(ablation=""), strategies, optima)
    _write(options.folder, optima)
    RUNS.mkdir(exist_ok=True)
    (RUNS / RATIOS).write_text(json.dumps(record_of(comparisons), indent=2) + "\n", encoding="utf-8")
    print(markdown(Section(note="All figures are simulated."), table_of(comparisons, strategies)))
    every = [each for family in optima.values() for each in family]
    print(_trust([each for each in every if each.found]))
    if left_out:
        print(f"Left out, no corridor with right-angled turns: {', '.join(left_out)}.")
    print(f"ratios: {RUNS / RATIOS}; the optimum of each world: {options.folder / OPTIMA}")
    unsolved = [each.world for each in every if not each.found]
    return _stopped(INCOMPLETE, f"no best trajectory was found in {', '.join(unsolved)}") if unsolved else 0


def _stopped(code: int, reason: object) -> int:
    print(f"optimum: {' '.join(str(reason).split())}", file=sys.stderr)
    return code


def _worlds(data: StudyData) -> tuple[dict[str, list[World]], list[str]]:
    """The worlds that are compared, by family, and the families left out."""
    if not data.provenance["question"].get("bounces"):
        raise StudyError(f"{data.folder}: not a study of bounces, expected one made with --bounces")
    worlds: dict[str, list[World]] = {}
    for source in data.sources:
        worlds.setdefault(source.family, []).append(source.world)
    compared = {family: each for family, each in worlds.items() if family in FAMILIES}
    if not compared:
        expected = f"expected worlds of {', '.join(FAMILIES)}"
        raise StudyError(f"{data.folder}: has worlds of {', '.join(worlds)} alone, {expected}")
    return compared, [family for family in worlds if family not in compared]


def _discs(data: StudyData) -> dict[str, Disc]:
    """The disc of each world by its name; the strategies of a study of bounces share their parameters."""
    try:
        grid = make_grid(question_from(data.provenance["question"]), data.sources)
    except TypeError as error:
        raise StudyError(f"{data.folder}: begun by another version ({error})") from None
    return {task.world.name: disc_of(task.settings) for task in grid}


def _optima(
    worlds: Mapping[str, Sequence[World]], discs: Mapping[str, Disc], jobs: int
) -> dict[str, list[WorldOptimum]]:
    every = [world for family in worlds.values() for world in family]
    found: dict[str, WorldOptimum] = {}
    with open_pool(jobs, None) as (executor, _), progress_bar(len(every), 0, "world") as bar:
        for each in executor.map(world_optimum, every, [discs[world.name] for world in every]):
            found[each.world] = each
            bar.update()
    return {family: [found[world.name] for world in each] for family, each in worlds.items()}


def _write(folder: Path, optima: Mapping[str, Sequence[WorldOptimum]]) -> None:
    """Writes a row for each world."""
    part = folder / f".{OPTIMA}.part"
    with part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, ["family", *(field.name for field in fields(WorldOptimum))])
        writer.writeheader()
        for family, each in optima.items():
            writer.writerows({"family": family, **asdict(optimum)} for optimum in each)
    os.replace(part, folder / OPTIMA)


def _trust(solved: Sequence[WorldOptimum]) -> str:
    """How far the trajectories can be trusted, in words."""
    differences = [each.disagreement for each in solved if each.found == len(GUESSED_OFFSETS)]
    if not differences:
        return "Each best trajectory is a local optimum, found from one initial guess."
    return (
        f"Each best trajectory is a local optimum; in {len(differences)} of {len(solved)} worlds those from "
        f"{len(GUESSED_OFFSETS)} initial guesses end within {100.0 * max(differences):.3f} % of one another."
    )


if __name__ == "__main__":
    sys.exit(main())
