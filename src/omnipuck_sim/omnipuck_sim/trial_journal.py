"""The journals of a trial's planner and controller in one file."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from collplan_core.parameters import Settings
from collplan_core.replay.journal import CONTROLLER, PLANNER, Journal
from collplan_core.worlds import World, world_text


@dataclass(frozen=True)
class TrialJournals:
    """Journals of the inputs and decisions of a trial's loops.

    Attributes:
        planner, controller: their journals.
    """

    planner: Journal
    controller: Journal


@contextmanager
def trial_journals(path: str | Path | None, world: World, settings: Settings, seed: int) -> Iterator[TrialJournals]:
    """Journals that are written to a file, which is replaced; without a path they keep nothing.

    Raises:
        OSError: the file cannot be written.
    """
    if path is None:
        yield TrialJournals(Journal(PLANNER), Journal(CONTROLLER))
        return
    with Path(path).open("w", encoding="utf-8") as file:

        def send(line: str) -> None:
            file.write(line + "\n")

        journals = TrialJournals(Journal(PLANNER, send), Journal(CONTROLLER, send))
        send(json.dumps({"trial": {"simulated": True, "world": world.name, "seed": seed}}))
        journals.planner.begin(settings, world_text(world) if settings.trial.known_map else None)
        journals.controller.begin(settings)
        try:
            yield journals
        finally:
            journals.planner.end_cycle()
            journals.controller.end_cycle()
