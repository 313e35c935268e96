"""What a check found: each finding with its verdict, and the share of its motions that were interrupted."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, degrees, sin

from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.calibration.body_motions import MotionEstimate
from collplan_core.calibration.lidar_fit import MountFit
from collplan_core.calibration.mocap_offset import ENOUGH_POSITION, ENOUGH_YAW, BodyOffset
from collplan_core.calibration.stream_quality import StreamQuality
from collplan_core.calibration.stroke_fit import AxesFit
from collplan_core.calibration.turn_fit import TurnFit
from collplan_core.parameters import Limits, Settings
from collplan_ros.node_kit.diagnostics import OK, WARN

ENOUGH_MOTIONS = 6
"""Interrupted motions from which on their share counts."""
HOPELESS, MANY = 1 / 3, 0.1
"""Shares of interrupted motions beyond which the check ends, and beyond which it reports why it takes so long."""


@dataclass(frozen=True)
class Interruptions:
    """Counts of motions driven, of motions that were interrupted, and of commands that reached the robot too late."""

    motions: int = 0
    interrupted: int = 0
    refused: int = 0

    @property
    def are_hopeless(self) -> bool:
        """True where so many motions are interrupted that further ones are not worth driving."""
        return self._beyond(HOPELESS)

    @property
    def are_many(self) -> bool:
        """True where interruptions could be the reason for an uncertain result."""
        return self._beyond(MANY)

    def _beyond(self, share: float) -> bool:
        worst = max(self.interrupted, self.refused)
        return worst >= ENOUGH_MOTIONS and worst > share * self.motions


def is_interrupted(between_commands: float, between_poses: float, limits: Limits) -> bool:
    """Returns whether a motion with such longest gaps [s] may differ from the one commanded.

    The robot stops where a command is older than limits.command_age, and commands take some of that time to reach it.
    """
    return between_commands > 0.5 * limits.command_age or between_poses > 0.5 * limits.pose_age


GOOD, DOUBTFUL, WRONG = "ok", "doubtful", "WRONG"
ENOUGH_RATE = 50.0
"""Pose rate below which the velocity window holds too few poses for a good line fit [Hz]."""
USUAL_ERROR, LARGEST_ERROR = 0.1, 0.3
"""Relative errors of a measured motion. A wheel that slips or whose radius was read off a ruler stays within the first;
beyond the second wheel radius, units or axes are set wrongly."""
NO_MOTION = 0.2
"""Ratio of measured to commanded motion below which the robot counts as not moving."""
LARGEST_DRIFT = 0.1
"""Largest velocity beside the commanded one that wheels and floor may add [m/s]."""
SURELY = 3.0
"""Standard deviations beyond a limit at which it is surely exceeded."""
ENOUGH_EXPLAINED = 0.6
"""Least share of the LIDAR's hits on surfaces of the world file; the rest are people and objects not in it."""
CLEARLY_WORSE = 0.1
"""Share by which any other mount must explain less."""
ENOUGH_PLACED = 0.005
"""Largest acceptable standard deviation of the LIDAR's place [m]."""
ENOUGH_TURNED = 0.5
"""Largest acceptable standard deviation of its direction [deg]."""


@dataclass(frozen=True)
class Finding:
    """One line of the check: a verdict and its explanation."""

    verdict: str
    text: str


def node_findings(statuses: Sequence[DiagnosticStatus]) -> list[Finding]:
    """One finding per node, from its own diagnostics."""
    verdicts = {OK: GOOD, WARN: DOUBTFUL}
    return [Finding(verdicts.get(s.level, WRONG), f"{s.name}: {s.message}") for s in statuses]


def stream_findings(quality: StreamQuality, settings: Settings) -> list[Finding]:
    """Findings on rate, gaps and noise of the poses of a robot at rest."""
    limit, assumed = settings.limits.pose_age, settings.mocap.position_noise
    rate = GOOD if quality.rate >= ENOUGH_RATE else DOUBTFUL
    gap = GOOD if quality.longest_gap < limit else WRONG
    noise = GOOD if quality.noise <= 2.0 * assumed else DOUBTFUL
    return [
        Finding(rate, f"{quality.rate:.1f} poses a second, at least {ENOUGH_RATE:g} required"),
        Finding(
            gap,
            f"jitter {1e3 * quality.jitter:.1f} ms, longest gap {1e3 * quality.longest_gap:.0f} ms; "
            f"the robot stops beyond {1e3 * limit:.0f} ms (limits.pose_age)"
            + ("" if gap == GOOD else ": the network, or this machine is too busy"),
        ),
        Finding(noise, f"noise at rest {1e3 * quality.noise:.2f} mm; mocap.position_noise is {1e3 * assumed:g} mm"),
    ]


def axes_finding(fit: AxesFit) -> Finding:
    """Finding on the motions along the axes: scale, direction, handedness."""
    if fit.scale < NO_MOTION:
        return Finding(WRONG, "the robot did not move: motors off, emergency stop, or cmd_vel does not reach it?")
    if fit.mirrored:
        return Finding(WRONG, "left is right: mocap.axes, or the order or direction of the wheels")
    verdict = _share_verdict(fit.scale, fit.scale * fit.uncertainty)
    moves = f"moves {fit.scale:.3f} +- {fit.scale * fit.uncertainty:.3f} times as far as commanded"
    if verdict == GOOD:
        return Finding(GOOD, f"{moves}, in the commanded direction")
    return Finding(verdict, f"{moves}: mocap.units, the radius of the wheels, or it touched something")


