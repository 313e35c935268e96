"""Renews frozen.json, and says in words what has changed; `make frozen` calls it."""

import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fingerprint import TOLERANCE, is_same

DATA = Path(__file__).with_name("frozen.json")


def frozen_parts() -> list[str]:
    """The parts of frozen.json."""
    return ["trials", "runs", "study"]


def now_of(part: str, scratch: Path) -> Any:
    """What a part is with the code of now; files go into an empty folder."""
    if part == "trials":
        from frozen_trials import frozen_trial, names

        return {f"{world} {strategy}": frozen_trial(world, strategy) for world, strategy in names()}
    if part == "runs":
        from frozen_runs import NAMES, frozen_run

        return {name: frozen_run(name, scratch) for name in NAMES}
    from frozen_study import frozen_study

    return frozen_study(scratch)


def differences(before: Any, now: Any, at: str = "") -> list[str]:
    """A sentence for each difference between two parts; numbers within 1e-9 are equal."""
    if before is None and isinstance(now, Mapping | list):
        return [f"{at}: new"]
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        if "digest" in before and "digest" in now:
            return (
                [] if is_same(before, now) else [f"{at}: other values ({before['count']} numbers, now {now['count']})"]
            )
        keys = [*before, *(key for key in now if key not in before)]
        return [each for key in keys for each in differences(before.get(key), now.get(key), f"{at} {key}".strip())]
    if isinstance(before, list) and isinstance(now, Sequence) and len(before) == len(now):
        pairs = zip(before, now, strict=True)
        return [each for k, (b, n) in enumerate(pairs) for each in differences(b, n, f"{at} [{k}]".strip())]
    if isinstance(before, float) and isinstance(now, float):
        both_nan = math.isnan(before) and math.isnan(now)
        same = both_nan or math.isclose(before, now, rel_tol=TOLERANCE, abs_tol=TOLERANCE)
    else:
        same = before == now
    return [] if same else [f"{at}: {before} -> {now}"]


def main() -> None:
    """Renews every part."""
    before = json.loads(DATA.read_text()) if DATA.exists() else {}
    with TemporaryDirectory() as scratch:
        now = {part: now_of(part, Path(scratch)) for part in frozen_parts()}
    now = json.loads(json.dumps(now))
    changed = [each for part in now for each in differences(before.get(part), now[part], part)]
    print("\n".join(changed) or "nothing has changed")
    lines = ",\n".join(f"{json.dumps(part)}: {_rows(content)}" for part, content in now.items())
    DATA.write_text("{" + lines + "}\n")


def _rows(content: Any) -> str:
    """JSON text of a part with a line for each of its entries."""
    if isinstance(content, Mapping):
        return "{\n" + ",\n".join(f"{json.dumps(key)}: {json.dumps(each)}" for key, each in content.items()) + "}"
    return "[\n" + ",\n".join(json.dumps(each) for each in content) + "]"


if __name__ == "__main__":
    sys.exit(main())
