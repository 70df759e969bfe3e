// Starts repaired in the worlds of MoveIt's messages, without MoveIt.
//
//     moveit FOLDER        with planning_scene.yaml, planning_scene.json and octomaps.txt
#include <extricate_moveit.hpp>
#include <messages.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

using extricate::Obstacle;
using extricate::Scene;
using extricate::Solver;
using extricate::moveit::FixedStart;
using extricate::moveit::FixLimits;
using extricate::moveit::Positions;
using extricate::moveit::StartFixer;
using extricate::moveit::detail::WorldParts;
using moveit_msgs::msg::PlanningScene;
using shape_msgs::msg::SolidPrimitive;

#define CHECK(condition)                                                         \
    do {                                                                         \
        if (!(condition)) {                                                      \
            std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                        \
        }                                                                        \
    } while (false)

/// Checks that a call throws, and that the message contains a text.
template <class Call>
static void refused(Call call, const std::string& text) {
    try {
        call();
    } catch (const extricate::Error& error) {
        if (std::string(error.what()).find(text) == std::string::npos) std::fprintf(stderr, "%s\n", error.what());
        CHECK(std::string(error.what()).find(text) != std::string::npos);
        return;
    }
    std::fprintf(stderr, "expected an error with: %s\n", text.c_str());
    CHECK(false);
}

