"""The command `make worth`: whether deliberate bounces pay on a robot, from its parameters.

    make worth ARGS="--params mine.yaml"
    make worth ARGS="--set robot.max_speed=0.46 --set robot.max_acceleration=0.9 --set robot.radius=0.17"
    make worth ARGS="--params mine.yaml --impulse 0.8"

Figures are simulated, and of robots that drive in every direction: docs/bounces.md, "Does it pay on my robot?".
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from collplan_core.parameters import ParameterError, Settings
from collplan_core.parameters.file import read_parameters
from collplan_study.analysis.statistics import Estimate
from collplan_study.errors import StudyError
from collplan_study.question.question import parse_axes
from collplan_study.report.content import number
from worth_curve import FAMILIES, expected, number_of, read_curve

SHIPPED = Settings()


def impulse_of(settings: Settings, speed: float) -> float:
    """Impulse on the body in a hit so fast into a wall [N s]; wheels that slip add nothing while it lasts."""
    return settings.robot.mass * (1.0 + settings.rebound.restitution) * speed


HARDEST = impulse_of(SHIPPED, SHIPPED.limits.impact_speed)
"""What the shipped robot takes at its limit. What a ring withstands was not measured, and the study hit no harder."""


def sentences(settings: Settings, impulse: float) -> Iterator[str]:
    """What `make worth` says of a robot whose ring withstands an impulse [N s]."""
    n, restitution = number_of(settings), settings.rebound.restitution
    yield f"N = v_max^2 / (a_max R) = {n:.1f}, with restitution {restitution:g}."
    cells = read_curve()
    found = {family: expected(cells, family, n, restitution) for family in FAMILIES}
    yield "Time that bounce is expected to save against avoid, simulated, with 95 % interval:"
    yield from (f"  {family:<11}{_percent(saved)}" for family, saved in found.items())
    fastest, v_max = impulse / impulse_of(settings, 1.0), settings.robot.max_speed
    yield f"A hit stays within {impulse:.2f} N s up to {fastest:.2f} m/s into the wall."
    if fastest < v_max:
        yield (
            f"That is below v_max, {v_max:g} m/s: set limits.impact_speed to {fastest:.2f}. "
            "The savings above are without such a limit and become less."
        )
    yield verdict(found)


def verdict(found: dict[str, Estimate]) -> str:
    """Bounce or avoid, and why."""
    sure = [family for family, saved in found.items() if saved.low is not None and saved.low > 0.0]
    if not sure:
        return "Use avoid: no kind of corridor surely saves time with bounces, and avoid hardly ever touches a wall."
    where = f"in corridors like {' and '.join(sure)}" if len(sure) < len(found) else "where corridors turn back"
    return f"Use bounce {where}, if the robot drives in every direction: walls turn it faster than its wheels."


def _percent(saved: Estimate) -> str:
    ends = f"{number(saved.value, 1)} % [{number(saved.low, 1)}, {number(saved.high, 1)}]"
    return f"{ends} ({saved.note}; this is the nearest)" if saved.note else ends


def settings_from(params: Path | None, texts: Sequence[str]) -> Settings:
    """Settings with the values of a parameter file, and those of texts KEY=VALUE above them.

    Raises:
        ParameterError, StudyError: either names the key.
    """
    values = {} if params is None else read_parameters(params)
    for key, given in parse_axes(texts).items():
        if len(given) != 1:
            raise StudyError(f"--set {key}: got {len(given)} values, expected one")
        values[key] = given[0]
    return SHIPPED.with_values(values)


def main(args: Sequence[str] | None = None) -> int:
    """Prints the sentences; exit code 2 for parameters that cannot be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--params", type=Path, metavar="FILE", help="ROS parameter file (default as shipped)")
    parser.add_argument("--set", dest="values", action="append", default=[], metavar="KEY=VALUE", help="a parameter")
    hardest = f"impulse that a hit may have [N s] (default {HARDEST:.2f}, the shipped robot's at limits.impact_speed)"
    parser.add_argument("--impulse", type=float, default=HARDEST, help=hardest)
    given = parser.parse_args(args)
    try:
        if not given.impulse > 0.0:
            raise StudyError(f"--impulse: got {given.impulse:g}, expected more than 0 N s")
        print("\n".join(sentences(settings_from(given.params, given.values), given.impulse)))
    except (ParameterError, StudyError) as error:
        print(f"worth: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
