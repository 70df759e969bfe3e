/* Repairs starts in collision in the worlds of MoveIt's messages. Building and testing need no ROS.
 *
 *     extricate::moveit::StartFixer fixer({urdf, srdf});
 *     auto start = fixer.fix(planning_scene, {{"joint1", 0.3}, ...}, limits);
 *     if (start.fixed) use(start.path);
 *
 * A planning scene is any struct with the members of a moveit_msgs::msg::PlanningScene that are read here: those of
 * ROS 2, or a test's own. Its world with the octomap, attached objects, allowed collisions and padding are used;
 * `notes` lists what is approximated or ignored.
 *
 * Without exceptions, a repair that fails returns a start that is empty and not fixed.
 * extricate::last_status() and last_error() then report the reason. */
#ifndef EXTRICATE_MOVEIT_HPP
#define EXTRICATE_MOVEIT_HPP

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <future>
#include <locale>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>

#include "extricate.hpp"

namespace extricate {
namespace moveit {

/// Joints and their positions [rad or m].
using Positions = std::vector<std::pair<std::string, double>>;

/// Limits of the repair of a start.
struct FixLimits {
    /// Largest displacement of any point of the robot, or of an object that it holds, on the path [m], 0 or more.
    double max_displacement = HUGE_VAL;
    /// Largest time [s]. What a StartFixer takes to prepare a new world is not counted.
    double max_seconds = 1.0;
    /// Clearance to aim at for the new start [m]; nan means that of the scene plus 1 mm. A near start with less, at
    /// least the scene's, is preferred to a far one and to one beyond max_displacement.
    double clearance = std::nan("");
    /// Joints that may move, such as those of the planning group; if the list is empty, all may.
    std::vector<std::string> joints;
    /// Goal of the motion that follows: of new starts about as near, the one nearest to it is preferred. Joints that it
    /// does not name are where they are at the start. If it is empty, no start is preferred.
    Positions toward;
};

/// Result of the repair of a start.
struct FixedStart {
    /// Whether the start needed no repair.
    bool was_free = false;
    /// Whether a free start within the limits was found, or the start was free.
    bool fixed = false;
    /// Positions of the joints with one coordinate in the new start; if the start was not fixed, in the old one.
    Positions positions;
    /// The way from the old start, which is the first row, to the new one, which is the last: positions of the joints
    /// in the order of `positions`. Edges are straight. Each is proved: on it no pair of bodies collides that does not
    /// at the old start, and none that does gets deeper by more than 1 mm. If joints were beyond their limits, the
    /// first edge leads straight back to the limits and is not proved.
    std::vector<std::vector<double>> path;
    /// Index into `path` from which on it is proved free.
    std::size_t free_from = 0;
    /// Distance from the old start to the new one, in the scene's metric.
    double depth = 0;
    /// Largest displacement of any point on the path from the old start [m].
    double max_displacement = 0;
    /// Least distance of any checked pair of bodies at the new start [m].
    double clearance = 0;
    /// Pairs of bodies that collided.
    std::vector<std::pair<std::string, std::string>> colliding;
    /// Joints that were beyond their limits.
    std::vector<std::string> outside;
    /// Content of the message that is approximated or ignored.
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
/// A number of TOML that reads as the same one.
inline std::string number(double value) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(17);
    text << std::scientific << value;
    return text.str();
}
/// A table of TOML in one line, from keys and values as TOML has them.
template <class Entries>
std::string table(const Entries& entries) {
    std::string text = "{ ", comma;
    for (const auto& [name, value] : entries) {
        text += comma + quoted(name) + " = " + value;
        comma = ", ";
    }
    return text + " }";
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

/// A robot as ROS describes it.
struct Description {
    /// Texts of its URDF and SRDF; an empty SRDF is none.
    std::string urdf, srdf;
    /// "joint", or "max-displacement", which minimises the largest displacement [m] of any point.
    std::string metric = "joint";
    /// Folders in which `package://` is looked up.
    std::vector<std::string> packages = sourced_packages();
    /// Joints that stay where they are, with their positions [rad or m], whatever their limits.
    Positions locked = {};
};

/// Makes a scene of a robot alone.
inline Scene robot(const Description& description) {
    std::string text = "metric = { kind = " + detail::quoted(description.metric) +
                       " }\n[[robot]]\nurdf = \"robot.urdf\"\npackages = [";
    for (const std::string& folder : description.packages)
        text += detail::quoted(folder) + ", ";
    text += "]\n";
    if (!description.locked.empty()) {
        // A joint whose two limits are equal stays. Joints without coordinates would change which pairs are checked.
        std::vector<std::pair<std::string, std::string>> limits;
        for (const auto& [joint, position] : description.locked)
            limits.emplace_back(joint, "[" + detail::number(position) + ", " + detail::number(position) + "]");
        text += "limits = " + detail::table(limits) + "\n";
    }
    std::vector<std::pair<std::string, std::string>> files = {{"robot.urdf", description.urdf}};
    if (!description.srdf.empty()) {
        text += "srdf = \"robot.srdf\"\n";
        files.emplace_back("robot.srdf", description.srdf);
    }
    return Scene::from_text(text, "", files);
}

namespace detail {

using extricate::detail::refuse;
using extricate::detail::shown;

/// A pose with its rotation as a unit quaternion x, y, z, w.
struct Placement {
    double position[3] = {0, 0, 0};
    double turned[4] = {0, 0, 0, 1};

    Pose pose() const {
        return Pose(position[0], position[1], position[2], turned[0], turned[1], turned[2], turned[3]);
    }
    void rotate(const double* vector, double* out) const {
        const double *q = turned, *v = vector;
        const double t[3] = {2 * (q[1] * v[2] - q[2] * v[1]), 2 * (q[2] * v[0] - q[0] * v[2]),
                             2 * (q[0] * v[1] - q[1] * v[0])};
        const double turn[3] = {q[1] * t[2] - q[2] * t[1], q[2] * t[0] - q[0] * t[2], q[0] * t[1] - q[1] * t[0]};
        for (int k = 0; k < 3; ++k)
            out[k] = v[k] + q[3] * t[k] + turn[k];
    }
    /// The pose of what `inner` places in the coordinates that this places.
    Placement then(const Placement& inner) const {
        Placement all;
        rotate(inner.position, all.position);
        for (int k = 0; k < 3; ++k)
            all.position[k] += position[k];
        const double *a = turned, *b = inner.turned;
        all.turned[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
        all.turned[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0];
        all.turned[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3];
        all.turned[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
        return all;
    }
    Placement inverse() const {
        Placement back;
        for (int k = 0; k < 3; ++k)
            back.turned[k] = -turned[k];
        back.turned[3] = turned[3];
        back.rotate(position, back.position);
        for (double& x : back.position)
            x = -x;
        return back;
    }
    bool is_identity() const {
        return position[0] == 0 && position[1] == 0 && position[2] == 0 && turned[0] == 0 && turned[1] == 0 &&
               turned[2] == 0;
    }
};

/// Places by a position and a quaternion. As in MoveIt, one of zeros alone is no rotation.
template <class Position, class Quaternion>
Placement placement(const Position& at, const Quaternion& turned) {
    Placement placed;
    const double position[3] = {at.x, at.y, at.z}, q[4] = {turned.x, turned.y, turned.z, turned.w};
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 3; ++k)
        placed.position[k] = position[k];
    if (length != 0)
        for (int k = 0; k < 4; ++k)
            placed.turned[k] = q[k] / length;
    return placed;
}

/// Reads the nodes of an OctoMap, which messages hold depth first, and collects its occupied leaves by their size.
class OctomapReader {
public:
    /// `value_bytes` is what each node of a full map has behind its log odds; a binary map has no values.
    OctomapReader(const signed char* data, std::size_t size, bool is_binary, std::size_t value_bytes)
        : data_(reinterpret_cast<const unsigned char*>(data)),
          end_(data_ + size),
          is_binary_(is_binary),
          value_bytes_(value_bytes) {}

    /// Cells of the occupied leaves, three indices each; `leaves[k]` are those of 2^k times the resolution.
    std::vector<std::vector<std::int32_t>> leaves = std::vector<std::vector<std::int32_t>>(LEVELS + 1);

    /// Returns whether the bytes are one whole tree.
    bool read() {
        const std::int32_t first[3] = {0, 0, 0};
        return (is_binary_ ? binary_node(LEVELS, first) : full_node(LEVELS, first)) && data_ == end_;
    }

private:
    /// OctoMap's trees have this depth.
    static constexpr int LEVELS = 16;

    void add(int level, const std::int32_t* first) {
        for (int k = 0; k < 3; ++k)
            leaves[level].push_back((first[k] - (1 << (LEVELS - 1))) >> level);
    }
    static void child(int level, const std::int32_t* first, int index, std::int32_t* out) {
        for (int k = 0; k < 3; ++k)
            out[k] = first[k] + ((index >> k & 1) << (level - 1));
    }
    /// A node of a binary map is two bits for each child: 0 unknown, 1 free, 2 occupied, 3 an inner node that follows.
    bool binary_node(int level, const std::int32_t* first) {
        if (level == 0 || end_ - data_ < 2) return false;
        const unsigned bits = data_[0] | static_cast<unsigned>(data_[1]) << 8;
        data_ += 2;
        for (int index = 0; index < 8; ++index) {
            const unsigned kind = bits >> (2 * index) & 3;
            std::int32_t corner[3];
            child(level, first, index, corner);
            if (kind == 2) add(level - 1, corner);
            if (kind == 3 && !binary_node(level - 1, corner)) return false;
        }
        return true;
    }
    /// A node of a full map is its log odds, a value, and one bit for each child. It is occupied at a probability of
    /// at least 0.5, OctoMap's own threshold.
    bool full_node(int level, const std::int32_t* first) {
        if (static_cast<std::size_t>(end_ - data_) < sizeof(float) + value_bytes_ + 1) return false;
        float log_odds;
        std::memcpy(&log_odds, data_, sizeof log_odds);
        data_ += sizeof log_odds + value_bytes_;
        const unsigned children = *data_++;
        if (children != 0 && level == 0) return false;
        if (children == 0 && log_odds >= 0) add(level, first);
        for (int index = 0; index < 8; ++index) {
            if (!(children >> index & 1)) continue;
            std::int32_t corner[3];
            child(level, first, index, corner);
            if (!full_node(level - 1, corner)) return false;
        }
        return true;
    }

    const unsigned char *data_, *end_;
    bool is_binary_;
    std::size_t value_bytes_;
};

/// FNV-1a, of 64 bits.
class Digest {
public:
    void add(const void* data, std::size_t size) {
        const unsigned char* bytes = static_cast<const unsigned char*>(data);
        for (std::size_t k = 0; k < size; ++k)
            value_ = (value_ ^ bytes[k]) * 0x100000001b3ULL;
    }
    void add(double value) { add(&value, sizeof value); }
    void add(std::size_t value) { add(&value, sizeof value); }
    void add(const std::string& text) {
        add(text.size());
        add(text.data(), text.size());
    }
    std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// Places the frames that a message names in the coordinates of the robot.
class Frames {
public:
    /// `world` is where the planning frame is.
    Frames(Scene robot, const Placement& world) : robot_(std::move(robot)), world_(world) {}

    /// Reads the frames that MoveIt knows, which are given in its planning frame.
    template <class Transforms>
    bool read(const Transforms& transforms) {
        for (const auto& each : transforms) {
            const std::string element = "fixed_frame_transforms: \"" + shown(each.child_frame_id) + "\"";
            if (!is_planning_frame(element, each.header.frame_id)) return false;
            known_[each.child_frame_id] =
                world_.then(placement(each.transform.translation, each.transform.rotation));
        }
        return true;
    }

    /// Finds where a frame is. No name means the planning frame, and so does the first one that is not known.
    bool find(const std::string& element, const std::string& frame, Placement& out) {
        out = world_;
        if (frame.empty() || frame == planning_) return true;
        auto found = known_.find(frame);
        if (found == known_.end()) {
            // The root link is where the robot is at every configuration; two tell it from links that move.
            const char* name = frame.c_str();
            const std::vector<double> q = robot_.sample(2);
            double at[32];
            if (extricate_scene_poses(robot_.get(), &name, 1, q.data(), 2, robot_.nq(), at, 2) != EXTRICATE_OK)
                return is_planning_frame(element, frame);
            for (int k = 0; k < 32; ++k)
                if (at[k] != (k % 16 % 5 == 0 ? 1.0 : 0.0))
                    return refuse(element + ": got the frame \"" + shown(frame) +
                                  "\", a link of the robot, expected the planning frame or the root link");
            // Without a joint between the two, the root link is the planning frame.
            if (world_.is_identity()) return is_planning_frame(element, frame);
            found = known_.emplace(frame, Placement()).first;
        }
        out = found->second;
        return true;
    }

private:
    bool is_planning_frame(const std::string& element, const std::string& frame) {
        if (planning_.empty()) planning_ = frame;
        return frame.empty() || frame == planning_ ||
               refuse(element + ": got the frame \"" + shown(frame) + "\" beside \"" + shown(planning_) +
                      "\", expected one planning frame, or one of fixed_frame_transforms");
    }

    Scene robot_;
    Placement world_;
    std::string planning_;
    std::map<std::string, Placement> known_;
};

/// An object that a link holds.
struct Held {
    Obstacle object;
    std::string link;
    std::vector<std::string> touch;
};

/// What a message says of the world, in parts of which a scene can be made.
class WorldParts {
public:
    std::vector<Obstacle> obstacles;
    std::vector<Held> held;
    std::vector<std::pair<std::string, std::string>> allowed;
    std::map<std::string, double> padding;
    std::vector<std::string> notes;

    /// Reads a PlanningScene, whose world takes the place of the obstacles of `robot`. Returns false if it is refused.
    template <class Message>
    bool read(const Scene& robot, const Message& message) {
        const Scene alone = robot.without_obstacles();
        for (const std::string& body : alone.bodies())
            bodies_.insert(body);
        Placement base;
        if (!read_base(robot, message.robot_state.multi_dof_joint_state, base)) return false;
        const Placement world = base.inverse();
        is_diff_ = message.is_diff;
        taken_ = bodies_;
        taken_.insert(OCTOMAP);
        for (const auto& object : message.world.collision_objects)
            name(object);
        for (const auto& attached : message.robot_state.attached_collision_objects)
            name(attached.object);
        if (!message.world.octomap.octomap.data.empty()) named_.insert(OCTOMAP);
        Frames frames(alone, world);
        if (!frames.read(message.fixed_frame_transforms)) return false;
        for (const auto& object : message.world.collision_objects) {
            if (!is_added(object)) continue;
            const std::string element = "collision object \"" + shown(object.id) + "\"";
            Placement frame;
            std::vector<Obstacle> shapes;
            if (!frames.find(element, object.header.frame_id, frame)) return false;
            if (!read_object(object, element, frame, shapes)) return false;
            for (Obstacle& shape : shapes) {
                standing_.insert(shape.name);
                obstacles.push_back(std::move(shape));
            }
        }
        if (!read_octomap(message.world.octomap, frames)) return false;
        for (const auto& attached : message.robot_state.attached_collision_objects)
            if (!read_attached(attached)) return false;
        if (!read_allowed(message.allowed_collision_matrix)) return false;
        for (const auto& entry : message.link_padding) {
            if (entry.padding > 0 && bodies_.count(entry.link_name)) padding[entry.link_name] = entry.padding;
            if (entry.padding < 0)
                notes.push_back("link_padding of " + entry.link_name + ": a negative one is ignored");
        }
        for (const auto& entry : message.link_scale)
            if (entry.scale != 1.0) notes.push_back("link_scale of " + entry.link_name + ": links keep their size");
        return true;
    }

    /// A number of all that the scene of this world uses. That two different worlds share one of its 2^64 values is
    /// most unlikely, but not excluded.
    std::uint64_t digest() const {
        Digest digest;
        digest.add(obstacles.size());
        digest.add(held.size());
        digest.add(allowed.size());
        digest.add(padding.size());
        for (const Obstacle& obstacle : obstacles)
            add(digest, obstacle);
        for (const Held& each : held)
            add(digest, each);
        for (const auto& [first, second] : allowed) {
            digest.add(first);
            digest.add(second);
        }
        for (const auto& [link, metres] : padding) {
            digest.add(link);
            digest.add(metres);
        }
        return digest.value();
    }

    /// The robot among the objects of this world, with all pairs checked. It is made of the scene `last` of the world
    /// `before`, if there is one: what that has prepared of the same shapes is kept.
    Scene objects(const Scene& robot, const WorldParts& before, const Scene& last) const {
        std::vector<std::pair<std::string, std::string>> padded;
        for (const auto& [link, metres] : padding)
            padded.emplace_back(link, number(metres));
        std::map<std::string, const Obstacle*> standing;
        std::map<std::string, const Held*> hanging;
        Scene world = last;
        if (last && padding == before.padding) {
            for (const Obstacle& obstacle : before.obstacles)
                standing[obstacle.name] = &obstacle;
            for (const Held& each : before.held)
                hanging[each.object.name] = &each;
        } else {
            world = padding.empty() ? robot.without_obstacles()
                                    : robot.in_world_text("padding.toml", "padding = " + table(padded) + "\n");
        }
        std::vector<Obstacle> added;
        std::vector<Held> taken;
        std::vector<std::pair<std::string, Pose>> moved;
        for (const Obstacle& obstacle : obstacles) {
            const auto found = standing.find(obstacle.name);
            if (found == standing.end() || digest_of(obstacle.shape) != digest_of(found->second->shape)) {
                added.push_back(obstacle);
                continue;
            }
            if (std::memcmp(&obstacle.pose, &found->second->pose, sizeof obstacle.pose) != 0)
                moved.emplace_back(obstacle.name, obstacle.pose);
            standing.erase(found);
        }
        for (const Held& each : held) {
            const auto found = hanging.find(each.object.name);
            if (found == hanging.end() || digest_of(each) != digest_of(*found->second))
                taken.push_back(each);
            else
                hanging.erase(found);
        }
        std::vector<std::string> gone;
        for (const auto& [name, obstacle] : standing)
            gone.push_back(name);
        for (const auto& [name, each] : hanging)
            gone.push_back(name);
        if (world && !gone.empty()) world = world.without(gone);
        if (world && !moved.empty()) world = world.moved(moved);
        if (world && !added.empty()) world = world.with_obstacles(added);
        for (const Held& each : taken)
            if (world) world = world.attached(each.object, each.link, each.touch);
        return world;
    }

    /// Whether the message says anything of objects, the map included.
    bool changes_objects() const { return !is_diff_ || clears_ || !named_.empty(); }

    /// Makes what a difference says the whole of it after what was known before: objects that it does not name stay.
    /// What a whole message says is left as it is.
    void follow(const WorldParts& before) {
        if (!is_diff_) return;
        std::set<std::string> taken;
        for (const Obstacle& obstacle : obstacles)
            taken.insert(obstacle.name);
        for (const Held& each : held)
            taken.insert(each.object.name);
        for (const auto& [object, shapes] : before.names_) {
            if (named_.count(object))
                taken.insert(shapes.begin(), shapes.end());
            else
                names_.emplace(object, shapes);
        }
        for (const Obstacle& obstacle : before.obstacles)
            if (!clears_ && taken.insert(obstacle.name).second) obstacles.push_back(obstacle);
        for (const Held& each : before.held)
            if (taken.insert(each.object.name).second) held.push_back(each);
        padding = before.padding;
        named_.insert(before.named_.begin(), before.named_.end());
        clears_ = clears_ || before.clears_;
        is_diff_ = before.is_diff_;
    }

    /// Forgets what was changed: this is now what was known before.
    void settle() {
        named_.clear();
        clears_ = is_diff_ = false;
    }

private:
    static void add(Digest& digest, const Shape& shape) {
        const ExtricateShape raw = shape.raw();
        digest.add(&raw.kind, sizeof raw.kind);
        digest.add(&raw.convex, sizeof raw.convex);
        digest.add(raw.size, sizeof raw.size);
        digest.add(raw.offset);
        const auto all = [&](const auto* numbers, std::size_t count) {
            digest.add(count);
            digest.add(numbers, 3 * count * sizeof *numbers);
        };
        all(raw.points, raw.point_count);
        all(raw.triangles, raw.triangle_count);
        all(raw.cells, raw.cell_count);
    }
    static void add(Digest& digest, const Obstacle& obstacle) {
        digest.add(obstacle.name);
        digest.add(&obstacle.pose, sizeof obstacle.pose);
        add(digest, obstacle.shape);
    }
    static void add(Digest& digest, const Held& held) {
        add(digest, held.object);
        digest.add(held.link);
        digest.add(held.touch.size());
        for (const std::string& touch : held.touch)
            digest.add(touch);
    }
    template <class Part>
    static std::uint64_t digest_of(const Part& part) {
        Digest digest;
        add(digest, part);
        return digest.value();
    }

    /// The pose of the robot's base, which MoveIt holds as a joint of several coordinates that the URDF does not have.
    template <class Joints>
    bool read_base(const Scene& robot, const Joints& state, Placement& base) {
        const std::vector<std::string> known = robot.joints();
        for (std::size_t k = 0; k < state.joint_names.size() && k < state.transforms.size(); ++k) {
            const auto& transform = state.transforms[k];
            const Placement placed = placement(transform.translation, transform.rotation);
            const bool is_known = std::find(known.begin(), known.end(), state.joint_names[k]) != known.end();
            if (is_known || k > 0)
                return refuse("multi_dof_joint_state: got \"" + shown(state.joint_names[k]) +
                              "\", expected no joint of several coordinates but that of the base");
            base = placed;
        }
        return true;
    }

    template <class Object>
    static bool is_added(const Object& object) {
        // 0 is to add it, 2 to append to it; what is to be removed or moved is not there.
        return static_cast<int>(object.operation) == 0 || static_cast<int>(object.operation) == 2;
    }

    /// Notes what becomes of an object. One that is moved or appended to keeps its shapes; 1 is to remove it, or with
    /// no name to remove all.
    template <class Object>
    void name(const Object& object) {
        const int operation = static_cast<int>(object.operation);
        if (operation == 1 && object.id.empty()) clears_ = true;
        if (operation == 0 || operation == 1) named_.insert(object.id);
        taken_.insert(object.id);
    }

    template <class Object>
    bool read_object(const Object& object, const std::string& element, const Placement& frame,
                     std::vector<Obstacle>& out) {
        const Placement whole = frame.then(placement(object.pose.position, object.pose.orientation));
        std::vector<Obstacle> shapes;
        const auto place = [&](Shape shape, const auto& poses, std::size_t at) {
            const Placement placed =
                poses.empty() ? whole : whole.then(placement(poses[at].position, poses[at].orientation));
            shapes.push_back(Obstacle{object.id, std::move(shape), placed.pose()});
        };
        const auto are_as_many = [&](const char* kind, std::size_t count, std::size_t poses) {
            return poses == 0 || poses == count ||
                   refuse(element + ": got " + std::to_string(count) + " " + kind + " and " + std::to_string(poses) +
                          " poses, expected as many");
        };
        if (!are_as_many("primitives", object.primitives.size(), object.primitive_poses.size()) ||
            !are_as_many("meshes", object.meshes.size(), object.mesh_poses.size()) ||
            !are_as_many("planes", object.planes.size(), object.plane_poses.size()))
            return false;
        for (std::size_t k = 0; k < object.primitives.size(); ++k) {
            const auto& primitive = object.primitives[k];
            const std::vector<double> sizes(primitive.dimensions.begin(), primitive.dimensions.end());
            const int kind = static_cast<int>(primitive.type);
            const std::size_t expected = kind == 1 ? 3 : kind == 2 ? 1 : 2;
            if (kind < 1 || kind > 4)
                return refuse(element + ": type: got " + std::to_string(kind) +
                              ", expected 1 (box), 2 (sphere), 3 (cylinder) or 4 (cone)");
            if (sizes.size() < expected)
                return refuse(element + ": dimensions: got " + std::to_string(sizes.size()) + " numbers, expected " +
                              std::to_string(expected));
            // The message has the height of cylinders and cones first.
            place(kind == 1   ? Shape::box(sizes[0], sizes[1], sizes[2])
                  : kind == 2 ? Shape::sphere(sizes[0])
                  : kind == 3 ? Shape::cylinder(sizes[1], sizes[0])
                              : cone(sizes[1], sizes[0]),
                  object.primitive_poses, k);
            if (kind == 4) notes.push_back(element + ": a cone is taken for the pyramid of 64 sides around it");
        }
        for (std::size_t k = 0; k < object.meshes.size(); ++k) {
            std::vector<double> corners;
            std::vector<std::uint32_t> triangles;
            for (const auto& corner : object.meshes[k].vertices)
                corners.insert(corners.end(), {corner.x, corner.y, corner.z});
            for (const auto& triangle : object.meshes[k].triangles)
                triangles.insert(triangles.end(),
                                 {triangle.vertex_indices[0], triangle.vertex_indices[1], triangle.vertex_indices[2]});
            place(Shape::mesh(std::move(corners), std::move(triangles)), object.mesh_poses, k);
        }
        for (std::size_t k = 0; k < object.planes.size(); ++k) {
            // The plane a x + b y + c z + d = 0.
            const auto& c = object.planes[k].coef;
            const double length = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
            place(Shape::half_space(c[0], c[1], c[2], -c[3] / length), object.plane_poses, k);
            notes.push_back(element + ": a plane is taken for all that lies behind it");
        }
        if (!take_names(object.id, element, shapes)) return false;
        for (Obstacle& shape : shapes)
            out.push_back(std::move(shape));
        return true;
    }

    /// Gives each shape of an object a name of its own: that of the object, or if there are several, a numbered one
    /// that no body and no object has.
    bool take_names(const std::string& object, const std::string& element, std::vector<Obstacle>& shapes) {
        if (names_.count(object)) return refuse(element + ": got a second object of this id, expected one");
        std::vector<std::string>& names = names_[object];
        std::size_t number = 0;
        for (Obstacle& shape : shapes) {
            while (shapes.size() > 1 && !taken_.insert(shape.name).second)
                shape.name = object + "-" + std::to_string(++number);
            names.push_back(shape.name);
        }
        return true;
    }

    /// The pyramid of 64 sides around a cone, whose tip is up and whose origin is in the middle of its height.
    static Shape cone(double radius, double height) {
        constexpr std::uint32_t SIDES = 64;
        const double half_turn = std::acos(-1.0), rim = radius / std::cos(half_turn / SIDES);
        std::vector<double> corners = {0, 0, height / 2, 0, 0, -height / 2};
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t k = 0; k < SIDES; ++k) {
            const double angle = 2 * half_turn * k / SIDES;
            const std::uint32_t here = 2 + k, next = 2 + (k + 1) % SIDES;
            corners.insert(corners.end(), {rim * std::cos(angle), rim * std::sin(angle), -height / 2});
            triangles.insert(triangles.end(), {here, next, 0, next, here, 1});
        }
        return Shape::mesh(std::move(corners), std::move(triangles), true);
    }

    template <class Octomap>
    bool read_octomap(const Octomap& message, Frames& frames) {
        const auto& map = message.octomap;
        if (map.data.empty()) return true;
        const std::string element = "world.octomap";
        const bool is_colour = map.id == "ColorOcTree";
        if (map.id != "OcTree" && !is_colour)
            return refuse(element + ": id: got \"" + shown(map.id) + "\", expected OcTree or ColorOcTree");
        OctomapReader reader(reinterpret_cast<const signed char*>(map.data.data()), map.data.size(), map.binary,
                             is_colour ? 3 : 0);
        if (!reader.read())
            return refuse(element + ": data: got " + std::to_string(map.data.size()) +
                          " bytes, expected the nodes of one tree of depth 16");
        Placement frame;
        if (!frames.find(element, message.header.frame_id, frame)) return false;
        const Pose pose = frame.then(placement(message.origin.position, message.origin.orientation)).pose();
        std::vector<Obstacle> shapes;
        double side = map.resolution;
        for (std::vector<std::int32_t>& cells : reader.leaves) {
            if (!cells.empty()) shapes.push_back(Obstacle{OCTOMAP, Shape::voxels(std::move(cells), side), pose});
            side *= 2;
        }
        if (!take_names(OCTOMAP, element, shapes)) return false;
        for (Obstacle& shape : shapes) {
            standing_.insert(shape.name);
            obstacles.push_back(std::move(shape));
        }
        return true;
    }

    template <class Attached>
    bool read_attached(const Attached& attached) {
        const auto& object = attached.object;
        if (!is_added(object)) return true;
        const std::string element = "attached object \"" + shown(object.id) + "\"";
        const std::string& frame = object.header.frame_id;
        if (!frame.empty() && frame != attached.link_name)
            return refuse(element + ": got the frame \"" + shown(frame) + "\" beside \"" + shown(attached.link_name) +
                          "\", expected that of the link that holds it");
        std::vector<Obstacle> shapes;
        if (!read_object(object, element, Placement(), shapes)) return false;
        for (Obstacle& shape : shapes) {
            Held each{std::move(shape), attached.link_name, {}};
            for (const std::string& link : attached.touch_links)
                if (link != attached.link_name && bodies_.count(link)) each.touch.push_back(link);
            held.push_back(std::move(each));
        }
        return true;
    }

    /// Names of the bodies that a name of the matrix stands for; none if there is no such body.
    std::vector<std::string> bodies_of(const std::string& name) const {
        const auto found = names_.find(name);
        if (found != names_.end()) return found->second;
        return bodies_.count(name) ? std::vector<std::string>{name} : std::vector<std::string>();
    }

    /// Collects the allowed pairs. An entry for a pair overrides defaults, and a default that forbids contact
    /// overrides one that allows it.
    template <class Matrix>
    bool read_allowed(const Matrix& matrix) {
        const std::vector<std::string>& names = matrix.entry_names;
        const std::string element = "allowed_collision_matrix";
        if (matrix.entry_values.size() != names.size())
            return refuse(element + ": got " + std::to_string(names.size()) + " names and " +
                          std::to_string(matrix.entry_values.size()) + " rows, expected as many");
        std::map<std::pair<std::string, std::string>, bool> pairs;
        const auto ordered = [](const std::string& a, const std::string& b) {
            return a < b ? std::make_pair(a, b) : std::make_pair(b, a);
        };
        for (std::size_t row = 0; row < names.size(); ++row) {
            const auto& enabled = matrix.entry_values[row].enabled;
            if (enabled.size() != names.size())
                return refuse(element + ": " + shown(names[row]) + ": got " + std::to_string(enabled.size()) +
                              " values, expected " + std::to_string(names.size()));
            for (std::size_t column = row + 1; column < names.size(); ++column)
                pairs[ordered(names[row], names[column])] = enabled[column];
        }
        if (matrix.default_entry_names.size() != matrix.default_entry_values.size())
            return refuse(element + ": got " + std::to_string(matrix.default_entry_names.size()) + " defaults and " +
                          std::to_string(matrix.default_entry_values.size()) + " values, expected as many");
        std::set<std::string> known = bodies_, refused;
        for (const auto& [object, shapes] : names_)
            known.insert(object);
        for (std::size_t k = 0; k < matrix.default_entry_names.size(); ++k)
            if (!matrix.default_entry_values[k]) refused.insert(matrix.default_entry_names[k]);
        for (const std::string& name : matrix.default_entry_names)
            for (const std::string& other : known)
                if (other != name && !refused.count(name) && !refused.count(other))
                    pairs.emplace(ordered(name, other), true);
        for (const auto& [pair, is_allowed] : pairs) {
            if (!is_allowed) continue;
            for (const std::string& first : bodies_of(pair.first))
                for (const std::string& second : bodies_of(pair.second))
                    // Obstacles are never checked against each other.
                    if (!standing_.count(first) || !standing_.count(second)) allowed.emplace_back(first, second);
        }
        return true;
    }

    /// MoveIt's name of the map.
    static constexpr const char* OCTOMAP = "<octomap>";

    std::set<std::string> bodies_, standing_;
    /// Names of bodies and objects, and those that were given to shapes.
    std::set<std::string> taken_;
    /// Names of the shapes of each object.
    std::map<std::string, std::vector<std::string>> names_;
    /// Whether the message is a difference, the objects that it adds or removes, and whether it removes all others.
    bool is_diff_ = false, clears_ = false;
    std::set<std::string> named_;
};

/// Joints with one coordinate, and the index of that coordinate.
inline std::map<std::string, std::size_t> coordinates(const Scene& world) {
    std::map<std::string, std::size_t> known;
    const std::vector<std::string> joints = world.joints();
    for (std::size_t k = 0; k < joints.size(); ++k) {
        std::size_t first = 0, count = 0;
        extricate_scene_joint_coordinates(world.get(), k, &first, &count);
        if (count == 1) known[joints[k]] = first;
    }
    return known;
}
}  // namespace detail

namespace detail {
/// Whether only joints of a list move on a path; an empty list means that all may.
inline bool moves_only(const std::vector<std::string>& may_move, const FixedStart& fixed) {
    for (std::size_t k = 0; k < fixed.positions.size(); ++k) {
        const bool is_listed = std::find(may_move.begin(), may_move.end(), fixed.positions[k].first) != may_move.end();
        for (const std::vector<double>& row : fixed.path)
            if (!may_move.empty() && !is_listed && row[k] != fixed.path[0][k]) return false;
    }
    return true;
}

/// The largest displacement of any point from a configuration beyond the limits to the nearest one within them [m];
/// infinity if the robot collides with itself there.
inline double displacement_to_limits(const Scene& world, const std::vector<double>& q,
                                     const std::vector<double>& within) {
    const Batch batch = query_batch(world.without_obstacles(), q);
    if (batch.summaries.empty() || !batch.summaries[0].found) return HUGE_VAL;
    for (std::size_t at = 0; at < q.size(); ++at)
        if (std::abs(batch.witnesses[at] - within[at]) > 1e-9) return HUGE_VAL;
    return batch.summaries[0].max_displacement;
}

inline std::string summary_of(const FixedStart& fixed, const FixLimits& limits, const Escape& escape) {
    if (fixed.was_free) return "the start is free";
    std::string text = "the start";
    if (!fixed.colliding.empty())
        text += " has " + fixed.colliding[0].first + " in collision with " + fixed.colliding[0].second;
    if (fixed.colliding.size() > 1) text += " and " + std::to_string(fixed.colliding.size() - 1) + " more pairs";
    if (!fixed.outside.empty())
        text += std::string(fixed.colliding.empty() ? "" : ", and") + " is beyond a limit of " + fixed.outside[0];
    char rest[240];
    if (!escape) {
        text += "; no path out of collision was found";
        std::snprintf(rest, sizeof rest, " on which nothing gets more than 1 mm deeper, but one of %g m",
                      escape.needed_tolerance());
        return std::isnan(escape.needed_tolerance()) ? text : text + rest;
    }
    std::snprintf(rest, sizeof rest, "; %s is %.4f away, moves points by up to %.4f m and keeps %.4f m",
                  fixed.fixed ? "its repair" : "the nearest free state", fixed.depth, fixed.max_displacement,
                  fixed.clearance);
    text += rest;
    if (fixed.fixed) return text;
    if (!moves_only(limits.joints, fixed)) return text + ", but moves joints that have to stay";
    std::snprintf(rest, sizeof rest, ", more than the %.4f m that are allowed", limits.max_displacement);
    return text + rest;
}
}  // namespace detail

/// Repairs a start in a world. Joints that the world does not have are ignored. An escape that moves a joint which
/// must stay is no repair here; a StartFixer then asks for one that does not.
inline FixedStart fix_start(const Scene& world, const Positions& start, const FixLimits& limits = FixLimits()) {
    FixedStart fixed;
    if (!(limits.max_displacement >= 0)) {
        detail::refuse("limits.max_displacement: got " + std::to_string(limits.max_displacement) +
                       ", expected 0 or more [m]");
        return fixed;
    }
    const auto began = std::chrono::steady_clock::now();
    const Solver solver(world);
    if (!solver) return fixed;
    const std::map<std::string, std::size_t> joints = detail::coordinates(world);
    const auto config = [&](const Positions& positions) {
        std::vector<std::string> names;
        std::vector<double> values;
        for (const auto& [joint, position] : positions) {
            if (!joints.count(joint)) continue;
            names.push_back(joint);
            values.push_back(position);
        }
        return world.config(names, values);
    };
    const auto [lower, upper] = world.limits();
    const auto clamped = [&, &lower = lower, &upper = upper](std::vector<double> q) {
        for (const auto& joint : joints)
            q[joint.second] = std::min(std::max(q[joint.second], lower[joint.second]), upper[joint.second]);
        return q;
    };
    const std::vector<double> q = config(start);
    if (last_status() != EXTRICATE_OK) return fixed;
    // A path cannot begin beyond the limits: it begins where the start is moved straight onto them.
    const std::vector<double> within = clamped(q);

    EscapeOptions options;
    options.aim = limits.clearance;
    options.max_seconds = limits.max_seconds;
    if (!limits.toward.empty()) {
        std::map<std::string, double> goal(start.begin(), start.end());
        for (const auto& [joint, position] : limits.toward)
            goal[joint] = position;
        options.toward = config(Positions(goal.begin(), goal.end()));
        if (last_status() != EXTRICATE_OK) return fixed;
        options.toward = clamped(options.toward);
    }
    Escape escape = solver.escape(within, options);
    if (last_status() != EXTRICATE_OK) return fixed;
    const double to_limits = q == within ? 0 : detail::displacement_to_limits(world, q, within);
    // If nothing near keeps that much, something near may keep the clearance of the scene.
    if (escape && to_limits + escape.max_displacement() > limits.max_displacement &&
        !(limits.clearance <= world.clearance())) {
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
        options.aim = world.clearance();
        options.max_seconds = std::max(1e-3, limits.max_seconds - spent.count());
        if (const Escape near = solver.escape(within, options)) escape = near;
    }

    for (const auto& [joint, at] : joints) {
        fixed.positions.emplace_back(joint, q[at]);
        if (q[at] != within[at]) fixed.outside.push_back(joint);
    }
    for (const ExtricatePairDistance& each : escape.colliding())
        fixed.colliding.push_back(world.names(each.pair));
    const auto add = [&](const auto& row) {
        fixed.path.emplace_back();
        for (const auto& joint : joints)
            fixed.path.back().push_back(row[joint.second]);
    };
    const Rows points = escape.points();
    if (escape) {
        if (q != within) add(q);
        for (std::size_t k = 0; k < points.size(); ++k)
            add(points[k]);
        fixed.free_from = escape.free_from() + (q == within ? 0 : 1);
        fixed.depth = world.metric_distance(q, points.back());
        fixed.max_displacement = to_limits + escape.max_displacement();
        fixed.clearance = solver.distance(points.back());
        fixed.was_free = fixed.path.size() == 1;
        fixed.fixed = fixed.max_displacement <= limits.max_displacement && detail::moves_only(limits.joints, fixed);
    }
    for (std::size_t k = 0; fixed.fixed && k < fixed.positions.size(); ++k)
        fixed.positions[k].second = fixed.path.back()[k];
    fixed.summary = detail::summary_of(fixed, limits, escape);
    return fixed;
}

/// Repairs starts of one robot in the worlds of planning scenes. Any number of threads may use it.
class StartFixer {
public:
    /// Makes the robot.
    explicit StartFixer(Description description)
        : robot_(moveit::robot(description)), description_(std::move(description)) {}
    /// Takes a robot, perhaps with a model that was learned from it, and its description. If a repair has to hold
    /// joints outside limits.joints, a robot is made of the description, without the model; if its URDF is empty, such
    /// a start is not repaired.
    explicit StartFixer(Scene robot, Description description = Description())
        : robot_(std::move(robot)), description_(std::move(description)) {}

    /// Repairs a start in the world of a planning scene, whose positions of joints are not read. Joints that the robot
    /// does not have are ignored.
    template <class Message>
    FixedStart fix(const Message& planning_scene, const Positions& start, const FixLimits& limits = FixLimits()) {
        detail::WorldParts parts;
        return parts.read(robot_, planning_scene) ? fix_in(parts, start, limits) : FixedStart();
    }

    /// Prepares the objects of a planning scene, or of a difference of one, in a thread. The first start in a world
    /// that has them is then repaired as fast as later ones; without this call, meshes take part of a second. Of scenes
    /// that come while one is being prepared, only what the last of them shows is prepared next.
    template <class Message>
    void prepare(const Message& planning_scene) {
        detail::WorldParts parts;
        if (!parts.read(robot_, planning_scene) || !parts.changes_objects()) return;
        const std::lock_guard<std::mutex> lock(preparing_mutex_);
        if (pending_) parts.follow(*pending_);
        pending_ = std::move(parts);
        if (is_preparing_) return;
        worker_ = std::async(std::launch::async, [this] { prepare_pending(); });
        is_preparing_ = true;
    }

    /// Waits for what is being prepared or made; what is only announced is dropped.
    ~StartFixer() {
        const std::lock_guard<std::mutex> lock(preparing_mutex_);
        pending_.reset();
    }

    /// The robot alone.
    const Scene& robot() const { return robot_; }

private:
    /// A scene, or the reason why there is none.
    struct Made {
        Scene scene;
        std::string error;
    };
    struct World {
        std::uint64_t digest;
        std::shared_future<Made> made;
    };
    /// The robot among objects, of which the next world is made.
    struct Objects {
        detail::WorldParts parts;
        Scene scene;
    };

    FixedStart fix_in(const detail::WorldParts& parts, const Positions& start, const FixLimits& limits) {
        const Made made = made_of(parts, limits.max_seconds).get();
        if (!made.scene) detail::refuse(made.error);
        if (!made.scene) return FixedStart();
        const auto began = std::chrono::steady_clock::now();
        FixedStart fixed = fix_start(made.scene, start, limits);
        if (last_status() != EXTRICATE_OK) return fixed;
        if (!detail::moves_only(limits.joints, fixed) && !description_.urdf.empty()) {
            const std::shared_ptr<StartFixer> locked = locked_fixer(start, limits);
            if (!locked->robot_) return FixedStart();
            FixLimits rest = limits;
            const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
            rest.max_seconds = std::max(1e-3, limits.max_seconds - spent.count());
            return locked->fix_in(parts, start, rest);
        }
        const std::vector<std::string> known = robot_.warnings();
        fixed.notes = parts.notes;
        for (const std::string& warning : made.scene.warnings())
            if (std::find(known.begin(), known.end(), warning) == known.end()) fixed.notes.push_back(warning);
        return fixed;
    }

    /// Finds the scene of a world, or begins to make it. Two are kept, because planners query the same ones again and
    /// again.
    std::shared_future<Made> made_of(const detail::WorldParts& parts, double max_seconds) {
        const std::uint64_t digest = parts.digest();
        const std::lock_guard<std::mutex> lock(mutex_);
        for (const World& world : worlds_)
            if (world.digest == digest) return world.made;
        const auto made = [this, parts, max_seconds] { return make(parts, max_seconds); };
        worlds_.push_front({digest, std::async(std::launch::async, made).share()});
        // A world that is dropped is waited for if it is still being made.
        if (worlds_.size() > 2) worlds_.pop_back();
        return worlds_.front().made;
    }

    Made make(const detail::WorldParts& parts, double max_seconds) {
        // What is being prepared already is not prepared twice, unless that takes longer than the start may.
        if (const std::shared_future<void> running = running_job(); running.valid())
            running.wait_for(std::chrono::duration<double>(std::min(std::max(0.0, max_seconds), 3600.0)));
        const Objects before = last_objects();
        Made made;
        const Scene objects = parts.objects(robot_, before.parts, before.scene);
        made.scene = objects && !parts.allowed.empty() ? objects.disabled(parts.allowed) : objects;
        if (!made.scene || !objects.prepare() || !made.scene.prepare()) return Made{Scene(), last_error()};
        keep(Objects{parts, objects});
        return made;
    }

    /// Prepares the announced scene, and those that are announced meanwhile.
    void prepare_pending() {
        for (;;) {
            std::packaged_task<void()> job;
            {
                const std::lock_guard<std::mutex> lock(preparing_mutex_);
                running_ = std::shared_future<void>();
                is_preparing_ = pending_.has_value();
                if (!is_preparing_) return;
                job = std::packaged_task<void()>(
                    [this, parts = std::move(*pending_)]() mutable { prepare_now(std::move(parts)); });
                pending_.reset();
                running_ = job.get_future().share();
            }
            // It keeps what is thrown. The first start in this world meets the same error, and reports it.
            job();
        }
    }
    void prepare_now(detail::WorldParts parts) {
        const Objects before = last_objects();
        parts.follow(before.parts);
        const Scene scene = parts.objects(robot_, before.parts, before.scene);
        if (scene && scene.prepare()) keep(Objects{std::move(parts), scene});
    }
    std::shared_future<void> running_job() {
        const std::lock_guard<std::mutex> lock(preparing_mutex_);
        return running_;
    }
    Objects last_objects() {
        const std::lock_guard<std::mutex> lock(objects_mutex_);
        return objects_;
    }
    void keep(Objects objects) {
        objects.parts.settle();
        const std::lock_guard<std::mutex> lock(objects_mutex_);
        objects_ = std::move(objects);
    }

    /// A fixer of the robot whose other joints stay where the start has them. The last one is kept, and serves while
    /// they do not move at all: what is proved for other positions is not proved for these.
    std::shared_ptr<StartFixer> locked_fixer(const Positions& start, const FixLimits& limits) {
        const std::map<std::string, std::size_t> known = detail::coordinates(robot_);
        Description description = description_;
        for (const auto& [joint, position] : start) {
            const bool may_move = std::find(limits.joints.begin(), limits.joints.end(), joint) != limits.joints.end();
            if (known.count(joint) && !may_move) description.locked.emplace_back(joint, position);
        }
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (locked_ && locked_->description_.locked == description.locked) return locked_;
        }
        const auto made = std::make_shared<StartFixer>(std::move(description));
        auto last = made;
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            // The last one may wait for its threads when it ends: not under the lock.
            std::swap(locked_, last);
        }
        return made;
    }

    Scene robot_;
    Description description_;
    std::mutex mutex_, objects_mutex_, preparing_mutex_;
    Objects objects_;
    std::shared_ptr<StartFixer> locked_;
    /// The scene to prepare next, and what is being prepared.
    std::optional<detail::WorldParts> pending_;
    std::shared_future<void> running_;
    bool is_preparing_ = false;
    // Last, so that their threads end before the rest does.
    std::deque<World> worlds_;
    std::future<void> worker_;
};

}  // namespace moveit
}  // namespace extricate

#endif
