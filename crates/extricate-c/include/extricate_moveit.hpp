/* Reads MoveIt's messages as text and repairs a start in collision. Building and testing need no ROS.
 *
 *     extricate::moveit::StartFixer fixer(extricate::moveit::robot(urdf, srdf, packages));
 *     auto start = fixer.fix(planning_scene_yaml, "scene.yaml", {{"joint1", 0.3}, ...}, limits);
 *     if (start.fixed) use(start.positions);
 *
 * A PlanningScene is YAML or JSON, as `ros2 topic echo`, rosbridge and the to_block_style_yaml() of every message
 * write it. Its world, attached objects, allowed collisions and padding are used; `notes` lists ignored content.
 *
 * Without exceptions, a repair that fails returns a start that is empty and not fixed.
 * extricate::last_status() and last_error() then report the reason. */
#ifndef EXTRICATE_MOVEIT_HPP
#define EXTRICATE_MOVEIT_HPP

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <sstream>

#include "extricate.hpp"

namespace extricate {
namespace moveit {

/// Joints and their positions [rad or m].
using Positions = std::vector<std::pair<std::string, double>>;

/// Limits of the repair of a start.
struct FixLimits {
    /// Largest displacement of any point of the robot, or of an object that it holds [m], 0 or more.
    double max_displacement = HUGE_VAL;
    /// Largest time [s].
    double max_seconds = 1.0;
    /// Clearance to aim at [m]; nan means that of the scene. A start with less clearance, at least the scene's, is
    /// preferred to one beyond max_displacement.
    double clearance = std::nan("");
    /// Joints that may move, such as those of the planning group; if the list is empty, all may.
    std::vector<std::string> joints;
};

/// Result of the repair of a start.
struct FixedStart {
    /// Whether the start needed no repair.
    bool was_free = false;
    /// Whether a free start within the limits was found.
    bool fixed = false;
    /// Positions of the joints with one coordinate in the new start; if the start was not fixed, in the old one.
    Positions positions;
    /// Distance from the old start to the new one, in the scene's metric, and its proved lower bound.
    double depth = 0, lower_bound = 0;
    /// Share of the depth that is not proved.
    double gap = 0;
    /// Largest displacement of any point from the old start to the new one [m].
    double max_displacement = 0;
    /// Clearance that the new start keeps [m]: the clearance to aim at, or less if that would be far.
    double clearance = 0;
    /// Pairs of bodies that collided.
    std::vector<std::pair<std::string, std::string>> colliding;
    /// Joints that were beyond their limits.
    std::vector<std::string> outside;
    /// Content of the message that is ignored.
    std::vector<std::string> notes;
    /// The whole result in one line, for a log.
    std::string summary;
};

namespace detail {
inline std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (char c : text) {
        const unsigned char code = static_cast<unsigned char>(c);
        char escaped[8];
        if (c == '"' || c == '\\') out += '\\';
        if (code < 0x20 || code == 0x7f) {
            std::snprintf(escaped, sizeof escaped, "\\u%04x", code);
            out += escaped;
        } else {
            out += c;
        }
    }
    return out + "\"";
}
}  // namespace detail

/// Folders of the packages that ROS 2 has sourced, in which `package://` is looked up.
inline std::vector<std::string> sourced_packages() {
    std::vector<std::string> folders;
    const char* prefixes = std::getenv("AMENT_PREFIX_PATH");
    std::istringstream all(prefixes ? prefixes : "");
    for (std::string prefix; std::getline(all, prefix, ':');)
        if (!prefix.empty()) folders.push_back(prefix + "/share");
    return folders;
}

/// Makes a scene of a robot alone from the texts of its URDF and SRDF (empty for none). `metric` is "joint", or
/// "max-displacement", which minimises the largest displacement [m] of any point.
inline Scene robot(const std::string& urdf, const std::string& srdf = "",
                   const std::vector<std::string>& packages = sourced_packages(), const std::string& metric = "joint") {
    std::string text = "metric = { kind = " + detail::quoted(metric) + " }\n[[robot]]\nurdf = \"robot.urdf\"\npackages = [";
    for (const std::string& folder : packages) text += detail::quoted(folder) + ", ";
    text += "]\n";
    std::vector<std::pair<std::string, std::string>> files = {{"robot.urdf", urdf}};
    if (!srdf.empty()) {
        text += "srdf = \"robot.srdf\"\n";
        files.emplace_back("robot.srdf", srdf);
    }
    return Scene::from_text(text, "", files);
}

/// Repairs starts of one robot. Any number of threads may use it.
class StartFixer {
public:
    /// Takes a robot, perhaps with a model that was learned from it.
    explicit StartFixer(Scene robot) : robot_(std::move(robot)) {}

    /// Repairs a start in the world of a message. The ending of `name` (.yaml, .json) sets the format, and error
    /// messages contain `name`. Joints that the robot does not have are ignored.
    FixedStart fix(const std::string& planning_scene, const std::string& name, const Positions& start,
                   const FixLimits& limits = FixLimits()) {
        const Scene world = in_world(planning_scene, name);
        if (!world) return FixedStart();
        const std::map<std::string, std::size_t> known = coordinates(world);
        std::vector<std::string> names;
        std::vector<double> values;
        for (const auto& [joint, position] : start) {
            if (!known.count(joint)) continue;
            names.push_back(joint);
            values.push_back(position);
        }
        const std::vector<double> q = world.config(names, values);
        return last_status() == EXTRICATE_OK ? fixed(world, q, limits) : FixedStart();
    }

