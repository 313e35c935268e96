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
MODULE_WORD = re.compile(r"^\s*(?:import|export)\b", re.MULTILINE)
CHARSET = re.compile(r'<meta charset="utf-8">')
TOKEN = re.compile(r'<meta name="token"[^>]*>\n')
TITLE = re.compile(r"<title>.*?</title>", re.DOTALL)
STYLE = re.compile(r'<link rel="stylesheet"[^>]*>')
SCRIPT = re.compile(r'<script type="module"[^>]*></script>')
START = "playRecordings();\n"


def one_file(title: str, recordings: Iterable[str]) -> str:
    """The text of the file, of a window with this title, which is any text, for recordings that are `packed`."""
    page = files("collplan_ros.view") / "page"
    style = "\n".join((page / name).read_text(encoding="utf-8") for name in STYLES)
    script = one_script({name: (page / name).read_text(encoding="utf-8") for name in SCRIPTS}) + START
    policy = f'<meta http-equiv="Content-Security-Policy" content="{_policy(script, style)}">'
    text = (page / "index.html").read_text(encoding="utf-8")
    text = _put(CHARSET, f'<meta charset="utf-8">\n{policy}', text)
    text = _put(TOKEN, "", text)
    text = _put(TITLE, f"<title>{escape(title)}</title>", text)
    text = _put(STYLE, f"<style>{_element(style)}</style>", text)
    # no script by its type, so that nothing runs it
    data = "".join(f'<script type="application/gzip" class="recording">{each}</script>\n' for each in recordings)
    return _put(SCRIPT, f'{data}<script type="module">{_element(script)}</script>', text)


def one_script(modules: Mapping[str, str]) -> str:
    """Modules without a name in common as one, each after those that it imports.

    Raises:
        ValueError: one of them imports or exports in another way than by names.
    """
    texts = []
    for name, text in modules.items():
        joined = EXPORT.sub("", IMPORT.sub("", text))
        left = MODULE_WORD.search(joined)
        if left is not None:
            line = joined[left.start() :].strip().splitlines()[0]
            raise ValueError(f"{name}: got {line!r}, expected imports of names and exported declarations")
        texts.append(joined)
    return "\n".join(texts)


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


def _element(text: str) -> str:
    """Text of a script or style.

    Raises:
        ValueError: it would end its own element.
    """
    if re.search(r"</(?:script|style)|<!--", text, re.IGNORECASE):
        raise ValueError("got the end of an element in a script or style, expected none")
    return text


def _put(place: re.Pattern[str], put: str, text: str) -> str:
    """The text with `put` in its only place.

    Raises:
        ValueError: there is no such place in the page, or several.
    """
    if len(place.findall(text)) != 1:
        raise ValueError(f"index.html: got {len(place.findall(text))} of {place.pattern}, expected one")
    return place.sub(lambda _: put, text)
