"""Becomes another program that the kernel kills when the thread that started this one ends: PARENT PROGRAM ARGUMENT ...

A program of its own, because nothing may run between fork and exec in a process that has threads.
"""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1

if __name__ == "__main__":
    parent, *command = sys.argv[1:]
    # SIGKILL, because a node that hangs would ignore SIGTERM; the setting survives exec
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != int(parent):  # the parent died before prctl took effect
        sys.exit(1)
    os.execv(command[0], command)
