"""The executor of every process: rclpy's EventsExecutor, which costs less than half of its others.

Those build a set of everything that they wait for anew at each message, which costs more than the message. It knows no
callback groups and no guard conditions.
"""

import sys
from collections.abc import Iterable
from contextlib import redirect_stderr

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node

TURN_PATIENCE = 0.2
"""Longest wait for what comes to an executor's queue in any case [s]."""


def events_executor(context: Context | None = None) -> Executor:
    """An EventsExecutor of a context, rclpy's default one where there is none."""
    # it turns faulthandler on, which refuses a stderr that is no file
    with redirect_stderr(sys.__stderr__):
        return EventsExecutor(context=context)


def run_all_due(executor: Executor, nodes: Iterable[Node]) -> bool:
    """Runs an EventsExecutor and its nodes until what was due at the call is done; returns whether anything was."""
    is_last, calls = [False], 0

    def end() -> None:
        is_last[0] = True

    # its queue is first in, first out
    executor.create_task(end)
    # a timer that /clock has made ready comes to the queue from another thread
    while not is_last[0] or any(timer.is_ready() for node in nodes for timer in node.timers):
        executor.spin_once(timeout_sec=TURN_PATIENCE)
        calls += 1
    return calls > 1