    /// Repairs the start whose positions are in `state`, the text of a message: `planning_scene` itself or another
    /// one.
    FixedStart fix(const std::string& planning_scene, const std::string& name, const std::string& state,
                   const std::string& state_name, const FixLimits& limits = FixLimits()) {
        const Scene world = in_world(planning_scene, name);
        if (!world) return FixedStart();
        const std::vector<double> q = world.config_text(state_name, state);
        return last_status() == EXTRICATE_OK ? fixed(world, q, limits) : FixedStart();
    }

    const Scene& robot() const { return robot_; }

private:
    /// Keeps the last world, because planners query the same one again and again.
    Scene in_world(const std::string& text, const std::string& name) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!world_ || text != text_) {
            world_ = robot_.in_world_text(name, text);
            text_ = text;
        }
        return world_;
    }

    /// Joints with one coordinate, and the index of that coordinate.
    static std::map<std::string, std::size_t> coordinates(const Scene& world) {
        std::map<std::string, std::size_t> known;
        const std::vector<std::string> joints = world.joints();
        for (std::size_t k = 0; k < joints.size(); ++k) {
            std::size_t first = 0, count = 0;
            extricate_scene_joint_coordinates(world.get(), k, &first, &count);
            if (count == 1) known[joints[k]] = first;
        }
        return known;
    }

    static Options options(const Scene& world, const FixLimits& limits) {
        Options options;
        options.max_seconds = limits.max_seconds;
        options.clearance = limits.clearance;
        if (limits.joints.empty()) return options;
        for (const std::string& joint : world.joints()) {
            bool may_move = false;
            for (const std::string& other : limits.joints) may_move = may_move || other == joint;
            if (!may_move) options.locked.push_back(joint);
        }
        return options;
    }

    FixedStart fixed(const Scene& world, const std::vector<double>& q, const FixLimits& limits) const {
        FixedStart start;
        if (!(limits.max_displacement >= 0)) {
            extricate::detail::refuse("limits.max_displacement: got " + std::to_string(limits.max_displacement) +
                                      ", expected 0 or more [m]");
            return start;
        }
        const auto began = std::chrono::steady_clock::now();
        Options asked = options(world, limits);
        Solver solver(world, asked);
        if (!solver) return start;
        std::optional<Answer> answer = solver.query(q);
        if (!answer && last_status() != EXTRICATE_NOTHING_FREE) return start;
        const std::vector<std::string> known = robot_.warnings();
        for (const std::string& warning : world.warnings())
            if (std::find(known.begin(), known.end(), warning) == known.end()) start.notes.push_back(warning);
        const auto is_far = [&] { return !answer || answer->max_displacement() > limits.max_displacement; };
        // If nothing near keeps that much, something near may keep the clearance of the scene.
        if (is_far() && limits.clearance > world.clearance()) {
            asked.clearance = std::nan("");
            const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
            // A solver takes no limit of 0.
            asked.max_seconds = std::max(1e-3, limits.max_seconds - spent.count());
            if (!solver.set_options(asked)) return start;
            if (const std::optional<Answer> near = solver.query(q)) answer = near;
        }
        const std::map<std::string, std::size_t> joints = coordinates(world);
        const bool is_allowed = !is_far();
        for (const auto& [joint, at] : joints)
            start.positions.emplace_back(joint, is_allowed ? answer->witness()[at] : q[at]);
        if (!answer) {
            start.summary = "the start is in collision, and no free state was found for the joints that may move";
            return start;
        }
        start.was_free = answer->is_free();
        start.fixed = is_allowed;
        start.depth = answer->depth();
        start.lower_bound = answer->lower_bound();
        start.gap = answer->gap();
        start.max_displacement = answer->max_displacement();
        start.clearance = answer->summary().clearance;
        for (const ExtricatePair& pair : answer->colliding()) start.colliding.push_back(world.names(pair));
        for (std::size_t at : answer->outside())
            for (const auto& [joint, coordinate] : joints)
                if (coordinate == at) start.outside.push_back(joint);
        start.summary = summary(start, limits);
        return start;
    }

    static std::string summary(const FixedStart& start, const FixLimits& limits) {
        if (start.was_free) return "the start is free";
        std::string text = "the start";
        if (!start.colliding.empty()) text += " has " + start.colliding[0].first + " in collision with " + start.colliding[0].second;
        if (start.colliding.size() > 1) text += " and " + std::to_string(start.colliding.size() - 1) + " more pairs";
        if (!start.outside.empty()) text += std::string(start.colliding.empty() ? "" : ", and") + " is beyond a limit of " + start.outside[0];
        char rest[240];
        std::snprintf(rest, sizeof rest, "; %s is %.4f away (at least %.4f), moves points by up to %.4f m and keeps %g m",
                      start.fixed ? "its repair" : "the nearest free state", start.depth, start.lower_bound,
                      start.max_displacement, start.clearance);
        text += rest;
        if (start.fixed) return text;
        std::snprintf(rest, sizeof rest, ", more than the %.4f m that are allowed", limits.max_displacement);
        return text + rest;
    }

    Scene robot_;
    std::mutex mutex_;
    std::string text_;
    Scene world_;
};

}  // namespace moveit
}  // namespace extricate

#endif
