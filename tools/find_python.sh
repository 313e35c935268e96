#!/bin/sh
# find_python.sh "VERSION..." [MODULE]: path of a Python of one of these versions that can make environments and, if
# a module is named, import it. Finds none: one line on stderr that says what to install, exit 1.
set -u
versions=$1
module=${2:-ensurepip}
seen= no_venv= no_module=
for name in python3 python3.12 python3.11 python3.13 python3.10 /usr/bin/python3; do
    version=$("$name" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || continue
    case "$seen " in *" $version "*) ;; *) seen="$seen $version" ;; esac
    case " $versions " in *" $version "*) ;; *) continue ;; esac
    if ! "$name" -c 'import ensurepip, venv' 2>/dev/null; then
        no_venv=${no_venv:-$version}
    elif ! "$name" -c "import $module" 2>/dev/null; then
        no_module=$version
    else
        # an environment made from an environment would lose its Python with it
        exec "$name" -c 'import os, sys; print(os.path.realpath(sys.executable))'
    fi
done

if [ -n "$no_venv" ]; then
    echo "Python $no_venv lacks venv and pip, install them: sudo apt install python$no_venv-venv" >&2
elif [ -n "$no_module" ]; then
    echo "no Python here imports $module: sudo apt install ros-jazzy-ros-base, or use a shell where no ROS is sourced" >&2
else
    echo "needs Python $versions, found${seen:- none}: for example sudo apt install python3.12 python3.12-venv" >&2
fi
exit 1
