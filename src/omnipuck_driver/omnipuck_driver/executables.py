"""The program of omnipuck_driver."""

from collplan_core.command_line import Executable

driver_node = Executable("omnipuck_driver.driver_node")
