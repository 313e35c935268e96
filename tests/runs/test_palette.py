"""Pictures have the colours of the live page on light ground."""

import re
from importlib.resources import files

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from collplan_ros.pictures import palette
from collplan_ros.pictures.palette import speed_colors

PAGE = (files("collplan_ros.view") / "page" / "colors.js").read_text(encoding="utf-8")
LIGHT = dict(re.findall(r'(\w+): "(#\w{6})"', PAGE[PAGE.index("const LIGHT") : PAGE.index("const DARK")]))
NAMES = {
    "TEXT": "text",
    "OBSTACLE": "solid",
    "WALL": "edge",
    "ROBOT": "robot",
    "GOAL": "goal",
    "SCAN": "scan",
    "PLAN": "plotLine",
    "DELIBERATE": "deliberate",
    "FORESEEN": "foreseen",
    "OTHER": "other",
    "OUTLINE": "outline",
}


def test_what_pictures_and_page_both_show_has_one_colour():
    assert {name: getattr(palette, name) for name in NAMES} == {name: LIGHT[each] for name, each in NAMES.items()}


def test_speeds_have_the_colours_of_the_page():
    (stops,) = re.findall(r"const SPEED = \[([^]]+)\]", PAGE)
    assert re.findall(r"#\w{6}", stops) == list(palette.SLOW_TO_FAST)
    (lightest,) = re.findall(r": ([\d.]+) \* clipped\)", PAGE)
    assert float(lightest) == palette.LIGHTEST
    assert np.array_equal(speed_colors(np.zeros(1))[0], [0x0D, 0x08, 0x87])


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_faster_is_lighter(one, other):
    """By the lightness that the eye sees, so that colours are not needed."""
    slow, fast = speed_colors(np.sort([one, other])) @ [0.2126, 0.7152, 0.0722]
    assert slow <= fast + 1e-9
