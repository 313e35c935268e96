"""What a run leaves in its folder, from a log made by hand."""

import csv
import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.plan import Contacts
from collplan_core.sensing.pose_filter import FRESH, PoseSample, filter_pose
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.options import Options, parse
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.results import write_results
from collplan_ros.bringup.robots import ROBOTS
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.pictures.trajectory_png import draw_trajectory
from collplan_ros.runs.impact_log import impacts_of, nearest_surface
from collplan_ros.runs.run_log import ImpactRecord, PlanRow, PoseRow, RunLog, SentCommand, SentManeuver, SentReference
from collplan_ros.runs.summary import summarize
from collplan_ros.runs.trajectory_file import COLUMNS, write_trajectory

EPOCH = 1.7e9
WALL = 1.0
RADIUS = Settings().robot.radius
WINDOW = Settings().mocap.velocity_window
HIT_AT = 1.0
SPEED = 0.5


def room() -> World:
    block = np.array([[WALL, -1.0], [2.0, -1.0], [2.0, 1.0], [WALL, 1.0]])
    return World("room", (block,), np.array([[-1.0, 0.5, 0.2]]), (-2.0, -1.5, 2.5, 1.5))


def bouncing_run() -> RunLog:
    """Straight at a wall with SPEED, met at HIT_AT, and back with half of it."""
    log = RunLog(sent_maneuvers=[SentManeuver(77.151, "free_space")])
    for k in range(200):
        t = 0.01 * k
        begin = WALL - RADIUS - SPEED * HIT_AT
        x = begin + SPEED * t if t < HIT_AT else WALL - RADIUS - 0.5 * SPEED * (t - HIT_AT)
        row = PoseRow(EPOCH + t, x, 0.1, 0.0, SPEED if t < HIT_AT else -0.5 * SPEED, 0.0, 77.0 + t)
        log.poses.append(row)
        log.truth.append(row)
        if k % 5 == 0:
            log.sent_commands.append(SentCommand(77.0 + t, 0.3 if t > 0.12 else 0.0, 0.0, 0.0))
            log.scans.append(
                simulate_scan(room(), State(row.stamp, np.array([row.x, row.y]), np.zeros(2), 0.0), Settings().lidar)
            )
        if k % 20 == 0:
            log.plans.append(PlanRow(EPOCH + t, EPOCH + t + np.array([0.0, 1.0]), np.array([[x, 0.1], [x + 0.5, 0.1]])))
            touch = Contacts(np.array([EPOCH + HIT_AT + 0.02]), np.array([[WALL, 0.12]]), np.array([[-0.6, 0.8]]))
            log.contacts[EPOCH + t] = touch if t < HIT_AT else Contacts.none()
            log.costs.append({"planning_time_ms": 1.0 + k, "candidates": 10.0, "candidates_before_pruning": 30.0})
    log.true_impacts.append(ImpactRecord(EPOCH + HIT_AT - 0.003, -1.5 * SPEED, 0.0))
    return log


def test_an_impact_is_placed_on_the_world():
    impacts = impacts_of(bouncing_run(), room(), WINDOW)
    assert impacts.points[0] == pytest.approx([WALL, 0.1], abs=1e-9)
    assert impacts.normals[0] == pytest.approx([-1.0, 0.0])
    assert impacts.before[0] == pytest.approx([SPEED, 0.0])
    assert impacts.after[0] == pytest.approx([-0.5 * SPEED, 0.0])
    assert impacts.foreseen.tolist() == impacts.deliberate.tolist() == [True]


def test_a_graze_is_not_deliberate_nor_is_what_no_plan_foresaw():
    log = bouncing_run()
    log.truth = [row._replace(vx=0.15 if row.vx > 0.0 else -0.1) for row in log.truth]
    log.true_impacts = [ImpactRecord(EPOCH + HIT_AT - 0.003, -0.25, 0.0)]
    assert impacts_of(log, room(), WINDOW).deliberate.tolist() == [False]
    log = bouncing_run()
    log.contacts = {stamp: Contacts.none() for stamp in log.contacts}
    impacts = impacts_of(log, room(), WINDOW)
    assert impacts.deliberate.tolist() == [False]
    assert np.isnan(impacts.direction_errors).all()


