"""The command `make worth`: whether deliberate bounces pay on a robot, from its parameters.

    make worth ARGS="--params mine.yaml"
    make worth ARGS="--set robot.max_speed=0.46 --set robot.max_acceleration=0.9 --set robot.radius=0.17"
    make worth ARGS="--params mine.yaml --impulse 0.8"

All figures are simulated, with a robot that drives in every direction. docs/bounces.md says what they rest on.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from collplan_core.parameters import ParameterError, Settings
from collplan_core.parameters.file import read_parameters
from collplan_study.analysis.statistics import Estimate
from collplan_study.errors import StudyError
from collplan_study.question.question import parse_axes
from collplan_study.report.content import with_interval
from worth_curve import expected, families_of, number_of, read_curve

SHIPPED = Settings()
MARGIN = 1.8
"""Most that bounce saves where it touches nothing, as it keeps 2 cm from walls and avoid keeps 3 [%]."""


def impulse_of(settings: Settings, speed: float) -> float:
    """Impulse of a hit so fast into a wall [N s]: m (1 + e) v, of the body alone."""
    return settings.robot.mass * (1.0 + settings.rebound.restitution) * speed


HARDEST = impulse_of(SHIPPED, SHIPPED.limits.impact_speed)
WHOSE = f"m (1 + e) v of the shipped robot at {SHIPPED.limits.impact_speed:g} m/s, as no ring's limit was measured"


def sentences(settings: Settings, impulse: float) -> Iterator[str]:
    """The sentences of `make worth` for a robot that withstands an impulse [N s]."""
    number, restitution = number_of(settings), settings.rebound.restitution
    cells = read_curve()
    found = {family: expected(cells, family, number, restitution) for family in families_of(cells)}
    yield verdict(found)
    yield f"N = v_max^2 / (a_max R) is {number:.1f}, the restitution {restitution:g}."
    yield "Time that bounce is expected to save against avoid, with 95 % interval, simulated:"
    for family, saved in found.items():
        note = f" ({saved.note})" if saved.note else ""
        yield f"  {family}: {with_interval(saved, 1, ' %')}{note}"
    fastest, v_max = impulse / impulse_of(settings, 1.0), settings.robot.max_speed
    yield f"A hit stays within {impulse:.2f} N s up to {fastest:.2f} m/s into the wall."
    if impulse == HARDEST:
        yield f"{impulse:.2f} N s is {WHOSE}: give yours by --impulse."
    if fastest < v_max:
        yield f"That is less than v_max: for bounce set limits.impact_speed to {fastest:.2f}, and expect to save less."


def verdict(found: Mapping[str, Estimate]) -> str:
    """Bounce or avoid, and why."""
    paying = [family for family, saved in found.items() if saved.low is not None and saved.low > MARGIN]
    if not paying:
        return "Use avoid: this robot brakes and turns about as fast by its own wheels as a wall would turn it."
    return f"Use bounce, if the robot drives in every direction: in {' and '.join(paying)} a wall turns it faster."


def settings_from(params: Path | None, texts: Sequence[str]) -> Settings:
    """Settings of a parameter file, and texts KEY=VALUE above them; ParameterError or StudyError names the key."""
    axes = parse_axes(texts)
    for key, given in axes.items():
        if len(given) != 1:
            raise StudyError(f"--set {key}: got {len(given)} values, expected one")
    values = {} if params is None else read_parameters(params)
    return SHIPPED.with_values(values | {key: value for key, (value,) in axes.items()})


def main(args: Sequence[str] | None = None) -> int:
    """Prints the sentences; exit code 2 for parameters that cannot be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--params", type=Path, metavar="FILE", help="ROS parameter file (default as shipped)")
    parser.add_argument("--set", dest="values", action="append", default=[], metavar="KEY=VALUE", help="a parameter")
    parser.add_argument("--impulse", type=float, default=HARDEST, help=f"limit of a hit [N s] ({HARDEST:.2f}: {WHOSE})")
    given = parser.parse_args(args)
    try:
        if not given.impulse > 0.0:
            raise StudyError(f"--impulse: got {given.impulse:g}, expected more than 0")
        print("\n".join(sentences(settings_from(given.params, given.values), given.impulse)))
    except (ParameterError, StudyError) as error:
        print(f"worth: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
