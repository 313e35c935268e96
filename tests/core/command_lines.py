"""What is wrong with a command line of a document: it goes through its own argument parser and is not run."""

import contextlib
import io
import re
import shlex

import collplan_core.parameters as parameters
from collplan_core.parameters.spec import specs
from collplan_ros.bringup.options import parse as parse_bringup
from collplan_ros.pictures.compare_runs import _parser as beside_parser
from collplan_ros.replay.main import _parser as replay_parser
from collplan_ros.runs.fit_robot import _parser as fit_robot_parser
from collplan_study.compare_engines import _parser as compare_engines_parser
from collplan_study.errors import StudyError
from collplan_study.optimum.options import parse as parse_optimum
from collplan_study.question.options import parse as parse_study
from repository import FILES, ROOT, SERVICES, SOURCES, TOPICS, source_of, wrong_value

TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
RUN_BY = {
    "run": ("bringup",),
    "study": ("study",),
    "study-bounce": ("study", "--bounces"),
    "optimum": ("optimum",),
    "animation": ("beside", "RUN"),
}
PARSERS = {
    "bringup": parse_bringup,
    "study": parse_study,
    "optimum": parse_optimum,
    "beside": beside_parser().parse_args,
    "compare_engines": compare_engines_parser().parse_args,
    "fit_robot": fit_robot_parser().parse_args,
    "replay": replay_parser().parse_args,
}
MODULES = {
    name: (path.split("/")[1], module)
    for path in FILES
    if re.fullmatch(r"src/\w+/\w+/executables\.py", path)
    for name, module in re.findall(r'^(\w+) = Executable\("([\w.]+)"\)', SOURCES[path], re.MULTILINE)
}
"""Package and module of each executable."""
OF_OTHERS = {("joy", "joy_node")}
"""Package and executable of what ROS has itself."""
SHELL = {"export", "source", "rviz2"}
HEADS = re.compile(
    r"(make|ros2|export|source|rviz2|bringup|study|optimum|beside|compare_engines|fit_robot|replay|"
    r"\.venv/bin/[a-z_]+)( |$)"
)


def declared_by(node: str) -> set[str]:
    groups = re.search(r"^GROUPS = \(([^)]*)\)", source_of(MODULES[node][1]), re.MULTILINE)
    single = set(re.findall(r'"([\w.]+)"', groups[1]))
    names = re.findall(r"\b[A-Z]\w+", groups[1])
    return single | {spec.key for name in names for spec in specs(getattr(parameters, name))}


def wrong_options(name: str, args: list[str]) -> list[str]:
    if name not in MODULES:
        return [name]
    if name not in PARSERS:
        values = [args[i + 1].split(":=") for i, arg in enumerate(args) if arg == "-p"]
        return [wrong for key, value in values for wrong in wrong_value(key, value, declared_by(name))]
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            PARSERS[name](args)
    except (SystemExit, StudyError) as error:
        return [] if getattr(error, "code", 1) == 0 else [f"{said.getvalue().strip()} {error}"]
    return []


def wrong_ros2(words: list[str]) -> list[str]:
    if words[0] == "run":
        package, name, *args = words[1:]
        if (package, name) in OF_OTHERS:
            return []
        known = MODULES.get(name, ("",))[0] == package
        return [] if name.isupper() else wrong_options(name, args) if known else [f"{package} {name}"]
    if words[0] == "param":
        return wrong_value(words[3], words[4] if len(words) > 4 else None, declared_by(words[2].lstrip("/")))
    names = {*TOPICS, *(f"/{name}" for name in SERVICES)}
    return [] if words[0] in ("pkg", "bag") or names & set(words) else [" ".join(words)]


def wrong_command(line: str) -> list[str]:
    head, *words = shlex.split(line, comments=True)
    name = head.removeprefix(".venv/bin/")
    if head == "make":
        wrong = [word for word in words if "=" not in word and word not in TARGETS]
        program, *options = RUN_BY.get(words[0], ("",)) if words else ("",)
        args = [word.removeprefix("ARGS=") for word in words if word.startswith("ARGS=")]
        return wrong + (wrong_options(program, [*options, *shlex.split(args[0])]) if program and args else [])
    if head == "ros2":
        return wrong_ros2(words)
    if name == "python":
        return [word for word in words if "/" in word and not (ROOT / word).exists()]
    return [] if head in SHELL or name.isupper() else wrong_options(name, words)
