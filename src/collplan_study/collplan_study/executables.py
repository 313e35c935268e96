"""The programs of collplan_study."""

from collplan_core.executable import Executable

compare_engines = Executable("collplan_study.compare_engines")
optimum = Executable("collplan_study.optimum.main")
study = Executable("collplan_study.main")
