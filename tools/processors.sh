#!/bin/sh
# processors.sh [PYTEST ARGUMENT...]: tests with the last bits of other processors, twice: with numpy's and OpenBLAS's
# code for an old one; with an old one's code of the C library and of numba, which compiles anew the first time. This one
# as it is: `make test`. The tests that pytest is given, or those of the core, of the simulator and what is frozen.
set -u
cd "$(dirname "$0")/.."
python=$VENV/bin/python
dispatched='from numpy._core._multiarray_umath import __cpu_dispatch__ as names; print(",".join(names))'
failed=0

run() {
    echo "$1:"
    shift
    # before the tests, whose time is limited
    "$python" -m collplan_core.warm_up
    "$python" -m pytest -n 2 --dist loadfile "$@"
}

[ $# -gt 0 ] || set -- tests/core tests/sim tests/frozen
(
    NPY_DISABLE_CPU_FEATURES=$("$python" -c "$dispatched")
    export NPY_DISABLE_CPU_FEATURES OPENBLAS_CORETYPE=Nehalem
    run "numpy and OpenBLAS for an old one" "$@"
) || failed=1
(
    export GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA NUMBA_CPU_NAME=generic
    run "C library and numba for an old one" "$@"
) || failed=1
exit $failed
