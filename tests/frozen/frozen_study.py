"""A study of 60 short trials."""

from pathlib import Path
from typing import Any

from collplan_study.main import main
from study_runs import table

GRID = ["--worlds", "corridor,random:3,u:4", "--strategies", "harness,low_risk,bounce,avoid,tolerate", "--trials", "4"]
OPTIONS = ["--map-periods", "0.2", "--seed", "11", "--set", "trial.timeout=4", "--no-report"]


def frozen_study(scratch: Path) -> list[dict[str, Any]]:
    """Rows of the study, without wall times."""
    main([*GRID, *OPTIONS, "--out", str(scratch / "study")])
    return table(scratch / "study").to_dicts()
