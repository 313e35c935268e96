"""What holds whichever engine computes the contacts."""

import numpy as np
import pytest

from collplan_core.parameters import Settings
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial import run_trial
from physics_scenes import make_world, quiet, unit

SPREADS = {"simulator.restitution_spread": 0.1, "simulator.friction_spread": 0.1, "simulator.wall_spread": 0.2}
MISSING = "MuJoCo is not installed: it needs Python 3.11"


@pytest.fixture(params=["pymunk", "mujoco"])
def name(request):
    if request.param == "mujoco":
        pytest.importorskip("mujoco", reason=MISSING)
    return request.param


def test_a_trial_with_mujoco_reaches_its_goal():
    pytest.importorskip("mujoco", reason=MISSING)
    settings = Settings().with_values({"simulator.engine": "mujoco", "planner.strategy": "bounce"})
    assert run_trial("corridor", settings, 3).outcome == "reached"


def test_equal_seeds_give_equal_runs(name):
    settings = Settings().with_values({"simulator.engine": name, **SPREADS})
    world = make_world(circles=[(0.4, 1.4, 0.1)], walled=True, bounds=(0.0, 0.0, 2.0, 2.0), start=np.array([0.5, 0.5]))
    ends = []
    for seed in (4, 5, 4):
        sim = Simulator(world, settings, seed)
        for k in range(8000):
            if k % 20 == 0:
                sim.command(unit(k / 1700), 0.2)
            sim.step()
        ends.append((*sim.state.position, *sim.state.velocity, sim.spin, *(i.time for i in sim.take_impacts())))
    assert ends[0] == ends[2] != ends[1]
    assert len(ends[0]) >= 5 + 3


def test_the_drive_is_the_same_with_each():
    pytest.importorskip("mujoco", reason=MISSING)
    for wheel_mass in (0.0, 0.35):
        velocities = []
        for name in ("pymunk", "mujoco"):
            sim = Simulator(make_world(), quiet(engine=name, wheel_mass=wheel_mass), 0, start=np.zeros(2))
            for k in range(1500):
                if k % 50 == 0:
                    sim.command(0.9 * unit(k / 300), 1.0)
                sim.step()
            velocities.append([*sim.state.velocity, sim.spin])
        np.testing.assert_allclose(*velocities, atol=2e-3)
