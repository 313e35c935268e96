"""Speed over the releases: one line a release, whatever was measured of it."""

from history import COLUMNS, read_history, write_history
from PIL import Image

MACHINE = {"time": "2026-11-28T12:00:00+00:00", "processor": "some processor"}


def measured(version, cycle, **ratios):
    """Figures as `make bench` writes them, reduced to what a line of history.csv takes."""
    rates = {"trials_per_second": {"harness": 15.0, "bounce": 2.61}}
    of_plans = {"median_us": 7203.4, "p99_us": 12903.1, "n": 90}
    times = {"cycle": {"median_us": cycle, "p99_us": 400.0, "n": 1575}, "plan_to_goal": of_plans}
    ratios = {"trial_harness_vs_1_0_0": 2.871, **ratios}
    return {"version": version, "commit": "abc", "machine": MACHINE, "ratios": ratios, **times, **rates}


def test_each_release_has_one_line_and_the_picture_shows_them(tmp_path):
    history, picture = tmp_path / "history.csv", tmp_path / "history.png"
    for version, cycle, ratios in [
        ("1.0.0", 310.0, {}),
        ("1.1.0", 290.0, {"scan_vs_irsim": 0.00412}),
        ("1.0.0", 300.0, {}),
    ]:
        write_history(measured(version, cycle, **ratios), history, picture)
        with Image.open(picture) as drawn:
            assert drawn.width > drawn.height > 0
    first, second = read_history(history)
    assert tuple(first) == COLUMNS
    assert [first[name] for name in COLUMNS[:4]] == ["1.0.0", "abc", "2026-11-28", "some processor"]
    assert (first["cycle.median_us"], second["cycle.median_us"]) == ("300", "290")
    assert (first["plan_to_goal.p99_us"], first["trials_per_second.bounce"]) == ("12900", "2.61")
    # skipped, and measured
    assert (first["ratios.scan_vs_irsim"], second["ratios.scan_vs_irsim"]) == ("", "0.00412")