def test_an_impact_that_the_ring_sensed_between_two_poses_has_the_velocities_of_the_poses_around():
    log = bouncing_run()
    log.truth, log.detected_impacts = [], [ImpactRecord(EPOCH + HIT_AT - 0.003, -0.7, 0.0)]
    # the velocities that the poses show are fitted over the last moments: they lag
    lagging = [max(-0.5 * SPEED, SPEED - 0.25 * (k - 99)) if k > 99 else SPEED for k in range(len(log.poses))]
    log.poses = [row._replace(vx=vx) for row, vx in zip(log.poses, lagging, strict=True)]
    impacts = impacts_of(log, room(), WINDOW)
    assert impacts.points[0] == pytest.approx([WALL, 0.1], abs=1e-9)
    assert impacts.before[0] == pytest.approx([SPEED, 0.0])
    assert impacts.after[0] == pytest.approx([-0.5 * SPEED, 0.0])


def test_plans_without_a_scan_of_their_stamp_and_many_a_second():
    log = bouncing_run()
    touch = log.contacts[EPOCH]
    log.contacts = {EPOCH + 0.01 * k + 0.003: touch for k in range(95)}
    log.plans = []
    assert impacts_of(log, room(), WINDOW).foreseen.tolist() == [True]
    # the last one before the hit no longer expects it
    log.contacts[EPOCH + 0.98] = Contacts.none()
    assert impacts_of(log, room(), WINDOW).foreseen.tolist() == [False]


def test_two_impacts_between_two_samples_are_kept_apart():
    log = bouncing_run()
    log.true_impacts = [
        ImpactRecord(EPOCH + HIT_AT - 0.006, -SPEED, 0.0),
        ImpactRecord(EPOCH + HIT_AT - 0.003, -0.5 * SPEED, 0.0),
    ]
    impacts = impacts_of(log, room(), WINDOW)
    assert impacts.before[:, 0] == pytest.approx([SPEED, 0.0], abs=1e-9)
    assert impacts.after[:, 0] == pytest.approx([0.0, -0.5 * SPEED], abs=1e-9)
    assert impacts.foreseen.sum() == 1


@given(st.floats(-1.99, 2.49), st.floats(-1.49, 1.49))
@settings(derandomize=True, deadline=None, max_examples=60)
def test_the_nearest_surface_is_shapelys(x, y):
    import shapely

    block, circle = shapely.Polygon(room().polygons[0]), shapely.Point(-1.0, 0.5).buffer(0.2, quad_segs=512)
    here = shapely.Point(x, y)
    if block.distance(here) < 1e-6 or circle.distance(here) < 1e-6:
        return
    point, normal = nearest_surface(room(), np.array([x, y]))
    distance = min(shape.distance(here) for shape in (block, circle, shapely.box(*room().bounds).exterior))
    assert np.hypot(*(point - [x, y])) == pytest.approx(distance, abs=1e-5)
    assert point + distance * normal == pytest.approx([x, y], abs=1e-5)


def test_the_summary_of_a_run_worked_by_hand():
    log = bouncing_run()
    summary = summarize(log, impacts_of(log, room(), WINDOW), "reached", np.array([0.0, 0.1]), Settings())
    assert summary["reached"] is True
    assert summary["arrival_time_s"] == pytest.approx(1.99 - 0.15, abs=1e-6)
    assert summary["path_length_m"] == pytest.approx(SPEED * 0.85 + 0.5 * SPEED * 0.99, abs=1e-6)
    assert summary["path_length_source"] == "ground_truth"
    assert (summary["impacts"], summary["impacts_foreseen"], summary["impacts_deliberate"]) == (1, 1, 1)
    assert summary["rebound_direction_error_deg"] == pytest.approx(np.degrees(np.arctan2(0.8, 0.6)))
    assert summary["plan_time_ms"] == {"p50": pytest.approx(91.0), "p99": pytest.approx(181.0, rel=0.02), "n": 10}
    assert summary["control_period_ms"]["p50"] == pytest.approx(50.0)
    assert summary["candidates"] == {"mean": 10.0, "before_pruning_mean": 30.0}
    assert summary["maneuvers"] == {"free_space": summary["control_period_ms"]["n"] + 1}


