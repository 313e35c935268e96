"""Broadcast of the transform from map to base_link, as tf2_ros does it; tf2_msgs is needed, which is no pip package."""

from collections.abc import Callable

from geometry_msgs.msg import TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.node import Node

from collplan_core.parameters.spec import ParameterError
from collplan_ros.messages.qos import TRANSFORMS


def frame_broadcast(node: Node) -> Callable[[Odometry], None]:
    """Makes a function that publishes the pose of an odometry message as a transform on /tf.

    Raises:
        ParameterError: tf2_msgs is not installed.
    """
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        raise ParameterError("mocap.publish_tf: got True, expected False where tf2_msgs is not installed") from None
    publisher = node.create_publisher(TFMessage, "/tf", TRANSFORMS)

    def broadcast(odometry: Odometry) -> None:
        position = odometry.pose.pose.position
        message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
        message.transform.translation = Vector3(x=position.x, y=position.y, z=position.z)
        message.transform.rotation = odometry.pose.pose.orientation
        publisher.publish(TFMessage(transforms=[message]))

    return broadcast
