// What the adapters use of MoveIt 2 (2.12, Jazzy), with just enough behind it to run them. Names and signatures are
// those of its headers: planning_request_adapter.hpp, planning_response_adapter.hpp, planning_response.hpp,
// planning_scene.hpp, robot_state.hpp, robot_model.hpp, robot_trajectory.hpp, moveit_error_code.hpp and
// synchronized_string_parameter.hpp.
#pragma once

#include <cmath>
#include <deque>
#include <functional>

#include <messages.hpp>
#include <rclcpp_stub.hpp>

namespace moveit::core {
/// In MoveIt a class derived of the message, which converts to and from it.
using MoveItErrorCode = moveit_msgs::msg::MoveItErrorCodes;
struct VariableBounds {
    double min_position_ = 0, max_position_ = 0, min_velocity_ = 0, max_velocity_ = 0, min_acceleration_ = 0,
           max_acceleration_ = 0;
    bool position_bounded_ = false, velocity_bounded_ = false, acceleration_bounded_ = false;
};
class JointModelGroup {
public:
    std::vector<std::string> names;
    const std::vector<std::string>& getActiveJointModelNames() const { return names; }
};
class RobotModel {
public:
    std::map<std::string, JointModelGroup> groups;
    std::map<std::string, VariableBounds> bounds;
    const JointModelGroup* getJointModelGroup(const std::string& name) const {
        const auto found = groups.find(name);
        return found == groups.end() ? nullptr : &found->second;
    }
    const VariableBounds& getVariableBounds(const std::string& name) const { return bounds.at(name); }
};
using RobotModelConstPtr = std::shared_ptr<const RobotModel>;
class RobotState {
public:
    RobotModelConstPtr model;
    std::vector<std::string> names;
    std::map<std::string, double> positions, velocities, accelerations;
    std::vector<moveit_msgs::msg::AttachedCollisionObject> attached;
    const RobotModelConstPtr& getRobotModel() const { return model; }
    const std::vector<std::string>& getVariableNames() const { return names; }
    double getVariablePosition(const std::string& name) const { return positions.at(name); }
    void setVariablePosition(const std::string& name, double value) { positions.at(name) = value; }
    bool hasVelocities() const { return !velocities.empty(); }
    double getVariableVelocity(const std::string& name) const { return velocities.at(name); }
    void zeroVelocities() {
        for (const std::string& name : names)
            velocities[name] = 0;
    }
    void zeroAccelerations() {
        for (const std::string& name : names)
            accelerations[name] = 0;
    }
    bool satisfiesBounds(const JointModelGroup* group, double margin = 0) const {
        for (const std::string& name : group->names) {
            const VariableBounds& bounds = model->bounds.at(name);
            if (!bounds.position_bounded_) continue;
            if (positions.at(name) < bounds.min_position_ - margin ||
                positions.at(name) > bounds.max_position_ + margin)
                return false;
        }
        return true;
    }
    void update(bool = false) {}
};
using RobotStatePtr = std::shared_ptr<RobotState>;
class Transforms {};
inline bool robotStateMsgToRobotState(const Transforms&, const moveit_msgs::msg::RobotState& message, RobotState& state,
                                      bool = true) {
    for (std::size_t k = 0; k < message.joint_state.name.size(); ++k)
        state.positions.at(message.joint_state.name[k]) = message.joint_state.position[k];
    // A message that is no difference says all that is attached.
    if (!message.is_diff) state.attached.clear();
    state.attached.insert(state.attached.end(), message.attached_collision_objects.begin(),
                          message.attached_collision_objects.end());
    return true;
}
inline void robotStateToRobotStateMsg(const RobotState& state, moveit_msgs::msg::RobotState& message, bool = true) {
    message = moveit_msgs::msg::RobotState();
    message.joint_state.name = state.names;
    for (const std::string& name : state.names)
        message.joint_state.position.push_back(state.positions.at(name));
    message.attached_collision_objects = state.attached;
}
}  // namespace moveit::core

