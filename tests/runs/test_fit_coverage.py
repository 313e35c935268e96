"""The intervals of fit_robot hold the truth as often as they say; tools/fit_coverage.py has the set-ups."""

import runpy
from pathlib import Path

import pytest
from scipy.stats import binom

TOOL = Path(__file__).parents[2] / "tools" / "fit_coverage.py"
SETUPS = 40
FEWEST = int(binom.ppf(0.002, SETUPS, 0.95))
"""Of 40 intervals of 95 %, fewer hold the truth once in 500 times."""
MOST_REFUSED = 4


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("engine", ["pymunk", "mujoco"])
def test_intervals_hold_the_truth_of_simulated_robots(engine):
    pytest.importorskip(engine, reason="MuJoCo is not installed: it needs Python 3.11")
    tool = runpy.run_path(str(TOOL))
    fits = {setup: tool["fitted"](setup, engine) for setup in range(SETUPS)}
    refused = {setup: fit for setup, (_, fit) in fits.items() if isinstance(fit, str)}
    assert len(refused) <= MOST_REFUSED, refused
    for key in tool["RANGES"]:
        missed = [
            setup
            for setup, (truth, fit) in fits.items()
            if setup not in refused and not fit.constants[key].holds(truth[key])
        ]
        assert len(missed) <= SETUPS - FEWEST, f"{key}: set-ups {missed}"
