"""Worlds in SDF and of BARN as world files, what is refused with its file and line, and BARN's score."""

import gzip
import json

import numpy as np
import pytest

from barn import main, optimal_lengths
from collplan_core.worlds import WorldError, read_world
from collplan_study.question.question import Question
from collplan_study.question.sources import load_sources
from fake_studies import fake_study, reached
from sdf import load_sdf

CYLINDER = "<cylinder><radius>0.2</radius><length>1</length></cylinder>"
BOX = "<box><size>2 1 0.5</size></box>"
START, GOAL = (-5.0, 0.0), (5.0, 0.0)


def model(shape, name="thing", at="", link_at="", collision_at=""):
    """A model with one link that holds the shape twice, as what collides and as what is seen."""
    poses = [f"<pose frame=''>{text}</pose>" if text else "" for text in (at, link_at, collision_at)]
    geometry = f"<geometry>{shape}</geometry>"
    return (
        f"<model name='{name}'>{poses[0]}\n<link name='link'>{poses[1]}\n<collision name='c'>{poses[2]}\n{geometry}"
        f"</collision>\n<visual name='v'>{geometry}</visual></link></model>\n"
    )


def write(folder, *pieces, name="small.world", head=""):
    text = f"<?xml version='1.0'?>\n{head}<sdf version='1.6'><world name='w'>\n{''.join(pieces)}</world></sdf>"
    (folder / name).write_bytes(gzip.compress(text.encode()) if name.endswith("gz") else text.encode())
    return folder / name


def turned(x, y, yaw):
    return np.array([[np.cos(yaw), -np.sin(yaw), x], [np.sin(yaw), np.cos(yaw), y], [0.0, 0.0, 1.0]])


def test_poses_compose_those_of_the_state_win_and_scale_is_one_factor(tmp_path):
    poses = [(1.0, 2.0, 0.3), (0.5, -1.0, -1.2), (0.2, 0.1, 2.0)]
    texts = [f"{x} {y} 0 0 0 {yaw}" for x, y, yaw in poses]
    moved = "<state><model name='b'><pose>0 3 0 0 0 0</pose></model></state>"
    path = write(tmp_path, model(BOX, "a", *texts), model(CYLINDER, "b", "1 2 0 0 0 0"), moved, name="small.world.gz")
    world = load_sdf(path, START, GOAL, 0.5)
    corners = np.linalg.multi_dot([*map(turned, *zip(*poses, strict=True))])
    corners = corners @ np.array([[-1, 1, 1, -1], [-0.5, -0.5, 0.5, 0.5], [1, 1, 1, 1]])
    np.testing.assert_allclose(world.polygons[0], 0.5 * corners[:2].T)
    np.testing.assert_allclose(world.circles, [[0.0, 1.5, 0.1]])
    assert (world.name, world.walled, world.start.tolist()) == ("small", False, [-2.5, 0.0])


WRONG = [
    (model("<mesh><uri>x</uri></mesh>"), ":6: model 'thing': mesh"),
    ("<include><uri>model://house</uri></include>", "not supported"),
    (model(CYLINDER).replace("0.2", "-1"), "got '-1'"),
    (model(CYLINDER, at="0 0 0 1.57 0 0"), "tilted"),
    (model(CYLINDER, at="0 0 zero 0 0 0"), ":3: model 'thing': pose"),
    (model(CYLINDER, at="-5 0 0 0 0 0"), "inside circles[0]"),
    ("", "no obstacles"),
    ("</world><world name='second'>", "2 worlds"),
    ("<world>", "as XML"),
]


def test_what_cannot_be_used_is_named_with_its_file(tmp_path):
    for piece, expected in WRONG:
        with pytest.raises(WorldError) as caught:
            load_sdf(write(tmp_path, piece), START, GOAL)
        assert expected in str(caught.value)
        assert "small.world" in str(caught.value)
    entity = "<!DOCTYPE sdf [<!ENTITY x SYSTEM 'file:///etc/hostname'>]>"
    with pytest.raises(WorldError, match="document type"):
        load_sdf(write(tmp_path, model(CYLINDER), head=entity), START, GOAL)


def test_barn_is_converted_and_scored(tmp_path, capsys):
    data, worlds = tmp_path / "data", tmp_path / "barn"
    data.mkdir()
    for name in ("world_10.world", "world_9.world.gz"):
        write(data, model(CYLINDER, at="-2 6 0 0 0 0"), name=name)
    assert main(["worlds", str(data), "--out", str(worlds), "--scale", "0.5"]) == 0
    world = read_world(worlds / "world_9.yaml")
    assert (world.name, world.goal.tolist()) == ("barn:9", [-1.125, 6.5])
    (data / "path_files").mkdir()
    # straight up the column of cells right of the start: from -4.575 + 16 * 0.15 = -2.175
    np.save(data / "path_files" / "path_10.npy", np.array([[16, 0], [16, 20]]))
    expected = np.hypot(0.075, 2.075) + 20 * 0.15 + np.hypot(0.075, 13.0 - 8.075)
    assert optimal_lengths(data) == {"barn:10": pytest.approx(expected)}
    (data / "path_length_m.json").write_text(json.dumps({"9": 20.0, "10": 20.0}))

    def touches_in_one(task):
        return reached(12.0, impacts=int(task.world.name == "barn:10"))

    question = Question((str(worlds),), ("harness",), map_periods=(0.2,), trials=1)
    study = fake_study(tmp_path / "study", touches_in_one, question, load_sources(question.worlds, None, None))
    capsys.readouterr()
    assert main(["score", str(study), str(data), "--scale", "0.5"]) == 0
    few = "(2 of 5 needed for an interval)"
    assert f"| harness | 2 | 2 | 2.40 | {5 / 12:.3f} {few} | 1 | {5 / 24:.3f} {few} |" in capsys.readouterr().out
