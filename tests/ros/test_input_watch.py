"""What there is to say about one input: once for each change, and never more."""

import random
from itertools import pairwise

import pytest

from collplan_ros.node_kit.input_watch import AWAITED, EVENT, NOBODY, PATIENCE, STATE, STREAM, InputWatch, Remark

COMES = Remark("scan", comes=True)
FRAME = "header.frame_id: got 'laser', expected 'base_link'"


class Scene:
    """A watch, and what is seen of its publishers."""

    def __init__(self, need=STREAM, publishers=NOBODY):
        self.publishers = publishers
        self.watch = InputWatch("scan", need, lambda: self.publishers)

    def second(self, taken=0, refused=()):
        """What is said after a second in which so many messages were taken, and others refused for these reasons."""
        for _ in range(taken):
            self.watch.took()
        for reason in refused:
            self.watch.refused(reason)
        return self.watch.check()


def test_a_stream_that_comes_is_said_once():
    scene = Scene()
    assert scene.second(20) == [COMES]
    assert [scene.second(20) for _ in range(5)] == [[]] * 5
    assert scene.watch.is_there


def test_a_stream_that_is_missing_is_said_once_for_each_reason():
    scene = Scene()
    assert [scene.second() for _ in range(4)] == [[], [Remark("no scan: 0 publishers")], [], []]
    scene.publishers = "1 publisher, nothing received"
    assert [scene.second() for _ in range(3)] == [[Remark("no scan: 1 publisher, nothing received")], [], []]
    assert not scene.watch.is_there
    assert scene.second(1) == [COMES]
    assert [scene.second() for _ in range(3)] == [[], [Remark("no scan: 1 publisher, nothing received")], []]


def test_one_missed_second_is_nothing():
    scene = Scene()
    assert [scene.second(taken) for taken in (3, 0, 3, 0, 3)] == [[COMES], [], [], [], []]


def test_a_refused_stream_is_refused_not_missing():
    scene = Scene(publishers="1 publisher, nothing received")
    refused = Remark(f"scan refused: {FRAME}")
    assert [scene.second(refused=[FRAME] * 20) for _ in range(4)] == [[refused], [], [], []]
    assert scene.second(refused=["other"]) == [Remark("scan refused: other")]
    assert not scene.watch.is_there
    assert scene.second(20) == [COMES]


def test_a_refusal_among_what_is_taken_is_said_beside_it():
    scene = Scene()
    assert scene.second(1, refused=[FRAME]) == [COMES, Remark(f"scan refused: {FRAME}")]
    assert scene.second(1, refused=[FRAME]) == []
    assert scene.second(refused=[FRAME]) == [Remark(f"scan refused: {FRAME}")]  # now nothing else comes
    assert scene.second(1) == [COMES]
    assert scene.second(1, refused=[FRAME]) == [Remark(f"scan refused: {FRAME}")]


def test_other_numbers_are_no_other_reason():
    scene = Scene()
    assert len(scene.second(1, refused=["pose [1.25, 3] at 17.001"])) == 2
    assert scene.second(1, refused=["pose [1.37, 14] at 18.101"]) == []


def test_a_state_is_there_while_somebody_publishes_it():
    scene = Scene(STATE)
    assert [scene.second() for _ in range(3)] == [[], [Remark("no scan: 0 publishers")], []]
    scene.publishers = "1 publisher, nothing received"
    assert scene.second(1) == [COMES]
    assert [scene.second() for _ in range(5)] == [[]] * 5
    scene.publishers = NOBODY
    assert [scene.second() for _ in range(3)] == [[], [Remark("no scan: 0 publishers")], []]
    scene.publishers = "1 publisher, nothing received"
    assert scene.second() == [COMES]


@pytest.mark.parametrize("need", [AWAITED, EVENT])
def test_what_comes_when_it_comes_is_never_missing(need):
    scene = Scene(need)
    assert scene.watch.is_there
    assert [scene.second(taken) for taken in (0, 0, 0, 1, 0, 0, 0, 1)] == [[]] * 8
    assert scene.second(refused=[FRAME]) == [Remark(f"scan refused: {FRAME}")]
    assert [scene.second() for _ in range(PATIENCE)] == [[]] * PATIENCE
    assert scene.second(refused=[FRAME]) == [Remark(f"scan refused: {FRAME}")]  # another one, later


def test_what_was_waited_for_is_said_to_come():
    scene = Scene(AWAITED)
    scene.watch.wait()
    assert [scene.second(taken) for taken in (0, 0, 1, 1)] == [[], [], [COMES], []]


def test_whatever_happens_nothing_is_said_twice_in_a_row_and_the_last_word_is_true():
    for seed in range(300):
        draw = random.Random(seed)
        scene = Scene(draw.choice([STREAM, STATE, AWAITED, EVENT]))
        said = []
        for _ in range(40):
            scene.publishers = draw.choice([NOBODY, "1 publisher, nothing received"])
            remarks = scene.second(draw.choice([0, 0, 3]), [draw.choice("ab")] * draw.choice([0, 0, 1]))
            assert len(remarks) <= 2, seed
            said += remarks
        for before, after in pairwise(said):
            assert before != after or "refused" in after.text, seed
        scene.publishers = "1 publisher, nothing received"
        for _ in range(PATIENCE + 1):
            scene.second(1)
        assert scene.watch.is_there, seed
        assert scene.second(1) == [], seed
