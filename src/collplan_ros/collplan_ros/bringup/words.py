"""Names in a sentence."""

from collections.abc import Sequence


def in_words(names: Sequence[str]) -> str:
    """The names as "a, b and c"; at least one."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
