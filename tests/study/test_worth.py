"""`make worth`: what is between the cells of the curve, the sentences, and what is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worth import main, sentences, settings_from
from worth_curve import Cell, expected, families_of, number_of, read_curve

CELLS = read_curve()


def test_the_curve_is_exact_at_its_cells():
    for cell in CELLS:
        found = expected(CELLS, cell.family, cell.number, cell.restitution)
        assert (found.value, found.low, found.high) == pytest.approx((cell.saved, cell.low, cell.high))
        assert not found.note


@given(st.sampled_from(families_of(CELLS)), st.floats(1.0, 40.0), st.floats(1.0, 40.0), st.floats(0.0, 1.0))
def test_savings_fall_with_n(family, one, other, restitution):
    less, more = (expected(CELLS, family, number, restitution) for number in sorted((one, other)))
    assert less.low <= less.value <= less.high
    assert less.low <= more.high
    assert less.value <= more.value or min(one, other) < THRESHOLD


THRESHOLD = 8.0
"""Below this N nothing is saved but a little by the margin, and the order of the cells is chance."""


OUTSIDE = "N 32 lies outside of what was studied, 4 to 16: this is the figure at 16"


def test_half_way_between_four_cells():
    corners = ((4, 0, 0), (16, 0, 4), (4, 1, 2), (16, 1, 10))
    cells = [Cell("u", n, e, saved, saved - 1, saved + 1) for n, e, saved in corners]
    found = expected(cells, "u", 8.0, 0.5)
    assert (found.value, found.low, found.high, found.note) == pytest.approx((4.0, 3.0, 5.0, ""))
    beyond = expected(cells, "u", 32.0, 0.0)
    assert (beyond.value, beyond.note) == (4.0, OUTSIDE)


SLOW = ["robot.max_speed=0.46", "robot.max_acceleration=0.9", "robot.radius=0.17"]


def test_a_slow_robot_avoids_and_a_fast_weak_one_bounces():
    assert number_of(settings_from(None, SLOW)) == pytest.approx(1.383, abs=1e-3)
    slow = list(sentences(settings_from(None, SLOW), 1.0))
    assert slow[0].startswith("Use avoid")
    assert any("u: " in each and "(N 1.38 lies outside of what was studied, 3 to 24: " in each for each in slow)
    weak = settings_from(None, ["robot.max_acceleration=1.0"])
    said = list(sentences(weak, 0.7 * 1.7 * 0.5))
    assert said[0].startswith("Use bounce")
    assert said[1].startswith("N = v_max^2 / (a_max R) is 16.0")
    assert any("up to 0.50 m/s" in each for each in said)
    assert any("set limits.impact_speed to 0.50" in each for each in said)


def test_a_file_is_read_and_set_outranks_it(tmp_path, capsys):
    file = tmp_path / "mine.yaml"
    file.write_text("/**:\n  ros__parameters:\n    robot: {max_speed: 0.9, radius: 0.2}\n")
    assert main(["--params", str(file), "--set", "robot.max_speed=1.2", "--set", "robot.max_acceleration=0.9"]) == 0
    said = capsys.readouterr().out
    assert "is 8.0" in said
    assert "1.43 N s is m (1 + e) v of the shipped robot at 1.2 m/s" in said


@pytest.mark.parametrize(
    ("args", "named"),
    [
        (["--set", "robot.max_sped=1"], "robot.max_sped"),
        (["--set", "robot.radius=0.1,0.2"], "robot.radius"),
        (["--params", "no_such.yaml"], "no_such.yaml"),
        (["--impulse", "nan"], "--impulse"),
    ],
)
def test_what_is_wrong_is_named(args, named, capsys):
    assert main(args) == 2
    assert named in capsys.readouterr().err
