#!/bin/sh
# environment.sh FOLDER PYTHON CONSTRAINTS WORDS PIP_ARGUMENT...: an environment of its own beside .venv, with what pip is
# asked for, under constraints; made anew where something of that has changed. WORDS say what it is.
set -eu
cd "$(dirname "$0")/.."
folder=$1 python=$2 constraints=$3 words=$4
shift 4

sum=$(cat "$constraints" requirements-test.txt requirements-site.txt studies/requirements*.txt src/*/setup.py tools/environment.sh | cksum)
made_from="$PWD $sum $*"
if [ "$(cat "$folder/.ready" 2>/dev/null)" != "$made_from" ]; then
    echo "Setting up $folder: $python, $words; takes a minute or two ..."
    "$python" -m venv --clear "$folder"
    pip() {
        "$folder/bin/python" -m pip --disable-pip-version-check -qq install --constraint "$constraints" "$@"
    }
    pip pip setuptools wheel
    pip --no-build-isolation --config-settings editable_mode=compat "$@"
    echo "$made_from" >"$folder/.ready"
fi
