#!/bin/sh
# build_ws.sh [COLCON ARGUMENT...]: builds ros_ws with $VENV's Python, whose path colcon writes into the executables,
# then tries each of them. Into build and install where ROS is sourced, else into folders that end in -wheels.
set -eu
: "${VENV:?make names the environment: call make ws}"
cd "$(dirname "$0")/.."

if [ -n "${ROS_DISTRO:-}" ]; then
    constraints=constraints-oldest.txt build=build install=install
else
    constraints=constraints.txt build=build-wheels install=install-wheels
    # set by make for the ROS packages from pip, which are no workspace that colcon can build upon
    unset AMENT_PREFIX_PATH
fi
"$VENV/bin/python" -m pip --disable-pip-version-check -qq install --constraint "$constraints" -r requirements-ws.txt

python=$PWD/$VENV/bin/python
cd ros_ws
COLCON_DEFAULTS_FILE=colcon_defaults.yaml "$python" -m colcon build --build-base "$build" --install-base "$install" "$@"

set +u
# shellcheck disable=SC1091  # made by the build
. "$install/setup.sh"
set -u

# a node refuses an unknown parameter once it has imported all it needs
starts() {
    case ${1##*/} in
    bringup | replay | beside | inspect | study)
        timeout 60 "$1" --help >/dev/null
        ;;
    *) timeout 60 "$1" --ros-args -p no_such.parameter:=1 2>&1 | grep -q '^[^ ].*no_such\.parameter' ;;
    esac
}
for executable in "$install"/*/lib/collplan_*/* "$install"/*/lib/omnipuck_*/*; do
    [ -f "$executable" ] || continue
    grep -q "^#!$python\$" "$executable" || { echo "$executable does not run with $python" >&2; exit 1; }
    starts "$executable" || { echo "$executable does not start" >&2; exit 1; }
    echo "$executable starts"
done
