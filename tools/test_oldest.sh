#!/bin/sh
# test_oldest.sh [PYTEST ARGUMENT...]: what an older version may lack, imports and interfaces, on the oldest versions
# declared, in .venv-oldest: the core with few examples, a trial of each planner, what reads files; not the documents,
# which speak of ROS. They are known to work together on Python 3.11 and 3.12; without one of those, says so and succeeds.
set -eu
cd "$(dirname "$0")/.."

if ! python=$(tools/find_python.sh "3.11 3.12" 2>&1); then
    echo "Oldest versions: SKIPPED, NOT TESTED: $python"
    exit 0
fi

tools/environment.sh .venv-oldest "$python" constraints-oldest.txt "oldest versions declared" -r requirements-test.txt \
    -e src/collplan_core -e src/collplan_ros -e src/omnipuck_driver -e "src/omnipuck_sim[mujoco]" -e src/collplan_study -e src/collplan_gym
echo "Oldest versions: $(.venv-oldest/bin/python -m pip --disable-pip-version-check freeze 2>/dev/null |
    grep -E '^(numpy|scipy|shapely|numba|pymunk)==' | tr '\n' ' ')"
.venv-oldest/bin/python -m collplan_core.warm_up
exec .venv-oldest/bin/python -m pytest --few-examples -n 2 --dist loadfile "$@" \
    --ignore tests/core/test_documents.py tests/core tests/oldest
