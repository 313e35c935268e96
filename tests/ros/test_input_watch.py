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
    watch = InputWatch("scan", need, lambda: publishers)
    for taken, refused, publishers, said in seconds:  # noqa: B007 (the watch asks for it)
        watch.n_taken += taken
        for _ in range(refused):
            watch.refused(f"pose {next(numbers)}")  # other numbers are no other reason
        lines = watch.check()
        assert bool(said) == bool(lines), (seconds, lines)
        assert said in str(lines)
