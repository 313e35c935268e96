"""What a scan must be to be used."""

import numpy as np
import pytest

from collplan_core.scan import Scan, ScanError

TURN = 2 * np.pi


def scan(ranges, angle_min=0.0, increment=TURN / 360, range_min=0.02, range_max=5.0, stamp=0.0) -> Scan:
    return Scan(stamp, angle_min, increment, range_min, range_max, np.asarray(ranges))


def test_a_scan_that_cannot_be_used_is_an_error_that_says_why():
    for change, words in [
        ({"ranges": []}, "shape"),
        ({"ranges": [1.0]}, "at least 2 beams"),
        ({"ranges": np.ones((2, 2))}, "shape"),
        ({"ranges": np.full(360, np.nan)}, "all 360 are NaN"),
        ({"ranges": [1.0, -0.5]}, "-0.5"),
        ({"increment": 0.0}, "step other than 0"),
        ({"increment": np.nan}, "nan"),
        ({"angle_min": np.inf}, "inf"),
        ({"stamp": np.nan}, "finite"),
        ({"increment": TURN / 300}, "full turn"),
        ({"increment": -TURN / 300}, "full turn"),
        ({"range_min": -0.1}, "range_min -0.1"),
        ({"range_min": 5.0}, "range_min < range_max"),
        ({"range_max": np.inf}, "range_max inf"),
        ({"range_max": np.nan}, "range_max nan"),
    ]:
        with pytest.raises(ScanError, match=words):
            scan(**{"ranges": np.ones(360), **change})


def test_ranges_beyond_the_limits_are_no_measurements():
    ranges = scan([0.01, 0.02, 5.0, 5.01, np.nan, np.inf, -np.inf]).ranges
    np.testing.assert_array_equal(ranges, [-np.inf, 0.02, 5.0, np.inf, np.nan, np.inf, -np.inf])


def test_a_scan_keeps_its_own_ranges():
    given = np.ones(360)
    kept = scan(given)
    given[0] = 3.0
    assert kept.ranges[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        kept.ranges[0] = 2.0


def test_angles():
    np.testing.assert_allclose(scan(np.ones(4), angle_min=1.0, increment=-0.5).angles, [1.0, 0.5, 0.0, -0.5])
