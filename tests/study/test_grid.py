"""The grid: its trials, their order, their seeds and their worlds; what it cannot be."""

from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.parameters import Settings, all_specs
from collplan_core.parameters.spec import ParameterError
from collplan_core.planners import PAPER
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import WorldError, load_world, save_world
from collplan_core.worlds.families import FAMILIES
from collplan_study.errors import StudyError
from collplan_study.question import held_out
from collplan_study.question.grid import NO_ABLATION, load_sources, make_grid, trial_seed
from collplan_study.question.question import Question
from collplan_study.question.specification import ABLATIONS
from collplan_study.question.specification import PAPER as PAPERS_QUESTION


def grid_of(changes=None, /, **parts):
    question = Question(**parts)
    sources = load_sources(question.worlds, question.start, question.goal)
    return make_grid(question, sources, changes or NO_ABLATION)


def test_the_default_is_the_papers_300_runs():
    grid = grid_of()
    tasks = list(grid)
    assert len(grid) == len(tasks) == 300
    cells = {(task.labels["strategy"], task.labels["map_period_s"]) for task in tasks}
    assert cells == set(product(PAPER_WEIGHTS, (0.2, 0.4, 0.6, 0.8, 1.0)))
    assert {task.labels["world"] for task in tasks} == {"corridor"}
    assert [task.index for task in tasks] == list(range(300))
    assert tasks[0].settings == Settings().with_values({"planner.map_period": 0.2})


def test_tasks_do_what_their_labels_say():
    for task in grid_of(
        worlds=("corridor", "random:3"), values=("simulator.noise=0,2", "planner.n_speeds=3"), trials=2
    ):
        labels, known = task.labels, task.settings.values()
        assert labels["seed"] == task.seed
        assert labels["world"] == task.world.name
        assert labels["family"] == task.world.name.split(":")[0]
        assert (labels["strategy"], labels["map_period_s"]) == (known["planner.strategy"], known["planner.map_period"])
        assert (labels["simulator.noise"], labels["planner.n_speeds"]) == (known["simulator.noise"], 3)


def test_strategies_periods_and_parameters_meet_the_same_noise():
    tasks = list(grid_of(worlds=("corridor", "slalom"), trials=3, values=("planner.n_speeds=3,4",)))
    seeds = {(task.labels["world"], task.labels["trial"]): task.seed for task in tasks}
    assert all(task.seed == seeds[task.labels["world"], task.labels["trial"]] for task in tasks)
    assert len(set(seeds.values())) == 6
    alone = list(grid_of(worlds=("slalom",), strategies=("low_risk",), map_periods=(0.5,), trials=3))
    assert [task.seed for task in alone] == [seeds["slalom", trial] for trial in range(3)]


@given(st.integers(0, 2**40), st.text(), st.integers(0, 10**6))
def test_seeds_fit_the_simulator_and_differ(study, world, trial):
    seed = trial_seed(study, world, trial)
    assert 0 <= seed <= all_specs()["simulator.seed"].high
    others = {
        trial_seed(study + 1, world, trial),
        trial_seed(study, world + "x", trial),
        trial_seed(study, world, trial + 1),
    }
    assert seed not in others


def test_other_strategies_have_one_period_of_their_own():
    periods = {task.labels["map_period_s"] for task in grid_of(strategies=("custom",), trials=1)}
    assert periods == {PAPER.map_period}
    assert {t.labels["map_period_s"] for t in grid_of(strategies=("custom",), trials=1, map_periods=(0.3,))} == {0.3}


