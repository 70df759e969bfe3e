// The same headers without exceptions: what fails gives an empty object, and last_status() and last_error() say why.
#include <extricate_moveit.hpp>
#include <messages.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>

using extricate::Scene;
using extricate::Shape;
using extricate::Solver;

#define CHECK(condition)                                                         \
    do {                                                                         \
        if (!(condition)) {                                                      \
            std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                        \
        }                                                                        \
    } while (false)

/// Whether the last call failed with this status, and its own message has this part.
static bool failed(extricate::Status status, const char* part) {
    const std::string said = extricate::last_error();
    // An older message must not pass for that of the next call.
    extricate_refuse("an older failure");
    if (extricate::last_status() == status && said.find(part) != std::string::npos) return true;
    std::fprintf(stderr, "got status %d: %s\n", extricate::last_status(), said.c_str());
    return false;
}

static void rows(const Scene& scene) {
    const std::vector<double> seven(7, 0.1);
    const char* whole = "rows: got 7 numbers, expected whole configurations of 3";
    CHECK(scene.check(seven).empty() && failed(EXTRICATE_ARGUMENT, whole));
    CHECK(scene.distances(seven).empty() && failed(EXTRICATE_ARGUMENT, whole));
    CHECK(extricate::query_batch(scene, seven).summaries.empty() && failed(EXTRICATE_ARGUMENT, whole));
    CHECK(scene.rows_of(seven) == 0 && failed(EXTRICATE_ARGUMENT, whole));
    CHECK(Scene().check(seven).empty() && failed(EXTRICATE_ARGUMENT, "scene: got none"));

    const std::vector<double> bad = {0, 0, 0, 0, std::nan(""), 0};
    CHECK(scene.check(bad).empty() && failed(EXTRICATE_CONFIGURATION, "row 1"));
    CHECK(scene.distances(bad).empty() && failed(EXTRICATE_CONFIGURATION, "row 1"));
    const extricate::Batch batch = extricate::query_batch(scene, bad);
    CHECK(batch.witnesses.empty() && batch.summaries.empty() && failed(EXTRICATE_CONFIGURATION, "row 1"));

    const std::vector<double> none;
    CHECK(scene.check(none).empty() && extricate::last_status() == EXTRICATE_OK);
    CHECK(Scene().check(none).empty() && failed(EXTRICATE_ARGUMENT, "scene: got none"));
    CHECK(scene.check({0, 0, 0, 1, 1, 1}).size() == 2 && extricate::last_status() == EXTRICATE_OK);
}

