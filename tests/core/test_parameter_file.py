"""Parameters: what is valid, files in ROS 2's forms, and errors that name file, key, value and range."""

import math
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from collplan_core.parameters import Settings, all_specs
from collplan_core.parameters.file import NODES, follows_clock, read_parameters, write_parameters
from collplan_core.parameters.groups import SHORTEST_MAP_PERIOD, without_effect
from collplan_core.parameters.spec import ParameterError, Spec
from collplan_core.yaml_text import LONGEST

ROOT = Path(__file__).parents[2]


TOPICS = st.from_regex(r"/?[a-z_][a-z_0-9]{0,8}(/y)?", fullmatch=True)
BOUND_TO_MORE = {
    "local_map.n_rays": st.integers(90, 180).map(lambda quarter: 4 * quarter),
    "planner.map_period": st.just(0.0) | st.floats(SHORTEST_MAP_PERIOD, 1.0),
    "limits.fence": st.floats(0.1, 1e3).map(lambda side: (0.0, 0.0, side, 0.0, 0.0, side)),
    "scan.median": st.sampled_from([1, 3, 9]),
    **dict.fromkeys(("mocap.topic", "base.topic", "base.touch_topic"), TOPICS),
    "emulator.faults": st.sampled_from(("", "unplugged", "lost=0.1, restarts=2")),
    "scan.masked_angles": st.lists(st.floats(-3.0, 3.0), max_size=4).map(lambda angles: (*angles, *angles)),
}
"""Of parameters that not every value of their range suits."""


def values_of(spec: Spec) -> st.SearchStrategy:
    kind = type(spec.default)
    if spec.key in BOUND_TO_MORE:
        return BOUND_TO_MORE[spec.key]
    if spec.choices:
        return st.sampled_from(spec.choices)
    if kind is bool:
        return st.booleans()
    if kind is int:
        return st.integers(int(spec.low), int(spec.high))
    if kind is float:
        return st.floats(spec.low, spec.high)
    if kind is tuple:
        count = len(spec.default)
        return st.lists(st.floats(spec.low, spec.high), min_size=count, max_size=count or 8).map(tuple)
    return st.text(st.characters(codec="utf-8", exclude_categories=["C"]), max_size=8)


@given(st.fixed_dictionaries({}, optional={key: values_of(spec) for key, spec in all_specs().items()}))
@example(values={"mocap.frame": "1e100"})
def test_what_is_written_is_read(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("parameters") / "all.yaml"
    expected = Settings().with_values(values)
    write_parameters(expected, path)
    assert Settings().with_values(read_parameters(path)) == expected


FORMS = {
    "full name": "/planner_node:\n  ros__parameters:\n    planner.map_period: 0.3\n",
    "beside ROS's own": "/**:\n  ros__parameters:\n    use_sim_time: true\n    planner.map_period: 0.3\n",
    "every node of the root": "/*:\n  ros__parameters:\n    planner.map_period: 0.3\n",
    "sections of one name": "/**:\n  ros__parameters:\n    planner: {map_period: 0.3}\n/**:\n  ros__parameters: {}\n",
    "another robot's": "/**: {ros__parameters: {planner.map_period: 0.3}}\n"
    "/robot2/**: {ros__parameters: {planner.map_period: 9}}",
    "node before all": "planner_node:\n  ros__parameters:\n    planner.map_period: 0.3\n"
    "/**:\n  ros__parameters:\n    planner.map_period: 0.7\n",
}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("/**: {ros__parameters: {use_sim_time: true}}", True),
        ("/**: {ros__parameters: {planner.map_period: 0.3}}", False),
        ("/robot2/**: {ros__parameters: {use_sim_time: true}}\n/**: {ros__parameters: {}}", False),
        ("/**: {ros__parameters: {use_sim_time: 1}}", "got .*1.*, expected true or false"),
        (
            "/**: {ros__parameters: {use_sim_time: true}}\nmocap_node: {ros__parameters: {use_sim_time: false}}",
            "use_sim_time: got .*mocap_node.*expected one value for every node",
        ),
    ],
)
def test_use_sim_time_of_a_file_is_one_value_for_every_node(tmp_path, text, expected):
    path = tmp_path / "sim.yaml"
    path.write_text(text)
    if isinstance(expected, bool):
        assert follows_clock(path) == expected
    else:
        with pytest.raises(ParameterError, match=expected):
            follows_clock(path)


def read(tmp_path: Path, text: str) -> dict:
    path = tmp_path / "parameters.yaml"
    path.write_text(text)
    return read_parameters(path)


def test_forms_of_ros(tmp_path):
    for form, text in FORMS.items():
        assert read(tmp_path, text) == {"planner.map_period": 0.3}, form


ROBOTS = """\
/**: {ros__parameters: {robot.radius: 0.1, mocap.subject: all}}
/robot1/**: {ros__parameters: {mocap.subject: first}}
robot2: {planner_node: {ros__parameters: {planner.map_period: 0.3}}}
/*/controller_node: {ros__parameters: {controller.k_p: 1.5}}
/camera/driver: {ros__parameters: {whatever: 1}}
/planner_node: {ros__parameters: {planner.goal_tolerance: 0.2}}
"""