def test_families_are_ranges_or_folders_and_all_ranges_are_held_out(tmp_path):
    sources = load_sources(("random:3", "random:10-12", "corridor"), None, None)
    assert [s.world.name for s in sources] == ["random:3", "random:10", "random:11", "random:12", "corridor"]
    assert [s.family for s in sources] == ["random"] * 4 + ["corridor"]
    for family in FAMILIES:
        sources = load_sources((f"{family}:0-3",), None, None)
        assert [(s.world.name, s.family) for s in sources] == [(f"{family}:{seed}", family) for seed in range(4)]
    for seed in (3, 4):
        save_world(load_world(f"random:{seed}"), tmp_path / f"{seed}.yaml")
    named = [(s.world.name, s.family) for s in load_sources((str(tmp_path),), None, None)]
    assert named == [("random:3", tmp_path.name), ("random:4", tmp_path.name)]
    assert {*held_out.FAMILIES, *held_out.FURTHER_FAMILIES} == {*FAMILIES}


def test_ablations_come_with_the_unchanged_grid_and_outrank_the_axes():
    grid = grid_of(ABLATIONS, strategies=("harness",), map_periods=(0.2,), trials=2, values=("simulator.noise=0.5",))
    names = [task.labels["ablation"] for task in grid]
    assert names[0] == ""
    assert sorted(set(names)) == sorted(ABLATIONS)
    assert len(grid) == 2 * len(ABLATIONS)
    for task in grid:
        changes = dict(ABLATIONS[task.labels["ablation"]])
        assert task.labels["simulator.noise"] == changes.get("simulator.noise", 0.5)
        assert {key: task.settings.values()[key] for key in changes} == changes
    question = Question(**{**PAPERS_QUESTION.with_ablations, "worlds": ("random:0-1",), "ablations": True})
    asked = make_grid(question, load_sources(question.worlds, None, None), ABLATIONS)
    assert len(asked) == len(ABLATIONS) * 2 * 3 * question.trials


def test_each_ablation_is_one_change_and_every_reading_that_has_a_printed_form_is_among_them():
    before = Settings().values()
    for name, changes in ABLATIONS.items():
        after = Settings().with_values(dict(changes)).values()
        assert {key for key in after if after[key] != before[key]} == set(changes), name
        assert bool(changes) == bool(name)
    changed = {key: value for changes in ABLATIONS.values() for key, value in changes.items()}
    printed = {key for key, spec in all_specs().items() if "printed" in spec.choices and spec.default != "printed"}
    assert {key for key, value in changed.items() if value == "printed"} == printed


WRONG = [
    ({"worlds": ("corridr",)}, WorldError, "corridor"),
    ({"worlds": ("random:9-3",)}, WorldError, "A-B"),
    ({"worlds": ("random:3", "random:0-9")}, StudyError, "random:3"),
    ({"worlds": (str(Path(__file__).parent),)}, WorldError, "no world files"),
    ({"trials": 0}, StudyError, "--trials: got"),
    ({"strategies": ("fast",)}, ParameterError, "got 'fast'"),
    ({"strategies": ("harness", "harness")}, StudyError, "2 times"),
    ({"values": ("planner.map_perid=1",)}, ParameterError, "planner.map_period"),
    ({"values": ("trial.known_map=true",)}, ParameterError, "known_map: got True .*harness, expected .*bounce"),
    ({"values": ("planner.gap_weight",)}, StudyError, "KEY=VALUE"),
    ({"values": ("planner.gap_weight=1,1.0",)}, StudyError, "once"),
    ({"values": ("planner.strategy=harness",)}, StudyError, "--strategies"),
    ({"values": ("robot.radius=0.3",)}, WorldError, "0.3 m"),
    ({"bounces": True, "strategies": ("bounce",)}, StudyError, "--strategies: got one"),
    ({"bounces": True, "values": ("robot.max_acceleration=1,2",)}, StudyError, "--set robot.max_acceleration=1,2"),
    ({"bounces": True, "map_periods": (0.05, 0.1)}, StudyError, "--map-periods"),
    ({"ablations": True, "ablation_strategies": ("avoid",)}, StudyError, "--ablation-strategies: got avoid"),
]


def test_what_cannot_be_run_is_said():
    for parts, error, expected in WRONG:
        with pytest.raises(error, match=expected):
            grid_of(**parts)