static std::string read(const std::string& path) {
    std::ifstream file(path);
    CHECK(file.good());
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

static double position(const FixedStart& start, const std::string& joint) {
    for (const auto& [name, value] : start.positions)
        if (name == joint) return value;
    CHECK(false);
    return 0;
}

static moveit_msgs::msg::CollisionObject primitive(const std::string& id, const std::string& frame, std::uint8_t type,
                                                   std::vector<double> sizes, double x, double y, double z) {
    moveit_msgs::msg::CollisionObject object;
    object.id = id;
    object.header.frame_id = frame;
    object.pose.position = {x, y, z};
    object.primitives.push_back({type, std::move(sizes)});
    object.primitive_poses.emplace_back();
    return object;
}

/// The structs of planning_scene.yaml: a table, and a can that the gripper holds.
static PlanningScene recorded() {
    PlanningScene scene;
    scene.world.collision_objects.push_back(
        primitive("table", "world", SolidPrimitive::BOX, {0.5, 1.0, 0.05}, 0.5, 0, 0.2));
    auto& can = scene.robot_state.attached_collision_objects.emplace_back();
    can.link_name = "gripper";
    can.object = primitive("can", "gripper", SolidPrimitive::CYLINDER, {0.12, 0.03}, 0, 0, 0.15);
    can.touch_links = {"gripper", "link_7"};
    scene.allowed_collision_matrix.entry_names = {"can", "table"};
    scene.allowed_collision_matrix.entry_values = {{{false, false}}, {{false, false}}};
    return scene;
}

static Scene in_world(const Scene& robot, const PlanningScene& message) {
    WorldParts parts;
    CHECK(parts.read(robot, message));
    const Scene world = parts.objects(robot, {}, {});
    return parts.allowed.empty() ? world : world.disabled(parts.allowed);
}

/// Structs and a text of the same message make the same scene.
static void structs_and_text(const std::string& folder, const std::string& name) {
    const Scene robot = Scene::builtin("shelf-arm");
    const Scene ours = in_world(robot, recorded()), theirs = robot.in_world_text(name, read(folder + "/" + name));
    CHECK(ours.bodies() == theirs.bodies() && ours.pair_count() == theirs.pair_count());
    std::vector<double> rows;
    for (int k = 0; k < 7 * 20; ++k)
        rows.push_back(std::sin(k * 1.7) * 1.5);
    CHECK(ours.distances(rows) == theirs.distances(rows));
}

static void repairs() {
    const PlanningScene message = recorded();
    StartFixer fixer(Scene::builtin("shelf-arm"));
    const Positions positions = {{"joint_1", 2.3}, {"joint_2", -1.7}, {"joint_3", 0}, {"joint_4", 0.7},
                                 {"joint_5", 0},   {"joint_6", 2.0},  {"joint_7", 0}, {"world_joint/x", 1}};
    // A limit of time would let the load of the machine decide.
    FixLimits limits;
    limits.max_seconds = HUGE_VAL;
    const FixedStart start = fixer.fix(message, positions, limits);
    std::printf("%s\n", start.summary.c_str());
    CHECK(start.fixed && !start.was_free && !start.colliding.empty() && start.positions.size() == 7);
    CHECK(start.depth > 0 && start.max_displacement > 0 && start.clearance >= 1e-4);
    // The path leads from the old start to the new one.
    CHECK(start.path.size() >= 2 && start.free_from < start.path.size());
    for (std::size_t k = 0; k < 7; ++k) {
        CHECK(start.path.front()[k] == positions[k].second && start.path.back()[k] == start.positions[k].second);
        CHECK(start.positions[k].first == positions[k].first);
    }
    const FixedStart again = fixer.fix(message, start.positions);
    CHECK(again.was_free && again.fixed && again.path.size() == 1 && again.positions == start.positions);

    // The limit on displacement is kept, and the start then stays.
    FixLimits near = limits;
    near.max_displacement = start.max_displacement / 2;
    const FixedStart far = fixer.fix(message, positions, near);
    CHECK(!far.fixed && position(far, "joint_2") == -1.7 && far.summary.find("more than the") != std::string::npos);

    // Threads share one fixer, and get the same answer.
    std::vector<std::thread> threads;
    for (int k = 0; k < 4; ++k)
        threads.emplace_back([&] { CHECK(fixer.fix(message, positions, limits).path == start.path); });
    for (std::thread& thread : threads)
        thread.join();

    // Objects that were announced make no difference.
    StartFixer other(Scene::builtin("shelf-arm"));
    other.prepare(message);
    CHECK(other.fix(message, positions, limits).colliding == start.colliding);
    // Neither do many that come at once, nor one that cannot be read or prepared, even if the fixer ends meanwhile.
    for (int k = 0; k < 100; ++k) {
        PlanningScene moved = recorded();
        moved.is_diff = k % 3 != 0;
        moved.world.collision_objects[0].pose.position.z += 0.001 * k;
        if (k == 50) moved.world.collision_objects[0].primitives[0].dimensions[0] = -1;
        other.prepare(moved);
    }
    CHECK(other.fix(message, positions, limits).colliding == start.colliding);
    other.prepare(message);
}

/// A difference keeps what it does not name, drops what it removes, and takes what it adds or attaches for the new one.
static void differences() {
    const Scene robot = Scene::builtin("shelf-arm");
    const auto after = [&](const PlanningScene& message, const WorldParts& before) {
        WorldParts parts;
        CHECK(parts.read(robot, message));
        parts.follow(before);
        std::vector<std::string> names;
        for (const Obstacle& obstacle : parts.obstacles)
            names.push_back(obstacle.name);
        for (const auto& each : parts.held)
            names.push_back("held " + each.object.name);
        std::sort(names.begin(), names.end());
        return names;
    };
    using Names = std::vector<std::string>;
    PlanningScene first = recorded(), next;
    first.world.collision_objects.push_back(primitive("two", "world", SolidPrimitive::SPHERE, {0.1}, 0, 1, 0.5));
    first.world.collision_objects[1].primitives.push_back({SolidPrimitive::SPHERE, {0.1}});
    first.world.collision_objects[1].primitive_poses.emplace_back();
    WorldParts before;
    CHECK(before.read(robot, first));
    CHECK(after(next, before) == Names());
    next.is_diff = true;
    CHECK(after(next, before) == Names({"held can", "table", "two-1", "two-2"}));
    next.world.collision_objects.push_back(primitive("two", "world", SolidPrimitive::SPHERE, {0.1}, 0, 0, 0.5));
    CHECK(after(next, before) == Names({"held can", "table", "two"}));
    next.world.collision_objects[0].operation = moveit_msgs::msg::CollisionObject::REMOVE;
    CHECK(after(next, before) == Names({"held can", "table"}));
    // What was held stands again.
    next.world.collision_objects[0] = primitive("can", "world", SolidPrimitive::SPHERE, {0.1}, 0, 0, 0.5);
    CHECK(after(next, before) == Names({"can", "table", "two-1", "two-2"}));
    // To remove an object without a name is to remove all of the world.
    next.world.collision_objects[0] = {};
    next.world.collision_objects[0].operation = moveit_msgs::msg::CollisionObject::REMOVE;
    CHECK(after(next, before) == Names({"held can"}));
}

/// A scene that is made of the one before equals one that is made from the beginning.
static void changes() {
    const Scene robot = Scene::builtin("shelf-arm");
    const auto parts_of = [&](const PlanningScene& message) {
        WorldParts parts;
        CHECK(parts.read(robot, message));
        return parts;
    };
    std::vector<PlanningScene> worlds(1, recorded());
    const auto next = [&]() -> PlanningScene& { return worlds.emplace_back(PlanningScene(worlds.back())); };
    worlds.reserve(20);
    next().world.collision_objects[0].pose.position.z += 0.1;
    next().world.collision_objects.push_back(primitive("ball", "world", SolidPrimitive::SPHERE, {0.1}, -0.3, 0.2, 0.6));
    next().world.collision_objects[1].primitives[0].dimensions[0] = 0.2;
    next().robot_state.attached_collision_objects[0].touch_links.clear();
    next().world.collision_objects.erase(worlds.back().world.collision_objects.begin());
    next().link_padding = {{"link_6", 0.02}};
    next().robot_state.attached_collision_objects[0].object.id = "ball";
    worlds.back().world.collision_objects.clear();
    next() = recorded();
    std::vector<double> rows;
    for (int k = 0; k < 7 * 20; ++k)
        rows.push_back(std::sin(k * 1.3) * 1.5);
    WorldParts before;
    Scene last;
    for (const PlanningScene& message : worlds) {
        const WorldParts parts = parts_of(message);
        const Scene changed = parts.objects(robot, before, last), fresh = parts.objects(robot, {}, {});
        std::vector<std::string> ours = changed.bodies(), theirs = fresh.bodies();
        std::sort(ours.begin(), ours.end());
        std::sort(theirs.begin(), theirs.end());
        CHECK(ours == theirs && changed.pair_count() == fresh.pair_count() &&
              changed.distances(rows) == fresh.distances(rows));
        CHECK(changed.check(rows) == fresh.check(rows));
        before = parts;
        last = changed;
    }
}

/// Everything that a scene is made of changes the digest.
static void digests() {
    const Scene robot = Scene::builtin("shelf-arm");
    std::set<std::uint64_t> seen;
    const auto is_new = [&](auto change) {
        PlanningScene message = recorded();
        change(message);
        WorldParts parts;
        CHECK(parts.read(robot, message));
        return seen.insert(parts.digest()).second;
    };
    CHECK(is_new([](PlanningScene&) {}) &&
          !is_new([](PlanningScene& m) { m.robot_state.joint_state.name = {"joint_1"}; }));
    CHECK(is_new([](PlanningScene& m) { m.world.collision_objects[0].primitives[0].dimensions[0] += 1e-9; }));
    CHECK(is_new([](PlanningScene& m) { m.world.collision_objects[0].id = "desk"; }));
    CHECK(is_new([](PlanningScene& m) { m.world.collision_objects.clear(); }));
    CHECK(is_new([](PlanningScene& m) { m.robot_state.attached_collision_objects.clear(); }));
    CHECK(is_new([](PlanningScene& m) { m.robot_state.attached_collision_objects[0].touch_links.pop_back(); }));
    CHECK(is_new([](PlanningScene& m) { m.allowed_collision_matrix.entry_values[0].enabled[1] = true; }));
    CHECK(is_new([](PlanningScene& m) { m.link_padding = {{"link_3", 0.01}}; }));
    CHECK(is_new([](PlanningScene& m) { m.link_padding = {{"link_3", 0.02}}; }));
}

static void objects() {
    const Scene robot = Scene::builtin("shelf-arm");
    const std::vector<double> q(7, 0.1);
    const auto distance = [&](const PlanningScene& message) { return Solver(in_world(robot, message)).distance(q); };
    const auto of = [&](const Obstacle& obstacle) {
        return Solver(robot.without_obstacles().with_obstacles({obstacle})).distance(q);
    };
    using extricate::Pose;
    using extricate::Shape;

    // Each shape, placed by the pose of its object and its own.
    const double half = std::sqrt(0.5);
    PlanningScene message;
    message.world.collision_objects.push_back(
        primitive("x", "world", SolidPrimitive::BOX, {0.1, 0.2, 0.3}, 0.4, 0.1, 0.6));
    auto& object = message.world.collision_objects[0];
    object.pose.orientation = {0, 0, half, half};
    object.primitive_poses[0].position = {0.1, 0, 0};
    CHECK(std::abs(distance(message) - of({"x", Shape::box(0.1, 0.2, 0.3), Pose(0.4, 0.2, 0.6, 0, 0, half, half)})) <
          1e-9);
    object.primitives[0] = {SolidPrimitive::SPHERE, {0.1}};
    CHECK(std::abs(distance(message) - of({"x", Shape::sphere(0.1), Pose(0.4, 0.2, 0.6)})) < 1e-9);
    object.primitives[0] = {SolidPrimitive::CYLINDER, {0.3, 0.1}};
    CHECK(std::abs(distance(message) - of({"x", Shape::cylinder(0.1, 0.3), Pose(0.4, 0.2, 0.6)})) < 1e-9);
    // A cone lies between the cylinder around it and half of it.
    object.primitives[0] = {SolidPrimitive::CONE, {0.3, 0.1}};
    CHECK(distance(message) >= of({"x", Shape::cylinder(0.1002, 0.3), Pose(0.4, 0.2, 0.6)}) - 1e-9);
    // A quaternion of zeros is no rotation.
    object.pose.orientation = {0, 0, 0, 0};
    object.primitives[0] = {SolidPrimitive::BOX, {0.1, 0.2, 0.3}};
    CHECK(std::abs(distance(message) - of({"x", Shape::box(0.1, 0.2, 0.3), Pose(0.5, 0.1, 0.6)})) < 1e-9);
    // Meshes and planes.
    object.primitives.clear();
    object.primitive_poses.clear();
    object.pose = {};
    object.meshes.push_back({{{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}},
                             {{0.4, 0, 0.6}, {0.5, 0, 0.6}, {0.4, 0.1, 0.6}, {0.4, 0, 0.7}}});
    CHECK(std::abs(distance(message) - of({"x", Shape::mesh({0.4, 0, 0.6, 0.5, 0, 0.6, 0.4, 0.1, 0.6, 0.4, 0, 0.7},
                                                            {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})})) < 1e-9);
    object.meshes.clear();
    object.planes.push_back({{0, 0, 2, 0.4}});
    CHECK(std::abs(distance(message) - of({"x", Shape::half_space(0, 0, 1, -0.2)})) < 1e-9);
    // What is removed is not there.
    object.operation = moveit_msgs::msg::CollisionObject::REMOVE;
    CHECK(in_world(robot, message).bodies() == robot.without_obstacles().bodies());

    // Two shapes of one object have names of their own, and a matrix that names the object means both.
    message = {};
    message.world.collision_objects.push_back(primitive("two", "world", SolidPrimitive::SPHERE, {0.1}, 0, 0, 0.5));
    message.world.collision_objects[0].primitives.push_back({SolidPrimitive::SPHERE, {0.1}});
    message.world.collision_objects[0].primitive_poses.emplace_back().position.z = 0.1;
    const std::size_t all = in_world(robot, message).pair_count();
    const std::vector<std::string> bodies = in_world(robot, message).bodies();
    CHECK(std::count(bodies.begin(), bodies.end(), "two-1") == 1 &&
          std::count(bodies.begin(), bodies.end(), "two-2") == 1);
    message.allowed_collision_matrix.entry_names = {"link_5", "two"};
    message.allowed_collision_matrix.entry_values = {{{false, true}}, {{true, false}}};
    CHECK(in_world(robot, message).pair_count() == all - 2);
    // A number that another object has as its name is left out, whichever comes first.
    for (const std::size_t at : {0, 1}) {
        PlanningScene alike;
        alike.world.collision_objects.push_back(message.world.collision_objects[0]);
        auto& all_objects = alike.world.collision_objects;
        all_objects.insert(all_objects.begin() + static_cast<std::ptrdiff_t>(at),
                           primitive("two-1", "world", SolidPrimitive::SPHERE, {0.1}, 0, 1, 0.5));
        WorldParts parts;
        CHECK(parts.read(robot, alike));
        std::set<std::string> names;
        for (const Obstacle& obstacle : parts.obstacles)
            names.insert(obstacle.name);
        CHECK(names == std::set<std::string>({"two-1", "two-2", "two-3"}));
    }
    // A default allows all of one name, unless an entry or another default forbids it.
    message.allowed_collision_matrix = {};
    message.allowed_collision_matrix.default_entry_names = {"two"};
    message.allowed_collision_matrix.default_entry_values = {true};
    const std::size_t none = in_world(robot, message).pair_count();
    CHECK(none < all && none == robot.without_obstacles().pair_count());
    message.allowed_collision_matrix.entry_names = {"link_5", "two"};
    message.allowed_collision_matrix.entry_values = {{{false, false}}, {{false, false}}};
    CHECK(in_world(robot, message).pair_count() == none + 2);
    message.allowed_collision_matrix.default_entry_names.push_back("link_4");
    message.allowed_collision_matrix.default_entry_values.push_back(false);
    CHECK(in_world(robot, message).pair_count() == none + 4);
    // Padding makes a link collide earlier.
    PlanningScene padded = recorded();
    padded.link_padding = {{"link_6", 0.02}, {"nobody", 0.1}, {"link_2", -0.1}};
    WorldParts parts;
    CHECK(parts.read(robot, padded) && parts.padding.size() == 1 && parts.notes.size() == 1);
    CHECK(in_world(robot, padded).bodies() == in_world(robot, recorded()).bodies());

    // The base of a mobile robot: the world is seen from it.
    message = {};
    message.world.collision_objects.push_back(primitive("x", "world", SolidPrimitive::SPHERE, {0.1}, 1.0, 2.4, 0.6));
    message.robot_state.multi_dof_joint_state.joint_names = {"virtual_joint"};
    message.robot_state.multi_dof_joint_state.transforms.push_back({{1.0, 2.0, 0.0}, {0, 0, half, half}});
    CHECK(std::abs(distance(message) - of({"x", Shape::sphere(0.1), Pose(0.4, 0, 0.6)})) < 1e-9);

    // An object may be in the frame of the root link, which moves with the base, or in one of the message's list.
    message.world.collision_objects[0] = primitive("x", "base", SolidPrimitive::SPHERE, {0.1}, 0.4, 0, 0.6);
    CHECK(std::abs(distance(message) - of({"x", Shape::sphere(0.1), Pose(0.4, 0, 0.6)})) < 1e-9);
    message.fixed_frame_transforms.push_back({{"world"}, "map", {{1.0, 2.0, 0.5}, {}}});
    message.world.collision_objects[0] = primitive("x", "map", SolidPrimitive::SPHERE, {0.1}, 0, 0.4, 0.1);
    CHECK(std::abs(distance(message) - of({"x", Shape::sphere(0.1), Pose(0.4, 0, 0.6)})) < 1e-9);

    // What is wrong is named.
    const auto broken = [&](auto change, const std::string& text) {
        PlanningScene wrong = recorded();
        change(wrong);
        refused([&] { in_world(robot, wrong); }, text);
    };
    broken([](PlanningScene& m) { m.world.collision_objects[0].primitives[0].type = 5; },
           "collision object \"table\": type: got 5");
    broken([](PlanningScene& m) { m.world.collision_objects[0].primitives[0].dimensions.pop_back(); },
           "dimensions: got 2 numbers, expected 3");
    broken([](PlanningScene& m) { m.world.collision_objects[0].primitive_poses.resize(3); },
           "got 1 primitives and 3 poses");
    broken([](PlanningScene& m) { m.world.collision_objects.push_back(m.world.collision_objects[0]); }, "table");
    broken([](PlanningScene& m) { m.world.collision_objects.push_back(primitive("x", "map", 2, {0.1}, 0, 0, 0)); },
           "got the frame \"map\" beside \"world\"");
    broken([](PlanningScene& m) { m.world.collision_objects.push_back(primitive("x", "base", 2, {0.1}, 0, 0, 0)); },
           "got the frame \"base\" beside \"world\"");
    broken([](PlanningScene& m) { m.world.collision_objects[0].header.frame_id = "link_3"; },
           "collision object \"table\": got the frame \"link_3\", a link of the robot");
    broken([](PlanningScene& m) { m.fixed_frame_transforms.push_back({{"odom"}, "map", {}}); },
           "collision object \"table\": got the frame \"world\" beside \"odom\"");
    broken([](PlanningScene& m) { m.fixed_frame_transforms = {{{"world"}, "map", {}}, {{"odom"}, "map", {}}}; },
           "fixed_frame_transforms: \"map\": got the frame \"odom\" beside \"world\"");
    broken([](PlanningScene& m) { m.robot_state.attached_collision_objects[0].object.header.frame_id = "base"; },
           "got the frame \"base\" beside \"gripper\"");
    broken([](PlanningScene& m) { m.robot_state.attached_collision_objects[0].link_name = "nowhere"; }, "nowhere");
    broken([](PlanningScene& m) { m.allowed_collision_matrix.entry_values.pop_back(); }, "got 2 names and 1 rows");
    broken([](PlanningScene& m) { m.allowed_collision_matrix.entry_values[1].enabled.pop_back(); },
           "table: got 1 values, expected 2");
    broken([](PlanningScene& m) { m.allowed_collision_matrix.default_entry_names = {"can"}; },
           "got 1 defaults and 0 values");
    broken(
        [](PlanningScene& m) {
            m.robot_state.multi_dof_joint_state.joint_names = {"joint_1"};
            m.robot_state.multi_dof_joint_state.transforms.emplace_back();
        },
        "multi_dof_joint_state: got \"joint_1\"");
}

/// Maps that OctoMap wrote, in all forms; cut off anywhere, they are refused.
static void octomaps(const std::string& text) {
    const Scene robot = Scene::builtin("shelf-arm");
    std::istringstream lines(text);
    int maps = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') continue;
        ++maps;
        PlanningScene message;
        auto& map = message.world.octomap.octomap;
        std::string bytes;
        std::istringstream(line) >> map.id >> map.binary >> bytes;
        map.resolution = 0.05;
        for (std::size_t k = 0; k < bytes.size(); k += 2)
            map.data.push_back(static_cast<std::int8_t>(std::stoi(bytes.substr(k, 2), nullptr, 16)));
        WorldParts parts;
        CHECK(parts.read(robot, message) && parts.obstacles.size() == 2);
        std::set<std::vector<std::int32_t>> fine;
        const ExtricateShape cells = parts.obstacles[0].raw().shape, leaf = parts.obstacles[1].raw().shape;
        for (std::size_t k = 0; k < cells.cell_count; ++k)
            fine.insert({cells.cells[3 * k], cells.cells[3 * k + 1], cells.cells[3 * k + 2]});
        CHECK(cells.cell_count == 32 && fine.size() == 32 && cells.size[0] == 0.05);
        for (std::int32_t y = -4; y < 4; ++y)
            for (std::int32_t z = 2; z < 6; ++z)
                CHECK(fine.count({9, y, z}));
        CHECK(leaf.cell_count == 1 && leaf.size[0] == 0.2 && leaf.cells[0] == -4 && leaf.cells[1] == 2 &&
              leaf.cells[2] == 0);
        CHECK(parts.obstacles[0].name == "<octomap>-1" &&
              in_world(robot, message).bodies().size() == robot.without_obstacles().bodies().size() + 2);
        // A matrix may allow contact with the map.
        message.allowed_collision_matrix.default_entry_names = {"<octomap>"};
        message.allowed_collision_matrix.default_entry_values = {true};
        CHECK(in_world(robot, message).pair_count() == robot.without_obstacles().pair_count());
        message.world.octomap.header.frame_id = "link_3";
        refused([&] { WorldParts().read(robot, message); }, "world.octomap: got the frame \"link_3\"");
        message.world.octomap.header.frame_id = "map";
        message.fixed_frame_transforms = {{{"world"}, "map", {{0, 0, 1}, {}}}};
        WorldParts raised;
        CHECK(raised.read(robot, message) && raised.obstacles[0].pose.position[2] == 1);
        const auto whole = map.data;
        for (std::size_t size = 1; size < whole.size(); ++size) {
            map.data.assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
            refused([&] { WorldParts().read(robot, message); },
                    "world.octomap: data: got " + std::to_string(size) + " bytes");
        }
        map.data = whole;
        map.data.push_back(0);
        refused([&] { WorldParts().read(robot, message); }, "expected the nodes of one tree");
        map.id = "CountingOcTree";
        refused([&] { WorldParts().read(robot, message); }, "id: got \"CountingOcTree\"");
    }
    CHECK(maps == 3);
}

