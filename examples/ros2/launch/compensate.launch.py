"""ros2 launch imulab_ros compensate.launch.py calibration:=/path/to/calibration.json"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    names = {"raw": "imu/data_raw", "calibrated": "imu/data"}
    return LaunchDescription(
        [DeclareLaunchArgument("calibration")]
        + [DeclareLaunchArgument(name, default_value=topic) for name, topic in names.items()]
        + [
            Node(
                package="imulab_ros",
                executable="compensate_node",
                parameters=[{"calibration": LaunchConfiguration("calibration")}],
                remappings=[(topic, LaunchConfiguration(name)) for name, topic in names.items()],
            )
        ]
    )
