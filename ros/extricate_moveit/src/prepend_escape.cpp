// A planning response adapter of MoveIt 2 (Jazzy and newer): puts the path by which FixStartState moved the start
// before the trajectory, which then begins where the robot is. Goes after ValidateSolution, which would refuse the
// states in collision:
//
//     response_adapters: [..., default_planning_response_adapters/ValidateSolution, extricate_moveit/PrependEscape]
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <class_loader/class_loader.hpp>
#include <moveit/planning_interface/planning_response_adapter.hpp>
#include <moveit/robot_state/conversions.hpp>
#include <rclcpp/rclcpp.hpp>

#include "moved_start.hpp"

namespace extricate_moveit {

class PrependEscape : public planning_interface::PlanningResponseAdapter {
public:
    [[nodiscard]] std::string getDescription() const override { return "PrependEscape (extricate)"; }

    void adapt(const planning_scene::PlanningSceneConstPtr& planning_scene,
               const planning_interface::MotionPlanRequest& req,
               planning_interface::MotionPlanResponse& res) const override {
        const MovedStart moved = std::exchange(moved_start(), MovedStart());
        if (!moved.is_in(planning_scene) || !res.trajectory || res.trajectory->empty()) return;
        auto& trajectory = *res.trajectory;
        const auto& path = moved.fixed.path;
        const std::string problem = problem_of(trajectory.getFirstWayPoint(), moved.fixed);
        if (!problem.empty()) {
            RCLCPP_WARN(logger_, "The trajectory does not begin where the robot is: %s", problem.c_str());
            return;
        }
        // The acceleration at rest, with which time parameterizations begin, would bend the last edge of the path.
        if (trajectory.getFirstWayPoint().hasVelocities()) trajectory.getFirstWayPointPtr()->zeroAccelerations();
        for (std::size_t at = path.size() - 1; at > 0; --at) {
            trajectory.setWayPointDurationFromPrevious(0,
                                                       seconds(*planning_scene->getRobotModel(), moved.fixed, at, req));
            moveit::core::RobotState state = trajectory.getFirstWayPoint();
            for (std::size_t k = 0; k < moved.fixed.positions.size(); ++k)
                state.setVariablePosition(moved.fixed.positions[k].first, path[at - 1][k]);
            state.zeroVelocities();
            state.zeroAccelerations();
            trajectory.addPrefixWayPoint(state, 0.0);
        }
        // Continuous joints of the path are within a turn; those of the trajectory go on from there.
        trajectory.unwind();
        moveit::core::robotStateToRobotStateMsg(trajectory.getFirstWayPoint(), res.start_state);
    }

private:
    /// Says why the path cannot end where a trajectory begins; empty if it can.
    static std::string problem_of(const moveit::core::RobotState& first, const extricate::moveit::FixedStart& fixed) {
        constexpr double TURN = 6.283185307179586;
        for (const auto& [joint, position] : fixed.positions) {
            const double apart = std::remainder(first.getVariablePosition(joint) - position, TURN);
            if (std::abs(apart) > 1e-6)
                return "joint " + joint + " of the plan begins " + std::to_string(apart) +
                       " from where the path out of collision ends";
            if (first.hasVelocities() && std::abs(first.getVariableVelocity(joint)) > 1e-6)
                return "joint " + joint + " of the plan does not begin at rest";
        }
        return "";
    }

    /// Time for the edge that ends at a point of the path. Every joint begins and ends at rest there, so that all of
    /// them follow one profile s(t) from 0 to 1, whether a controller interpolates by cubic or quintic splines: the
    /// motion stays on the straight edge that was proved. The larger peaks of the two are 15/8 in velocity (quintic)
    /// and 6 in acceleration (cubic).
    static double seconds(const moveit::core::RobotModel& model, const extricate::moveit::FixedStart& fixed,
                          std::size_t at, const planning_interface::MotionPlanRequest& req) {
        constexpr double TURN = 6.283185307179586;
        const auto scaled = [](double limit, double factor) {
            return factor > 0 && factor <= 1 ? limit * factor : limit;
        };
        // The controllers want times that increase.
        double longest = 1e-3;
        for (std::size_t k = 0; k < fixed.positions.size(); ++k) {
            const auto& bounds = model.getVariableBounds(fixed.positions[k].first);
            double moved = std::abs(fixed.path[at][k] - fixed.path[at - 1][k]);
            if (!bounds.position_bounded_) moved = std::abs(std::remainder(moved, TURN));
            const double velocity =
                bounds.velocity_bounded_ ? std::min(bounds.max_velocity_, -bounds.min_velocity_) : 1.0;
            const double acceleration =
                bounds.acceleration_bounded_ ? std::min(bounds.max_acceleration_, -bounds.min_acceleration_) : 1.0;
            longest = std::max({longest, 15.0 / 8.0 * moved / scaled(velocity, req.max_velocity_scaling_factor),
                                std::sqrt(6.0 * moved / scaled(acceleration, req.max_acceleration_scaling_factor))});
        }
        return longest;
    }

    rclcpp::Logger logger_ = rclcpp::get_logger("extricate.prepend_escape");
};

}  // namespace extricate_moveit

CLASS_LOADER_REGISTER_CLASS(extricate_moveit::PrependEscape, planning_interface::PlanningResponseAdapter)
