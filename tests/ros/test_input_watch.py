"""What there is to say about one input: once for each change, and never more."""

import pytest

from collplan_ros.node_kit.input_watch import COMES, EVENT, NOBODY, STATE, STREAM, InputWatch

HEARD = "1 publisher, nothing received"
ABSENT, SILENT = (f"no scan: {seen}" for seen in (NOBODY, HEARD))


@pytest.mark.parametrize(
    ("need", "seconds"),
    [
        # messages taken, refused, who publishes, what is said: missing once a reason, one missed second is nothing
        (STREAM, [(0, 0, NOBODY, ""), (0, 0, NOBODY, ABSENT), (0, 0, NOBODY, ""), (0, 0, HEARD, SILENT)]),
        (
            STREAM,
            [(3, 0, HEARD, COMES), (0, 0, HEARD, ""), (3, 0, HEARD, ""), (0, 0, HEARD, ""), (0, 0, HEARD, SILENT)],
        ),
        # refused is not missing, and once for each reason; so is that nothing else comes any more
        (STREAM, [(0, 20, HEARD, "refused"), (0, 20, HEARD, ""), (1, 1, HEARD, COMES), (1, 1, HEARD, "")]),
        (STREAM, [(1, 1, HEARD, COMES), (0, 1, HEARD, "refused")]),
        # a state is there while somebody publishes it
        (STATE, [(1, 0, HEARD, COMES), (0, 0, HEARD, ""), (0, 0, NOBODY, ""), (0, 0, NOBODY, ABSENT)]),
        (EVENT, [(0, 0, NOBODY, ""), (0, 0, NOBODY, ""), (1, 0, HEARD, ""), (0, 1, HEARD, "refused")]),
    ],
)
def test_what_is_said(need, seconds):
    publishers, numbers = NOBODY, iter(range(1000))
    watch = InputWatch("scan", need, lambda: publishers, str)
    for taken, refused, publishers, said in seconds:  # noqa: B007 (the watch asks for it)
        watch.n_taken += taken
        for _ in range(refused):
            watch.refused(f"pose {next(numbers)}")  # other numbers are no other reason
        lines = watch.check()
        assert bool(said) == bool(lines), (seconds, lines)
        assert said in str(lines)


WRONG = "1 publisher, but of type Odd, expected Even"


@pytest.mark.parametrize("need", [STREAM, STATE, EVENT])
def test_a_publisher_of_another_type_is_told_once_also_beside_a_right_one_and_where_quiet_is_usual(need):
    wrong = ""
    watch = InputWatch("scan", need, lambda: WRONG if wrong else NOBODY, lambda: wrong)
    said = []
    for wrong, taken in [("", 0), ("", 0), (WRONG, 0), (WRONG, 0), (WRONG, 3), (WRONG, 3), ("", 3), (WRONG, 3)]:  # noqa: B007 (the watch asks for it)
        watch.n_taken += taken
        said.append([text for text in watch.check().values() if WRONG in text])
    # told where it comes first, and anew after it was gone
    assert [len(lines) for lines in said[2:4]] == [1, 0]
    assert sum(map(len, said[2:6])) <= 2
    assert said[6:] == [[], [f"scan: {WRONG}"]]


def test_a_hint_is_told_once_for_as_long_as_it_is_true():
    watch = InputWatch("scan", STREAM, lambda: NOBODY, str)
    told = []
    for hint in ("", "20% are 0", "30% are 0", "", "40% are 0"):
        watch.n_taken, watch.hint = watch.n_taken + 1, hint
        told.append("hint" in watch.check())
    assert told == [False, True, False, False, True]
