"""Trials of these sources over those of 1.0.0, so that no feature makes them slower by a factor unseen."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

from answering import Ask, SkippedError, answering
from timing import compared, in_turn

ROOT = Path(__file__).resolve().parents[1]
RELEASE, COMMIT = "1.0.0", "b23341a1"
KEPT = ROOT / "build" / f"src-{COMMIT}"
SHORT = ("serpentine:90301", "baffles:90300")
WORLDS = {"harness": ("corridor", "random:90302"), "bounce": SHORT, "avoid": SHORT}


def over_release(rounds: int) -> dict[str, Any]:
    """Processor time a simulated second of trials over that of 1.0.0, by strategy; both run the same seeds in turn.

    Raises SkippedError where git does not have the sources of 1.0.0, or they do not run here.
    """
    found: dict[str, Any] = {}
    with _trials_of(ROOT / "src") as ours, _trials_of(_released()) as theirs:
        for strategy, worlds in WORLDS.items():
            asked = partial(_paces, strategy, worlds)
            sides = {"ours": partial(asked, ours), "peer": partial(asked, theirs)}
            in_turn(sides, 1)  # compiles
            found[f"trial_{strategy}_vs_1_0_0"] = compared(**in_turn(sides, rounds))
    return found


def _paces(strategy: str, worlds: Sequence[str], ask: Ask, seed: int) -> list[float]:
    return ask("paces", strategy=strategy, worlds=worlds, seed=seed)


def _trials_of(sources: Path) -> AbstractContextManager[Ask]:
    packages = os.pathsep.join(str(package) for package in sorted(sources.iterdir()))
    return answering(sys.executable, "trial_server.py", packages)


def _released() -> Path:
    """Returns the sources of 1.0.0, which are written the first time; git is only read."""
    if not KEPT.exists():
        archive = ["git", "-C", ROOT, "archive", "--format=tar", COMMIT, "src"]
        KEPT.parent.mkdir(exist_ok=True)
        try:
            with tempfile.TemporaryDirectory(dir=KEPT.parent) as unpacked:
                sources = subprocess.run(archive, capture_output=True, check=True).stdout
                subprocess.run(["tar", "-x", "-C", unpacked], input=sources, capture_output=True, check=True)
                (Path(unpacked) / "src").rename(KEPT)
        except (OSError, subprocess.CalledProcessError) as error:
            said = (getattr(error, "stderr", None) or str(error).encode()).decode().strip()
            raise SkippedError(f"git has no {COMMIT} here, as in a tarball or a shallow clone: {said}") from None
    return KEPT
