"""The data set of BARN: its files, rules, scores and shortest paths, and runs through worlds like its own."""

import json

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.worlds import WorldError
from collplan_study.barn.data_set import barn_files, barn_rules, load_barn, optimal_lengths, optimal_time, score
from collplan_study.errors import StudyError
from collplan_study.question.sources import load_sources
from collplan_study.run.study_folder import make_folder, read_sources, source_records
from sdf_files import CYLINDER, model, write

ENDS = ((-5.0, 0.0), (5.0, 0.0))


@pytest.fixture
def folder(tmp_path):
    for name in ("world_10.world", "world_9.world.gz"):
        write(tmp_path, model(CYLINDER, at="-2 6 0 0 0 0"), name=name, compressed=name.endswith("gz"))
    (tmp_path / "README.md").write_text("not a world")
    return tmp_path


def test_score_by_hand():
    table = [(True, 5.0, 0.5), (True, 20.0, 0.25), (True, 30.0, 1 / 6), (True, 99.0, 0.125), (False, 5.0, 0.0)]
    for arrives, time, expected in table:
        assert score(arrives, time, optimal_time(10.0)) == pytest.approx(expected), (arrives, time)


def test_files_by_number_with_their_own_start_and_goal_scaled_or_not(folder):
    files = barn_files(folder)
    assert [(n, path.name) for n, path in files.items()] == [(9, "world_9.world.gz"), (10, "world_10.world")]
    world, half = load_barn(files[9]), load_barn(files[9], 0.5)
    assert world.name == half.name == "barn:9"
    np.testing.assert_array_equal([world.start, world.goal], [[-2.25, 3.0], [-2.25, 13.0]])
    np.testing.assert_array_equal([half.start, half.goal], [[-1.125, 1.5], [-1.125, 6.5]])
    trial = Settings().with_values(barn_rules(0.5))
    assert (trial.planner.goal_tolerance, trial.trial.timeout) == (0.5, 100.0)


def test_folders_without_worlds_or_with_one_twice_are_refused(tmp_path, folder):
    (tmp_path / "empty").mkdir()
    with pytest.raises(WorldError, match="world_N"):
        barn_files(tmp_path / "empty")
    write(folder, model(CYLINDER), name="world_9.world")
    with pytest.raises(WorldError, match="same world"):
        barn_files(folder)


def test_lengths_from_the_list_or_from_the_paths_of_the_data_set(folder):
    assert optimal_lengths(folder) == {}
    (folder / "path_files").mkdir()
    # straight up the column of cells right of the start: from -4.575 + 16 * 0.15 = -2.175
    np.save(folder / "path_files" / "path_10.npy", np.array([[16, 0], [16, 20]]))
    expected = np.hypot(0.075, 2.075) + 20 * 0.15 + np.hypot(0.075, 13.0 - 8.075)
    assert optimal_lengths(folder) == {"barn:10": pytest.approx(expected)}
    for content in (b"", b"\x80\x04N."):
        (folder / "path_files" / "path_10.npy").write_bytes(content)
        with pytest.raises(WorldError, match=r"path_10\.npy"):
            optimal_lengths(folder)
    (folder / "path_length_m.json").write_text(json.dumps({"9": 12.0, "77": 1.0}))
    assert optimal_lengths(folder) == {"barn:9": 12.0}
    assert optimal_lengths(folder, 0.5) == {"barn:9": 6.0}
    for text in ("", "[]", '{"9": "far"}', '{"9": -1}', '{"9": NaN}', '{"nine": 1}', '{"9": [1]}'):
        (folder / "path_length_m.json").write_text(text)
        with pytest.raises(WorldError, match=r"path_length_m\.json"):
            optimal_lengths(folder)


def test_it_comes_with_its_rules_and_lengths_and_comes_back_from_a_study_folder(tmp_path, folder):
    (folder / "path_length_m.json").write_text('{"9": 12.0}')
    sources = load_sources([f"barn:{folder}"], None, None, 0.5)
    assert [source.world.name for source in sources] == ["barn:9", "barn:10"]
    assert [source.optimal_length for source in sources] == [6.0, None]
    assert all(source.values == {"planner.goal_tolerance": 0.5, "trial.timeout": 100.0} for source in sources)
    assert {source.family for source in sources} == {"barn"}
    study = make_folder(tmp_path / "study", {}, sources)
    again = read_sources(study, {"sources": source_records(sources)})
    assert [source.optimal_length for source in again] == [6.0, None]
    assert [source.world.circles.tolist() for source in again] == [source.world.circles.tolist() for source in sources]


def test_options_that_do_not_fit_are_refused(tmp_path, folder):
    for given_world, ends, scale, error, why in [
        (f"barn:{folder}", ENDS, 1.0, StudyError, "leave out"),
        ("corridor", (None, None), 0.5, StudyError, r"--barn-scale: got 0\.5"),
        (f"barn:{folder}", (None, None), -1.0, WorldError, "got -1"),
        ("barn:", (None, None), 1.0, StudyError, "barn:DIR"),
        (f"barn:{tmp_path}/none", (None, None), 1.0, WorldError, "no such"),
    ]:
        with pytest.raises(error, match=why):
            load_sources([given_world], *ends, *([] if scale == 1.0 else [scale]))
    path = write(tmp_path, model(CYLINDER), name="maze.world.gz", compressed=True)
    for start, goal in ((None, None), (ENDS[0], None), (None, ENDS[1])):
        with pytest.raises(StudyError, match="--start X Y and --goal X Y"):
            load_sources([str(path)], start, goal)
    (source,) = load_sources([str(path)], *ENDS)
    assert (source.world.name, source.family, dict(source.values)) == ("maze", "maze", {})
    assert source.world.goal.tolist() == [5.0, 0.0]
