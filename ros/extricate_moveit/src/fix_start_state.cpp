// A planning request adapter of MoveIt 2 (Jazzy and newer): a start in collision, or beyond its limits, becomes the nearest
// free one. Goes before the planner, in the place of FixStartStateCollision of older versions:
//
//     request_adapters: [..., extricate_moveit/FixStartState, default_planning_request_adapters/CheckStartStateCollision]
//
// What is converted, and how, is in extricate_moveit.hpp, which knows no ROS and is tested without.
#include <iomanip>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include <class_loader/class_loader.hpp>
#include <moveit/robot_state/conversions.hpp>
#include <moveit/planning_interface/planning_request_adapter.hpp>
#include <rclcpp/logging.hpp>
#include <rclcpp/node.hpp>

#include <extricate_moveit.hpp>

namespace extricate_moveit {

using extricate::moveit::FixedStart;
using extricate::moveit::FixLimits;
using extricate::moveit::Positions;
using extricate::moveit::StartFixer;
using moveit_msgs::msg::MoveItErrorCodes;

class FixStartState : public planning_interface::PlanningRequestAdapter {
public:
    void initialize(const rclcpp::Node::SharedPtr& node, const std::string& parameter_namespace) override {
        node_ = node;
        const std::string own = parameter_namespace + ".extricate.";
        // Beyond this the robot would jump: the request fails, and says how far the nearest free state is.
        max_displacement_ = parameter(own + "max_displacement", 0.05);
        max_seconds_ = parameter(own + "max_seconds", 1.0);
        // Of the collision checker of MoveIt, which judges the start next, meshes and rounding may differ.
        clearance_ = parameter(own + "clearance", 1e-3);
        // "joint", or "max-displacement": the state that moves no point more than it must.
        metric_ = parameter(own + "metric", std::string("joint"));
        // A learned model of the robot; empty for none.
        model_ = parameter(own + "model", std::string());
    }

    [[nodiscard]] std::string getDescription() const override { return "FixStartState (extricate)"; }

    [[nodiscard]] moveit::core::MoveItErrorCode adapt(const planning_scene::PlanningSceneConstPtr& planning_scene,
                                                      planning_interface::MotionPlanRequest& req) const override {
        moveit::core::MoveItErrorCode status;
        status.source = getDescription();
        status.val = MoveItErrorCodes::SUCCESS;
        try {
            moveit::core::RobotState start = planning_scene->getCurrentState();
            moveit::core::robotStateMsgToRobotState(planning_scene->getTransforms(), req.start_state, start);
            const FixedStart fixed = fix(*planning_scene, start, req.group_name);
            for (const std::string& note : fixed.notes) RCLCPP_DEBUG(logger_, "%s", note.c_str());
            if (fixed.was_free) return status;
            if (!fixed.fixed) {
                status.val = MoveItErrorCodes::START_STATE_IN_COLLISION;
                status.message = fixed.summary;
                return status;
            }
            for (const auto& [joint, position] : fixed.positions) start.setVariablePosition(joint, position);
            start.update();
            moveit::core::robotStateToRobotStateMsg(start, req.start_state);
            RCLCPP_WARN(logger_, "%s", fixed.summary.c_str());
        } catch (const std::exception& error) {
            status.val = MoveItErrorCodes::FAILURE;
            status.message = error.what();
        }
        return status;
    }

private:
    FixedStart fix(const planning_scene::PlanningScene& scene, const moveit::core::RobotState& start,
                   const std::string& group) const {
        moveit_msgs::msg::PlanningScene message;
        scene.getPlanningSceneMsg(message);
        // What the start holds counts, not what the current state does.
        moveit::core::robotStateToRobotStateMsg(start, message.robot_state);
        // Not taken, and megabytes as text.
        message.world.octomap.octomap.data.clear();
        // The state changes with every request, the world seldom: without it the text tells whether it did.
        Positions positions;
        for (const std::string& name : start.getVariableNames()) positions.emplace_back(name, start.getVariablePosition(name));
        message.robot_state.joint_state.name.clear();
        message.robot_state.joint_state.position.clear();
        message.robot_state.joint_state.velocity.clear();
        message.robot_state.joint_state.effort.clear();
        std::ostringstream text;
        // Messages print six digits unless told otherwise.
        text << std::setprecision(17);
        moveit_msgs::msg::to_block_style_yaml(message, text);

        FixLimits limits;
        limits.max_displacement = max_displacement_;
        limits.max_seconds = max_seconds_;
        limits.clearance = clearance_;
        if (const auto* joints = scene.getRobotModel()->getJointModelGroup(group)) limits.joints = joints->getActiveJointModelNames();
        return fixer().fix(text.str(), "planning_scene.yaml", positions, limits);
    }

    /// Made once, when the robot's description is there.
    StartFixer& fixer() const {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!fixer_) {
            const std::string urdf = parameter("robot_description", std::string());
            const std::string srdf = parameter("robot_description_semantic", std::string());
            const extricate::Scene robot = model_.empty()
                                               ? extricate::moveit::robot(urdf, srdf, extricate::moveit::sourced_packages(), metric_)
                                               : extricate::Scene(model_);
            fixer_ = std::make_unique<StartFixer>(robot);
        }
        return *fixer_;
    }

    template <class T>
    T parameter(const std::string& name, const T& usual) const {
        if (!node_->has_parameter(name)) node_->declare_parameter<T>(name, usual);
        return node_->get_parameter(name).get_value<T>();
    }

    rclcpp::Node::SharedPtr node_;
    rclcpp::Logger logger_ = rclcpp::get_logger("extricate.fix_start_state");
    double max_displacement_ = 0.05, max_seconds_ = 1.0, clearance_ = 1e-3;
    std::string metric_, model_;
    mutable std::mutex mutex_;
    mutable std::unique_ptr<StartFixer> fixer_;
};

}  // namespace extricate_moveit

CLASS_LOADER_REGISTER_CLASS(extricate_moveit::FixStartState, planning_interface::PlanningRequestAdapter)
