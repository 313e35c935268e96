"""python tools/pictures [NAME...]: makes docs/pictures anew, all of them or those named."""

import sys
from importlib import import_module
from pathlib import Path

import matplotlib as mpl

from drawing import STYLE

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "pictures"
PICTURES = ("local_map", "maneuvers", "time_to_goal_cycle", "time_saved")


def main(names: list[str]) -> int:
    unknown = sorted(set(names) - set(PICTURES))
    if unknown:
        print(f"pictures: got {', '.join(unknown)}, expected {', '.join(PICTURES)}", file=sys.stderr)
        return 2
    for name in names or PICTURES:
        path = FOLDER / f"{name}.png"
        with mpl.rc_context(STYLE):
            import_module(name).draw(path)
        print(f"{path.relative_to(FOLDER.parents[1])}, {path.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
