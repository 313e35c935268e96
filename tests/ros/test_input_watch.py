"""What there is to say about one input: once for each change, and never more."""

import random
from itertools import pairwise

from collplan_ros.node_kit.input_watch import AWAITED, EVENT, NOBODY, PATIENCE, STATE, STREAM, InputWatch, Remark

COMES = Remark("scan", comes=True)
HEARD = "1 publisher, nothing received"
REFUSED = Remark("scan refused: frame")


class Scene:
    """A watch, and what is seen of its publishers."""

    def __init__(self, need=STREAM, publishers=NOBODY):
        self.publishers = publishers
        self.watch = InputWatch("scan", need, lambda: self.publishers)

    def second(self, taken=0, refused=()):
        """What is said after a second in which so many messages were taken, and others refused for these reasons."""
        self.watch.n_taken += taken
        for reason in refused:
            self.watch.refused(reason)
        return self.watch.check()


def test_a_stream_that_is_missing_is_said_once_for_each_reason_and_so_is_that_it_comes():
    scene = Scene()
    nobody, silent = Remark(f"no scan: {NOBODY}"), Remark(f"no scan: {HEARD}")
    assert [scene.second() for _ in range(4)] == [[], [nobody], [], []]
    scene.publishers = HEARD
    assert [scene.second() for _ in range(3)] == [[silent], [], []]
    assert not scene.watch.is_there
    # one missed second is nothing
    assert [scene.second(taken) for taken in (3, 0, 3, 0, 3)] == [[COMES], [], [], [], []]
    assert scene.watch.is_there
    assert [scene.second() for _ in range(3)] == [[], [silent], []]


def test_a_refused_stream_is_refused_not_missing_and_other_numbers_are_no_other_reason():
    scene = Scene(publishers=HEARD)
    said = [scene.second(refused=["pose 1.25 at 17"] * 20) for _ in range(3)]
    assert said == [[Remark("scan refused: pose 1.25 at 17")], [], []]
    assert scene.second(refused=["pose 2.5 at 18"]) == []
    assert not scene.watch.is_there
    assert scene.second(1, refused=["frame"]) == [COMES, REFUSED]
    assert scene.second(1, refused=["frame"]) == []
    assert scene.second(refused=["frame"]) == [REFUSED]  # now nothing else comes


def test_a_state_is_there_while_somebody_publishes_it():
    scene = Scene(STATE)
    nobody = [[], [Remark(f"no scan: {NOBODY}")], []]
    assert [scene.second() for _ in range(3)] == nobody
    scene.publishers = HEARD
    assert [scene.second(taken) for taken in (1, 0, 0, 0)] == [[COMES], [], [], []]
    scene.publishers = NOBODY
    assert [scene.second() for _ in range(3)] == nobody
    scene.publishers = HEARD
    assert scene.second() == [COMES]


def test_what_comes_when_it_comes_is_never_missing_unless_it_is_waited_for():
    for need in (AWAITED, EVENT):
        scene = Scene(need)
        assert scene.watch.is_there
        assert [scene.second(taken) for taken in (0, 0, 0, 1, 0, 0, 0, 1)] == [[]] * 8, need
        assert scene.second(refused=["frame"]) == [REFUSED]
        assert [scene.second() for _ in range(PATIENCE)] == [[]] * PATIENCE
        assert scene.second(refused=["frame"]) == [REFUSED], "another one, later"
    scene = Scene(AWAITED)
    scene.watch.is_waited_for = True
    assert [scene.second(taken) for taken in (0, 0, 1, 1)] == [[], [], [COMES], []]


def test_whatever_happens_nothing_is_said_twice_in_a_row_and_the_last_word_is_true():
    for seed in range(300):
        draw = random.Random(seed)
        scene = Scene(draw.choice([STREAM, STATE, AWAITED, EVENT]))
        said = []
        for _ in range(40):
            scene.publishers = draw.choice([NOBODY, HEARD])
            remarks = scene.second(draw.choice([0, 0, 3]), [draw.choice("ab")] * draw.choice([0, 0, 1]))
            assert len(remarks) <= 2, seed
            said += remarks
        for before, after in pairwise(said):
            assert before != after or "refused" in after.text, seed
        scene.publishers = HEARD
        for _ in range(PATIENCE + 1):
            scene.second(1)
        assert scene.watch.is_there, seed
        assert scene.second(1) == [], seed
