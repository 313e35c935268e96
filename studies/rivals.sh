#!/bin/sh
# rivals.sh [OPTION...]: `make rivals`: studies/rivals in .venv-rivals, which has OMPL, PyTorch and CasADi; `--help` lists
# its options. PyTorch's own build for CPUs is a few GB smaller; pip takes it where PIP_EXTRA_INDEX_URL names its index.
set -eu
cd "$(dirname "$0")/.."

python=$(tools/find_python.sh "3.11 3.12" 2>&1) || {
    echo "rivals: $python" >&2
    exit 1
}
tools/environment.sh .venv-rivals "$python" constraints.txt "OMPL and PyTorch" -r requirements-test.txt \
    -r studies/requirements.txt -r studies/requirements-rivals.txt -e src/collplan_core -e src/collplan_ros \
    -e src/omnipuck_driver -e src/omnipuck_sim -e src/collplan_study
.venv-rivals/bin/python -m collplan_core.warm_up
# planning times are those of one core
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
export PYTHONPATH=studies${PYTHONPATH:+:$PYTHONPATH}
exec .venv-rivals/bin/python -m rivals "$@"
