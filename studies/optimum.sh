#!/bin/sh
# optimum.sh [OPTION...]: `make optimum`: studies/optimum in .venv-optimum, which has CasADi; `--help` lists its options.
set -eu
cd "$(dirname "$0")/.."

python=$(tools/find_python.sh "3.10 3.11 3.12 3.13" 2>&1) || {
    echo "optimum: $python" >&2
    exit 1
}
tools/environment.sh .venv-optimum "$python" constraints.txt "CasADi" -r requirements-test.txt \
    -r studies/requirements.txt -e src/collplan_core -e src/collplan_ros -e src/omnipuck_driver \
    -e "src/omnipuck_sim[mujoco]" -e src/collplan_study
.venv-optimum/bin/python -m collplan_core.warm_up
# each process solves a world of its own
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
export PYTHONPATH=studies${PYTHONPATH:+:$PYTHONPATH}
exec .venv-optimum/bin/python -m optimum "$@"
