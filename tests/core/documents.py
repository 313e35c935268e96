"""What a document names and the project does not have: each check gives a list of it."""

import ast
import re
from pathlib import Path
from tempfile import NamedTemporaryFile

import yaml

from collplan_core.parameters import GROUPS, ParameterError, Settings
from collplan_core.parameters.file import read_parameters
from command_lines import HEADS, wrong_command
from repository import (
    EVERYTHING,
    FILES,
    FOLDERS,
    ROOT,
    SOURCES,
    TOPICS,
    found,
    is_defined,
    is_importable,
    is_there,
    source_of,
    wrong_value,
)

OF_RECEIVERS = {
    yaml.safe_load(path.read_text())["/**"]["ros__parameters"]["mocap"]["topic"]
    for path in ROOT.glob("src/collplan_ros/collplan_ros/config/mocap_*.yaml")
}


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
    kinds = r"[\w.-]+(/[\w.-]+)*(/|\.(py|md|sh|toml|svg|rviz|yaml|json|jsonl|csv|png|gif|html|parquet))"
    paths = [s for s in spans(text) if re.fullmatch(kinds, s) or re.fullmatch(rf"({'|'.join(FOLDERS)})(/[\w.-]+)+", s)]
    paths += re.findall(r"[\w/]+\.py\b", "\n".join(blocks(text, "")))
    return [path for path in paths if not is_there(path)]


def wrong_functions(text: str) -> list[str]:
    wrong = []
    for path, names in re.findall(r"^([\w/]+\.py): ([\w, .]+)$", "\n".join(spans(text)), re.MULTILINE):
        files = found(path)
        source = SOURCES[files[0]] if len(files) == 1 else ""
        wrong += [f"{path}: {name}" for name in names.split(", ") if not is_defined(name, source)]
    return wrong


def wrong_imports(text: str) -> list[str]:
    nodes = [node for block in blocks(text, "python") for node in ast.walk(ast.parse(block))]
    named = [(n.module, alias.name) for n in nodes if isinstance(n, ast.ImportFrom) for alias in n.names]
    ours = [(module, name) for module, name in named if f"src/{module.split('.')[0]}" in FILES]
    return [f"{module}.{name}" for module, name in ours if not is_importable(name, source_of(module))]


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
    return [name for name in topics if name not in TOPICS | OF_RECEIVERS and not is_there(name)]


def listed(text: str, head: str) -> set[str]:
    """The code in the first column of the table with this head."""
    table = re.search(rf"^\| {head} \|.*\n((?:\|.*\n)+)", text, re.MULTILINE)
    return set(re.findall(r"^\| `([^`]+)`", table[1], re.MULTILINE))


def untrue(text: str, folder: Path) -> list[str]:
    names = (wrong_paths, wrong_functions, wrong_imports, wrong_parameters, wrong_topics)
    checks = (*names, wrong_parameter_files, wrong_commands)
    return wrong_links(text, folder) + [each for check in checks for each in check(text)]
