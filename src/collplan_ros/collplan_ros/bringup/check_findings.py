"""What `bringup --check` makes of what it measured, in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees

from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.calibration.mocap_offset import AxesFit, BodyOffset
from collplan_core.calibration.stream_quality import StreamQuality
from collplan_core.parameters import Settings
from collplan_ros.node_kit.diagnostics import OK, WARN

GOOD, DOUBTFUL, WRONG = "ok", "doubtful", "WRONG"
ENOUGH_RATE = 50.0
"""Below it the velocity's window holds fewer poses than a line is fitted well through [Hz]."""
LARGEST_ERROR = 0.3
"""By which a measured motion may miss a commanded one, as a share; beyond it wheels, units or axes are not as said."""
NO_MOTION = 0.2
ENOUGH_CERTAINTY = 0.5
"""Of the body's heading [deg]."""


@dataclass(frozen=True)
class Finding:
    """One line of the check: a verdict and what it is about."""

    verdict: str
    text: str


def of_nodes(statuses: Mapping[str, DiagnosticStatus]) -> list[Finding]:
    """Of what each node says of itself."""
    verdicts = {OK: GOOD, WARN: DOUBTFUL}
    return [Finding(verdicts.get(s.level, WRONG), f"{name}: {s.message}") for name, s in sorted(statuses.items())]


def of_stream(quality: StreamQuality, settings: Settings) -> list[Finding]:
    """Of the poses of a robot at rest."""
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


def of_axes(fit: AxesFit) -> Finding:
    """Of the motions along the axes."""
    if fit.scale < NO_MOTION:
        return Finding(WRONG, "the robot did not move: motors off, emergency stop, or cmd_vel does not get there?")
    if fit.mirrored:
        return Finding(WRONG, "left is right: mocap.axes, or the order or direction of the wheels")
    if abs(fit.scale - 1.0) > LARGEST_ERROR:
        surely = abs(fit.scale - 1.0) > LARGEST_ERROR + 3.0 * fit.scale * fit.uncertainty
        verdict = WRONG if surely else DOUBTFUL
        return Finding(verdict, f"moves {fit.scale:.3g} times as far as told: mocap.units, or the radius of the wheels")
    return Finding(GOOD, f"moves {fit.scale:.3f} times as far as told, to the side it was told")


def of_turn(share: float) -> Finding:
    """Of the turn in place: measured over commanded."""
    if abs(share) < NO_MOTION:
        return Finding(WRONG, "the robot did not turn, or its heading is not measured")
    if share < 0.0:
        return Finding(WRONG, "turns to the other side than told: mocap.axes, or the direction of the wheels")
    verdict = GOOD if abs(share - 1.0) <= LARGEST_ERROR else WRONG
    return Finding(verdict, f"turns {share:.3f} times as far as told")


def of_offset(offset: BodyOffset, fit: AxesFit) -> Finding:
    """Of the body's place on the robot."""
    uncertainty = degrees(fit.uncertainty)
    verdict = GOOD if uncertainty <= ENOUGH_CERTAINTY else DOUBTFUL
    return Finding(
        verdict,
        f"the measured body is {1e3 * offset.x:+.1f} mm ahead and {1e3 * offset.y:+.1f} mm left of the centre, "
        f"turned by {degrees(offset.yaw):+.2f} +- {uncertainty:.2f} deg",
    )