def turn_finding(fit: TurnFit) -> Finding:
    """Finding on the turns in place."""
    if abs(fit.share) < NO_MOTION:
        return Finding(WRONG, "the robot did not turn, or its heading is not measured")
    if fit.share < 0.0:
        return Finding(WRONG, "turns against the commanded direction: mocap.axes, or the direction of the wheels")
    verdict = _share_verdict(fit.share, fit.share_uncertainty)
    turns = f"turns {fit.share:.3f} +- {fit.share_uncertainty:.3f} times as far as commanded"
    return Finding(verdict, turns if verdict == GOOD else f"{turns}: kinematics.mount_radius, the radius of the wheels")


def _share_verdict(share: float, uncertainty: float) -> str:
    """Verdict on a measured motion over the commanded one."""
    error = abs(share - 1.0)
    if error <= USUAL_ERROR:
        return GOOD
    return WRONG if error > LARGEST_ERROR + SURELY * uncertainty else DOUBTFUL


def drift_finding(fit: AxesFit, offset: BodyOffset) -> Finding:
    """Finding on the velocity that wheels and floor add to the commanded one while the robot drives."""
    # the fit sees the robot's own from the body that is turned on it
    robot = fit.robot_bias * complex(cos(offset.yaw), sin(offset.yaw))
    floor = fit.room_bias
    verdict = GOOD if max(abs(robot), abs(floor)) <= LARGEST_DRIFT else DOUBTFUL
    return Finding(
        verdict,
        f"drifts while it drives by {1e3 * robot.real:+.0f} mm/s ahead and {1e3 * robot.imag:+.0f} mm/s to the left, "
        f"and by {1e3 * floor.real:+.0f}, {1e3 * floor.imag:+.0f} mm/s in x, y of the room, "
        f"+- {1e3 * fit.bias_uncertainty:.0f} mm/s; not counted as an offset",
    )


def interruption_finding(found: Interruptions) -> Finding:
    """Finding on interruptions of the motions."""
    verdict = WRONG if found.are_hopeless else DOUBTFUL if found.are_many else GOOD
    counts = f"{found.interrupted} of {found.motions} motions were interrupted, {found.refused} commands came too late"
    return Finding(
        verdict, counts if verdict == GOOD else f"{counts}: this machine is too slow or too busy, or poses are lost"
    )


def offset_finding(known: MotionEstimate) -> Finding:
    """Finding on the place of the measured body on the robot."""
    offset = known.offset
    uncertainty = 1e3 * offset.position_uncertainty
    text = (
        f"the measured body is {1e3 * offset.x:+.1f} +- {uncertainty:.1f} mm ahead and {1e3 * offset.y:+.1f} +- "
        f"{uncertainty:.1f} mm left of the centre, turned by {degrees(offset.yaw):+.2f} +- "
        f"{degrees(offset.yaw_uncertainty):.2f} deg"
    )
    if known.is_certain:
        return Finding(GOOD, text)
    wanted = f"+- {1e3 * ENOUGH_POSITION:g} mm and {degrees(ENOUGH_YAW):.2g} deg"
    return Finding(DOUBTFUL, f"{text}; {wanted} are required to drive with it")


def scans_finding(late: float, limits: Limits) -> Finding:
    """Finding on the scans' delay `late` behind their stamps, by the poses' clock [s]."""
    if -limits.pose_age <= late <= limits.scan_age:
        return Finding(GOOD, f"scans come {1e3 * late:.0f} ms after their stamps, by the poses' clock")
    side, apart, limit = ("after", late, limits.scan_age) if late > 0.0 else ("before", -late, limits.pose_age)
    return Finding(
        WRONG,
        f"scans come {apart:.2f} s {side} their stamps, by the poses' clock, limit {limit:.2f} s: the clocks of LIDAR "
        "and motion capture differ (chrony, NTP), or scan.stamp_offset",
    )


def lidar_finding(fit: MountFit | None, n_scans: int) -> Finding:
    """Finding on the LIDAR's mounting pose, from `n_scans` scans of a robot at rest."""
    if fit is None:
        return Finding(WRONG, f"{n_scans} scans of the robot at rest show too little, or the world file holds nothing")
    share, mount = f"{fit.explained:.0%} of the LIDAR's hits are on surfaces of the world file", fit.mount
    if fit.explained < ENOUGH_EXPLAINED:
        return Finding(WRONG, f"{share} at best, wherever the LIDAR is: is it this room?")
    if fit.rival > fit.explained - CLEARLY_WORSE:
        rival = f"{fit.rival:.0%} if it were mounted another way round"
        return Finding(DOUBTFUL, f"{share}, and {rival}: begin at another place of the room")
    x, y, yaw = fit.uncertainty.tolist()
    over = ", upside down" if mount.mirrored else ""
    verdict = GOOD if max(x, y) <= ENOUGH_PLACED and degrees(yaw) <= ENOUGH_TURNED else DOUBTFUL
    return Finding(
        verdict,
        f"the LIDAR is {1e3 * mount.x:+.1f} mm ahead and {1e3 * mount.y:+.1f} mm left of the centre, "
        f"turned by {degrees(mount.yaw):+.2f} +- {degrees(yaw):.2f} deg{over}; {share}",
    )
