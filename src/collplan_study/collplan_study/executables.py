"""The program of collplan_study."""

from collplan_core.command_line import Executable

study = Executable("collplan_study.main")