def test_sections_of_other_robots_are_left_out_by_the_rule_of_ros(tmp_path):
    (tmp_path / "robots.yaml").write_text(ROBOTS)
    for namespace, of_it in (
        ("/", {"mocap.subject": "all", "planner.goal_tolerance": 0.2}),
        ("/robot1", {"mocap.subject": "first", "controller.k_p": 1.5}),
        ("robot2/", {"mocap.subject": "all", "planner.map_period": 0.3, "controller.k_p": 1.5}),
        ("/a/b", {"mocap.subject": "all"}),
    ):
        assert read_parameters(tmp_path / "robots.yaml", namespace) == {"robot.radius": 0.1, **of_it}, namespace
    (tmp_path / "robots.yaml").write_text("planner_node: {ros__parameters: {planner.map_period: 0.3}}")
    with pytest.raises(ParameterError, match=r"planner_node: .*expected /robot1/planner_node"):
        read_parameters(tmp_path / "robots.yaml", "/robot1")


def in_every_node(text: str) -> str:
    return "/**:\n  ros__parameters:\n    " + text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("teleop: {deadzone: 0.2, rate: 20.0}", "teleop.deadzone and 1 more: no longer a parameter"),
        ("simulator.patience: 2.0\nteleop_node: {ros__parameters: {robot.mass: 0.2}}", "simulator.patience: no"),
    ],
)
def test_a_file_with_removed_parameters_is_read_with_a_sentence(tmp_path, caplog, text, said):
    assert read(tmp_path, in_every_node(f"robot.radius: 0.1\n    {text}")) == {"robot.radius": 0.1}
    assert [f"{tmp_path / 'parameters.yaml'}: {said}" in message for message in caplog.messages] == [True]


def test_no_parameter_begins_as_a_removed_one_does():
    assert without_effect(all_specs()) == ""


BAD = {
    "a key that is gone": (in_every_node("time_to_goal.speed_limit: 1.3"), ["no longer", "limits.impact_speed"]),
    "unknown key": (in_every_node("planner.map_periods: 0.3"), ["planner.map_periods", "planner.map_period"]),
    "wrong type": (in_every_node("robot.max_speed: fast"), ["robot.max_speed", "'fast'", "0.05", "5"]),
    "no sections": ("planner.strategy: harness", ["planner.strategy", "ros__parameters"]),
    "nodes that differ": (
        "mocap_node: {ros__parameters: {robot.radius: 0.1}}\nplanner_node: {ros__parameters: {robot.radius: 0.2}}",
        ["robot.radius", "0.1", "0.2"],
    ),
    "unknown node in a namespace": (
        "robot1: {planer_node: {ros__parameters: {planner.map_period: 0.3}}}",
        ["no section is for nodes of /", "expected /**"],
    ),
    "key given twice": (
        in_every_node("robot: {radius: 0.1}\n    planner.map_period: 0.3\n    robot.radius: 0.2"),
        ["robot.radius", "0.1", "0.2"],
    ),
    "key twice in two groups": (
        in_every_node("robot: {radius: 0.1}\n    robot: {radius: 0.2}"),
        ["line 4: radius", "line 3"],
    ),
    "key twice in two sections": (2 * in_every_node("robot.radius: 0.1\n"), ["line 6: robot.radius", "line 3"]),
    "emptied group": (in_every_node("robot:"), ["robot: holds nothing"]),
    "date": (in_every_node("robot.radius: 2026-13-45"), ["robot.radius", "2026-13-45"]),
}


HOSTILE = {
    "alias of itself": ("a: &a\n  b: *a\n", ["line 1", "alias"]),
    "deep": ("[" * 20_000, ["too deep"]),
    "long": ("#" * (LONGEST + 1), [f"expected at most {LONGEST}"]),
}


def test_a_bad_file_is_one_short_line_with_file_key_value_and_range(tmp_path):
    for kind, (text, words) in (BAD | HOSTILE).items():
        with pytest.raises(ParameterError) as error:
            read(tmp_path, text)
        message = str(error.value)
        for word in [str(tmp_path / "parameters.yaml"), *words]:
            assert word in message, kind
        assert "\n" not in message, kind
        assert len(message) < 500, kind


def test_what_is_no_file_or_one_without_end_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="no such"):
        read_parameters(tmp_path / "none.yaml")
    with pytest.raises(ParameterError, match=r"/dev/zero: got .* bytes"):
        read_parameters("/dev/zero")


def test_every_node_with_parameters_can_have_a_section():
    sources = [path.read_text() for path in (ROOT / "src").rglob("*.py")]
    names = [re.findall(r'super\(\).__init__\("(\w+)"', text) for text in sources if "\nGROUPS = " in text]
    assert sorted(NODES) == sorted(name for found in names for name in found)


