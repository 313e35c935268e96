"""Verdicts of `bringup --check` on its measurements."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees

from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.calibration.lidar_fit import MountFit
from collplan_core.calibration.mocap_offset import AxesFit, BodyOffset
from collplan_core.calibration.stream_quality import StreamQuality
from collplan_core.parameters import Settings
from collplan_ros.node_kit.diagnostics import OK, WARN

GOOD, DOUBTFUL, WRONG = "ok", "doubtful", "WRONG"
ENOUGH_RATE = 50.0
"""Pose rate below which the velocity window holds too few poses for a good line fit [Hz]."""
LARGEST_ERROR = 0.3
"""Largest relative error of a measured motion; beyond it wheel radius, units or axes are set wrongly."""
NO_MOTION = 0.2
"""Ratio of measured to commanded motion below which the robot counts as not moving."""
ENOUGH_CERTAINTY = 0.5
"""Largest acceptable standard deviation of the body's heading [deg]."""

ENOUGH_EXPLAINED = 0.6
"""Least share of the LIDAR's hits on surfaces of the world file: people and what else is not in it are the rest."""
CLEARLY_WORSE = 0.1
"""By so much less must any other mount explain."""
ENOUGH_PLACED = 0.005
"""Largest acceptable standard deviation of the LIDAR's place [m]."""


@dataclass(frozen=True)
class Finding:
    """One line of the check: a verdict and its explanation."""

    verdict: str
    text: str


def node_findings(statuses: Mapping[str, DiagnosticStatus]) -> list[Finding]:
    """One finding per node, from its own diagnostics."""
    verdicts = {OK: GOOD, WARN: DOUBTFUL}
    return [Finding(verdicts.get(s.level, WRONG), f"{name}: {s.message}") for name, s in sorted(statuses.items())]


def stream_findings(quality: StreamQuality, settings: Settings) -> list[Finding]:
    """Findings on rate, gaps and noise of the poses of a robot at rest."""
    limit, assumed = settings.limits.pose_age, settings.mocap.position_noise
    rate = GOOD if quality.rate >= ENOUGH_RATE else DOUBTFUL
    gap = GOOD if quality.longest_gap < limit else WRONG
    noise = GOOD if quality.noise <= 2.0 * assumed else DOUBTFUL
    return [
        Finding(rate, f"{quality.rate:.1f} poses a second, at least {ENOUGH_RATE:g} wanted"),
        Finding(
            gap,
            f"jitter {1e3 * quality.jitter:.1f} ms, longest gap {1e3 * quality.longest_gap:.0f} ms; "
            f"the robot stops beyond {1e3 * limit:.0f} ms (limits.pose_age)",
        ),
        Finding(noise, f"noise at rest {1e3 * quality.noise:.2f} mm; mocap.position_noise says {1e3 * assumed:g} mm"),
    ]


def axes_finding(fit: AxesFit) -> Finding:
    """Finding on the motions along the axes: scale, direction, handedness."""
    if fit.scale < NO_MOTION:
        return Finding(WRONG, "the robot did not move: motors off, emergency stop, or cmd_vel does not get there?")
    if fit.mirrored:
        return Finding(WRONG, "left is right: mocap.axes, or the order or direction of the wheels")
    if abs(fit.scale - 1.0) > LARGEST_ERROR:
        surely = abs(fit.scale - 1.0) > LARGEST_ERROR + 3.0 * fit.scale * fit.uncertainty
        verdict = WRONG if surely else DOUBTFUL
        return Finding(verdict, f"moves {fit.scale:.3g} times as far as told: mocap.units, or the radius of the wheels")
    return Finding(GOOD, f"moves {fit.scale:.3f} times as far as told, to the side it was told")


def turn_finding(share: float) -> Finding:
    """Finding on the turn in place; `share` is the measured angle over the commanded one."""
    if abs(share) < NO_MOTION:
        return Finding(WRONG, "the robot did not turn, or its heading is not measured")
    if share < 0.0:
        return Finding(WRONG, "turns to the other side than told: mocap.axes, or the direction of the wheels")
    verdict = GOOD if abs(share - 1.0) <= LARGEST_ERROR else WRONG
    return Finding(verdict, f"turns {share:.3f} times as far as told")


def offset_finding(offset: BodyOffset, fit: AxesFit) -> Finding:
    """Finding on the place of the measured body on the robot."""
    uncertainty = degrees(fit.uncertainty)
    verdict = GOOD if uncertainty <= ENOUGH_CERTAINTY else DOUBTFUL
    return Finding(
        verdict,
        f"the measured body is {1e3 * offset.x:+.1f} mm ahead and {1e3 * offset.y:+.1f} mm left of the centre, "
        f"turned by {degrees(offset.yaw):+.2f} +- {uncertainty:.2f} deg",
    )


def lidar_finding(fit: MountFit | None, n_scans: int) -> Finding:
    """Finding on the place of the LIDAR on the robot, from `n_scans` scans of a robot at rest."""
    if fit is None:
        return Finding(WRONG, f"{n_scans} scans of the robot at rest show too little, or the world file holds nothing")
    share, mount = f"{fit.explained:.0%} of what the LIDAR shows is on surfaces of the world file", fit.mount
    if fit.explained < ENOUGH_EXPLAINED:
        return Finding(WRONG, f"{share} at best, wherever the LIDAR is: is it this room?")
    if fit.rival > fit.explained - CLEARLY_WORSE:
        rival = f"{fit.rival:.0%} if it were mounted another way round"
        return Finding(DOUBTFUL, f"{share}, and {rival}: begin at another place of the room")
    x, y, yaw = fit.uncertainty.tolist()
    over = ", upside down" if mount.mirrored else ""
    verdict = GOOD if max(x, y) <= ENOUGH_PLACED and degrees(yaw) <= ENOUGH_CERTAINTY else DOUBTFUL
    return Finding(
        verdict,
        f"the LIDAR is {1e3 * mount.x:+.1f} mm ahead and {1e3 * mount.y:+.1f} mm left of the centre, "
        f"turned by {degrees(mount.yaw):+.2f} +- {degrees(yaw):.2f} deg{over}; {share}",
    )
