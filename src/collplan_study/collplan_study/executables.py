"""The program of collplan_study."""

from collplan_core.executable import Executable

study = Executable("collplan_study.main")
