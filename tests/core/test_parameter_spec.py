"""Every parameter: its default is valid, and what lies outside its range is refused by key, value and range."""

import math
import runpy
from pathlib import Path

import pytest

from collplan_core.parameters import Settings, all_specs
from collplan_core.parameters.spec import ParameterError, Spec

ROOT = Path(__file__).parents[2]
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
    """A value of the parameter's type made of a number: of a fence three corners, of a mask both its ends."""
    if spec.key == "limits.fence":
        return (0.0, 0.0, number, 0.0, 0.0, number)
    if spec.key == "scan.masked_angles":
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


def test_what_is_misspelt_is_refused_with_the_nearest():
    with pytest.raises(ParameterError, match=r"planner\.map_perod: unknown.*planner\.map_period"):
        Settings().with_values({"planner.map_perod": 0.2})
    with pytest.raises(ParameterError, match=r"'bonce', .*bounce"):
        Settings().with_values({"planner.strategy": "bonce"})
    with pytest.raises(ParameterError, match="unknown"):
        Settings().with_values({"map_period": 0.2})


def test_set_values_leave_the_others_alone_and_whole_numbers_become_numbers():
    before = Settings().values()
    after = Settings().with_values({"planner.n_directions": 16, "robot.mass": 1}).values()
    assert after == before | {"planner.n_directions": 16, "robot.mass": 1.0}
    assert type(after["robot.mass"]) is float


def test_the_page_has_every_parameter_as_the_code_has_it():
    tool = runpy.run_path(str(ROOT / "tools" / "parameter_table.py"))
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert tool["with_tables"](page) == page, "run tools/parameter_table.py"
