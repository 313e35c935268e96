"""Start, run and shutdown of a node, the same for every executable."""

import argparse
import gc
import os
import re
import signal
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from collplan_core.parameters.spec import ParameterError
from collplan_ros.node_kit.events_executor import events_executor
from collplan_ros.node_kit.reachability import why_no_graph, why_no_logs
from collplan_ros.node_kit.stop_signal import StopSignal

STARTUP_ERROR = 2
"""Exit code of a node that could not be made."""
LOOK_PERIOD = 0.02
"""Between two looks whether a signal has come [s]: the robot drives on for so long."""
PARAMETER = re.compile(r"(?:[^:]+:)?([^:]+):=")
"""KEY:=VALUE, or NODE:KEY:=VALUE."""
# RuntimeError: rcl's own errors, among them ROS arguments and parameter files that cannot be read
_STARTUP_ERRORS = (ValueError, OSError, RuntimeError, ParameterException, NameValidationException)


def run_node(make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Runs one node until SIGINT, SIGTERM, SIGHUP or the end of its context; returns the exit code.

    `make_node` makes it in rclpy's default context; `args` are the command line with the program's name, sys.argv when
    None. At the end `node.stop()` is called, if the node has it, while messages can still be sent; then what a callback
    raised is raised again.

    The code is 0, 2 when the node could not be made, after one line on stderr that says why, or 128 and the signal that
    came meanwhile.
    """
    argv, stop_signal = list(sys.argv if args is None else args), StopSignal()
    with stop_signal.listening():
        return _run(make_node, argv, stop_signal)


def _run(make_node: Callable[[], Node], argv: list[str], stop_signal: StopSignal) -> int:
    program = Path(argv[0]).name if argv else "node"
    try:
        _refuse_other_arguments(program, argv)
        local = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST"
        if why := why_no_graph(os.environ, local) or why_no_logs(os.environ):
            raise OSError(why)
        with stop_signal.at_once():
            rclpy.init(args=argv, signal_handler_options=SignalHandlerOptions.NO)
            node = make_node()
        _refuse_parameters_of_others(node, argv)
    except KeyboardInterrupt:  # while it was made
        rclpy.try_shutdown()
        return 128 + (stop_signal.number or signal.SIGINT)
    except _STARTUP_ERRORS as error:
        print(f"{program}: {' '.join(str(error).split())}", file=sys.stderr)
        rclpy.try_shutdown()
        return STARTUP_ERROR
    _spin(node, stop_signal)
    return 0


def _refuse_other_arguments(program: str, argv: list[str]) -> None:
    """Exits with usage on arguments outside --ros-args, which ROS would ignore without a word."""
    usage = "%(prog)s [--ros-args -p KEY:=VALUE --params-file FILE -r FROM:=TO ...]"
    argparse.ArgumentParser(prog=program, usage=usage).parse_args(remove_ros_args(argv)[1:])


def _refuse_parameters_of_others(node: Node, argv: list[str]) -> None:
    """Raises ParameterError on a parameter given by name that this node does not have; files serve every node."""
    for option, value in pairwise(argv):
        given = PARAMETER.match(value) if option in ("-p", "--param") else None
        if given and not node.has_parameter(given[1]):
            raise ParameterError(f"{given[1]}: no parameter of {node.get_name()}")


def _spin(node: Node, stop_signal: StopSignal) -> None:
    executor, never = events_executor(), Future()
    executor.add_node(node)
    # what was compiled and imported stays; to look through it for garbage takes a tenth of a second and more
    gc.freeze()
    try:
        while stop_signal.number is None and rclpy.ok():
            # spin_once() would end after each callback; spin() waits until a time that overflows, at full load
            executor.spin_until_future_complete(never, timeout_sec=LOOK_PERIOD)
    finally:
        _end(node, executor)


def _end(node: Node, executor: Executor) -> None:
    try:
        if hasattr(node, "stop") and rclpy.ok():
            node.stop()
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def publish_acknowledged(publisher: Publisher, message: object, timeout: float = 1.0) -> bool:
    """Publishes and waits until every reliable listener has received it, at most `timeout` [s]; whether all have."""
    publisher.publish(message)
    return publisher.wait_for_all_acked(Duration(seconds=timeout))
