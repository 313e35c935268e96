"""The documents are true: files, links, functions, parameters, make targets, commands and topics in them exist."""

import pytest

from documents import listed, untrue
from repository import ROOT, SERVICES, TOPICS

DOCUMENTS = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted(ROOT.glob("docs/*.md")), ROOT / "benchmarks/README.md"]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_document_names_is_there(document):
    assert untrue(document.read_text(encoding="utf-8"), document.parent) == []


def test_every_topic_and_service_is_listed():
    text = (ROOT / "docs/ros.md").read_text(encoding="utf-8")
    assert listed(text, "topic") == TOPICS
    assert listed(text, "service") == SERVICES


@pytest.mark.parametrize(
    "text",
    [
        "# A part\n[limits](docs/limits.md), [part](docs/limits.md#simulation), [here](#a-part), [else](https://a.org/b)",
        "`docs/limits.md`, `local_map/`, `costs/total.py`, `tests/core`, `runs/latest/`, `summary.json`, `lab.yaml`",
        "`local_map/build.py: build_local_map`, `strategies.py: PAPER_WEIGHTS, TIME_TO_GOAL`",
        "`planner.map_period`, `planner.strategy: low_risk`, `simulator.noise:=0.5`, `robot.max_acceleration=1`",
        "`mocap/odom` and `/diagnostics`, `make help`, `make`, `--seed 3`, `.venv/bin/NODE`",
        '```\nmake run ARGS="--world u:17 --goal 1.0 0.5"  # a comment\nmake study ARGS=--help\n```',
        "```\nmake study-bounce ARGS='--run main \\\n  --out there'\n.venv/bin/python -m pytest tests/core\n```",
        "```\nros2 run collplan_ros lidar_node --ros-args -p lidar.world:=slalom\nros2 topic echo planner/costs\n```",
        "```\nros2 param set /planner_node planner.map_period 0.4\nros2 service call /cancel std_srvs/srv/Trigger\n```",
        "```\n00 | a picture of bytes -> no command; build.py -> frontiers.py\n```",
        "```yaml\n/**:\n  ros__parameters:\n    robot: {radius: 0.1}\n```\n```yaml\nstart: [0.3, 1.0]\n```",
        "```python\nfrom collplan_core.parameters import Settings\nfrom omnipuck_sim.trial import run_trial\n```",
    ],
)
def test_what_is_true_passes(text):
    assert untrue(text, ROOT) == []


@pytest.mark.parametrize(
    "text",
    [
        "[gone](docs/gone.md)",
        "[no such part](docs/limits.md#no-such-part)",
        "[no such part](#no-such-part)",
        "`docs/gone.md`",
        "`no_such_folder/`",
        "`src/collplan_core/gone`",
        "`no_such_output.csv`",
        "```\nscan -> no_such_stage.py -> plan\n```",
        "`local_map/build.py: no_such_function`",
        "`plan_cycle.py: plan_cycle`",  # which of the two?
        "`planner.no_such_key`",
        "```yaml\n/**:\n  ros__parameters:\n    robot: {radus: 0.1}\n```",
        "```yaml\n/**:\n  ros__parameters:\n    robot: {max_speed: 9.0}\n```",
        "`planner.strategy: no_such_strategy`",
        "`robot.radius:=50`",
        "`no_such/topic`",
        "`/no_such_topic`",
        "`--no-such-option`",
        "`make no-such-target`",
        "```\nmake help\nno_such_command\n```",
        '```\nmake run ARGS="--no-such-option"\n```',
        '```\nmake study ARGS="--trials many"\n```',
        "```\n.venv/bin/no_such_program\n```",
        "```\n.venv/bin/beside\n```",
        "```\n.venv/bin/python -m pytest tests/gone\n```",
        "```\nros2 run omnipuck_sim planner_node\n```",
        "```\nros2 run collplan_ros lidar_node --ros-args -p planner.map_period:=0.4\n```",
        "```\nros2 param set /lidar_node lidar.rate 0\n```",
        "```\nros2 topic echo no_such_topic\n```",
        "```\nros2 service call /no_such_service std_srvs/srv/Trigger\n```",
        "```python\nfrom collplan_core.parameters import NoSuchThing\n```",
        "```python\nfrom collplan_core.no_such_module import Settings\n```",
    ],
)
def test_what_is_not_true_is_found(text):
    assert len(untrue(text, ROOT)) == 1
