// A planning request adapter of MoveIt 2 (Jazzy and newer): a start in collision, or beyond its limits, becomes the
// free one to which a proved path leads. Goes before the checks of the start:
//
//     request_adapters: [..., extricate_moveit/FixStartState,
//     default_planning_request_adapters/CheckStartStateCollision]
//
// If anything keeps it from its work, it says so in the log and leaves the request as it is.
// What is converted, and how, is in extricate_moveit.hpp, which knows no ROS and is tested without.
#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>

#include <class_loader/class_loader.hpp>
#include <moveit/planning_interface/planning_request_adapter.hpp>
#include <moveit/rdf_loader/synchronized_string_parameter.hpp>
#include <moveit/robot_state/conversions.hpp>
#include <moveit_msgs/msg/planning_scene.hpp>
#include <rclcpp/rclcpp.hpp>

#include <extricate_moveit.hpp>
#include <extricate_moveit/extricate_moveit_parameters.hpp>

#include "moved_start.hpp"

namespace extricate_moveit {

using extricate::moveit::Description;
using extricate::moveit::FixedStart;
using extricate::moveit::FixLimits;
using extricate::moveit::Positions;
using extricate::moveit::StartFixer;

/// YAML reads `1` as an integer, which a node refuses for a double: makes it one before the parameter is read.
inline void accept_integer(rclcpp::Node& node, const std::string& name) {
    if (node.has_parameter(name)) {
        const rclcpp::Parameter parameter = node.get_parameter(name);
        if (parameter.get_type() == rclcpp::ParameterType::PARAMETER_INTEGER)
            node.set_parameter(rclcpp::Parameter(name, static_cast<double>(parameter.as_int())));
        return;
    }
    const auto& overrides = node.get_node_parameters_interface()->get_parameter_overrides();
    const auto found = overrides.find(name);
    if (found == overrides.end() || found->second.get_type() != rclcpp::ParameterType::PARAMETER_INTEGER) return;
    const auto value = static_cast<double>(found->second.get<std::int64_t>());
    node.declare_parameter(name, rclcpp::ParameterValue(value), rcl_interfaces::msg::ParameterDescriptor(), true);
}

class FixStartState : public planning_interface::PlanningRequestAdapter {
public:
    void initialize(const rclcpp::Node::SharedPtr& node, const std::string& parameter_namespace) override {
        for (const char* name : {"max_displacement", "max_seconds", "clearance"})
            accept_integer(*node, parameter_namespace + ".extricate." + name);
        parameters_ = extricate_moveit_parameters::ParamListener(node, parameter_namespace).get_params().extricate;
        Description description;
        // The parameter of the node, or else what is latched on the topic, as for MoveIt itself.
        rdf_loader::SynchronizedStringParameter urdf, srdf;
        description.urdf = urdf.loadInitialValue(node, "robot_description");
        description.srdf = srdf.loadInitialValue(node, "robot_description_semantic");
        description.metric = parameters_.metric;
        fixer_ = std::async(std::launch::async, read_robot, description, parameters_.model).share();
        // Meshes take part of a second to prepare: that begins when the scene changes, not when a plan is asked for.
        // A message may still be handled when the adapter is gone, so its handler has its own share of the fixer.
        scenes_ = node->create_subscription<moveit_msgs::msg::PlanningScene>(
            "monitored_planning_scene", rclcpp::QoS(10),
            [fixer = fixer_, logger = logger_](const std::shared_ptr<const moveit_msgs::msg::PlanningScene> scene) {
                prepare(fixer, logger, *scene);
            });
    }

    [[nodiscard]] std::string getDescription() const override { return "FixStartState (extricate)"; }