/// A robot of two joints, as a robot description has it; its base may touch its second link by the SRDF.
static void descriptions() {
    const std::string urdf =
        "<robot name='r'><link name='a'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        "<link name='b'/><link name='c'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        "<joint name='j' type='prismatic'><parent link='a'/><child link='b'/><axis xyz='1 0 0'/>"
        "<limit lower='0' upper='2' effort='1' velocity='1'/></joint>"
        "<joint name='k' type='prismatic'><parent link='b'/><child link='c'/><axis xyz='0 1 0'/>"
        "<limit lower='0' upper='2' effort='1' velocity='1'/></joint></robot>";
    const std::string srdf = "<robot name='r'><disable_collisions link1='a' link2='c' reason='Never'/></robot>";
    const PlanningScene world;
    StartFixer strict({urdf, "", "max-displacement", {"/some/\"folder\""}});
    const FixedStart apart = strict.fix(world, {{"j", 0.0}, {"k", 0.0}, {"virtual/x", 1.0}});
    CHECK(apart.fixed && !apart.was_free && apart.colliding.size() == 1);
    // The aim is the clearance of the scene, 0.1 mm, and 1 mm.
    CHECK(std::abs(apart.depth - 0.2011) < 1e-3 && std::abs(apart.max_displacement - apart.depth) < 1e-9);
    // Joints that are not in the group stay, even if the nearest way would move them.
    for (const char* metric : {"joint", "max-displacement"}) {
        StartFixer fixer({urdf, "", metric});
        FixLimits limits;
        limits.joints = {"k"};
        limits.max_seconds = HUGE_VAL;
        const FixedStart along = fixer.fix(world, {{"j", 0.19}, {"k", 0.0}}, limits);
        CHECK(along.fixed && position(along, "j") == 0.19 && position(along, "k") > 0.05 && position(along, "k") < 0.1);
        // Without the description the robot cannot be locked, and the start stays.
        StartFixer bare(fixer.robot());
        const FixedStart not_locked = bare.fix(world, {{"j", 0.19}, {"k", 0.0}}, limits);
        CHECK(!not_locked.fixed && not_locked.summary.find("joints that have to stay") != std::string::npos);
        StartFixer described(fixer.robot(), {urdf, "", metric});
        CHECK(described.fix(world, {{"j", 0.19}, {"k", 0.0}}, limits).path == along.path);
    }
    StartFixer allowed({urdf, srdf, "joint", {}});
    CHECK(allowed.fix(world, {{"j", 0.0}, {"k", 0.0}}).was_free);
    // Beyond a limit the path leads straight back.
    const FixedStart beyond = allowed.fix(world, {{"j", 2.001}, {"k", 0.0}});
    CHECK(beyond.fixed && position(beyond, "j") == 2.0 && beyond.outside == std::vector<std::string>{"j"});
    CHECK(beyond.path.size() == 2 && beyond.path[0][0] == 2.001 && beyond.free_from == 1 &&
          std::abs(beyond.max_displacement - 1e-3) < 1e-6);
    FixLimits limits;
    limits.max_displacement = 5e-4;
    CHECK(!allowed.fix(world, {{"j", 2.001}, {"k", 0.0}}, limits).fixed);
    // Toward a goal: of two ways that are about as long, the one on its side.
    limits = {};
    limits.toward = {{"k", 1.0}};
    const FixedStart toward = strict.fix(world, {{"j", 0.01}, {"k", 0.01}}, limits);
    CHECK(toward.fixed && position(toward, "k") > position(toward, "j"));
}

