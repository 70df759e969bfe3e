// What generate_parameter_library (0.5) makes of extricate_moveit_parameters.yaml, written by hand: each parameter is
// declared with its type, unless it is there already, and read as that type. Validation is left out.
#pragma once
#include <rclcpp_stub.hpp>

namespace extricate_moveit_parameters {
struct Params {
    struct {
        double max_displacement = 0.05, max_seconds = 1.0, clearance = 0.001;
        std::string metric = "joint", model;
    } extricate;
};
class ParamListener {
public:
    ParamListener(const rclcpp::Node::SharedPtr& node, const std::string& prefix) {
        const auto declared = [&](const std::string& name, const auto& usual) {
            const std::string full = prefix + "." + name;
            if (!node->has_parameter(full)) node->declare_parameter(full, rclcpp::ParameterValue(usual));
            return node->get_parameter(full);
        };
        auto& own = params_.extricate;
        own.max_displacement = declared("extricate.max_displacement", own.max_displacement).as_double();
        own.max_seconds = declared("extricate.max_seconds", own.max_seconds).as_double();
        own.clearance = declared("extricate.clearance", own.clearance).as_double();
        own.metric = declared("extricate.metric", own.metric).as_string();
        own.model = declared("extricate.model", own.model).as_string();
    }
    Params get_params() const { return params_; }

private:
    Params params_;
};
}  // namespace extricate_moveit_parameters
