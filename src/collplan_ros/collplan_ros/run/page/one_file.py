"""The live page and recordings as one HTML file that loads nothing and runs no other script than its own."""

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from html import escape
from importlib.resources import files
from typing import Any

SCRIPTS = (
    "geometry.js",
    "dom.js",
    "colors.js",
    "state.js",
    "layers.js",
    "canvas.js",
    "pacing.js",
    "plots.js",
    "panels.js",
    "drive.js",
    "page.js",
    "player.js",
)
"""Modules of the page, each after those that it imports."""
STYLES = ("style.css", "player.css")
IMPORT = re.compile(r"""^import\s[^;]*?["']\./[\w.]+["'];?[^\S\n]*\n""", re.MULTILINE)
EXPORT = re.compile(r"^export\s+(?=(?:async\s+)?(?:const|let|class|function)\b)", re.MULTILINE)
START = "playRecordings();\n"


def one_file(title: str, recordings: Iterable[str]) -> str:
    """The text of the file, of a window with this title, which is any text, for recordings that are `packed`."""
    style, script = "\n".join(map(_page_file, STYLES)), page_script() + START
    policy = f'<meta http-equiv="Content-Security-Policy" content="{_policy(script, style)}">'
    # no script by its type, so that nothing runs it
    data = "".join(f'<script type="application/gzip" class="recording">{each}</script>\n' for each in recordings)
    text = _page_file("index.html")
    for live, recorded in (
        ('<meta charset="utf-8">', f'<meta charset="utf-8">\n{policy}'),
        ('<meta name="token" content="@TOKEN@">\n', ""),
        ("<title>collplan</title>", f"<title>{escape(title)}</title>"),
        ('<link rel="stylesheet" href="style.css">', f"<style>{style}</style>"),
        ('<script type="module" src="main.js"></script>', f'{data}<script type="module">{script}</script>'),
    ):
        text = text.replace(live, recorded)
    return text


def page_script() -> str:
    """The modules of the page as one, without what they import of each other: they have no name in common."""
    return "\n".join(EXPORT.sub("", IMPORT.sub("", _page_file(name))) for name in SCRIPTS)


def _page_file(name: str) -> str:
    return (files("collplan_ros.view") / "page" / name).read_text(encoding="utf-8")


def packed(recording: Mapping[str, Any]) -> str:
    """Recording of a run as text for the page: JSON, compressed by gzip, in base64, which means nothing in HTML."""
    text = json.dumps(recording, separators=(",", ":"), allow_nan=False)
    # without the time of now: equal recordings are equal files
    return base64.b64encode(gzip.compress(text.encode(), compresslevel=9, mtime=0)).decode()


def _policy(script: str, style: str) -> str:
    """A content security policy that allows this script, this style, and nothing from anywhere."""
    return (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
