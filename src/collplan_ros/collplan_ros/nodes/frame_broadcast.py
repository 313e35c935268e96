"""Broadcast of the transform from map to base_link; tf2_ros is needed, which is not on the package index."""

from collections.abc import Callable

from geometry_msgs.msg import TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.node import Node

from collplan_core.parameters.spec import ParameterError


def frame_broadcast(node: Node) -> Callable[[Odometry], None]:
    """Makes a function that broadcasts the pose of an odometry message as a transform.

    Raises:
        ParameterError: tf2_ros is not installed.
    """
    try:
        from tf2_ros import TransformBroadcaster
    except ImportError:
        raise ParameterError("mocap.publish_tf: got True, expected False where tf2_ros is not installed") from None
    broadcaster = TransformBroadcaster(node)

    def broadcast(odometry: Odometry) -> None:
        position = odometry.pose.pose.position
        message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
        message.transform.translation = Vector3(x=position.x, y=position.y, z=position.z)
        message.transform.rotation = odometry.pose.pose.orientation
        broadcaster.sendTransform(message)

    return broadcast
