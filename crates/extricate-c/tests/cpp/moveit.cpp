// Starts repaired from recorded messages of MoveIt, without MoveIt.
//
//     moveit FOLDER        with planning_scene.yaml and planning_scene.json
#include <extricate_moveit.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

using extricate::Scene;
using extricate::moveit::FixedStart;
using extricate::moveit::FixLimits;
using extricate::moveit::StartFixer;

#define CHECK(condition)                                                         \
    do {                                                                         \
        if (!(condition)) {                                                      \
            std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                        \
        }                                                                        \
    } while (false)

static std::string read(const std::string& path) {
    std::ifstream file(path);
    CHECK(file.good());
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

static std::string replaced(std::string text, const std::string& old, const std::string& with) {
    const std::size_t at = text.find(old);
    CHECK(at != std::string::npos);
    return text.replace(at, old.size(), with);
}

static double position(const FixedStart& start, const std::string& joint) {
    for (const auto& [name, value] : start.positions)
        if (name == joint) return value;
    CHECK(false);
    return 0;
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
    const std::string srdf =
        "<robot name='r'><disable_collisions link1='a' link2='c' reason='Never'/></robot>";
    const std::string world = R"({"world": {"collision_objects": []}})";
    StartFixer strict(extricate::moveit::robot(urdf, "", {"/some/\"folder\""}, "max-displacement"));
    const FixedStart apart = strict.fix(world, "w.json", {{"j", 0.0}, {"k", 0.0}, {"virtual/x", 1.0}});
    CHECK(apart.fixed && !apart.was_free && apart.colliding.size() == 1);
    CHECK(std::abs(apart.depth - 0.2001) < 1e-3 && std::abs(apart.max_displacement - apart.depth) < 1e-9);
    FixLimits limits;
    limits.joints = {"k"};
    const FixedStart along = strict.fix(world, "w.json", {{"j", 0.0}, {"k", 0.0}}, limits);
    CHECK(along.fixed && position(along, "j") == 0.0 && position(along, "k") >= 0.2);
    StartFixer allowed(extricate::moveit::robot(urdf, srdf, {}));
    CHECK(allowed.fix(world, "w.json", {{"j", 0.0}, {"k", 0.0}}).was_free);
    const FixedStart beyond = allowed.fix(world, "w.json", {{"j", 2.001}, {"k", 0.0}});
    CHECK(beyond.fixed && position(beyond, "j") <= 2.0 && beyond.outside == std::vector<std::string>{"j"});
}

/// A block that touches one side of a slot too narrow for the clearance that is aimed at: it stays in the slot.
static void narrow_places() {
    const std::string urdf =
        "<robot name='r'><link name='rail'/><link name='block'><collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision></link>"
        "<joint name='x' type='prismatic'><parent link='rail'/><child link='block'/><axis xyz='1 0 0'/>"
        "<limit lower='-2' upper='2' effort='1' velocity='1'/></joint></robot>";
    const auto wall = [](const char* name, const char* x) {
        return std::string("{\"id\": \"") + name + "\", \"header\": {\"frame_id\": \"rail\"}, \"operation\": 0, \"primitives\": "
               "[{\"type\": 1, \"dimensions\": [0.4, 2, 2]}], \"primitive_poses\": [{\"position\": {\"x\": " + x +
               ", \"y\": 0, \"z\": 0}, \"orientation\": {\"x\": 0, \"y\": 0, \"z\": 0, \"w\": 1}}]}";
    };
    const auto world = [](const std::string& walls) { return "{\"world\": {\"collision_objects\": [" + walls + "]}}"; };
    const std::string right = wall("right", "0.2509");
    StartFixer fixer(extricate::moveit::robot(urdf, "", {}));
    FixLimits limits;
    limits.clearance = 1e-3;
    limits.max_displacement = 1e-3;
    const FixedStart start = fixer.fix(world(right + ", " + wall("left", "-0.2509")), "w.json", {{"x", 0.00117}}, limits);
    CHECK(start.fixed && start.max_displacement < 1e-3 && start.clearance >= 1e-4 && start.clearance < 9e-4);
    // Beside one wall more is kept, farther than allowed; the scene's clearance is near.
    limits.clearance = 5e-3;
    const FixedStart beside = fixer.fix(world(right), "w.json", {{"x", 0.00117}}, limits);
    CHECK(beside.fixed && beside.max_displacement < 4e-4 && std::abs(beside.clearance - 1e-4) < 1e-12);
    limits.max_displacement = 1e-4;
    CHECK(!fixer.fix(world(right), "w.json", {{"x", 0.00117}}, limits).fixed);
}

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: moveit FOLDER\n"), 2;
    const std::string yaml = read(std::string(argv[1]) + "/planning_scene.yaml");
    const std::string json = read(std::string(argv[1]) + "/planning_scene.json");
    StartFixer fixer(Scene::builtin("shelf-arm"));

    const FixedStart start = fixer.fix(yaml, "planning_scene.yaml", yaml, "planning_scene.yaml");
    std::printf("%s\n", start.summary.c_str());
    CHECK(start.fixed && !start.was_free && !start.colliding.empty() && start.positions.size() == 7);
    CHECK(start.lower_bound > 0 && start.lower_bound <= start.depth && start.gap < 1 && start.max_displacement > 0);

    // The other format says the same; and by the names of joints, as an adapter has them.
    const FixedStart other = fixer.fix(json, "planning_scene.json", json, "planning_scene.json");
    CHECK(other.depth == start.depth && other.positions == start.positions);
    const extricate::moveit::Positions positions = {{"joint_1", 2.3}, {"joint_2", -1.7}, {"joint_3", 0}, {"joint_4", 0.7},
                                                    {"joint_5", 0},   {"joint_6", 2.0},  {"joint_7", 0}, {"world_joint/x", 1}};
    CHECK(fixer.fix(yaml, "planning_scene.yaml", positions).depth == start.depth);
    CHECK(fixer.fix(yaml, "planning_scene.yaml", start.positions).was_free);

    // The limit on displacement is kept, and the start then stays.
    FixLimits limits;
    limits.max_displacement = start.max_displacement / 2;
    const FixedStart far = fixer.fix(yaml, "planning_scene.yaml", positions, limits);
    CHECK(!far.fixed && position(far, "joint_2") == -1.7 && far.summary.find("more than the") != std::string::npos);

    // What the matrix allows is no collision; what is held moves with the hand.
    const std::string allowing = replaced(yaml, "  default_entry_names: []\n  default_entry_values: []",
                                          "  default_entry_names: [can, table]\n  default_entry_values: [true, true]");
    const FixedStart allowed = fixer.fix(allowing, "planning_scene.yaml", positions);
    CHECK(allowed.depth <= start.depth && allowed.colliding.size() <= start.colliding.size());
    bool is_held = false;
    const Scene world = Scene::builtin("shelf-arm").in_world_text("planning_scene.yaml", yaml);
    for (const std::string& body : world.bodies()) is_held = is_held || body == "can";
    CHECK(is_held);

    // Threads share one.
    std::vector<std::thread> threads;
    for (int k = 0; k < 4; ++k)
        threads.emplace_back([&] { CHECK(fixer.fix(yaml, "planning_scene.yaml", positions).depth == start.depth); });
    for (std::thread& thread : threads) thread.join();

    // What is wrong is named.
    try {
        fixer.fix(replaced(yaml, "frame_id: gripper", "frame_id: nowhere"), "planning_scene.yaml", positions);
        CHECK(false);
    } catch (const extricate::Error& error) {
        CHECK(std::string(error.what()).find("nowhere") != std::string::npos);
    }
    descriptions();
    narrow_places();
    std::puts("messages of MoveIt: passed");
}