def test_without_a_truth_the_poses_and_the_detected_impacts_count():
    log = bouncing_run()
    log.truth, log.detected_impacts = [], [ImpactRecord(EPOCH + HIT_AT, -0.7, 0.0)]
    impacts = impacts_of(log, room(), WINDOW)
    assert impacts.after[0] == pytest.approx([-0.5 * SPEED, 0.0])
    assert impacts.before[0] == pytest.approx([0.7 - 0.5 * SPEED, 0.0])
    summary = summarize(log, impacts, "timeout", np.array([0.0, 0.1]), Settings())
    assert (summary["impacts"], summary["impacts_foreseen"], summary["impacts_deliberate"]) == (1, 1, 1)
    assert summary["arrival_time_s"] is None
    assert "5 Hz" in summary["path_length_source"]
    assert summary["path_length_m"] == pytest.approx(SPEED * 0.85 + 0.5 * SPEED * 0.99, rel=0.05)


def detected_run(before: np.ndarray, after: np.ndarray, noise: float) -> RunLog:
    """A robot without ground truth that meets the wall at HIT_AT + 4 ms, as the pose filter sees it."""
    log, memory, random = RunLog(), FRESH, np.random.default_rng(5)
    met, place = HIT_AT + 0.004, np.array([WALL - RADIUS, 0.1])
    for k in range(150):
        t = 0.01 * k
        point = place + (before if t < met else after) * (t - met) + random.normal(0.0, noise, 2)
        result, memory = filter_pose(memory, PoseSample(EPOCH + t, point, 0.0), t, Settings())
        if result.impact is not None:
            log.detected_impacts.append(ImpactRecord(EPOCH + t, *result.impact.tolist()))
        if result.state is not None:
            log.poses.append(PoseRow(EPOCH + t, *point.tolist(), 0.0, *result.state.velocity.tolist(), 77.0 + t))
        if k % 20 == 10:
            touch = Contacts(np.array([EPOCH + met]), np.array([[WALL, 0.1]]), after[None])
            log.contacts[EPOCH + t] = touch if t < met else Contacts.none()
    return log


@pytest.mark.parametrize("noise", [2e-4, 2e-3])
@pytest.mark.parametrize(("before", "after"), [((0.9, 0.3), (-0.63, 0.24)), ((0.6, -0.5), (-0.45, -0.4))])
def test_an_impact_detected_in_the_poses_has_its_velocities_before_and_after(before, after, noise):
    log = detected_run(np.array(before), np.array(after), noise)
    impacts = impacts_of(log, room(), WINDOW)
    assert len(impacts) == 1
    assert impacts.before[0] == pytest.approx(before, abs=0.04 + 60.0 * noise)
    assert impacts.after[0] == pytest.approx(after, abs=0.02 + 60.0 * noise)
    assert impacts.normals[0] == pytest.approx([-1.0, 0.0])
    assert impacts.deliberate.tolist() == [True]
    assert impacts.direction_errors[0] < 0.3


def prepared() -> Preparation:
    return Preparation(ROBOTS["sim"], "local", Settings(), room(), np.array([0.0, 0.1]), {})


def test_all_files_are_written(tmp_path):
    folder = RunFolder(tmp_path / "runs")
    folder.become_latest()
    write_results(folder, bouncing_run(), prepared(), "reached", Options())
    latest = tmp_path / "runs" / "latest"
    summary = json.loads((latest / "summary.json").read_text())
    assert summary["simulated"] is True
    assert summary["assumed"]["robot.radius"] == RADIUS
    impacts = list(csv.DictReader((latest / "impacts.csv").open()))
    assert [(row["foreseen"], row["deliberate"]) for row in impacts] == [("true", "true")]
    assert float(impacts[0]["t"]) == pytest.approx(HIT_AT - 0.153, abs=1e-5)
    vectors = [[float(impacts[0][f"{name}_v{axis}"]) for axis in "xy"] for name in ("before", "after")]
    np.testing.assert_allclose(vectors, [[SPEED, 0.0], [-0.5 * SPEED, 0.0]], atol=1e-5)
    assert float(impacts[0]["direction_error"]) == pytest.approx(np.arctan2(0.8, 0.6), abs=1e-5)
    last = list(csv.DictReader((latest / "trajectory.csv").open()))[-1]
    assert float(last["t"]) == pytest.approx(summary["arrival_time_s"], abs=1e-6)
    from PIL import Image

    for name, frames in (("trajectory.png", 1), ("run.gif", 15)):
        with Image.open(latest / name) as image:
            assert getattr(image, "n_frames", 1) >= frames
            assert image.convert("L").getextrema()[0] < image.convert("L").getextrema()[1]


