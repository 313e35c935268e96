"""Progress of a study, where somebody watches and where it goes to a file."""

import io

from collplan_study.run import progress
from collplan_study.run.progress import show_progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_file_gets_whole_lines_now_and_then(monkeypatch):
    clock = iter([0.0, 10.0, 31.0, 40.0, 70.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    said = io.StringIO()
    with show_progress(100, 20, "trial", said) as done:
        for number in (5, 10, 1, 4):
            done(number)
    assert said.getvalue() == "35 of 100 trials, 15 of them in 31 s\n40 of 100 trials, 20 of them in 70 s\n"


def test_a_terminal_gets_a_bar():
    said = Terminal()
    with show_progress(4, 1, "trial", said) as done:
        done(3)
    assert "4/4" in said.getvalue()
    assert "\r" in said.getvalue()