namespace robot_trajectory {
class RobotTrajectory {
public:
    bool empty() const { return waypoints_.empty(); }
    std::size_t getWayPointCount() const { return waypoints_.size(); }
    const moveit::core::RobotState& getWayPoint(std::size_t at) const { return *waypoints_[at]; }
    const moveit::core::RobotState& getFirstWayPoint() const { return *waypoints_.front(); }
    moveit::core::RobotStatePtr& getFirstWayPointPtr() { return waypoints_.front(); }
    double getWayPointDurationFromPrevious(std::size_t at) const {
        return at < durations_.size() ? durations_[at] : 0.0;
    }
    RobotTrajectory& setWayPointDurationFromPrevious(std::size_t at, double value) {
        if (durations_.size() <= at) durations_.resize(at + 1, 0.0);
        durations_[at] = value;
        return *this;
    }
    RobotTrajectory& addSuffixWayPoint(const moveit::core::RobotState& state, double dt) {
        waypoints_.push_back(std::make_shared<moveit::core::RobotState>(state));
        durations_.push_back(dt);
        return *this;
    }
    RobotTrajectory& addPrefixWayPoint(const moveit::core::RobotState& state, double dt) {
        waypoints_.push_front(std::make_shared<moveit::core::RobotState>(state));
        durations_.push_front(dt);
        return *this;
    }
    /// Turns continuous joints on, where they would jump by a whole turn.
    RobotTrajectory& unwind() {
        for (const auto& [name, bounds] : getFirstWayPoint().getRobotModel()->bounds) {
            if (bounds.position_bounded_) continue;
            double offset = 0, last = getFirstWayPoint().getVariablePosition(name);
            for (const moveit::core::RobotStatePtr& state : waypoints_) {
                const double here = state->getVariablePosition(name), half_turn = std::acos(-1.0);
                if (last > here + half_turn) offset += 2 * half_turn;
                if (here > last + half_turn) offset -= 2 * half_turn;
                last = here;
                state->setVariablePosition(name, here + offset);
            }
        }
        return *this;
    }

private:
    std::deque<moveit::core::RobotStatePtr> waypoints_;
    std::deque<double> durations_;
};
using RobotTrajectoryPtr = std::shared_ptr<RobotTrajectory>;
}  // namespace robot_trajectory

namespace planning_scene {
class PlanningScene {
public:
    moveit::core::RobotState current;
    /// Its world, allowed collisions and padding.
    moveit_msgs::msg::PlanningScene message;
    const moveit::core::RobotState& getCurrentState() const { return current; }
    const moveit::core::Transforms& getTransforms() const { return transforms_; }
    const moveit::core::RobotModelConstPtr& getRobotModel() const { return current.model; }
    void getPlanningSceneMsg(moveit_msgs::msg::PlanningScene& out) const {
        out = message;
        moveit::core::robotStateToRobotStateMsg(current, out.robot_state);
    }

private:
    moveit::core::Transforms transforms_;
};
using PlanningSceneConstPtr = std::shared_ptr<const PlanningScene>;
}  // namespace planning_scene

namespace rdf_loader {
using StringCallback = std::function<void(const std::string&)>;
/// In MoveIt it waits for the topic, and may follow it.
class SynchronizedStringParameter {
public:
    std::string loadInitialValue(const std::shared_ptr<rclcpp::Node>& node, const std::string& name,
                                 const StringCallback& = {}, bool = false, double = 10.0) {
        const std::string empty;
        const auto& overrides = node->get_node_parameters_interface()->get_parameter_overrides();
        const std::string own = overrides.count(name) ? overrides.at(name).get<std::string>() : empty;
        return own.empty() && node->latched.count(name) ? node->latched.at(name) : own;
    }
};
}  // namespace rdf_loader

namespace planning_interface {
/// In MoveIt the message of this name.
struct MotionPlanRequest {
    moveit_msgs::msg::RobotState start_state;
    std::vector<moveit_msgs::msg::Constraints> goal_constraints;
    std::string group_name;
    double max_velocity_scaling_factor = 0, max_acceleration_scaling_factor = 0;
};
struct MotionPlanResponse {
    robot_trajectory::RobotTrajectoryPtr trajectory;
    moveit_msgs::msg::RobotState start_state;
};
class PlanningRequestAdapter {
public:
    virtual ~PlanningRequestAdapter() = default;
    virtual void initialize(const rclcpp::Node::SharedPtr&, const std::string&) {}
    [[nodiscard]] virtual std::string getDescription() const = 0;
    [[nodiscard]] virtual moveit::core::MoveItErrorCode adapt(
        const planning_scene::PlanningSceneConstPtr& planning_scene,
        planning_interface::MotionPlanRequest& req) const = 0;
};
class PlanningResponseAdapter {
public:
    virtual ~PlanningResponseAdapter() = default;
    virtual void initialize(const rclcpp::Node::SharedPtr&, const std::string&) {}
    [[nodiscard]] virtual std::string getDescription() const = 0;
    virtual void adapt(const planning_scene::PlanningSceneConstPtr& planning_scene,
                       const planning_interface::MotionPlanRequest& req,
                       planning_interface::MotionPlanResponse& res) const = 0;
};
}  // namespace planning_interface

/// In place of a plugin loader: makes adapters by the names of their base classes.
template <class Base>
std::unique_ptr<Base> make_adapter();
#define CLASS_LOADER_REGISTER_CLASS(Derived, Base) \
    template <>                                    \
    std::unique_ptr<Base> make_adapter<Base>() {   \
        return std::make_unique<Derived>();        \
    }
