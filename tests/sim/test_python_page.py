"""docs/python.md: each of its examples runs as it stands, and the names that the packages offer are there."""

import re
from pathlib import Path

import pytest

import collplan_core
import omnipuck_sim
from collplan_core.planners import PLANNERS
from collplan_core.strategies import NAMES

PAGE = (Path(__file__).parents[2] / "docs/python.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^## (.+?)\n.*?```python\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE))
LONGEST = {"A world, a scan, a plan": 6, "Your own planner": 20}
SAID = {
    "A world, a scan, a plan": "contacts",
    "A trial with a picture": "serpentine:2, bounce, seed 1: reached",
    "Your own planner": "floor, straight, seed 1: reached",
    "A sweep of a parameter": "a_max 3.0",
    "A policy for an environment": "True",
}


@pytest.mark.parametrize("title", EXAMPLES)
def test_an_example_runs_and_is_short(title, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setattr("collplan_core.planners.PLANNERS", dict(PLANNERS))
    names = list(NAMES)
    try:
        exec(EXAMPLES[title], {})
    finally:
        NAMES[:] = names
    assert SAID[title] in capsys.readouterr().out
    lines = [line for line in EXAMPLES[title].splitlines() if line.strip()]
    assert len(lines) <= LONGEST.get(title, 12)
    assert (tmp_path / "trial.png").exists() == ("picture" in title)


def test_the_packages_offer_what_they_name():
    for package in (collplan_core, omnipuck_sim):
        assert all(getattr(package, name).__name__ == name for name in package.__all__)
        with pytest.raises(AttributeError, match="no_such"):
            _ = package.no_such