/// A block that touches one side of a slot too narrow for the clearance that is aimed at: it stays in the slot.
static void narrow_places() {
    const std::string urdf =
        "<robot name='r'><link name='rail'/><link name='block'><collision><geometry><box size='0.1 0.1 "
        "0.1'/></geometry></collision></link>"
        "<joint name='x' type='prismatic'><parent link='rail'/><child link='block'/><axis xyz='1 0 0'/>"
        "<limit lower='-2' upper='2' effort='1' velocity='1'/></joint></robot>";
    PlanningScene slot, wall;
    wall.world.collision_objects.push_back(primitive("right", "rail", SolidPrimitive::BOX, {0.4, 2, 2}, 0.2509, 0, 0));
    slot = wall;
    slot.world.collision_objects.push_back(primitive("left", "rail", SolidPrimitive::BOX, {0.4, 2, 2}, -0.2509, 0, 0));
    StartFixer fixer({urdf, "", "joint", {}});
    FixLimits limits;
    limits.clearance = 1e-3;
    limits.max_displacement = 1e-3;
    const FixedStart start = fixer.fix(slot, {{"x", 0.00117}}, limits);
    CHECK(start.fixed && start.max_displacement < 1e-3 && start.clearance >= 1e-4 && start.clearance < 9e-4);
    // Beside one wall more is kept, farther than allowed; the scene's clearance is near.
    limits.clearance = 5e-3;
    const FixedStart beside = fixer.fix(wall, {{"x", 0.00117}}, limits);
    CHECK(beside.fixed && beside.max_displacement < 4e-4 && std::abs(beside.clearance - 1e-4) < 1e-5);
    limits.max_displacement = 1e-4;
    CHECK(!fixer.fix(wall, {{"x", 0.00117}}, limits).fixed);
}

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: moveit FOLDER\n"), 2;
    const std::string folder = argv[1];
    structs_and_text(folder, "planning_scene.yaml");
    structs_and_text(folder, "planning_scene.json");
    octomaps(read(folder + "/octomaps.txt"));
    objects();
    digests();
    changes();
    repairs();
    differences();
    descriptions();
    narrow_places();
    std::puts("messages of MoveIt: passed");
}
