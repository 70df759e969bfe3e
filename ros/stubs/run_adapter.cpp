// Runs the adapter against the stubs: a start in collision becomes free, and one that would have to jump is refused.
//
//     run_adapter FOLDER MESSAGE        of the built-in arm as files, with install/share linked to itself; a recorded PlanningScene
#include <moveit/stub.hpp>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include <extricate.hpp>

static std::string read(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    const std::string folder = argv[1];
    auto node = std::make_shared<rclcpp::Node>();
    node->declare_parameter<std::string>("robot_description", read(folder + "/robot/arm.urdf"));
    node->declare_parameter<double>("pipeline.extricate.max_displacement", 2.0);
    setenv("AMENT_PREFIX_PATH", (folder + "/install").c_str(), 1);
    auto adapter = make_adapter();
    adapter->initialize(node, "pipeline");

    auto scene = std::make_shared<planning_scene::PlanningScene>();
    scene->text = read(argv[2]);
    const double positions[7] = {2.3, -1.7, 0, 0.7, 0, 2.0, 0};
    for (int k = 0; k < 7; ++k) {
        const std::string name = "joint_" + std::to_string(k + 1);
        scene->current.names.push_back(name);
        scene->current.positions[name] = positions[k];
        scene->model->groups["arm"].names.push_back(name);
    }
    planning_interface::MotionPlanRequest request;
    request.group_name = "arm";
    const auto fixed = adapter->adapt(scene, request);
    if (fixed.val != moveit_msgs::msg::MoveItErrorCodes::SUCCESS || request.start_state.joint_state.name.size() != 7)
        return std::fprintf(stderr, "not fixed: %s\n", fixed.message.c_str()), 1;
    planning_interface::MotionPlanRequest again = request;
    if (adapter->adapt(scene, again).val != 1 || again.start_state.joint_state.position != request.start_state.joint_state.position)
        return std::fprintf(stderr, "a free start was changed\n"), 1;

    auto careful = make_adapter();
    node->parameters["careful.extricate.max_displacement"] = rclcpp::Parameter{1e-6};
    careful->initialize(node, "careful");
    planning_interface::MotionPlanRequest refused;
    const auto status = careful->adapt(scene, refused);
    if (status.val != moveit_msgs::msg::MoveItErrorCodes::START_STATE_IN_COLLISION || !refused.start_state.joint_state.name.empty())
        return std::fprintf(stderr, "a jump was allowed\n"), 1;

    auto broken = make_adapter();
    node->parameters["robot_description"] = rclcpp::Parameter{std::string("<robot")};
    broken->initialize(node, "broken");
    const auto failure = broken->adapt(scene, refused);
    if (failure.val != moveit_msgs::msg::MoveItErrorCodes::FAILURE || failure.message.empty()) return 1;
    std::puts("the adapter: passed");
}
