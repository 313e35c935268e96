"""The constants of the robot that recorded runs share."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from collplan_core.calibration.drive_fit import DriveFit, fit_drive
from collplan_core.calibration.fitted_constant import FittedConstant, TooLittle, Unexplained
from collplan_core.calibration.rebound_fit import ReboundFit, fit_rebound
from collplan_ros.fit.recorded_drive import driven_stretches
from collplan_ros.fit.recorded_impacts import measured_impacts
from collplan_ros.fit.recorded_path import FittedRun


@dataclass(frozen=True)
class RobotFit:
    """Drive and rebound of the robot that drove the runs.

    Attributes:
        drive, rebound: the constants.
        usable: number of hits that the rebound is from; left_out: number of others by reason.
    """

    drive: DriveFit
    rebound: ReboundFit
    usable: int
    left_out: Counter[str]

    @property
    def constants(self) -> dict[str, FittedConstant]:
        """The constants by parameter."""
        return {
            "robot.max_acceleration": self.drive.max_acceleration,
            "robot.velocity_lag": self.drive.velocity_lag,
            "rebound.restitution": self.rebound.restitution,
            "rebound.friction": self.rebound.friction,
        }


def fit_robot(runs: Sequence[FittedRun]) -> RobotFit:
    """Fits the robot's constants: the drive first, which then gives the wheels' motion around each hit.

    Raises:
        Unexplained: runs of robots of different radius, or a drive law that does not explain the poses.
        TooLittle: the runs do not determine the constants.
    """
    _check_one_robot(runs)
    drive = fit_drive([driven_stretches(run) for run in runs])
    impacts, left_out = measured_impacts(runs, drive)
    try:
        rebound = fit_rebound(impacts, runs[0].settings.robot.inertia_factor)
    except TooLittle as error:
        raise TooLittle(f"{error}\n{hits_found(runs, len(impacts), left_out)}") from None
    return RobotFit(drive, rebound, len(impacts), left_out)


def hits_found(runs: Sequence[FittedRun], usable: int, left_out: Counter[str]) -> str:
    """Returns how many hits there were and why some do not count, a line each."""
    kind = "simulated" if runs[0].simulated else "real"
    of_runs = f"{len(runs)} {kind} run{'s' if len(runs) > 1 else ''}"
    lines = [f"hits found in {of_runs}: {usable + left_out.total()}, usable: {usable}"]
    return "\n".join([*lines, *(f"  left out: {count:3}  {reason}" for reason, count in left_out.most_common())])


def _check_one_robot(runs: Sequence[FittedRun]) -> None:
    first, radius = runs[0], runs[0].settings.robot.radius
    for run in runs[1:]:
        other = run.settings.robot.radius
        if other != radius:
            raise Unexplained(
                f"robot.radius: {run.name} was driven with {other:g} m and {first.name} with {radius:g} m, "
                "expected runs of one robot"
            )


def believed_otherwise(fit: RobotFit, runs: Sequence[FittedRun]) -> list[str]:
    """Returns a sentence for each drive constant whose value in the runs lies outside its fitted interval."""
    sentences = []
    for key in ("robot.max_acceleration", "robot.velocity_lag"):
        found = fit.constants[key]
        believed = sorted({float(run.settings.values()[key]) for run in runs})
        wrong = [f"{value:g}" for value in believed if not found.holds(value)]
        if wrong:
            sentences.append(
                f"{key}: the runs used {' and '.join(wrong)}, the poses give {found.value:.4g} ({found.low:.4g} to "
                f"{found.high:.4g}): their plans were made for another drive"
            )
    return sentences
