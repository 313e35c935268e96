#!/bin/sh
# dist.sh: the six packages as wheels in dist/, then installed and tried outside of the sources: in an environment
# without ROS, then with the ROS of pip in it, or in one upon the ROS that is sourced.
set -eu
: "${VENV:?make names the environment: call make dist}"
cd "$(dirname "$0")/.."
project=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

pip() {
    interpreter=$1
    shift
    "$interpreter" -m pip --disable-pip-version-check -qq "$@"
}
fail() {
    echo "dist: $*" >&2
    exit 1
}

# of a copy: what an earlier build has left beside the sources would be in the wheels
mkdir "$work/src"
cp -R src/. "$work/src"
rm -rf dist "$work"/src/*/build "$work"/src/*/*.egg-info
pip "$VENV/bin/python" wheel --no-deps --no-build-isolation --wheel-dir dist "$work"/src/*
rm -rf "$work/src"

# environment NAME PYTHON CONSTRAINTS [OPTION...]: makes one with the wheels in it
environment() {
    bin=$work/$1/bin python=$2 constraints=$project/$3
    shift 3
    "$python" -m venv "$@" "${bin%/bin}"
    pip "$bin/python" install --constraint "$constraints" pip
    pip "$bin/python" install --constraint "$constraints" "$project"/dist/*.whl
}
start() {
    for program in "$@"; do
        timeout 120 "$bin/$program" --help >/dev/null || fail "$program of the wheels does not start"
        echo "$program starts"
    done
}

cd "$work"
echo "Trying the wheels without ROS ..."
ros_of_the_shell=${PYTHONPATH:-}
unset PYTHONPATH
python=$("$project/tools/find_python.sh" "3.10 3.11 3.12 3.13")
environment plain "$python" constraints.txt
! "$bin/python" -c 'import rclpy' 2>/dev/null || fail "rclpy is in an environment that was to be without ROS"
start study replay beside inspect
"$bin/study" --worlds corridor --strategies harness --map-periods 0.2 --trials 1 --jobs 1 --out study >said.txt 2>&1 ||
    { cat said.txt >&2; fail "study of the wheels does not run"; }
[ -s study/report.html ] || fail "study of the wheels has written no report"
echo "study runs"

echo "Trying them with ROS ..."
if [ -n "${ROS_DISTRO:-}" ]; then
    export PYTHONPATH="$ros_of_the_shell"
    python=$("$project/tools/find_python.sh" "3.10 3.11 3.12 3.13" rclpy)
    environment ros "$python" constraints-oldest.txt --system-site-packages
else
    pip "$bin/python" install --constraint "$project/constraints.txt" -r "$project/requirements-ros.txt"
    export AMENT_PREFIX_PATH="$work/plain"
fi
# shellcheck disable=SC2046  # a list
start $("$bin/python" - collplan-core collplan-ros omnipuck-driver omnipuck-sim collplan-study collplan-gym <<'PROGRAMS'
import sys
from importlib.metadata import distribution
print(*(entry.name for name in sys.argv[1:] for entry in distribution(name).entry_points))
PROGRAMS
)
"$bin/bringup" --no-pictures --out runs >said.txt 2>&1 || { cat said.txt >&2; fail "bringup of the wheels does not run"; }
echo "bringup reaches its goal"
echo "The wheels are in dist/:"
ls "$project/dist"
