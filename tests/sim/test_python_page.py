"""The Python of the pages and of examples/ runs as it stands, and the names that the packages offer are there."""

import json
import re
from pathlib import Path

import pytest
import yaml

import collplan_core
import omnipuck_sim
from collplan_core.planners import PLANNERS
from collplan_core.strategies import NAMES

ROOT = Path(__file__).parents[2]
IN_A_PAGE = r"^## ([^\n]+)\n(?:(?!^## ).)*?```python\n(.*?)```"
PAGES = "".join((ROOT / name).read_text(encoding="utf-8") for name in ("docs/python.md", "README.md"))
EXAMPLES = dict(re.findall(IN_A_PAGE, PAGES, re.DOTALL | re.MULTILINE))
SCRIPTS = sorted({*ROOT.glob("examples/*.py")} - {ROOT / "examples/recorded_run.py"})
LONGEST = {"A world, a scan, a plan": 6, "Your own planner": 20}
SAID = {
    "A world, a scan, a plan": "contacts",
    "A trial with a picture": "serpentine:2, bounce, seed 1: reached",
    "Your own planner": "floor, straight, seed 1: reached",
    "A policy for an environment": "True",
    "From Python": "serpentine:2, bounce, seed 1: reached",
}


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Runs code where it may leave pictures, without what it registers; gives what it prints."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setattr("sys.argv", ["example"])
    monkeypatch.setattr("collplan_core.planners.PLANNERS", dict(PLANNERS))
    names = list(NAMES)

    def run_code(code, file=""):
        try:
            exec(compile(code, file, "exec"), {"__name__": "__main__", "__file__": file})
        finally:
            NAMES[:] = names
        return capsys.readouterr().out

    return run_code


@pytest.mark.parametrize("title", EXAMPLES)
def test_an_example_of_a_page_runs_and_is_short(title, run, tmp_path):
    assert SAID[title] in run(EXAMPLES[title])
    lines = [line for line in EXAMPLES[title].splitlines() if line.strip()]
    assert len(lines) <= LONGEST.get(title, 12)
    assert bool(list(tmp_path.glob("*.png"))) == ("savefig" in EXAMPLES[title])


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_runs_and_leaves_its_picture(script, run, tmp_path):
    said = run(script.read_text(encoding="utf-8"), str(script))
    assert said
    assert not any(word in said for word in ("stuck", "aborted", "timeout", "late"))
    assert (tmp_path / f"{script.stem}.png").exists()


def test_the_notebook_runs_cell_by_cell(run, tmp_path):
    notebook = json.loads((ROOT / "examples/first_steps.ipynb").read_text(encoding="utf-8"))
    assert all(cell.get("outputs", []) == [] for cell in notebook["cells"])
    code = "\n".join("".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code")
    assert "serpentine:2, bounce, seed 1: reached" in run(code)
    assert (tmp_path / "first_steps.png").exists()


def test_the_tutorial_shows_the_room():
    page = (ROOT / "docs/tutorials/student.md").read_text(encoding="utf-8")
    (room,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert yaml.safe_load(room) == yaml.safe_load((ROOT / "examples/room.yaml").read_text(encoding="utf-8"))


def test_the_packages_offer_what_they_name():
    for package in (collplan_core, omnipuck_sim):
        assert all(getattr(package, name).__name__ == name for name in package.__all__)
        with pytest.raises(AttributeError, match="no_such"):
            _ = package.no_such
