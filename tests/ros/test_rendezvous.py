"""Robots of one simulated world wait for each other before each step, and for none that has ended."""

import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest

from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.rendezvous import Rendezvous
from omnipuck_sim.robot.company import Company
from physics_scenes import launched, make_world

STARTS = [np.array([-0.4, 0.0]), np.array([0.4, 0.0])]
SPEEDS = [np.array([0.5, 0.05]), np.array([-0.3, 0.0])]


def robots():
    return [launched(make_world(), start, speed) for start, speed in zip(STARTS, SPEEDS, strict=True)]


def gathered(simulators):
    rendezvous = Rendezvous(STARTS)
    places = rendezvous.places
    return rendezvous, [place.share(each) for place, each in zip(places, simulators, strict=True)]


def stepped(step, count, slow=0.0):
    for _ in range(count):
        time.sleep(slow)
        step()
    return count


@pytest.mark.parametrize("slow", [(0.0, 0.0), (0.001, 0.0), (0.0, 0.001)])
def test_time_passes_as_one_whoever_is_slow_and_goes_on_when_one_has_ended(slow):
    alone, together = robots(), robots()
    company = Company(alone)
    for _ in range(900):
        company.step()
    rendezvous, steps = gathered(together)
    drives = [partial(stepped, step, count, each) for step, count, each in zip(steps, (600, 900), slow, strict=True)]
    assert rendezvous.run(drives) == [600, 900]
    for one, other in zip(alone, together, strict=True):
        assert one.time == other.time
        assert one.state.position.tolist() == other.state.position.tolist()
        # they have met
        assert len(one.take_impacts()) == len(other.take_impacts()) == 1


def test_a_callback_of_another_thread_that_does_not_return_ends_the_process():
    program = """
import threading, time
from collplan_ros.bringup import stepped_nodes
stepped_nodes.LOOK_PERIOD = 0.01
def hang():
    watch = stepped_nodes.HangWatch(ends_process=True)
    with watch.watching():
        watch.begin("planner_node")
        time.sleep(60.0)
thread = threading.Thread(target=hang)
thread.start()
thread.join()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=50, check=False)
    assert (ended.returncode, ended.stderr) == (3, "bringup: planner_node hangs: its process ends\n")


def test_each_is_ready_once_all_are_and_one_that_cannot_start_ends_all():
    rendezvous = Rendezvous(STARTS)
    first, second = rendezvous.places
    assert not first.all_ready()
    assert second.all_ready()
    assert first.all_ready()

    def wait(place):
        while not place.all_ready():
            time.sleep(0.001)

    def fail():
        raise StartError("no room")

    rendezvous = Rendezvous(STARTS)
    with pytest.raises(StartError, match="no room"):
        rendezvous.run([partial(wait, rendezvous.places[0]), fail])
