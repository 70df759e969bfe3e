// What the adapter uses of MoveIt and ROS 2, with just enough behind it to run the adapter. Names and signatures are those
// of MoveIt 2 (Jazzy); nothing else is.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <variant>
#include <vector>

namespace moveit_msgs::msg {
struct JointState {
    std::vector<std::string> name;
    std::vector<double> position, velocity, effort;
};
struct RobotState {
    JointState joint_state;
};
struct Octomap {
    std::vector<signed char> data;
};
struct OctomapWithPose {
    Octomap octomap;
};
struct PlanningSceneWorld {
    OctomapWithPose octomap;
};
struct PlanningScene {
    RobotState robot_state;
    PlanningSceneWorld world;
    /// What a recorded message says.
    std::string text;
};
struct MoveItErrorCodes {
    static constexpr int SUCCESS = 1, FAILURE = 99999, START_STATE_IN_COLLISION = -10;
    int val = 0;
    std::string message, source;
};
inline void to_block_style_yaml(const PlanningScene& message, std::ostream& out, std::size_t = 0) { out << message.text; }
}  // namespace moveit_msgs::msg

namespace moveit::core {
using MoveItErrorCode = moveit_msgs::msg::MoveItErrorCodes;
class JointModelGroup {
public:
    std::vector<std::string> names;
    const std::vector<std::string>& getActiveJointModelNames() const { return names; }
};
class RobotModel {
public:
    std::map<std::string, JointModelGroup> groups;
    const JointModelGroup* getJointModelGroup(const std::string& name) const {
        const auto found = groups.find(name);
        return found == groups.end() ? nullptr : &found->second;
    }
};
using RobotModelConstPtr = std::shared_ptr<const RobotModel>;
class RobotState {
public:
    std::vector<std::string> names;
    std::map<std::string, double> positions;
    const std::vector<std::string>& getVariableNames() const { return names; }
    double getVariablePosition(const std::string& name) const { return positions.at(name); }
    void setVariablePosition(const std::string& name, double value) { positions.at(name) = value; }
    void update(bool = false) {}
};
class Transforms {};
inline bool robotStateMsgToRobotState(const Transforms&, const moveit_msgs::msg::RobotState& message, RobotState& state, bool = true) {
    for (std::size_t k = 0; k < message.joint_state.name.size(); ++k)
        state.positions.at(message.joint_state.name[k]) = message.joint_state.position[k];
    return true;
}
inline void robotStateToRobotStateMsg(const RobotState& state, moveit_msgs::msg::RobotState& message, bool = true) {
    message.joint_state.name = state.names;
    message.joint_state.position.clear();
    for (const std::string& name : state.names) message.joint_state.position.push_back(state.positions.at(name));
}
}  // namespace moveit::core

namespace planning_scene {
class PlanningScene {
public:
    moveit::core::RobotState current;
    std::shared_ptr<moveit::core::RobotModel> model = std::make_shared<moveit::core::RobotModel>();
    std::string text;
    const moveit::core::RobotState& getCurrentState() const { return current; }
    const moveit::core::Transforms& getTransforms() const { return transforms_; }
    moveit::core::RobotModelConstPtr getRobotModel() const { return model; }
    void getPlanningSceneMsg(moveit_msgs::msg::PlanningScene& message) const { message.text = text; }

private:
    moveit::core::Transforms transforms_;
};
using PlanningSceneConstPtr = std::shared_ptr<const PlanningScene>;
}  // namespace planning_scene

namespace rclcpp {
struct Logger {};
inline Logger get_logger(const std::string&) { return {}; }
struct Parameter {
    std::variant<double, std::string> value;
    template <class T>
    T get_value() const {
        return std::get<T>(value);
    }
};
class Node {
public:
    using SharedPtr = std::shared_ptr<Node>;
    std::map<std::string, Parameter> parameters;
    bool has_parameter(const std::string& name) const { return parameters.count(name) > 0; }
    template <class T>
    T declare_parameter(const std::string& name, const T& usual) {
        parameters[name] = Parameter{usual};
        return usual;
    }
    Parameter get_parameter(const std::string& name) const { return parameters.at(name); }
};
}  // namespace rclcpp

namespace planning_interface {
struct MotionPlanRequest {
    moveit_msgs::msg::RobotState start_state;
    std::string group_name;
};
class PlanningRequestAdapter {
public:
    virtual ~PlanningRequestAdapter() = default;
    virtual void initialize(const rclcpp::Node::SharedPtr& node, const std::string& parameter_namespace) = 0;
    [[nodiscard]] virtual std::string getDescription() const = 0;
    [[nodiscard]] virtual moveit::core::MoveItErrorCode adapt(const planning_scene::PlanningSceneConstPtr& planning_scene,
                                                              planning_interface::MotionPlanRequest& req) const = 0;
};
}  // namespace planning_interface

#define RCLCPP_DEBUG(logger, ...) (void)(logger), (void)std::snprintf(nullptr, 0, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) (void)(logger), std::printf(__VA_ARGS__), std::printf("\n")

/// In place of a plugin loader: makes the adapter.
std::unique_ptr<planning_interface::PlanningRequestAdapter> make_adapter();
#define CLASS_LOADER_REGISTER_CLASS(Derived, Base) \
    std::unique_ptr<Base> make_adapter() { return std::make_unique<Derived>(); }
