"""The documents are true: their links lead somewhere, and their parameters and tables are those of the code."""

import pytest

from documents import ROOT, SERVICES, TOPICS, blocks, listed, untrue, wrong_links

DOCUMENTS = sorted(path for each in ("*.md", "docs/**/*.md", "benchmarks/*.md") for path in ROOT.glob(each))


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_document_names_is_there(document):
    # what has gone is named there
    wrong = wrong_links if document.name == "CHANGELOG.md" else untrue
    assert wrong(document.read_text(encoding="utf-8"), document.parent) == []


def test_every_topic_and_service_is_listed():
    text = (ROOT / "docs/ros.md").read_text(encoding="utf-8")
    assert listed(text, "topic") == TOPICS
    assert listed(text, "service") == SERVICES


def test_the_table_of_a_hit_is_what_the_lines_below_it_print(capsys):
    page = (ROOT / "docs/safety.md").read_text(encoding="utf-8")
    (lines,) = blocks(page, "python")
    exec(lines, {})
    rows = capsys.readouterr().out.splitlines()
    assert [line for line in page.splitlines() if line in rows] == rows
    assert rows[0].startswith("| 0.7 | 61, 122, 245 |")


def test_what_is_not_true_is_found():
    for text in UNTRUE:
        assert len(untrue(text, ROOT)) == 1, text


UNTRUE = [
    "[no such part](docs/limits.md#no-such-part)",
    "`planner.no_such_key`",
    "```yaml\n/**:\n  ros__parameters:\n    robot: {radus: 0.1}\n```",
]
