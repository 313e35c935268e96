"""The place of a LIDAR at the end of a chain of frames."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from collplan_core.calibration.frame_chain import Link, mount_in

UPSIDE_DOWN = Rotation.from_euler("x", np.pi)
level = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.0, 3.0), st.booleans())


def link(parent: str, x: float, y: float, yaw: float, inverted: bool = False) -> Link:
    turn = Rotation.from_euler("z", yaw)
    return Link(parent, np.array([x, y, 0.1]), (turn * UPSIDE_DOWN if inverted else turn).as_quat())


@given(chain=st.lists(level, min_size=1, max_size=4), point=st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
def test_a_point_seen_by_the_lidar_is_where_the_chain_puts_it(chain, point):
    names = ["base_link", *map(str, range(len(chain)))]
    links = {child: link(parent, *each) for parent, child, each in zip(names, names[1:], chain, strict=False)}
    mount = mount_in(links, "base_link", names[-1])
    seen = np.array([*point, 0.0])
    for name in reversed(names[1:]):
        seen = links[name].position + Rotation.from_quat(links[name].quaternion).apply(seen)
    x, y = point[0], -point[1] if mount.mirrored else point[1]
    turned = math.cos(mount.yaw) * x - math.sin(mount.yaw) * y, math.sin(mount.yaw) * x + math.cos(mount.yaw) * y
    np.testing.assert_allclose((mount.x + turned[0], mount.y + turned[1]), seen[:2], atol=1e-9)


def test_frames_that_nothing_joins_have_no_place_and_a_tilted_lidar_is_refused():
    links = {"laser": link("mast", 0.1, 0.0, 0.0), "mast": link("other_base", 0.0, 0.0, 0.0), "a": link("a", 0, 0, 0)}
    assert mount_in(links, "base_link", "laser") is None
    assert mount_in(links, "base_link", "a") is None
    links["laser"] = Link("base_link", np.zeros(3), Rotation.from_euler("y", 0.6).as_quat())
    with pytest.raises(ValueError, match="laser is tilted by 34 degrees on base_link"):
        mount_in(links, "base_link", "laser")


def hung(links, parent, at, name, chain):
    """Hangs a chain of frames below a frame at `at`; returns the last one and where that is."""
    for k, (x, y, yaw, _) in enumerate(chain):
        child = f"{name}{k}"
        links[child] = link(parent, x, y, yaw)
        at, parent = (at[0] + at[1].apply(links[child].position), at[1] * Rotation.from_euler("z", yaw)), child
    return parent, at


@given(root=st.lists(level, max_size=2), base=st.lists(level, max_size=3), laser=st.lists(level, max_size=3))
def test_a_lidar_is_found_wherever_it_and_the_robot_hang_in_one_tree(root, base, laser):
    links: dict[str, Link] = {}
    footprint, at = hung(links, "world", (np.zeros(3), Rotation.identity()), "root", root)
    (base_frame, (base_at, base_turn)), (frame, (laser_at, laser_turn)) = (
        hung(links, footprint, at, name, chain) for name, chain in (("base", base), ("laser", laser))
    )
    mount = mount_in(links, base_frame, frame)
    np.testing.assert_allclose((mount.x, mount.y), base_turn.inv().apply(laser_at - base_at)[:2], atol=1e-9)
    turned = (base_turn.inv() * laser_turn).as_euler("xyz")[2]
    assert math.remainder(mount.yaw - turned, math.tau) == pytest.approx(0.0, abs=1e-9)
