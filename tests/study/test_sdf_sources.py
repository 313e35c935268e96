"""Worlds of a study that come in SDF."""

import pytest

from collplan_core.worlds import WorldError
from collplan_study.errors import StudyError
from collplan_study.question.sources import load_sources
from collplan_study.run.study_folder import make_folder, read_sources, source_records
from sdf_files import CYLINDER, model, write

ENDS = ((-5.0, 0.0), (5.0, 0.0))


@pytest.fixture
def barn(tmp_path):
    folder = tmp_path / "barn"
    folder.mkdir()
    for name in ("world_3.world", "world_9.world"):
        write(folder, model(CYLINDER, at="-2 6 0 0 0 0"), name=name)
    (folder / "path_length_m.json").write_text('{"3": 12.0}')
    return folder


@pytest.mark.parametrize(("name", "compressed"), [("maze.sdf", False), ("maze.world.gz", True), ("maze", False)])
def test_sdf_file_needs_start_and_goal(tmp_path, name, compressed):
    path = write(tmp_path, model(CYLINDER), name=name, compressed=compressed)
    for start, goal in ((None, None), (ENDS[0], None), (None, ENDS[1])):
        with pytest.raises(StudyError, match="expected --start X Y and --goal X Y"):
            load_sources([str(path)], start, goal)
    (source,) = load_sources([str(path)], *ENDS)
    assert (source.world.name, source.family, dict(source.values)) == ("maze", "maze", {})
    assert source.world.goal.tolist() == [5.0, 0.0]


def test_barn_comes_with_its_rules_and_lengths(barn):
    sources = load_sources([f"barn:{barn}"], None, None, 0.5)
    assert [source.world.name for source in sources] == ["barn:3", "barn:9"]
    assert [source.optimal_length for source in sources] == [6.0, None]
    assert all(source.values == {"planner.goal_tolerance": 0.5, "trial.timeout": 100.0} for source in sources)
    assert {source.family for source in sources} == {"barn"}


def test_barn_comes_back_from_a_study_folder(tmp_path, barn):
    sources = load_sources([f"barn:{barn}"], None, None)
    folder = make_folder(tmp_path / "study", {}, sources)
    again = read_sources(folder, {"sources": source_records(sources)})
    assert [source.optimal_length for source in again] == [12.0, None]
    assert [source.world.circles.tolist() for source in again] == [source.world.circles.tolist() for source in sources]


def test_barn_options_that_do_not_fit(tmp_path, barn):
    with pytest.raises(StudyError, match="leave out --start and --goal"):
        load_sources([f"barn:{barn}"], *ENDS)
    with pytest.raises(StudyError, match=r"--barn-scale: got 0\.5 without its worlds"):
        load_sources(["corridor"], None, None, 0.5)
    with pytest.raises(WorldError, match="scale: got -1"):
        load_sources([f"barn:{barn}"], None, None, -1.0)
    with pytest.raises(StudyError, match="expected barn:DIR"):
        load_sources(["barn:"], None, None)
    with pytest.raises(WorldError, match="no such folder"):
        load_sources([f"barn:{tmp_path}/none"], None, None)


def test_missing_sdf_file():
    with pytest.raises(WorldError, match=r"none\.world: no such file"):
        load_sources(["none.world"], *ENDS)
