#!/bin/sh
# test_legs.sh test|soak [PYTEST ARGUMENT...]: all legs of the tests, each whatever became of the one before; a line on
# each at the end. Fails where one did.
set -u
: "${VENV:?make names the environment: call make test or make soak}"
cd "$(dirname "$0")/.."
mode=$1
shift
oldest=
report= failed=0
trap 'exit 130' INT

leg() {
    name=$1 began=$(date +%s)
    shift
    word=passed
    "$@" || word="FAILED, exit code $?" failed=1
    report="$report
  $name: $word, $(($(date +%s) - began)) s"
}

# two processes, each with a ROS domain of its own, one of them for whole graphs: tests/conftest.py
side_by_side="-n 2 --dist loadfile"
# shellcheck disable=SC2086  # two options
case $mode in
test)
    leg "installed versions" "$VENV/bin/python" -m pytest $side_by_side "$@"
    # the properties held above, and whole trials show how the robot does, not what an older version lacks
    oldest="--few-examples $(printf -- '--ignore=tests/sim/test_%s.py ' stuck_trials motion_in_trials replayed_trials \
        lying_scans true_scans false_poses sensor_trials corridor_routes body_motions firmwares_agree)"
    ;;
soak)
    leg "installed versions, with the long ones" "$VENV/bin/python" -m pytest $side_by_side -m "soak or not soak" "$@"
    leg "core without its compiler" env NUMBA_DISABLE_JIT=1 "$VENV/bin/python" -m pytest $side_by_side tests/core "$@"
    ;;
*)
    echo "test_legs.sh: test or soak, not $mode" >&2
    exit 2
    ;;
esac
if why=$(tools/find_python.sh "3.11 3.12" 2>&1 >/dev/null); then
    leg "oldest versions" tools/test_oldest.sh $side_by_side $oldest "$@"
else
    report="$report
  oldest versions: SKIPPED, NOT TESTED: $why"
fi
echo "Tests:$report"
exit "$failed"
