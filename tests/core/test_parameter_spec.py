"""Every parameter: its default is valid, and what lies outside its range is refused by key, value and range."""

import math
from dataclasses import dataclass

import pytest

from collplan_core.parameters import GROUPS, Robot, Settings, all_specs
from collplan_core.parameters.spec import ParameterError, Parameters, Spec, parameter, specs

SPECS = list(all_specs().values())
WRONG_TYPES = {
    bool: ("true", 1, None),
    int: (1.0, "1", True, None),
    float: ("1.0", True, None, [1.0]),
    str: (1, True, None),
    tuple: (1.0, True, None, "1.0", ["1.0"], [None]),
}


def refusal(spec: Spec, value: object) -> str:
    with pytest.raises(ParameterError) as refused:
        Settings().with_values({spec.key: value})
    message = str(refused.value)
    assert spec.key in message
    assert repr(value) in message
    assert spec.expected in message
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


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.key)
def test_default_and_bounds_are_valid(spec):
    bounds = [of_kind(bound, spec) for bound in (spec.low, spec.high) if bound is not None]
    for value in (spec.default, *bounds, *spec.choices):
        assert Settings().with_values({spec.key: value}).values()[spec.key] == value
    assert spec.doc


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.key)
def test_wrong_type_is_refused(spec):
    for value in WRONG_TYPES[type(spec.default)]:
        refusal(spec, value)


@pytest.mark.parametrize("spec", [s for s in SPECS if s.low is not None], ids=lambda spec: spec.key)
def test_below_the_range_is_refused(spec):
    assert f"{spec.low:g}" in refusal(spec, outside(spec.low, spec, -1.0))


@pytest.mark.parametrize("spec", [s for s in SPECS if s.high is not None], ids=lambda spec: spec.key)
def test_beyond_the_range_is_refused(spec):
    assert f"{spec.high:g}" in refusal(spec, outside(spec.high, spec, 1.0))


@pytest.mark.parametrize("spec", [s for s in SPECS if isinstance(s.default, float)], ids=lambda spec: spec.key)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_number_that_is_not_finite_is_refused(spec, value):
    refusal(spec, value)


@pytest.mark.parametrize("spec", [s for s in SPECS if s.choices], ids=lambda spec: spec.key)
def test_unknown_choice_is_refused_with_the_known_ones(spec):
    message = refusal(spec, "no such choice")
    assert all(choice in message for choice in spec.choices)


def test_every_number_has_a_range():
    numbers = [spec for spec in SPECS if type(spec.default) in (int, float)]
    assert [spec.key for spec in numbers if spec.low is None or spec.high is None] == []


def test_unknown_key_is_refused_with_the_nearest():
    with pytest.raises(
        ParameterError, match=r"^planner\.map_perod: unknown parameter, did you mean planner\.map_period"
    ):
        Settings().with_values({"planner.map_perod": 0.2})


def test_a_choice_that_is_misspelt_is_refused_with_the_nearest():
    with pytest.raises(ParameterError, match=r"'bonce', expected one of .*; did you mean bounce\?"):
        Settings().with_values({"planner.strategy": "bonce"})


@pytest.mark.parametrize("key", ["", "planner", "planner.map_period.more", "map_period", ".radius"])
def test_key_of_another_form_is_unknown(key):
    with pytest.raises(ParameterError, match="unknown parameter"):
        Settings().with_values({key: 0.2})


def test_group_checks_itself():
    with pytest.raises(ParameterError, match=r"^robot\.radius: got -1\.0, expected a number in \[0\.01, 1\] m$"):
        Robot(radius=-1.0)


def test_whole_number_becomes_a_number_where_one_is_expected():
    speed = Settings().with_values({"robot.max_speed": 1}).robot.max_speed
    assert type(speed) is float


def test_set_values_leave_the_others_alone():
    before = Settings().values()
    after = Settings().with_values({"planner.n_directions": 16, "robot.mass": 1.5}).values()
    assert after == before | {"planner.n_directions": 16, "robot.mass": 1.5}


def test_keys_name_group_and_field_once():
    assert len(SPECS) == sum(len(specs(group)) for group in GROUPS)
    assert {key.split(".")[0] for key in all_specs()} == {group.group for group in GROUPS}
    assert list(Settings().values()) == list(all_specs())


def test_field_without_default_is_a_mistake_of_the_group():
    @dataclass(frozen=True)
    class Nameless(Parameters):
        group = "nameless"
        size: float

    with pytest.raises(TypeError, match=r"Nameless\.size has no default"):
        specs(Nameless)


def test_expected_is_said_in_words():
    @dataclass(frozen=True)
    class Example(Parameters):
        group = "example"
        speed: float = parameter(1.0, "doc", unit="m/s", low=0.0)
        count: int = parameter(1, "doc", high=5)
        on: bool = parameter(True, "doc")
        name: str = parameter("a", "doc", choices=("a", "b"))

    assert [spec.expected for spec in specs(Example)] == [
        "a number in [0, inf] m/s",
        "a whole number in [-inf, 5]",
        "true or false",
        "one of a, b",
    ]