def test_the_sets_of_lidars_say_how_scans_are_read_and_nothing_else():
    for path in sorted((ROOT / "src/collplan_ros/collplan_ros/config").glob("lidar_*.yaml")):
        values = read_parameters(path)
        assert values["scan.frame"], path
        assert all(key.startswith("scan.") or key == "limits.lost_beams" for key in values), path
        assert path.name in (ROOT / "docs/hardware.md").read_text(), path


def test_the_sets_of_bases_fit_together_and_are_said_to_be_untried():
    sets = sorted((ROOT / "src/collplan_ros/collplan_ros/config").glob("base_*.yaml"))
    assert len(sets) == 5
    for path in sets:
        settings = Settings().with_values(read_parameters(path))
        assert settings.robot.max_speed <= settings.cap.speed, path
        assert settings.mocap.frame or not settings.mocap.localised, path
        assert "Untried" in path.read_text(), path
        assert path.name in (ROOT / "docs/tutorials/own_robot.md").read_text(), path


SPECS = list(all_specs().values())
NOT_FINITE = (math.nan, math.inf, -math.inf)
WRONG = {
    bool: ("true", 1, None),
    int: (1.0, "1", True, None),
    float: ("1.0", True, None, [1.0], *NOT_FINITE),
    str: (1, True, None),
    tuple: (1.0, True, None, "1.0", ["1.0"], [None]),
}


def refusal(spec: Spec, value: object) -> str:
    with pytest.raises(ParameterError) as refused:
        Settings().with_values({spec.key: value})
    message = str(refused.value)
    for part in (spec.key, repr(value), spec.expected):
        assert part in message, spec.key
    return message


def of_kind(number: float, spec: Spec) -> object:
    """A value of the parameter's type made of a number: of a fence three corners, of a mask or floor both numbers."""
    if spec.key == "limits.fence":
        return (0.0, 0.0, number, 0.0, 0.0, number)
    if spec.key == "scan.masked_angles" or spec.key.endswith(".floor_tilt"):
        return (number, number)
    return (number,) if isinstance(spec.default, tuple) else type(spec.default)(number)


def outside(bound: float, spec: Spec, direction: float) -> object:
    if isinstance(spec.default, tuple):
        return (0.0, math.nextafter(bound, direction * math.inf))
    return int(bound + direction) if isinstance(spec.default, int) else math.nextafter(bound, direction * math.inf)


def test_default_bounds_and_choices_are_valid_and_documented():
    for spec in SPECS:
        bounds = [of_kind(bound, spec) for bound in (spec.low, spec.high) if bound is not None]
        for value in (spec.default, *bounds, *spec.choices):
            assert Settings().with_values({spec.key: value}).values()[spec.key] == value, spec.key
        assert spec.doc, spec.key
        assert type(spec.default) not in (int, float) or None not in (spec.low, spec.high), spec.key


def test_what_is_of_the_wrong_type_outside_the_range_or_no_choice_is_refused():
    for spec in SPECS:
        for value in WRONG[type(spec.default)]:
            refusal(spec, value)
        for bound, direction in ((spec.low, -1.0), (spec.high, 1.0)):
            if bound is not None:
                assert f"{bound:g}" in refusal(spec, outside(bound, spec, direction)), spec.key
        if spec.choices:
            assert all(choice in refusal(spec, "nonsense") for choice in spec.choices), spec.key


def test_numbers_of_numpy_are_numbers_of_their_kind():
    given = {
        "robot.mass": np.int32(1),
        "simulator.seed": np.uint8(3),
        "limits.fence": np.array([0, 0, 1, 0, 1, 1], np.float32),
    }
    given |= {"trial.known_map": np.bool_(True), "planner.strategy": np.str_("bounce")}
    after = Settings().with_values(given)
    assert (after.robot.mass, after.simulator.seed, after.trial.known_map) == (1.0, 3, True)
    assert all(type(each) is float for each in after.limits.fence)
    for key, value in (("simulator.seed", np.float64(1.0)), ("robot.mass", np.bool_(True)), ("robot.mass", np.nan)):
        with pytest.raises(ParameterError, match=key):
            Settings().with_values({key: value})


def test_the_page_has_every_parameter_as_the_code_has_it():
    tool = runpy.run_path(str(ROOT / "tools" / "parameter_table.py"))
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert tool["with_tables"](page) == page, "run tools/parameter_table.py"


SCALED = [spec for spec in all_specs().values() if spec.of_radius]


@given(st.floats(0.03, 0.3), st.floats(0.03, 0.3))
def test_lengths_at_their_defaults_follow_the_radius_and_others_stay(first, second):
    assert len(SCALED) == 9
    given = {"robot.radius": first, "time_to_goal.grid_spacing": 0.0517}
    once = Settings().with_values(given)
    twice = once.with_values({"robot.radius": second})
    for settings, radius in ((once, first), (twice, second)):
        values = settings.values()
        assert values["time_to_goal.grid_spacing"] == 0.0517
        for spec in SCALED:
            if spec.key in given:
                continue
            scaled = spec.default * radius / 0.09
            assert values[spec.key] == pytest.approx(min(max(scaled, spec.low), spec.high))
    written = once.with_values(once.values())
    assert written == once
