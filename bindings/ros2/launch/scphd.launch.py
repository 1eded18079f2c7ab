"""Starts the node with a file of parameters: `ros2 launch scphd_node scphd.launch.py params:=FILE`."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    params = DeclareLaunchArgument("params", description="a file of parameters, as scphd-publish --params writes it")
    node = Node(
        package="scphd_node",
        executable="scphd-node",
        name="scphd",
        parameters=[LaunchConfiguration("params")],
        remappings=[],
    )
    return LaunchDescription([params, node])
