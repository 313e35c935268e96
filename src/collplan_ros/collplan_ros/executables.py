"""The programs of collplan_ros: its nodes, bringup, and what reads recordings."""

from collplan_core.command_line import Executable

base_node = Executable("collplan_ros.nodes.base_node")
mocap_node = Executable("collplan_ros.nodes.mocap_node")
lidar_node = Executable("collplan_ros.nodes.lidar_node")
planner_node = Executable("collplan_ros.nodes.planner_node")
controller_node = Executable("collplan_ros.nodes.controller_node")
view_node = Executable("collplan_ros.nodes.view_node")
bringup = Executable("collplan_ros.bringup.main")
replay = Executable("collplan_ros.replay.main")
beside = Executable("collplan_ros.run.page.beside")
inspect = Executable("collplan_ros.inspect.main")
