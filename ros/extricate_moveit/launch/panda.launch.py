"""move_group for the Panda of moveit_resources with simulated controllers and both adapters in its OMPL pipeline."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder


def with_adapters(pipeline):
    """Puts the adapters in their places among those that the pipeline has, and sets their parameters."""
    checks, judge = "CheckStartState", "ValidateSolution"
    requests, responses = list(pipeline["request_adapters"]), list(pipeline["response_adapters"])
    first_check = next((k for k, name in enumerate(requests) if checks in name), len(requests))
    requests.insert(first_check, "extricate_moveit/FixStartState")
    last_judge = next((k + 1 for k, name in enumerate(responses) if judge in name), len(responses))
    responses.insert(last_judge, "extricate_moveit/PrependEscape")
    return {
        **pipeline,
        "request_adapters": requests,
        "response_adapters": responses,
        "extricate": {"max_displacement": 0.1},
    }


def generate_launch_description():
    config = MoveItConfigsBuilder("moveit_resources_panda").planning_pipelines(pipelines=["ompl"]).to_moveit_configs()
    config.planning_pipelines["ompl"] = with_adapters(config.planning_pipelines["ompl"])
    controllers = Path(get_package_share_directory("moveit_resources_panda_moveit_config")) / "config" / "ros2_controllers.yaml"
    names = ["joint_state_broadcaster", "panda_arm_controller", "panda_hand_controller"]
    return LaunchDescription(
        [
            Node(
                package="tf2_ros",
                executable="static_transform_publisher",
                arguments=["--frame-id", "world", "--child-frame-id", "panda_link0"],
            ),
            Node(package="robot_state_publisher", executable="robot_state_publisher", parameters=[config.robot_description]),
            Node(
                package="controller_manager",
                executable="ros2_control_node",
                parameters=[str(controllers)],
                remappings=[("/controller_manager/robot_description", "/robot_description")],
            ),
            *[Node(package="controller_manager", executable="spawner", arguments=[name]) for name in names],
            Node(package="moveit_ros_move_group", executable="move_group", output="screen", parameters=[config.to_dict()]),
        ]
    )
