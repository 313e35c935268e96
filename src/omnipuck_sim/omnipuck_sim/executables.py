"""The programs of omnipuck_sim: the simulated robot, as a node and behind a serial line."""

from collplan_core.command_line import Executable

firmware_emulator = Executable("omnipuck_sim.emulator.firmware_emulator")
simulator_node = Executable("omnipuck_sim.node.simulator_node")
