"""The page's files: they ask for nothing but each other, and text from the network is never taken for code."""

import re
from pathlib import Path

import collplan_ros.view

PAGE = Path(collplan_ros.view.__file__).parent / "page"
FILES = {path.name: path.read_text(encoding="utf-8") for path in sorted(PAGE.iterdir())}
SCRIPTS = {name: text for name, text in FILES.items() if name.endswith(".js")}


def test_nothing_comes_from_elsewhere():
    for name, text in FILES.items():
        plain = re.sub(r"/\*.*?\*/|^\s*//.*$", "", text, flags=re.DOTALL | re.MULTILINE)
        assert re.findall(r"https?:|(?<!:)//[a-z]|@import|url\(|XMLHttpRequest|sendBeacon", plain) == [], name


def test_text_is_never_taken_for_code_and_markup_holds_no_code_and_no_style():
    markup = r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|srcdoc"
    code = r"\beval\b|new Function|setAttribute\(\"(?:on|style)"
    for name, text in SCRIPTS.items():
        assert re.findall(f"{markup}|{code}", text) == [], name
    index = FILES["index.html"]
    assert re.findall(r"\son\w+=|\sstyle=|<style|javascript:|<script[^>]*>(?!</script>)", index) == []


def test_scripts_import_files_that_are_there_and_share_no_name():
    """So that they can be put one after another into a page that is one file."""
    imported = {name: re.findall(r'from "\./([^"]+)"', text) for name, text in SCRIPTS.items()}
    assert {each for names in imported.values() for each in names} <= set(SCRIPTS)
    statements = [line for text in SCRIPTS.values() for line in text.splitlines() if line.startswith("import ")]
    assert all(re.fullmatch(r'import \{ [\w, ]+ \} from "\./[\w.]+";', line) for line in statements)
    declared = r"^(?:export )?(?:const|let|function|class|async function) (\w+)"
    names = [name for text in SCRIPTS.values() for name in re.findall(declared, text, re.MULTILINE)]
    assert sorted(names) == sorted(set(names))


def test_each_element_that_a_script_asks_for_is_there():
    asked = {name for text in SCRIPTS.values() for name in re.findall(r'byId\("(\w+)"\)', text)}
    assert asked - set(re.findall(r'\sid="(\w+)"', FILES["index.html"])) == set()