    [[nodiscard]] moveit::core::MoveItErrorCode adapt(const planning_scene::PlanningSceneConstPtr& planning_scene,
                                                      planning_interface::MotionPlanRequest& req) const override {
        moved_start() = MovedStart();
        moveit::core::MoveItErrorCode status;
        status.source = getDescription();
        status.val = moveit_msgs::msg::MoveItErrorCodes::SUCCESS;
        try {
            move_start(planning_scene, req);
        } catch (const std::exception& error) {
            RCLCPP_WARN(logger_, "The start stays as it is: %s", error.what());
        }
        return status;
    }

private:
    using Parameters = decltype(extricate_moveit_parameters::Params::extricate);
    using Fixer = std::shared_ptr<StartFixer>;

    static Fixer read_robot(const Description& description, const std::string& model) {
        if (model.empty() && description.urdf.empty())
            throw std::runtime_error(
                "robot_description: got nothing, expected a parameter of the node or a message on the topic");
        Fixer fixer = model.empty() ? std::make_shared<StartFixer>(description)
                                    : std::make_shared<StartFixer>(extricate::Scene(model), description);
        fixer->robot().prepare();
        return fixer;
    }

    static void prepare(const std::shared_future<Fixer>& fixer, const rclcpp::Logger& logger,
                        const moveit_msgs::msg::PlanningScene& scene) {
        try {
            if (fixer.wait_for(std::chrono::seconds(0)) == std::future_status::ready) fixer.get()->prepare(scene);
        } catch (const std::exception& error) {
            RCLCPP_DEBUG(logger, "The scene is not prepared: %s", error.what());
        }
    }

    void move_start(const planning_scene::PlanningSceneConstPtr& planning_scene,
                    planning_interface::MotionPlanRequest& req) const {
        moveit::core::RobotState start = planning_scene->getCurrentState();
        moveit::core::robotStateMsgToRobotState(planning_scene->getTransforms(), req.start_state, start);
        if (fixer_.wait_for(std::chrono::duration<double>(parameters_.max_seconds)) != std::future_status::ready)
            throw std::runtime_error("the robot is still being read");

        moveit_msgs::msg::PlanningScene message;
        planning_scene->getPlanningSceneMsg(message);
        // What the start holds counts, not what the current state does.
        moveit::core::robotStateToRobotStateMsg(start, message.robot_state);
        Positions positions;
        for (const std::string& name : start.getVariableNames())
            positions.emplace_back(name, start.getVariablePosition(name));
        FixLimits limits;
        limits.max_displacement = parameters_.max_displacement;
        limits.max_seconds = parameters_.max_seconds;
        limits.clearance = parameters_.clearance;
        const auto* group = planning_scene->getRobotModel()->getJointModelGroup(req.group_name);
        if (group) limits.joints = group->getActiveJointModelNames();
        if (!req.goal_constraints.empty())
            for (const auto& goal : req.goal_constraints.front().joint_constraints)
                limits.toward.emplace_back(goal.joint_name, goal.position);

        FixedStart fixed = fixer_.get()->fix(message, positions, limits);
        for (const std::string& note : fixed.notes)
            RCLCPP_DEBUG(logger_, "%s", note.c_str());
        if (fixed.was_free) return;
        if (!fixed.fixed) throw std::runtime_error(fixed.summary);
        for (const auto& [joint, position] : fixed.positions)
            start.setVariablePosition(joint, position);
        start.update();
        // Limits of joint_limits.yaml may be narrower than those of the URDF.
        if (group && !start.satisfiesBounds(group))
            throw std::runtime_error(fixed.summary + ", but is beyond MoveIt's own limits");
        moveit::core::robotStateToRobotStateMsg(start, req.start_state);
        RCLCPP_WARN(logger_, "%s", fixed.summary.c_str());
        moved_start() = MovedStart{planning_scene, std::move(fixed)};
    }

    rclcpp::Logger logger_ = rclcpp::get_logger("extricate.fix_start_state");
    Parameters parameters_;
    std::shared_future<Fixer> fixer_;
    rclcpp::Subscription<moveit_msgs::msg::PlanningScene>::SharedPtr scenes_;
};

}  // namespace extricate_moveit

CLASS_LOADER_REGISTER_CLASS(extricate_moveit::FixStartState, planning_interface::PlanningRequestAdapter)
