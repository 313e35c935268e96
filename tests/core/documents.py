"""What a document names and the project does not have: each check gives a list of it."""

import ast
import re
from pathlib import Path
from tempfile import NamedTemporaryFile

import yaml

from collplan_core.parameters import GROUPS, ParameterError, Settings, all_specs
from collplan_core.parameters.file import read_parameters

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "docs", "examples", "tools", "studies", "benchmarks")
SOURCES = {
    path.relative_to(ROOT).as_posix(): path.read_text() for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")
}
EVERYTHING = "\n".join(SOURCES.values())
OF_BASES = {"/cmd_vel", "/fault", "/odom", "/scan"}
"""Topics of a robot that takes velocities."""
CALLS = [node for source in SOURCES.values() for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]


def named_in_calls(*functions: str) -> set[str]:
    """The literal texts given to functions of these names, wherever in the sources."""
    calls = [call for call in CALLS if ast.unparse(call.func).split(".")[-1] in functions]
    given = [each.value for call in calls for each in call.args if isinstance(each, ast.Constant)]
    return {each for each in given if isinstance(each, str)}


NAMED = set(re.findall(r'^TOPIC = "([\w/]+)"', EVERYTHING, re.MULTILINE)) | {all_specs()["mocap.topic"].default}
TOPICS = (named_in_calls("create_publisher", "create_subscription", "listen") | NAMED) - OF_BASES
SERVICES = named_in_calls("create_service", "_serve")


def wrong_value(key: str, value: str | None) -> list[str]:
    """What is wrong with a value of a parameter: the key is unknown, or it does not take the value."""
    if key not in all_specs():
        return [key]
    try:
        if value is not None:
            all_specs()[key].checked(yaml.safe_load(value))
    except ParameterError as error:
        return [str(error)]
    return []


def blocks(text: str, language: str) -> list[str]:
    return [
        body for kind, body in re.findall(r"^```(\w*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE) if kind == language
    ]


def prose(text: str) -> str:
    return re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def headings(text: str) -> set[str]:
    lines = re.findall(r"^#+ (.*)$", prose(text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines}


def wrong_links(text: str, folder: Path) -> list[str]:
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", prose(text)) if "://" not in link]
    return [link for link in links if not leads_somewhere(link, text, folder)]


def leads_somewhere(link: str, text: str, folder: Path) -> bool:
    path, _, part = link.partition("#")
    page = folder / path
    return page.exists() and (not part or part in headings(page.read_text() if path else text))


def wrong_parameters(text: str) -> list[str]:
    groups = "|".join(group.group for group in GROUPS)
    spans = [" ".join(span.split()) for span in re.findall(r"`([^`]+)`", prose(text))]
    keys = [re.fullmatch(rf"((?:{groups})\.(?!py\b|yaml\b)\w+)(?:(?::=|=|: )([^,]+))?", span) for span in spans]
    return [wrong for key in keys if key for wrong in wrong_value(key[1], key[2])]


def wrong_parameter_files(text: str) -> list[str]:
    wrong = []
    for block in blocks(text, "yaml"):
        if "ros__parameters" in block:
            with NamedTemporaryFile("w", suffix=".yaml") as file:
                file.write(block)
                file.flush()
                try:
                    Settings().with_values(read_parameters(Path(file.name)))
                except ParameterError as error:
                    wrong.append(str(error))
    return wrong


def listed(text: str, head: str) -> set[str]:
    """The code in the first column of the table with this head."""
    table = re.search(rf"^\| {head} \|.*\n((?:\|.*\n)+)", text, re.MULTILINE)
    return set(re.findall(r"^\| `([^`]+)`", table[1], re.MULTILINE))


def untrue(text: str, folder: Path) -> list[str]:
    return wrong_links(text, folder) + wrong_parameters(text) + wrong_parameter_files(text)
