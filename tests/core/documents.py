"""What a document names and the project does not have: each check gives a list of it."""

import ast
import re
import shlex
from itertools import pairwise
from pathlib import Path
from tempfile import NamedTemporaryFile

import yaml

from collplan_core.parameters import GROUPS, ParameterError, Settings, all_specs
from collplan_core.parameters.file import read_parameters

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "docs", "examples", "tests", "tools", "studies", "benchmarks", ".ci")
FILES = {
    path.relative_to(ROOT).as_posix()
    for path in (*ROOT.glob("*"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*")))
    if "__pycache__" not in path.parts
}
SOURCES = {path: (ROOT / path).read_text() for path in FILES if path.endswith(".py") and not path.startswith("tests/")}
EVERYTHING = "\n".join(SOURCES.values())
OF_THE_READER = {
    "first.py",
    *(f"{name}.yaml" for name in ("lab", "base", "floor", "spread", "my_arena", "my_room")),
}
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
ACTIONS = set(re.findall(r'^ACTION = "(\w+)"', EVERYTHING, re.MULTILINE))
SERVICES = named_in_calls("create_service", "_serve")


def found(path: str) -> list[str]:
    """The files and folders whose path ends so."""
    return [file for file in FILES if f"/{file}".endswith("/" + path.rstrip("/"))]


def is_there(path: str) -> bool:
    """Whether it is in the repository, written by the code, or the reader's own."""
    name = path.rstrip("/").split("/")[-1]
    written = path.startswith(("runs/", ".venv")) or f'"{name}"' in EVERYTHING
    return bool(found(path)) or written or name in OF_THE_READER


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


OF_RECEIVERS = {
    yaml.safe_load(path.read_text())["/**"]["ros__parameters"]["mocap"]["topic"]
    for path in ROOT.glob("src/collplan_ros/collplan_ros/config/mocap_*.yaml")
}
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
PACKAGES = {"tf2_echo": "tf2_ros"} | {
    name: path.split("/")[1]
    for path in FILES
    if re.fullmatch(r"src/\w+/\w+/executables\.py", path)
    for name in re.findall(r"^(\w+) = Executable\(", SOURCES[path], re.MULTILINE)
}
"""Of each executable."""
SHELL = {"cd", "export", "git", "source", "rviz2", "python", "ros2"}
HEADS = re.compile(
    r"(make|ros2|export|source|rviz2|bringup|study|beside|replay|"
    r"\.venv/bin/[a-z_]+)( |$)"
)


def wrong_command(line: str) -> list[str]:
    """Of a command line: a target, program, option, parameter or topic that is not there."""
    head, *words = shlex.split(line, comments=True)
    name, wrong = head.removeprefix(".venv/bin/"), []
    if head == "make":
        wrong = [word for word in words if "=" not in word and word not in TARGETS]
        words = [part for word in words for part in shlex.split(word.removeprefix("ARGS="))]
    elif head == "ros2" and words[0] == "run":
        wrong = [] if words[2].isupper() or PACKAGES.get(words[2]) == words[1] else [words[2]]
    elif head == "ros2" and words[0] == "param":
        wrong = wrong_value(words[3], words[4] if len(words) > 4 else None)
    elif head == "ros2" and words[0] not in ("pkg", "bag") and words[:2] != ["topic", "list"]:
        named = {*TOPICS, *ACTIONS, *OF_BASES, *(f"/{each}" for each in SERVICES)}
        return [] if named & {word.removeprefix("/collplan") for word in words} else [line]
    elif head not in SHELL and not name.isupper() and name not in (*SHELL, *PACKAGES):
        wrong = [name]
    if name == "python":
        return [word for word in words if "/" in word and not word.startswith("runs/") and not (ROOT / word).exists()]
    values = [word.split(":=") for before, word in pairwise(words) if before == "-p"]
    options = [word.split("=")[0] for word in words if re.match(r"--[a-z]", word) and word != "--help"]
    wrong += [each for key, value in values for each in wrong_value(key, value)]
    return wrong + [option for option in options if f'"{option}"' not in EVERYTHING]


def blocks(text: str, language: str) -> list[str]:
    return [
        body for kind, body in re.findall(r"^```(\w*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE) if kind == language
    ]


def prose(text: str) -> str:
    return re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def spans(text: str) -> list[str]:
    return [" ".join(span.split()) for span in re.findall(r"`([^`]+)`", prose(text))]


def headings(text: str) -> set[str]:
    """Headings of a document, spelt as links to them are."""
    lines = re.findall(r"^#+ (.*)$", prose(text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines}


def wrong_links(text: str, folder: Path) -> list[str]:
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", prose(text)) if "://" not in link]
    return [link for link in links if not leads_somewhere(link, text, folder)]


def leads_somewhere(link: str, text: str, folder: Path) -> bool:
    path, _, part = link.partition("#")
    page = folder / path
    return page.exists() and (not part or part in headings(page.read_text() if path else text))


def wrong_paths(text: str) -> list[str]:
    kinds = r"[\w.-]+(/[\w.-]+)*(/|\.(py|md|sh|toml|svg|rviz|yaml|json|jsonl|csv|png|html|parquet))"
    paths = [s for s in spans(text) if re.fullmatch(kinds, s) or re.fullmatch(rf"({'|'.join(FOLDERS)})(/[\w.-]+)+", s)]
    paths += re.findall(r"[\w/]+\.py\b", "\n".join(blocks(text, "")))
    return [path for path in paths if not is_there(path)]


def wrong_parameters(text: str) -> list[str]:
    groups = "|".join(group.group for group in GROUPS)
    keys = [re.fullmatch(rf"((?:{groups})\.(?!py\b|yaml\b)\w+)(?:(?::=|=|: )([^,]+))?", span) for span in spans(text)]
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


def wrong_commands(text: str) -> list[str]:
    lines = [span for span in spans(text) if HEADS.match(span) and " " in span]
    for block in blocks(text, ""):
        whole = [line for line in block.replace("\\\n", " ").splitlines() if line.strip()]
        lines += whole if any(HEADS.match(line) for line in whole) else []
    options = [option for span in spans(text) for option in re.findall(r"^--[a-z-]+", span)]
    wrong = [f"{line}: {wrong}" for line in lines for wrong in wrong_command(line)]
    return wrong + [option for option in options if f'"{option}"' not in EVERYTHING]


def wrong_topics(text: str) -> list[str]:
    named = [span for span in spans(text) if re.fullmatch(r"/?[a-z_]+(/[a-z_]+)+|/[a-z_]+", span)]
    topics = [name for name in named if name.split("/")[0] not in FOLDERS]
    return [name for name in topics if name not in TOPICS | OF_RECEIVERS | OF_BASES and not is_there(name)]


def listed(text: str, head: str) -> set[str]:
    """The code in the first column of the table with this head."""
    table = re.search(rf"^\| {head} \|.*\n((?:\|.*\n)+)", text, re.MULTILINE)
    return set(re.findall(r"^\| `([^`]+)`", table[1], re.MULTILINE))


def untrue(text: str, folder: Path) -> list[str]:
    names = (wrong_paths, wrong_parameters, wrong_topics)
    checks = (*names, wrong_parameter_files, wrong_commands)
    return wrong_links(text, folder) + [each for check in checks for each in check(text)]
