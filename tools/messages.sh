#!/bin/sh
# messages.sh: `make messages`: message packages that pip lacks, from the definitions in tests/messages, into
# .messages/install for $VENV's Python. Tests use them. Where something is missing that it needs, it says so and succeeds.
set -eu
: "${VENV:?make names the environment: call make messages}"
cd "$(dirname "$0")/.."

skip() {
    echo "Messages: SKIPPED, NOT TESTED: $*"
    exit 0
}

if [ -n "${ROS_DISTRO:-}" ]; then
    "$VENV/bin/python" -c 'import nav2_msgs, tf2_msgs' 2>/dev/null ||
        skip "this ROS lacks some: sudo apt install ros-$ROS_DISTRO-nav2-msgs ros-$ROS_DISTRO-tf2-msgs"
    exit 0
fi

# what is compiled fits this Python alone; an environment made from an environment would lose its Python with it
python=$("$VENV/bin/python" -c 'import os, sys; print(os.path.realpath(sys.executable))')
headers=$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')

out=$PWD/.messages
made_from="$PWD $python $(find tests/messages requirements-messages.txt tools/messages.sh -type f | sort | xargs cksum | cksum)"
[ "$(cat "$out/.ready" 2>/dev/null)" != "$made_from" ] || exit 0
# the tests use no others than those that are defined now
rm -rf "$out"

missing=
command -v cmake >/dev/null || missing="$missing cmake"
command -v make >/dev/null || missing="$missing make"
command -v cc >/dev/null || missing="$missing gcc"
command -v c++ >/dev/null || missing="$missing g++"
[ -f "$headers/Python.h" ] || missing="$missing python$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')-dev"
[ -z "$missing" ] || skip "generating messages needs$missing: sudo apt install$missing"

tools/environment.sh .venv-messages "$python" requirements-messages.txt "rosidl's generators" -r requirements-messages.txt
env=$PWD/.venv-messages

# the packages of pip name the headers of the machine that built them
numpy=$("$env/bin/python" -c 'import numpy; print(numpy.get_include())')
grep -rlF /opt/python/cp3 "$env/share" --include='*.cmake' | xargs -r sed -E -i \
    -e "s#/opt/python/cp3[^;\"]*/site-packages/numpy/_core/include#$numpy#g" \
    -e "s#/opt/python/cp3[^;\"]*/include/python3\.[0-9]+#$headers#g"

export AMENT_PREFIX_PATH="$env" CMAKE_PREFIX_PATH="$env" LD_LIBRARY_PATH="$env/lib"
unset PYTHONPATH
mkdir "$out"
for definitions in tests/messages/*/; do
    package=$(basename "$definitions")
    source=$out/source/$package log=$out/$package.log
    echo "Generating $package ..."
    mkdir -p "$source"
    cp -R "$definitions." "$source"
    # made here, not kept: a workspace above this repository would take them for the packages themselves
    cat >"$source/package.xml" <<XML
<package format="3">
  <name>$package</name>
  <version>0.0.0</version>
  <description>Some of its definitions, for tests</description>
  <maintainer email="nobody@example.org">nobody</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
</package>
XML
    cat >"$source/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.22)
project($ENV{PACKAGE})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
set(used action_msgs builtin_interfaces geometry_msgs std_msgs)
foreach(each ${used})
  find_package(${each} REQUIRED)
endforeach()
# found beside the libraries, no variable has to name their folder
set(CMAKE_INSTALL_RPATH "$ORIGIN;$ORIGIN/../../..")
file(GLOB definitions RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} msg/*.msg action/*.action)
rosidl_generate_interfaces(${PROJECT_NAME} ${definitions} DEPENDENCIES ${used})
ament_package()
CMAKE
    {
        PACKAGE=$package cmake -S "$source" -B "$out/build/$package" \
            -DCMAKE_INSTALL_PREFIX="$out/install" -DPython3_EXECUTABLE="$env/bin/python" &&
            cmake --build "$out/build/$package" --parallel "$(nproc)" &&
            cmake --install "$out/build/$package"
    } >"$log" 2>&1 || {
        tail -n 30 "$log" >&2
        echo "messages: $package was not generated, $log says why" >&2
        exit 1
    }
done
rm -rf "$out/build"
echo "$made_from" >"$out/.ready"
