"""The data set of BARN: its files, rules and shortest paths, and runs through worlds like its own."""

import json
import os
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.worlds import WorldError
from collplan_study.analysis.rows import read_rows
from collplan_study.barn.data_set import barn_files, barn_rules, load_barn, optimal_lengths, optimal_time, score
from collplan_study.main import main
from collplan_study.tables.table_files import TABLE
from omnipuck_sim.trial import run_trial
from sdf_files import BARN_CYLINDER, CYLINDER, model, write


@pytest.fixture
def folder(tmp_path):
    for name in ("world_10.world", "world_9.world.gz"):
        write(tmp_path, model(CYLINDER, at="-2 6 0 0 0 0"), name=name, compressed=name.endswith("gz"))
    (tmp_path / "README.md").write_text("not a world")
    return tmp_path


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> Path:
    """A folder of two worlds like those of the data set: rows of its cylinders across the way, with a gap in each."""
    folder = tmp_path_factory.mktemp("barn")
    for n, gaps in ((3, (-3.5, -1.5)), (165, (-1.5, -3.5, -1.5))):
        rows = (row(5.5 + 2.0 * place, gap) for place, gap in enumerate(gaps))
        write(folder, *(model(BARN_CYLINDER, at=f"{x} {y} 0 0 0 0") for x, y in chain(*rows)), name=f"world_{n}.world")
    (folder / "path_length_m.json").write_text(json.dumps({"3": 11.0, "165": 12.0}))
    return folder


def row(y, gap):
    return [(round(x, 3), y) for x in np.arange(-4.5, 0.0, 0.15) if abs(x - gap) > 0.5]


@pytest.fixture(scope="module")
def data() -> Path:
    """The real data set, where it is installed."""
    if "BARN_DIR" not in os.environ:
        pytest.skip("BARN_DIR is not set: the folder of the BARN worlds")
    return Path(os.environ["BARN_DIR"])


def test_files_by_number(folder):
    assert [(n, path.name) for n, path in barn_files(folder).items()] == [
        (9, "world_9.world.gz"),
        (10, "world_10.world"),
    ]


def test_own_start_and_goal_scaled_or_not(folder):
    path = barn_files(folder)[9]
    world, small = load_barn(path), load_barn(path, 0.5)
    assert world.name == small.name == "barn:9"
    np.testing.assert_array_equal([world.start, world.goal], [[-2.25, 3.0], [-2.25, 13.0]])
    np.testing.assert_array_equal([small.start, small.goal], [[-1.125, 1.5], [-1.125, 6.5]])


def test_rules_are_parameters():
    trial = Settings().with_values(barn_rules(0.5))
    assert (trial.planner.goal_tolerance, trial.trial.timeout) == (0.5, 100.0)


def test_no_worlds(tmp_path, folder):
    with pytest.raises(WorldError, match="no such folder"):
        barn_files(tmp_path / "none")
    (tmp_path / "empty").mkdir()
    with pytest.raises(WorldError, match=r"expected files called world_N\.world"):
        barn_files(tmp_path / "empty")
    write(folder, model(CYLINDER), name="world_9.world")
    with pytest.raises(WorldError, match=r"world_9\.world\.gz: the same world as world_9\.world"):
        barn_files(folder)


def test_lengths_from_the_list(folder):
    (folder / "path_length_m.json").write_text(json.dumps({"9": 12.0, "77": 1.0}))
    assert optimal_lengths(folder) == {"barn:9": 12.0}
    assert optimal_lengths(folder, 0.5) == {"barn:9": 6.0}


def test_lengths_from_the_paths_of_the_data_set(folder):
    assert optimal_lengths(folder) == {}
    (folder / "path_files").mkdir()
    # straight up the column of cells right of the start: from -4.575 + 16 * 0.15 = -2.175
    np.save(folder / "path_files" / "path_10.npy", np.array([[16, 0], [16, 20]]))
    expected = np.hypot(0.075, 2.075) + 20 * 0.15 + np.hypot(0.075, 13.0 - 8.075)
    assert optimal_lengths(folder) == {"barn:10": pytest.approx(expected)}


@pytest.mark.parametrize("text", ["", "[]", '{"9": "far"}', '{"9": -1}', '{"9": NaN}', '{"nine": 1}', '{"9": [1]}'])
def test_lengths_that_are_none(folder, text):
    (folder / "path_length_m.json").write_text(text)
    with pytest.raises(WorldError, match=r"path_length_m\.json: .*expected {"):
        optimal_lengths(folder)


@pytest.mark.parametrize("content", [b"", b"no array", b"\x80\x04N."])
def test_paths_that_are_none(folder, content):
    (folder / "path_files").mkdir()
    (folder / "path_files" / "path_10.npy").write_bytes(content)
    with pytest.raises(WorldError, match=r"path_10\.npy: cannot be read"):
        optimal_lengths(folder)


def test_counts_of_the_data(data):
    worlds = {n: load_barn(path) for n, path in barn_files(data).items()}
    counts = {n: len(world.circles) for n, world in worlds.items()}
    assert {n: counts[n] for n in (3, 87, 165)} == {3: 200, 87: 186, 165: 345}
    assert (len(counts), sum(counts.values())) == (40, 10_024)
    assert all((world.circles[:, 2] == 0.075).all() and not world.polygons for world in worlds.values())
    lengths = optimal_lengths(data)
    assert lengths.keys() == {world.name for world in worlds.values()}
    assert lengths["barn:3"] == pytest.approx(11.9509, abs=1e-4)


def test_small_worlds_hold_every_cylinder(small):
    worlds = {n: load_barn(path) for n, path in barn_files(small).items()}
    assert {n: len(world.circles) for n, world in worlds.items()} == {3: 47, 165: 70}
    for world in worlds.values():
        assert (world.circles[:, 2] == 0.075).all()
        assert not world.polygons
        assert not world.walled
    np.testing.assert_allclose(worlds[3].circles[:2, :2], [[-4.5, 5.5], [-4.35, 5.5]])
    assert optimal_lengths(small) == {"barn:3": 11.0, "barn:165": 12.0}


def check_run(world):
    trial = run_trial(world, Settings().with_values(barn_rules()), 0)
    assert trial.outcome == "reached"
    assert np.hypot(*(trial.trajectory[-1, 1:3] - world.goal)) < 1.05
    # no faster than straight ahead at top speed, up to the tolerance
    assert trial.arrival_time > 9.0 / Settings().robot.max_speed


@pytest.mark.parametrize("n", [3, 165])
def test_a_run_through_a_small_world(small, n):
    check_run(load_barn(barn_files(small)[n]))


def test_a_run_through_a_world_of_the_data(data):
    check_run(load_barn(barn_files(data)[165]))


def test_a_study_of_small_worlds_has_their_score(small, tmp_path):
    folder = tmp_path / "study"
    few = ["--strategies", "harness", "--map-periods", "0.2", "--trials", "1", "--jobs", "1"]
    assert main(["--worlds", f"barn:{small}", *few, "--out", str(folder)]) == 0
    rows = {row["world"]: row for row in read_rows(folder / TABLE).dicts()}
    assert {name: row["outcome"] for name, row in rows.items()} == {"barn:3": "reached", "barn:165": "reached"}
    times = {"barn:3": optimal_time(11.0), "barn:165": optimal_time(12.0)}
    expected = np.mean([score(True, rows[name]["arrival_time_s"], times[name]) for name in times])
    page = (folder / "report.html").read_text()
    assert "BARN&#x27;s score" in page
    assert f"<td>{expected:.3f} (2 of 5 needed for an interval)</td>" in page