static void configurations(const Scene& scene) {
    CHECK(scene.config({"a", "b"}, {1}).empty() && failed(EXTRICATE_ARGUMENT, "joints, positions: got 2 and 1"));
    CHECK(scene.config({"no such joint"}, {1}).empty() && failed(EXTRICATE_INPUT, "no such joint"));
    CHECK(scene.config_text("state.json", "{").empty() && failed(EXTRICATE_INPUT, "state.json"));
    CHECK(scene.config_text("state.json", std::string("{}\0", 3)).empty() && failed(EXTRICATE_ARGUMENT, "byte 2"));
    CHECK(std::isnan(scene.metric_distance({0, 0, 0}, {0, 0})) && failed(EXTRICATE_ARGUMENT, "from, to: got 3 and 2"));
    CHECK(Scene().limits().first.empty() && failed(EXTRICATE_ARGUMENT, "scene"));

    Solver solver(scene);
    CHECK(!solver.check_segment({0, 0, 0}, {0, 0}).is_free && failed(EXTRICATE_ARGUMENT, "from, to: got 3 and 2"));
    CHECK(!solver.check_segment({0, 0, 0}, {0, 0, 0}, -1).is_free && failed(EXTRICATE_ARGUMENT, "resolution"));
    CHECK(!solver.check({0}) && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(std::isnan(solver.distance({0})) && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(solver.pair_distances({0}).empty() && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(!solver.query({0.0}) && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(solver.query({0.4, 0.0, 0.0})->depth() > 0 && extricate::last_status() == EXTRICATE_OK);
    CHECK(!solver.warm_up(-1) && failed(EXTRICATE_ARGUMENT, "seconds"));

    extricate::Options wrong;
    wrong.effort = static_cast<extricate::Effort>(99);
    CHECK(!solver.set_options(wrong) && failed(EXTRICATE_ARGUMENT, "options.effort"));
    Solver bad(scene, wrong);
    CHECK(!bad && failed(EXTRICATE_ARGUMENT, "options.effort"));
    CHECK(!bad.query({0, 0, 0}) && failed(EXTRICATE_ARGUMENT, "solver: got a null pointer"));
    extricate::StreamOptions holding;
    holding.hysteresis = 2;
    extricate::Stream stream(scene, {}, holding);
    CHECK(!stream && failed(EXTRICATE_ARGUMENT, "hysteresis"));
    CHECK(!stream.query({0, 0, 0}) && failed(EXTRICATE_ARGUMENT, "stream: got a null pointer"));
    CHECK(!stream.restart() && failed(EXTRICATE_ARGUMENT, "stream: got a null pointer"));
    CHECK(!stream.set_scene(scene) && failed(EXTRICATE_ARGUMENT, "stream: got a null pointer"));
}

static void motions(const Scene& scene) {
    Solver solver(scene), none{Scene()};
    CHECK(!none && failed(EXTRICATE_ARGUMENT, "scene: got a null pointer"));
    const extricate::Escape escape = none.escape({0, 0, 0});
    CHECK(!escape && escape.points().empty() && escape.checks() == 0 && failed(EXTRICATE_ARGUMENT, "solver: got a null"));
    extricate::EscapeOptions wrong;
    wrong.tolerance = -1;
    CHECK(!solver.escape({0, 0, 0}, wrong) && failed(EXTRICATE_ARGUMENT, "options.tolerance: got -1"));
    CHECK(!solver.plan({0, 0, 0}, {0, 0}) && failed(EXTRICATE_ARGUMENT, "start, goal: got 3 and 2"));
    CHECK(!solver.plan({0, 0, 0}, {0, 0, std::nan("")}) && failed(EXTRICATE_CONFIGURATION, "goal: configuration: `joint_3`"));
    CHECK(!solver.repair({0, 0}) && failed(EXTRICATE_ARGUMENT, "rows: got 2 numbers"));
    CHECK(!solver.repair(std::vector<double>()) && failed(EXTRICATE_INPUT, "rows: got none"));
    CHECK(!solver.nearest_exit({0}) && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(solver.contacts({0, 0, 0}, std::nan("")).empty() && failed(EXTRICATE_ARGUMENT, "within"));
    CHECK(solver.colliding_pairs({0}).empty() && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(scene.sample(2, static_cast<extricate::Sample>(9)).empty() && failed(EXTRICATE_ARGUMENT, "kind: got 9"));
    CHECK(scene.always_colliding(0).empty() && failed(EXTRICATE_ARGUMENT, "samples"));
    CHECK(scene.poses({0, 0, 0}, {"no such link"}).empty() && failed(EXTRICATE_ARGUMENT, "no such link"));
    CHECK(scene.mesh(999).points.empty() && failed(EXTRICATE_ARGUMENT, "body: got 999"));
    CHECK(scene.robot_filter({0, 0}, {0, 0, 0}).empty() && failed(EXTRICATE_ARGUMENT, "points: got 2"));
    CHECK(scene.check_segments({0, 0, 0}, {0, 0, std::nan("")}).empty() && failed(EXTRICATE_CONFIGURATION, "to: row 0"));
    CHECK(scene.positions({0}).empty() && failed(EXTRICATE_CONFIGURATION, "expected 3"));
    CHECK(!extricate::Hand(scene, "none") && failed(EXTRICATE_INPUT, "none"));
    CHECK(!extricate::Roadmap::load("none.roadmap", scene) && failed(EXTRICATE_FILE, "none.roadmap"));
    extricate::LoadOptions limits;
    limits.limits = {{"trianglez", 1}};
    CHECK(!Scene("none.toml", limits) && failed(EXTRICATE_ARGUMENT, "trianglez"));
}

static void scenes(const Scene& scene) {
    const Scene none("none.toml");
    CHECK(!none && failed(EXTRICATE_FILE, "none.toml"));
    CHECK(!Solver(none) && failed(EXTRICATE_ARGUMENT, "scene"));
    CHECK(!Scene::builtin("none") && failed(EXTRICATE_INPUT, "none"));
    CHECK(!Scene::from_text(std::string("a\0b", 3)) && failed(EXTRICATE_ARGUMENT, "text: byte 1: got a zero"));
    CHECK(!Scene::from_text("", "", {{"r.urdf", std::string(1, '\0')}}) && failed(EXTRICATE_ARGUMENT, "r.urdf: byte 0"));
    CHECK(!scene.in_world_text("w.toml", std::string("\0", 1)) && failed(EXTRICATE_ARGUMENT, "text: byte 0"));
    CHECK(!scene.with_obstacles({{"cloud", Shape::points({1, 2, 3, 4}, 0.1)}}) &&
          failed(EXTRICATE_ARGUMENT, "obstacle \"cloud\": points: got 4 numbers, expected three each"));
    CHECK(!scene.with_obstacles({{"cells", Shape::voxels({1, 2}, 0.1)}}) && failed(EXTRICATE_ARGUMENT, "cells: got 2"));
    CHECK(!scene.attached({"can", Shape::mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2, 0})}, scene.bodies()[0]) &&
          failed(EXTRICATE_ARGUMENT, "triangles: got 4"));
    CHECK(!scene.moved({{"none", {}}}) && failed(EXTRICATE_INPUT, "none"));
    CHECK(!scene.learn(1000, 0) && failed(EXTRICATE_ARGUMENT, "seconds: got 0"));
    CHECK(!scene.save("none.model") && failed(EXTRICATE_ARGUMENT, "nothing was learned"));
}

static void starts(const Scene& scene) {
    using extricate::moveit::fix_start;
    extricate::moveit::FixLimits limits;
    const moveit_msgs::msg::PlanningScene world;
    moveit_msgs::msg::PlanningScene broken;
    broken.world.collision_objects.resize(1);
    broken.world.collision_objects[0].id = "ball";
    broken.world.collision_objects[0].primitives.resize(1);
    extricate::moveit::StartFixer fixer(scene), none{Scene()};
    extricate::moveit::Positions start, nowhere;
    for (const std::string& joint : scene.joints()) {
        start.emplace_back(joint, 0.0);
        nowhere.emplace_back(joint, std::nan(""));
    }
    const auto empty = [](const extricate::moveit::FixedStart& fixed) {
        return !fixed.fixed && fixed.summary.empty() && fixed.positions.empty();
    };
    CHECK(empty(fixer.fix(broken, start)) && failed(EXTRICATE_ARGUMENT, "type: got 0"));
    broken.world.collision_objects[0].primitives[0] = {shape_msgs::msg::SolidPrimitive::SPHERE, {-1.0}};
    CHECK(empty(fixer.fix(broken, start)) && failed(EXTRICATE_ARGUMENT, "-1"));
    CHECK(empty(fixer.fix(world, nowhere)) && failed(EXTRICATE_CONFIGURATION, scene.joints()[0].c_str()));
    CHECK(empty(none.fix(world, start)) && failed(EXTRICATE_ARGUMENT, "scene: got a null pointer"));
    CHECK(empty(fix_start(Scene(), start)) && failed(EXTRICATE_ARGUMENT, "scene"));
    limits.max_seconds = 0;
    CHECK(empty(fixer.fix(world, start, limits)) && failed(EXTRICATE_ARGUMENT, "max_seconds"));
    limits = {};
    limits.max_displacement = std::nan("");
    CHECK(empty(fixer.fix(world, start, limits)) && failed(EXTRICATE_ARGUMENT, "limits.max_displacement"));
    CHECK(fixer.fix(world, start).fixed && extricate::last_status() == EXTRICATE_OK);
}

int main() {
    const Scene scene = Scene::builtin("planar-arm");
    CHECK(scene && extricate::last_status() == EXTRICATE_OK);
    rows(scene);
    configurations(scene);
    motions(scene);
    scenes(scene);
    starts(scene);
}
