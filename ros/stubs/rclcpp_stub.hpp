// What the adapters use of ROS 2 (rclcpp 28, Jazzy), with just enough behind it to run them. A parameter has a static
// type, which no value of another type may take, unless it was declared from the launch file alone.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <messages.hpp>

namespace rcl_interfaces::msg {
struct ParameterDescriptor {};
}  // namespace rcl_interfaces::msg

namespace rclcpp {
struct Logger {};
inline Logger get_logger(const std::string&) { return {}; }

enum ParameterType { PARAMETER_NOT_SET, PARAMETER_INTEGER, PARAMETER_DOUBLE, PARAMETER_STRING };

namespace exceptions {
struct InvalidParameterTypeException : std::runtime_error {
    explicit InvalidParameterTypeException(const std::string& name)
        : std::runtime_error("parameter '" + name + "' has invalid type") {}
};
}  // namespace exceptions

class ParameterValue {
public:
    ParameterValue() = default;
    explicit ParameterValue(std::int64_t value) : value_(value) {}
    explicit ParameterValue(double value) : value_(value) {}
    explicit ParameterValue(const std::string& value) : value_(value) {}
    ParameterType get_type() const { return static_cast<ParameterType>(value_.index()); }
    template <class T>
    const T& get() const {
        if (!std::holds_alternative<T>(value_)) throw exceptions::InvalidParameterTypeException("?");
        return std::get<T>(value_);
    }

private:
    std::variant<std::monostate, std::int64_t, double, std::string> value_;
};

class Parameter {
public:
    Parameter(std::string name, ParameterValue value) : name_(std::move(name)), value_(std::move(value)) {}
    Parameter(std::string name, double value) : Parameter(std::move(name), ParameterValue(value)) {}
    const std::string& get_name() const { return name_; }
    ParameterType get_type() const { return value_.get_type(); }
    std::int64_t as_int() const { return value_.get<std::int64_t>(); }
    double as_double() const { return value_.get<double>(); }
    const std::string& as_string() const { return value_.get<std::string>(); }
    const ParameterValue& get_parameter_value() const { return value_; }

private:
    std::string name_;
    ParameterValue value_;
};

namespace node_interfaces {
class NodeParametersInterface {
public:
    /// Of launch files and the command line.
    const std::map<std::string, ParameterValue>& get_parameter_overrides() const { return overrides; }
    std::map<std::string, ParameterValue> overrides;
};
}  // namespace node_interfaces

struct QoS {
    explicit QoS(std::size_t) {}
};
template <class Message>
struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
    std::function<void(std::shared_ptr<const Message>)> callback;
};

class Node {
public:
    using SharedPtr = std::shared_ptr<Node>;
    /// With `declares_overrides`, all overrides are parameters from the beginning, as in move_group.
    explicit Node(std::map<std::string, ParameterValue> overrides = {}, bool declares_overrides = false) {
        interface_->overrides = std::move(overrides);
        if (declares_overrides) parameters_ = interface_->overrides;
    }
    /// Texts that publishers left behind on topics, by their names.
    std::map<std::string, std::string> latched;

    bool has_parameter(const std::string& name) const { return parameters_.count(name) > 0; }
    const ParameterValue& declare_parameter(const std::string& name, const ParameterValue& usual,
                                            const rcl_interfaces::msg::ParameterDescriptor& = {},
                                            bool ignores_override = false) {
        const auto found = interface_->overrides.find(name);
        const bool is_overridden = found != interface_->overrides.end() && !ignores_override;
        if (is_overridden && found->second.get_type() != usual.get_type())
            throw exceptions::InvalidParameterTypeException(name);
        return parameters_[name] = is_overridden ? found->second : usual;
    }
    Parameter get_parameter(const std::string& name) const { return Parameter(name, parameters_.at(name)); }
    void set_parameter(const Parameter& parameter) {
        parameters_[parameter.get_name()] = parameter.get_parameter_value();
    }
    template <class Message, class Callback>
    typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic, const QoS&,
                                                                  Callback callback) {
        auto made = std::make_shared<Subscription<Message>>(Subscription<Message>{callback});
        subscriptions[topic] = [made](const void* message) {
            made->callback(std::make_shared<const Message>(*static_cast<const Message*>(message)));
        };
        return made;
    }
    /// Calls subscribers of a topic, by its name, with a message of their type.
    std::map<std::string, std::function<void(const void*)>> subscriptions;
    std::shared_ptr<node_interfaces::NodeParametersInterface> get_node_parameters_interface() { return interface_; }

private:
    std::shared_ptr<node_interfaces::NodeParametersInterface> interface_ =
        std::make_shared<node_interfaces::NodeParametersInterface>();
    std::map<std::string, ParameterValue> parameters_;
};
}  // namespace rclcpp

#define RCLCPP_DEBUG(logger, ...) (void)(logger), (void)std::snprintf(nullptr, 0, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) (void)(logger), warned(__VA_ARGS__)

/// Keeps the last warning for tests.
inline std::string& last_warning() {
    static thread_local std::string text;
    return text;
}
template <class... Values>
void warned(const char* format, Values... values) {
    std::vector<char> text(4096);
    std::snprintf(text.data(), text.size(), format, values...);
    last_warning() = text.data();
}