@pytest.mark.parametrize("goal", [(2.0, 0.4), (-1e-05, -3.0)])
@pytest.mark.parametrize("network", [None, "subnet"])
def test_the_line_that_repeats_a_run_gives_robot_goal_and_parameters(goal, network):
    first = Options(robot="serial:/dev/my robot", goal=goal, network=network, timeout=9.0)
    program, *arguments = shlex.split(first.repeat(np.array(goal), Path("the runs/latest/parameters.yaml")))
    again = parse(arguments)
    assert (program, again.robot, again.goal, again.network) == ("bringup", first.robot, goal, network)
    assert again.params == Path("the runs/latest/parameters.yaml")


@pytest.mark.parametrize("height", [0.5, 3.0, 12.0], ids=["wide", "room", "tall"])
def test_legend_and_axis_label_lie_apart(tmp_path, monkeypatch, height):
    from matplotlib.figure import Figure

    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: drawn.append(figure))
    world = World("arena", (), np.zeros((0, 3)), (-2.0, -0.5 * height, 2.5, 0.5 * height), True, None, None)
    log = bouncing_run()
    draw_trajectory(tmp_path / "a.png", log, impacts_of(log, room(), WINDOW), world, np.zeros(2), Settings(), "title")
    (figure,) = drawn
    figure.draw_without_rendering()
    (legend,) = figure.legends
    label = figure.axes[0].xaxis.label.get_window_extent()
    assert len(legend.get_texts()) == 4
    assert not legend.get_window_extent().overlaps(label)
    assert legend.get_window_extent().y0 >= 0.0


def test_a_run_of_which_nothing_is_known_still_has_its_files(tmp_path):
    folder = RunFolder(tmp_path)
    summary = write_results(folder, RunLog(), prepared(), "graph_lost", Options())
    assert summary["reached"] is False
    assert summary["plan_time_ms"] == {"p50": None, "p99": None, "n": 0}
    assert json.loads(folder.summary.read_text())["impacts"] == 0


def test_the_trajectory_worked_by_hand(tmp_path):
    log = RunLog(
        poses=[
            PoseRow(EPOCH, 0.0, 0.0, 0.0, 0.0, 0.0, 77.0),
            PoseRow(EPOCH + 0.5, 0.4, 1.0, 0.1, 0.8, 2.0, 77.5),
        ],
        sent_commands=[SentCommand(77.1, 0.3, -0.1, 0.2), SentCommand(77.6, 9.0, 9.0, 9.0)],
        sent_maneuvers=[SentManeuver(77.101, "free_space")],
        sent_references=[SentReference(77.101, 0.5, 1.0)],
    )
    write_trajectory(tmp_path / "trajectory.csv", log)
    first, second = csv.DictReader((tmp_path / "trajectory.csv").open())
    assert tuple(first) == COLUMNS
    assert (first["cmd_vx"], first["ref_x"], first["maneuver"]) == ("nan", "nan", "stopped")
    assert (float(first["t"]), second["maneuver"]) == (pytest.approx(-0.1, abs=1e-6), "free_space")
    assert [float(second[key]) for key in COLUMNS[:-1]] == pytest.approx(
        [0.4, 0.4, 1.0, 0.1, 0.8, 2.0, 0.3, -0.1, 0.2, 0.5, 1.0], abs=1e-6
    )


def test_runs_of_the_same_second_have_folders_of_their_own(tmp_path):
    folders = [RunFolder(tmp_path) for _ in range(3)]
    for folder in folders:
        folder.become_latest()
    assert len({folder.path for folder in folders}) == 3
    assert (tmp_path / "latest").resolve() == folders[-1].path
    folders[0].discard()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == sorted(
        ["latest", folders[1].path.name, folders[2].path.name]
    )


def test_a_folder_that_cannot_be_written_is_one_clear_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StartError, match=r"run folder .*file/runs: cannot be written: Not a directory"):
        RunFolder(tmp_path / "file" / "runs")
    (tmp_path / "latest" / "in_the_way").mkdir(parents=True)
    with pytest.raises(StartError, match="latest: cannot be written"):
        RunFolder(tmp_path).become_latest()
