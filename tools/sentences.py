"""Prints for each page its lines, its sentences and how many words a sentence has; tables and code are left out.

`python tools/sentences.py [PAGE...]`, by default all pages. Inline code counts as one word, a link as what it shows.
The end of a list item, of a caption and of a paragraph ends a sentence. The last column is the longest one.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = ("*.md", "docs/**/*.md", "benchmarks/*.md", "src/omnipuck_driver/firmware/*.md")


def blocks(text: str) -> list[str]:
    """Paragraphs and list items as plain words."""
    text = re.sub(r"^```.*?^```|<!--.*?-->", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^(#|\||!\[| {0,3}> ).*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"^\s*(-|\d+\.) (\[.\] )?", "\n\n", text, flags=re.MULTILINE)
    text = re.sub(r"`[^`]+`", "Code", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return [" ".join(block.split()) for block in re.split(r"\n\s*\n", text) if block.strip()]


def sentences(text: str) -> list[int]:
    """Number of words of each sentence."""
    found = [each for block in blocks(text) for each in re.split(r"(?<=[.!?])[*)\"]*\s+(?=[*(\"]*[A-Z])", block)]
    words = [len(re.findall(r"\w[\w./^%'-]*", each)) for each in found]
    return [count for count in words if count]


def main(names: list[str]) -> None:
    pages = [Path(name) for name in names] or sorted({page for each in PAGES for page in ROOT.glob(each)})
    print(f"{'page':<44}{'lines':>7}{'sentences':>11}{'mean':>7}{'over 30':>9}{'longest':>9}")
    total_lines, total = 0, list[int]()
    for page in pages:
        text = page.read_text(encoding="utf-8")
        total_lines += len(text.splitlines())
        counts = sentences(text)
        total += counts
        row(str(page.resolve().relative_to(ROOT)), len(text.splitlines()), counts)
    row("all", total_lines, total)


def row(name: str, lines: int, counts: list[int]) -> None:
    mean = sum(counts) / max(len(counts), 1)
    over = 100 * sum(count > 30 for count in counts) / max(len(counts), 1)
    print(f"{name:<44}{lines:>7}{len(counts):>11}{mean:>7.1f}{over:>7.0f} %{max(counts, default=0):>9}")


if __name__ == "__main__":
    main(sys.argv[1:])
