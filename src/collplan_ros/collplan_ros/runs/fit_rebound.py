"""The program fit_rebound: fit_robot by its earlier name."""

import sys
from collections.abc import Sequence

from collplan_ros.runs import fit_robot


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    print("fit_rebound is fit_robot now, and will go with the next version", file=sys.stderr)
    return fit_robot.main(args)


if __name__ == "__main__":
    sys.exit(main())
