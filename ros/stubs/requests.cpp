// Runs both adapters on 200 planning requests against the stubs, with a planner that goes straight to the goal, and
// judges what comes out by a scene that is made of the same world without any message. The same requests are generated
// at every run.
//
//     requests FOLDER        of the built-in arm as files, with install/share linked to itself
//
// Prints a table, and fails if any request came out wrong.
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include <extricate_moveit.hpp>
#include <moveit_stub.hpp>

using extricate::Obstacle;
using extricate::Pose;
using extricate::Scene;
using extricate::Shape;
using extricate::Solver;
using planning_interface::MotionPlanRequest;
using planning_interface::MotionPlanResponse;
using planning_interface::PlanningRequestAdapter;
using planning_interface::PlanningResponseAdapter;
using rclcpp::ParameterValue;

namespace {

const double PI = std::acos(-1.0);
const std::size_t ARM_JOINTS = 7;

std::string read(const std::string& path) {
    std::ifstream file(path);
    if (!file.good()) throw std::runtime_error(path + ": cannot be read");
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Numbers that are the same on every machine (splitmix64).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double between(double lower, double upper) {
        std::uint64_t x = state_ += 0x9e3779b97f4a7c15ULL;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
        return lower + (upper - lower) * static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

/// One world in both forms: as a message, and as the judge's scene.
struct World {
    moveit_msgs::msg::PlanningScene message;
    Scene judge;
};

moveit_msgs::msg::CollisionObject object(const std::string& name, std::uint8_t type, std::vector<double> dimensions,
                                         double x, double y, double z) {
    moveit_msgs::msg::CollisionObject object;
    object.header.frame_id = "world";
    object.id = name;
    // Half of the pose is that of the object, half that of its shape.
    object.pose.position = {x / 2, y / 2, z / 2};
    object.primitives.push_back({type, std::move(dimensions)});
    object.primitive_poses.emplace_back().position = {x / 2, y / 2, z / 2};
    return object;
}

void add_box(World& world, const std::string& name, double a, double b, double c, double x, double y, double z) {
    world.message.world.collision_objects.push_back(
        object(name, shape_msgs::msg::SolidPrimitive::BOX, {a, b, c}, x, y, z));
    world.judge = world.judge.with_obstacles({Obstacle{name, Shape::box(a, b, c), Pose(x, y, z)}});
}

/// The shelf of the built-in scene.
World shelf(const Scene& robot) {
    World world{{}, robot};
    add_box(world, "table", 1.8, 1.6, 0.05, 0.3, 0, -0.03);
    add_box(world, "shelf_left", 0.3, 0.03, 0.9, 0.65, 0.4, 0.45);
    add_box(world, "shelf_right", 0.3, 0.03, 0.9, 0.65, -0.4, 0.45);
    add_box(world, "shelf_back", 0.03, 0.83, 0.9, 0.815, 0, 0.45);
    add_box(world, "board_low", 0.3, 0.77, 0.03, 0.65, 0, 0.15);
    add_box(world, "board_middle", 0.3, 0.77, 0.03, 0.65, 0, 0.5);
    add_box(world, "board_top", 0.3, 0.77, 0.03, 0.65, 0, 0.885);
    world.message.world.collision_objects.push_back(
        object("post", shape_msgs::msg::SolidPrimitive::CYLINDER, {1.2, 0.04}, -0.05, -0.5, 0.6));
    world.judge = world.judge.with_obstacles({Obstacle{"post", Shape::cylinder(0.04, 1.2), Pose(-0.05, -0.5, 0.6)}});
    // The base stands on the table.
    auto& matrix = world.message.allowed_collision_matrix;
    matrix.entry_names = {"base", "table"};
    matrix.entry_values = {{{false, true}}, {{true, false}}};
    world.judge = world.judge.disabled({{"base", "table"}});
    return world;
}

/// Writes occupied cells as the nodes of an octree, as octomap_msgs does: full as MoveIt sends it, or binary.
class OctomapWriter {
public:
    OctomapWriter(std::vector<std::array<std::int32_t, 3>> cells, bool is_binary)
        : cells_(std::move(cells)), is_binary_(is_binary) {
        for (auto& cell : cells_)
            for (std::int32_t& index : cell)
                index += 1 << 15;
        node(16, {0, 0, 0});
    }
    std::vector<std::int8_t> bytes;

private:
    bool holds(int level, const std::array<std::int32_t, 3>& first) const {
        for (const auto& cell : cells_) {
            bool is_inside = true;
            for (int k = 0; k < 3; ++k)
                is_inside = is_inside && cell[k] >> level == first[k] >> level;
            if (is_inside) return true;
        }
        return false;
    }
    void node(int level, const std::array<std::int32_t, 3>& first) {
        unsigned children = 0;
        std::array<std::array<std::int32_t, 3>, 8> corners;
        for (int index = 0; index < 8 && level > 0; ++index) {
            for (int k = 0; k < 3; ++k)
                corners[index][k] = first[k] + ((index >> k & 1) << (level - 1));
            if (holds(level - 1, corners[index])) children |= 1u << index;
        }
        if (is_binary_) {
            unsigned bits = 0;
            for (int index = 0; index < 8; ++index)
                if (children >> index & 1) bits |= (level == 1 ? 2u : 3u) << (2 * index);
            if (level == 0) return;
            bytes.push_back(static_cast<std::int8_t>(bits & 255));
            bytes.push_back(static_cast<std::int8_t>(bits >> 8));
        } else {
            const float log_odds = 3.5f;
            std::int8_t value[sizeof log_odds];
            std::memcpy(value, &log_odds, sizeof log_odds);
            bytes.insert(bytes.end(), value, value + sizeof log_odds);
            bytes.push_back(static_cast<std::int8_t>(children));
        }
        for (int index = 0; index < 8; ++index)
            if (children >> index & 1) node(level - 1, corners[index]);
    }
    std::vector<std::array<std::int32_t, 3>> cells_;
    bool is_binary_;
};

/// A wall of voxels before the arm.
World voxels(const Scene& robot, bool is_binary) {
    World world{{}, robot};
    add_box(world, "floor", 2, 2, 0.05, 0, 0, -0.03);
    world.message.allowed_collision_matrix.entry_names = {"base", "floor"};
    world.message.allowed_collision_matrix.entry_values = {{{false, true}}, {{true, false}}};
    std::vector<std::array<std::int32_t, 3>> cells;
    std::vector<std::int32_t> flat;
    for (std::int32_t y = -10; y < 10; ++y)
        for (std::int32_t z = 4; z < 16; ++z) {
            cells.push_back({9, y, z});
            flat.insert(flat.end(), {9, y, z});
        }
    auto& octomap = world.message.world.octomap;
    octomap.octomap.id = "OcTree";
    octomap.octomap.binary = is_binary;
    octomap.octomap.resolution = 0.05;
    octomap.octomap.data = OctomapWriter(cells, is_binary).bytes;
    octomap.origin.position.z = 0.02;
    world.judge = world.judge.with_obstacles({Obstacle{"wall", Shape::voxels(flat, 0.05), Pose(0, 0, 0.02)}})
                      .disabled({{"base", "floor"}});
    return world;
}

/// The shelf, and a can in the hand that may touch the gripper and the finger.
World with_can(const Scene& robot) {
    World world = shelf(robot);
    moveit_msgs::msg::AttachedCollisionObject can;
    can.link_name = "gripper";
    can.touch_links = {"gripper", "link_7", "finger"};
    can.object = object("can", shape_msgs::msg::SolidPrimitive::CYLINDER, {0.12, 0.03}, 0, 0, 0.15);
    can.object.header.frame_id = "gripper";
    world.message.robot_state.attached_collision_objects.push_back(can);
    world.judge = world.judge.attached(Obstacle{"can", Shape::cylinder(0.03, 0.12), Pose(0, 0, 0.15)}, "gripper",
                                       {"link_7", "finger"});
    return world;
}

/// A ring of 1,800 triangles around the arm, far below it.
World with_mesh(const Scene& robot) {
    World world = shelf(robot);
    constexpr std::uint32_t SIDES = 30;
    std::vector<double> corners;
    std::vector<std::uint32_t> triangles;
    auto& object = world.message.world.collision_objects.emplace_back();
    object.id = "ring";
    object.pose.position.z = -2;
    auto& mesh = object.meshes.emplace_back();
    object.mesh_poses.emplace_back();
    for (std::uint32_t k = 0; k < SIDES * SIDES; ++k) {
        const double around = 2 * PI * (k / SIDES) / SIDES, across = 2 * PI * (k % SIDES) / SIDES,
                     radius = 0.6 + 0.1 * std::cos(across);
        mesh.vertices.push_back({radius * std::cos(around), radius * std::sin(around), 0.1 * std::sin(across)});
        const std::uint32_t next = (k + SIDES) % (SIDES * SIDES), aside = k / SIDES * SIDES + (k + 1) % SIDES,
                            both = next / SIDES * SIDES + (k + 1) % SIDES;
        mesh.triangles.push_back({{k, next, both}});
        mesh.triangles.push_back({{k, both, aside}});
    }
    for (const auto& vertex : mesh.vertices)
        corners.insert(corners.end(), {vertex.x, vertex.y, vertex.z});
    for (const auto& triangle : mesh.triangles)
        triangles.insert(triangles.end(), triangle.vertex_indices.begin(), triangle.vertex_indices.end());
    world.judge = world.judge.with_obstacles({Obstacle{"ring", Shape::mesh(corners, triangles), Pose(0, 0, -2)}});
    return world;
}

/// Positions of the joints, in the order of the scene.
using Positions = std::vector<double>;

/// What a request is to come to.
enum class Expected { Unchanged, Moved, Kept };

struct Category {
    const char* name;
    std::size_t count, passed;
    double worst_ms;
};

class Bench {
public:
    explicit Bench(const std::string& folder) {
        setenv("AMENT_PREFIX_PATH", (folder + "/install").c_str(), 1);
        // A finger that is not in the group, and a last joint without limits.
        urdf_ = read(folder + "/robot/arm.urdf");
        replace("joint name=\"joint_7\" type=\"revolute\"", "joint name=\"joint_7\" type=\"continuous\"");
        replace("</robot>",
                "<link name='finger'><collision><origin xyz='0 0.03 0.12'/><geometry><box size='0.02 0.01 "
                "0.04'/></geometry></collision></link>"
                "<joint name='finger_joint' type='prismatic'><parent link='gripper'/><child link='finger'/><axis "
                "xyz='0 1 0'/>"
                "<limit lower='0' upper='0.04' effort='1' velocity='0.1'/></joint></robot>");
        robot_ = extricate::moveit::robot({urdf_, srdf_});
        auto model = std::make_shared<moveit::core::RobotModel>();
        joints_ = robot_.joints();
        const auto [lower, upper] = robot_.limits();
        lower_ = lower;
        upper_ = upper;
        for (std::size_t k = 0; k < joints_.size(); ++k) {
            auto& bounds = model->bounds[joints_[k]];
            bounds = {lower[k], upper[k], -1, 1, -2, 2, joints_[k] != "joint_7", true, true};
            if (k < ARM_JOINTS) model->groups["arm"].names.push_back(joints_[k]);
        }
        model_ = model;
    }

    const Scene& robot() const { return robot_; }

    /// A node whose description is a parameter, or on the topic if `by_topic`.
    rclcpp::Node::SharedPtr node(std::map<std::string, ParameterValue> overrides, const std::string& urdf,
                                 bool by_topic, bool declares = true) {
        if (!by_topic && !urdf.empty()) {
            overrides["robot_description"] = ParameterValue(urdf);
            overrides["robot_description_semantic"] = ParameterValue(srdf_);
        }
        auto node = std::make_shared<rclcpp::Node>(overrides, declares);
        if (by_topic) node->latched = {{"robot_description", urdf}, {"robot_description_semantic", srdf_}};
        return node;
    }

    const std::string& urdf() const { return urdf_; }

    /// Adapters of one pipeline.
    struct Pipeline {
        std::unique_ptr<PlanningRequestAdapter> request = make_adapter<PlanningRequestAdapter>();
        std::unique_ptr<PlanningResponseAdapter> response = make_adapter<PlanningResponseAdapter>();
    };
    Pipeline pipeline(const rclcpp::Node::SharedPtr& node) {
        Pipeline made;
        made.request->initialize(node, "ompl");
        made.response->initialize(node, "ompl");
        return made;
    }

    /// A start that is free by at least 2 mm, or that touches: on the way from a free configuration into a collision, 1
    /// to 10 mm deep. `beyond` puts a joint that far over its limit.
    Positions start(const World& world, bool is_free, double beyond = 0) {
        const Solver solver(world.judge);
        const auto drawn = [&] {
            Positions q;
            for (std::size_t k = 0; k < joints_.size(); ++k)
                q.push_back(random_.between(lower_[k], upper_[k]));
            if (beyond != 0) q[1] = upper_[1];
            return q;
        };
        for (int attempt = 0; attempt < 10000; ++attempt) {
            Positions q = drawn();
            if (solver.distance(q) < 2e-3) continue;
            if (!is_free) {
                const Positions into = drawn();
                const double wanted = random_.between(1e-3, 8e-3);
                Positions at = q;
                double depth = 0;
                for (int step = 1; step <= 2000 && depth < wanted; ++step) {
                    for (std::size_t k = 0; k < q.size(); ++k)
                        at[k] = q[k] + (into[k] - q[k]) * step / 2000;
                    depth = -solver.distance(at);
                }
                if (depth < wanted || depth > 1e-2) continue;
                q = at;
            }
            q[1] += beyond;
            return q;
        }
        throw std::runtime_error("no start was found");
    }

    void run(Category& category, Pipeline& pipeline, const World& world, const Positions& q, Expected expected,
             const std::string& warning = "", bool is_explicit = false) {
        ++category.count;
        auto scene = std::make_shared<planning_scene::PlanningScene>();
        scene->message = world.message;
        scene->current.model = model_;
        scene->current.names = joints_;
        scene->current.attached = world.message.robot_state.attached_collision_objects;
        for (std::size_t k = 0; k < joints_.size(); ++k)
            scene->current.positions[joints_[k]] = is_explicit ? 0.0 : q[k];
        MotionPlanRequest request;
        request.group_name = "arm";
        request.max_velocity_scaling_factor = 0.5;
        request.start_state.is_diff = true;
        if (is_explicit)
            for (std::size_t k = 0; k < joints_.size(); ++k) {
                request.start_state.joint_state.name.push_back(joints_[k]);
                request.start_state.joint_state.position.push_back(q[k]);
            }
        auto& goal = request.goal_constraints.emplace_back().joint_constraints;
        for (std::size_t k = 0; k < ARM_JOINTS; ++k)
            goal.push_back({joints_[k], 0.3});
        const MotionPlanRequest before = request;

        last_warning().clear();
        const auto began = std::chrono::steady_clock::now();
        const auto status = pipeline.request->adapt(scene, request);
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
        category.worst_ms = std::max(category.worst_ms, took.count());
        const std::string said = last_warning();
        MotionPlanResponse response = plan(*scene, request);
        const auto& first = response.trajectory->getFirstWayPoint().positions;
        pipeline.response->adapt(scene, request, response);

        std::string fault;
        const bool is_same = request.start_state.joint_state.position == before.start_state.joint_state.position &&
                             request.start_state.joint_state.name == before.start_state.joint_state.name;
        if (status.val != moveit_msgs::msg::MoveItErrorCodes::SUCCESS) fault = "the request was refused";
        if (expected != Expected::Moved) {
            if (!is_same) fault = "the start was changed";
            if (response.trajectory->getWayPointCount() != 2 ||
                response.trajectory->getFirstWayPoint().positions != first)
                fault = "the trajectory was changed";
            if (expected == Expected::Unchanged && !said.empty()) fault = "a warning about a free start";
            if (expected == Expected::Kept && said.find(warning) == std::string::npos)
                fault = "no warning with \"" + warning + "\"";
        } else {
            if (is_same) fault = "the start was not changed";
            if (fault.empty()) fault = fault_of(world, q, request, response);
        }
        if (fault.empty())
            ++category.passed;
        else
            std::fprintf(stderr, "%s, request %zu: %s (warning: %s)\n", category.name, category.count, fault.c_str(),
                         said.c_str());
    }

private:
    void replace(const std::string& old, const std::string& with) {
        const std::size_t at = urdf_.find(old);
        if (at == std::string::npos) throw std::runtime_error("arm.urdf: expected " + old);
        urdf_.replace(at, old.size(), with);
    }

    /// Goes straight from the start of a request to its goal, timed as MoveIt's own time parameterization begins: at
    /// rest, accelerating.
    MotionPlanResponse plan(const planning_scene::PlanningScene& scene, const MotionPlanRequest& request) const {
        moveit::core::RobotState state = scene.getCurrentState();
        moveit::core::robotStateMsgToRobotState(scene.getTransforms(), request.start_state, state);
        MotionPlanResponse response;
        response.trajectory = std::make_shared<robot_trajectory::RobotTrajectory>();
        state.zeroVelocities();
        for (const std::string& name : joints_)
            state.accelerations[name] = 0.7;
        response.trajectory->addSuffixWayPoint(state, 0.0);
        for (const auto& goal : request.goal_constraints[0].joint_constraints)
            state.setVariablePosition(goal.joint_name, goal.position);
        response.trajectory->addSuffixWayPoint(state, 3.0);
        return response;
    }

    Positions of(const moveit::core::RobotState& state) const {
        Positions q;
        for (const std::string& joint : joints_)
            q.push_back(state.getVariablePosition(joint));
        return q;
    }

    /// Why the answer to a colliding start is wrong; empty if it is right.
    std::string fault_of(const World& world, const Positions& q, const MotionPlanRequest& request,
                         const MotionPlanResponse& response) const {
        const Solver judge(world.judge);
        const auto& trajectory = *response.trajectory;
        const std::size_t points = trajectory.getWayPointCount();
        if (points < 3) return "no path was put before the trajectory";
        // Its first point is where the robot is; execution allows 0.01.
        const Positions first = of(trajectory.getWayPoint(0));
        for (std::size_t k = 0; k < first.size(); ++k)
            if (std::abs(std::remainder(first[k] - q[k], k == 6 ? 2 * PI : HUGE_VAL)) > 1e-12)
                return "the trajectory begins elsewhere than the robot is";
        if (first.back() != of(trajectory.getWayPoint(points - 1)).back()) return "a joint outside the group moves";
        // The planner's own part begins at the new start, which is free.
        Positions end;
        for (const std::string& joint : joints_)
            for (std::size_t k = 0; k < request.start_state.joint_state.name.size(); ++k)
                if (request.start_state.joint_state.name[k] == joint)
                    end.push_back(request.start_state.joint_state.position[k]);
        if (!judge.check(end)) return "the new start is not free";
        const Positions joined = of(trajectory.getWayPoint(points - 2));
        for (std::size_t k = 0; k < end.size(); ++k)
            if (std::abs(std::remainder(joined[k] - end[k], k == 6 ? 2 * PI : HUGE_VAL)) > 1e-9)
                return "the path ends elsewhere than the plan begins";

        const std::vector<double> deepest = judge.pair_distances(first);
        bool is_free = false;
        Positions from = first;
        for (std::size_t at = 1; at + 1 < points; ++at) {
            const Positions to = of(trajectory.getWayPoint(at));
            double longest = 0;
            for (std::size_t k = 0; k < to.size(); ++k)
                longest = std::max(longest, std::abs(to[k] - from[k]));
            const double seconds = trajectory.getWayPointDurationFromPrevious(at);
            if (!(seconds > 0) || longest * 1.5 > seconds * 0.5 + 1e-9)
                return "an edge is faster than its joints may be";
            for (const auto& [name, velocity] : trajectory.getWayPoint(at).velocities)
                if (velocity != 0 || trajectory.getWayPoint(at).accelerations.at(name) != 0)
                    return "a point of the path is not at rest";
            // Once an edge is proved free, the rest has to be.
            const bool is_within = within(from) && within(to);
            const bool is_proved = is_within && judge.check_segment(from, to).is_free;
            if (is_free && !is_proved) return "an edge after the free ones is not proved";
            is_free = is_proved;
            for (int step = 0; !is_proved && step <= 40; ++step) {
                Positions between = from;
                for (std::size_t k = 0; k < to.size(); ++k)
                    between[k] += (to[k] - from[k]) * step / 40;
                const std::vector<double> distances = judge.pair_distances(between);
                for (std::size_t pair = 0; pair < distances.size(); ++pair)
                    if (distances[pair] < std::min(deepest[pair] - 1e-3 - 1e-9, 1e-4))
                        return "a pair gets deeper by " + std::to_string(deepest[pair] - distances[pair]);
            }
            from = to;
        }
        return "";
    }

    bool within(const Positions& q) const {
        for (std::size_t k = 0; k < q.size(); ++k)
            if (k != 6 && (q[k] < lower_[k] || q[k] > upper_[k])) return false;
        return true;
    }

    std::string urdf_,
        srdf_ =
            "<robot name='seven-joint-arm'><disable_collisions link1='finger' link2='link_7' reason='Never'/></robot>";
    Scene robot_;
    moveit::core::RobotModelConstPtr model_;
    std::vector<std::string> joints_;
    std::vector<double> lower_, upper_;
    Random random_{2026};
};

int run(const std::string& folder) {
    Bench bench(folder);
    const std::map<std::string, ParameterValue> wide = {{"ompl.extricate.max_displacement", ParameterValue(2.0)},
                                                        {"ompl.extricate.max_seconds", ParameterValue(30.0)}};
    // As YAML has them without a decimal point.
    const std::map<std::string, ParameterValue> integers = {
        {"ompl.extricate.max_displacement", ParameterValue(std::int64_t{2})},
        {"ompl.extricate.max_seconds", ParameterValue(std::int64_t{30})}};
    auto usual = bench.pipeline(bench.node(wide, bench.urdf(), false));
    std::vector<World> worlds;
    worlds.push_back(shelf(bench.robot()));
    worlds.push_back(voxels(bench.robot(), false));
    worlds.push_back(voxels(bench.robot(), true));
    worlds.push_back(with_can(bench.robot()));
    std::vector<Category> table;
    const auto category = [&](const char* name) -> Category& { return table.emplace_back(Category{name, 0, 0, 0}); };
    table.reserve(20);

    Category& free = category("free");
    for (int k = 0; k < 60; ++k)
        bench.run(free, usual, worlds[k / 15], bench.start(worlds[k / 15], true), Expected::Unchanged, "", k % 2);
    Category& colliding = category("colliding with boxes");
    for (int k = 0; k < 45; ++k)
        bench.run(colliding, usual, worlds[0], bench.start(worlds[0], false), Expected::Moved, "", k % 2);
    Category& inside = category("inside voxels");
    for (int k = 0; k < 30; ++k)
        bench.run(inside, usual, worlds[1 + k / 15], bench.start(worlds[1 + k / 15], false), Expected::Moved);
    Category& held = category("with an object in the hand");
    for (int k = 0; k < 20; ++k)
        bench.run(held, usual, worlds[3], bench.start(worlds[3], false), Expected::Moved);
    Category& beyond = category("beyond a limit");
    for (int k = 0; k < 15; ++k)
        bench.run(beyond, usual, worlds[0], bench.start(worlds[0], k < 10, 0.002 * (k + 1)), Expected::Moved);

    Category& far = category("farther than allowed");
    auto careful = bench.pipeline(bench.node({{"ompl.extricate.max_displacement", ParameterValue(1e-6)},
                                              {"ompl.extricate.max_seconds", ParameterValue(30.0)}},
                                             bench.urdf(), false));
    for (int k = 0; k < 6; ++k)
        bench.run(far, careful, worlds[0], bench.start(worlds[0], false), Expected::Kept, "more than the");
    Category& topic = category("description by topic");
    auto by_topic = bench.pipeline(bench.node(integers, bench.urdf(), true));
    for (int k = 0; k < 6; ++k)
        bench.run(topic, by_topic, worlds[0], bench.start(worlds[0], false), Expected::Moved);
    Category& whole = category("integers as parameters");
    auto undeclared = bench.pipeline(bench.node(integers, bench.urdf(), false, false));
    for (int k = 0; k < 4; ++k)
        bench.run(whole, undeclared, worlds[0], bench.start(worlds[0], false), Expected::Moved);
    Category& none = category("no description");
    auto without = bench.pipeline(bench.node(wide, "", false));
    for (int k = 0; k < 4; ++k)
        bench.run(none, without, worlds[0], bench.start(worlds[0], k % 2), Expected::Kept, "robot_description");
    Category& broken = category("a mesh of the robot is missing");
    std::string lacking = bench.urdf();
    lacking.replace(lacking.find("link_3.stl"), 10, "nowhere.stl");
    auto unreadable = bench.pipeline(bench.node(wide, lacking, false));
    for (int k = 0; k < 5; ++k)
        bench.run(broken, unreadable, worlds[0], bench.start(worlds[0], k % 2), Expected::Kept, "nowhere.stl");
    Category& cut = category("an octomap that is cut off");
    World torn = worlds[1];
    torn.message.world.octomap.octomap.data.resize(99);
    for (int k = 0; k < 5; ++k)
        bench.run(cut, usual, torn, bench.start(worlds[1], k % 2), Expected::Kept, "octomap");

    // What a new world costs the first request in it. Those with meshes are announced, as the planning scene monitor
    // does.
    auto node = bench.node(wide, bench.urdf(), false);
    auto timed = bench.pipeline(node);
    Category ignored{"", 0, 0, 0};
    const Positions anywhere = bench.start(worlds[0], true);
    bench.run(ignored, timed, World{{}, bench.robot()}, anywhere, Expected::Unchanged);
    worlds.push_back(with_mesh(bench.robot()));
    const char* names[] = {"boxes", "a full octomap", "a binary octomap", "boxes and a held object",
                           "a mesh of 1,800 triangles"};
    std::printf("%-32s %10s %10s\n", "a world of", "first ms", "later ms");
    for (std::size_t k = 0; k < worlds.size(); ++k) {
        node->subscriptions.at("monitored_planning_scene")(&worlds[k].message);
        std::this_thread::sleep_for(std::chrono::seconds(k == 4 ? 3 : 0));
        Category first{"first", 0, 0, 0}, later{"later", 0, 0, 0};
        const Positions start = bench.start(worlds[k], true);
        bench.run(first, timed, worlds[k], start, Expected::Unchanged);
        bench.run(later, timed, worlds[k], start, Expected::Unchanged);
        std::printf("%-32s %10.1f %10.1f\n", names[k], first.worst_ms, later.worst_ms);
    }

    std::size_t count = 0, passed = 0;
    std::printf("%-32s %8s %8s %10s\n", "requests", "count", "passed", "worst ms");
    for (const Category& each : table) {
        std::printf("%-32s %8zu %8zu %10.1f\n", each.name, each.count, each.passed, each.worst_ms);
        count += each.count;
        passed += each.passed;
    }
    std::printf("%-32s %8zu %8zu\n", "all", count, passed);
    return count == 200 && passed == count ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: requests FOLDER\n"), 2;
    return run(argv[1]);
}
