"""Checks a study and loads what it needs, before the first trial."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import WorldError
from collplan_study.errors import StudyError
from collplan_study.question.grid import NO_ABLATION, TrialGrid, make_grid
from collplan_study.question.options import NONE, StudyOptions
from collplan_study.question.question import Question, question_from
from collplan_study.question.sources import Source, load_sources
from collplan_study.question.specification import specification_of
from collplan_study.run.provenance import Provenance, check_code, new_provenance
from collplan_study.run.study_folder import check_new, read_provenance, read_sources
from omnipuck_sim.robot.engine import check_installed


@dataclass(frozen=True, eq=False)
class Study:
    """A study that is ready to run; `folder` is None where it has none yet."""

    grid: TrialGrid
    sources: tuple[Source, ...]
    provenance: Provenance
    folder: Path | None

    @property
    def code(self) -> str:
        """Hash of the code that its trials are run by."""
        return str(self.provenance["code"]["trial"])


def prepare(options: StudyOptions) -> Study:
    """The study that the options describe, new or resumed. Writes nothing.

    Raises:
        StudyError: the study cannot be run; the message gives the reason in one line.
    """
    try:
        study = _new(options) if options.resume is None else _resumed(options, options.resume)
        if options.run != NONE:
            check_installed(study.grid.tasks[0].settings.simulator)
    except (WorldError, ParameterError) as error:
        raise StudyError(str(error)) from None
    return study


def _new(options: StudyOptions) -> Study:
    question = options.question()
    check_new(options.out)
    sources = load_sources(question.worlds, question.start, question.goal)
    ablations = _ablations(question)
    grid = make_grid(question, sources, ablations)
    return Study(grid, sources, new_provenance(question, sources, ablations, len(grid)), None)


def _resumed(options: StudyOptions, folder: Path) -> Study:
    provenance = read_provenance(folder)
    try:
        question = options.question(question_from(provenance["question"]))
        check_code(provenance, folder)
        sources = read_sources(folder, provenance)
        return Study(make_grid(question, sources, provenance["ablations"]), sources, provenance, folder)
    except (AttributeError, KeyError, TypeError) as error:
        raise StudyError(f"{folder}: its provenance was changed ({error}), expected what a study wrote") from None


def _ablations(question: Question) -> Mapping[str, Mapping[str, Any]]:
    if not question.ablations:
        return NO_ABLATION
    return specification_of(question.bounces).ablations(question.engine)
