// What extricate.hpp promises, on a scene file and queries, one a line, numbers between blanks.
//
//     interface SCENE QUERIES            checks everything, and prints depth, bound and witness of each
//                                        query as hexadecimal numbers, which scripts/check-c.sh compares
//                                        with those of `extricate query --json`; then the points of
//                                        each escape, of a plan and of a repair, a path a line
#if __has_include(<Eigen/Core>)
#define EXTRICATE_WITH_EIGEN
#endif
#include <extricate.hpp>

#include <array>
#include <atomic>
#include <cfenv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

using extricate::Answer;
using extricate::Options;
using extricate::Pose;
using extricate::Scene;
using extricate::Shape;
using extricate::Solver;
using Rows = std::vector<std::vector<double>>;

static int checks = 0;
#define CHECK(condition)                                                             \
    do {                                                                             \
        ++checks;                                                                    \
        if (!(condition)) {                                                          \
            std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);     \
            std::exit(1);                                                            \
        }                                                                            \
    } while (false)

/// The message of what `work` throws, and that its code is this one.
template <class Work>
static std::string refused(extricate::Status status, Work work) {
    try {
        work();
    } catch (const extricate::Error& error) {
        if (error.status() != status) std::fprintf(stderr, "status %d: %s\n", error.status(), error.what());
        CHECK(error.status() == status);
        CHECK(extricate::last_status() == status);
        return error.what();
    }
    std::fprintf(stderr, "nothing was refused\n");
    std::exit(1);
}

static bool contains(const std::string& text, const char* part) {
    if (text.find(part) != std::string::npos) return true;
    std::fprintf(stderr, "got: %s\n", text.c_str());
    return false;
}

static Rows read(const char* path) {
    Rows rows;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream numbers(line);
        rows.emplace_back(std::istream_iterator<double>(numbers), std::istream_iterator<double>());
    }
    return rows;
}

static bool same(const Answer& a, const Answer& b) {
    return std::memcmp(&a.summary(), &b.summary(), offsetof(ExtricateSummary, unique)) == 0 && a.config() == b.config();
}

static void print(const Answer& answer) {
    std::printf("%a %a", answer.depth(), answer.lower_bound());
    for (double x : answer.witness()) std::printf(" %a", x);
    std::printf("\n");
}

static void print(const extricate::Rows& points) {
    for (const auto& q : points)
        for (double x : q) std::printf("%a ", x);
    std::printf("\n");
}

/// Eight threads share one solver, which nobody has asked before; every answer is that of one thread.
static void threads_share(const Scene& scene, const Rows& rows, const std::vector<Answer>& answers) {
    std::atomic<int> equal{0};
    const Solver solver(scene.without({}));
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 8; ++thread) {
        threads.emplace_back([&, thread] {
            for (std::size_t k = 0; k < rows.size(); ++k) {
                const std::size_t at = (k + 3 * static_cast<std::size_t>(thread)) % rows.size();
                equal += same(*solver.query(rows[at]), answers[at]) && solver.check(answers[at].witness());
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK(equal == 8 * static_cast<int>(rows.size()));
}

static void batches(const Scene& scene, const Rows& rows, const std::vector<Answer>& answers) {
    std::vector<double> flat;
    for (const auto& q : rows) flat.insert(flat.end(), q.begin(), q.end());
    const extricate::Batch batch = extricate::query_batch(scene, flat, Options(), 2);
    const std::vector<bool> free = scene.check(batch.witnesses, 2);
    const std::vector<double> distances = scene.distances(batch.witnesses);
    Solver solver(scene);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        CHECK(batch.summaries[k].depth == answers[k].depth() && batch.summaries[k].found);
        CHECK(std::equal(answers[k].witness().begin(), answers[k].witness().end(), &batch.witnesses[k * scene.nq()]));
        CHECK(free[k] && distances[k] >= scene.clearance() * (1 - 1e-9));
        CHECK(solver.distance(answers[k].witness()) == distances[k]);
        const double measured = scene.metric_distance(rows[k], answers[k].witness());
        CHECK(std::abs(measured - answers[k].depth()) <= 1e-9 * (1 + measured));
    }
    flat.back() = std::nan("");
    CHECK(contains(refused(EXTRICATE_CONFIGURATION, [&] { return extricate::query_batch(scene, flat); }), "row"));
    flat.pop_back();
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return extricate::query_batch(scene, flat); }), "whole configurations"));
}

static void options(const Scene& scene, const std::vector<double>& q) {
    Options wanted;
    wanted.exits = 3;
    wanted.segment = wanted.free_radius = true;
    Solver solver(scene, wanted);
    const Answer answer = *solver.query(q);
    CHECK(!answer.exits().empty() && answer.exits()[0].depth == answer.depth());
    CHECK(std::equal(answer.witness().begin(), answer.witness().end(), answer.exits()[0].witness));
    CHECK(answer.summary().segment_free_from > 0 && answer.summary().free_radius >= 0);
    CHECK(!answer.colliding().empty() && answer.verified() && answer.lower_bound() <= answer.depth());
    CHECK(!scene.names(answer.colliding()[0]).first.empty() && answer.gradient().size() == scene.nv());

    Options proved;
    proved.effort = extricate::Effort::proved;
    proved.gap = 0.5;
    CHECK(solver.set_options(proved));
    CHECK(solver.query(q)->gap() <= 1);
    const std::vector<double> witness = *solver.nearest_exit(q);
    CHECK(witness.size() == q.size() && solver.check(witness) && solver.nearest_exit(witness) == witness);

    Options locked;
    locked.locked = {scene.joints()[0]};
    CHECK(solver.set_options(locked));
    if (const auto kept = solver.query(q)) CHECK(kept->witness()[0] == q[0]);
    locked.locked = {"no such joint"};
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return solver.set_options(locked); }), "no such joint"));

    Options toward;
    toward.toward = answer.config();
    CHECK(solver.set_options(toward) && solver.query(q));
    toward.toward.pop_back();
    CHECK(contains(refused(EXTRICATE_CONFIGURATION, [&] { return solver.set_options(toward); }), "coordinates"));

    int asked = 0;
    Options stopped;
    stopped.stop = [&asked] { return ++asked > 1; };
    CHECK(solver.set_options(stopped));
    (void)solver.query(q);
    CHECK(asked > 0);

    Options wrong;
    wrong.gap = 2;
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { Solver(scene, wrong); }), "options.gap: got 2"));
    CHECK(solver.warm_up(0.001));

    const std::vector<double> short_q(q.begin(), q.end() - 1);
    CHECK(contains(refused(EXTRICATE_CONFIGURATION, [&] { return solver.query(short_q); }), "expected"));
    std::vector<double> beyond = q;
    beyond[0] = scene.limits().second[0] + 0.01;
    Solver usual(scene);
    CHECK(usual.query(beyond)->outside().size() == 1 && !usual.check(beyond));
    Options strict;
    strict.refuse_outside = true;
    CHECK(contains(refused(EXTRICATE_CONFIGURATION, [&] { return Solver(scene, strict).query(beyond); }), "within"));
}

static void streams(const Scene& scene, const std::vector<double>& q) {
    extricate::Stream stream(scene);
    const Answer first = *stream.query(q), second = *stream.query(q);
    CHECK(second.depth() <= first.depth() * (1 + 1e-12));
    CHECK(stream.restart() && same(*stream.query(q), first));
    CHECK(stream.set_scene(scene.without_obstacles()) && stream.query(q));
    extricate::StreamOptions holding;
    holding.hysteresis = 1;
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { extricate::Stream(scene, Options(), holding); }), "hysteresis: got 1"));
    extricate::StreamOptions proxy;
    proxy.continuous = true;
    extricate::Stream gliding(scene, Options(), proxy);
    const Answer frame = *gliding.query(q);
    CHECK(frame.nearest() >= 0 && frame.nearest() <= frame.depth() && !frame.detour() && std::isnan(first.nearest()));
    Options several;
    several.exits = 3;
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { extricate::Stream(scene, several); }), "options.exits: got 3"));
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return stream.set_scene(Scene::builtin("planar-arm")); }), "coordinates"));
}

/// Whether some body overlaps the one of this name at `q`.
static bool overlaps(const Scene& scene, const std::vector<double>& q, const char* name) {
    Solver solver(scene);
    const std::vector<double> distances = solver.pair_distances(q);
    for (std::size_t k = 0; k < distances.size(); ++k) {
        const auto [first, second] = scene.names(extricate_scene_pair(scene.get(), k));
        if ((first == name || second == name) && distances[k] < 0) return true;
    }
    return false;
}

static void worlds(const Scene& scene, const std::vector<double>& q) {
    const Scene empty = scene.without_obstacles();
    const Scene ball = empty.with_obstacles({{"ball", Shape::sphere(0.5), Pose(0.0, 0.0, 0.4)}});
    CHECK(ball.bodies().size() == empty.bodies().size() + 1 && ball.pair_count() > empty.pair_count());
    CHECK(overlaps(ball, q, "ball"));
    CHECK(!overlaps(ball.moved({{"ball", Pose(0, 0, 9)}}), q, "ball"));
    CHECK(ball.without({"ball"}).pair_count() == empty.pair_count());
    const std::string link = empty.bodies().back();
    CHECK(ball.disabled({{link, "ball"}}).pair_count() + 1 == ball.pair_count());
    const Scene held = ball.attached({"can", Shape::cylinder(0.03, 0.1), Pose(0, 0, 0.1)}, link, {"ball"});
    CHECK(held.bodies().back() == "can" && held.pair_count() > ball.pair_count());
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return ball.attached({"can", Shape::sphere(0.1)}, "no link"); }), "no link"));
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return ball.moved({{"bal", Pose()}}); }), "ball"));
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return ball.moved({{"ball", Pose(0, 0, 0, 0, 0, 0, 2)}}); }), "quaternion"));

    const std::vector<double> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<std::uint32_t> triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const Scene many = empty.with_obstacles({{"wedge", Shape::mesh(corners, triangles)},
                                             {"hull", Shape::mesh(corners, triangles, true), Pose(3, 0, 0)},
                                             {"cloud", Shape::points({1, 1, 1, 2, 2, 2}, 0.1)},
                                             {"cells", Shape::voxels({1, 2, 3}, 0.1)},
                                             {"floor", Shape::half_space(0, 0, 1, -5)},
                                             {"box", Shape::box(1, 2, 3), Pose(5, 0, 0)},
                                             {"pill", Shape::capsule(0.1, 1), Pose(7, 0, 0)}});
    CHECK(many.bodies().size() == empty.bodies().size() + 7);
    const auto broken = [&] { return empty.with_obstacles({{"wedge", Shape::mesh(corners, {0, 1, 9})}}); };
    CHECK(contains(refused(EXTRICATE_INPUT, broken), "wedge"));

    const std::string world = "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.2 }\npose = { xyz = [0.5, 0, 0.5] }\n";
    const Scene told = scene.in_world_text("world.toml", world);
    Solver here(empty.with_obstacles({{"ball", Shape::sphere(0.2), Pose(0.5, 0.0, 0.5)}})), there(told);
    CHECK(same(*here.query(q), *there.query(q)));
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return scene.in_world_text("world.toml", "x = 1"); }), "world.toml"));
    CHECK(contains(refused(EXTRICATE_FILE, [&] { return scene.in_world("none.scene"); }), "none.scene"));

#ifdef EXTRICATE_WITH_EIGEN
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.translation() << 0, 0, 9;
    place.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
    CHECK(!overlaps(ball.moved({{"ball", place}}), q, "ball"));
    const Eigen::VectorXd vector = Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size()));
    const Answer answer = *here.query(vector);
    CHECK(answer.vector().size() == vector.size() && answer.vector()[0] == answer.witness()[0]);
#endif
}

static bool same(const extricate::Rows& a, const extricate::Rows& b) {
    return a.size() == b.size() && a.nq() == b.nq() && std::equal(a.data(), a.data() + a.size() * a.nq(), b.data());
}

/// Escapes, plans and repairs: all edges are proved, and threads that share a solver get the same.
static void motions(const Scene& scene, const Rows& rows, const std::vector<Answer>& answers, const std::string& folder) {
    const Solver solver(scene);
    std::size_t found = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const extricate::Escape escape = solver.escape(rows[k]);
        CHECK(!escape.colliding().empty() && escape.colliding()[0].distance < scene.clearance() && escape.checks() > 0);
        CHECK(!escape || std::isnan(escape.needed_tolerance()));
        if (!escape) continue;
        ++found;
        CHECK(escape.points().nq() == scene.nq() && escape.free_from() < escape.points().size());
        CHECK(std::equal(rows[k].begin(), rows[k].end(), escape.points().front().begin()));
        CHECK(solver.check(escape.points().back()) && escape.deepening() <= 1e-3 && escape.length() > 0);
        CHECK(escape.method() != extricate::EscapeMethod::none && escape.method() != extricate::EscapeMethod::free);
        for (std::size_t at = escape.free_from(); at + 1 < escape.points().size(); ++at)
            CHECK(solver.check_segment(escape.points()[at], escape.points()[at + 1]).is_free);
    }
    CHECK(found > 0);
    const auto witness = answers[0].witness();
    const extricate::Escape none = solver.escape(witness);
    CHECK(none && none.method() == extricate::EscapeMethod::free && none.points().size() == 1);
    extricate::EscapeOptions hurried;
    hurried.stop = [] { return true; };
    hurried.toward = answers[1].config();
    CHECK(!solver.escape(rows[0], hurried));

    // The witnesses touch, so that a plan begins a little beside them.
    const std::vector<double> free = scene.sample(2, extricate::Sample::free, 3);
    const std::size_t nq = scene.nq();
    const extricate::Config start(free.data(), nq), goal(free.data() + nq, nq);
    extricate::Roadmap roadmap(scene, 1);
    CHECK(roadmap && roadmap.size() == 0);
    const extricate::Plan plan = solver.plan(start, goal), colliding = solver.plan(rows[0], goal, roadmap);
    CHECK(plan && plan.free_from() == 0 && plan.free_to() + 1 == plan.points().size() && !plan.start_escape());
    CHECK(plan.method() != extricate::PlanMethod::none && plan.checks() > 0 && plan.length() > 0);
    for (std::size_t at = 0; at + 1 < plan.points().size(); ++at)
        CHECK(solver.check_segment(plan.points()[at], plan.points()[at + 1]).is_free);
    CHECK(colliding.start_escape() && !colliding.goal_escape());
    CHECK(colliding ? colliding.free_from() > 0 : !*colliding.start_escape());
    CHECK(roadmap.save(folder + "/arm.roadmap"));
    CHECK(extricate::Roadmap::load(folder + "/arm.roadmap", scene).size() == roadmap.size());
    extricate::PlanOptions few;
    few.threads = 5000;
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return solver.plan(start, goal, few); }), "options.threads: got 5000"));

    extricate::PlanOptions held;
    held.keep = "gripper";
    CHECK(contains(refused(EXTRICATE_CONFIGURATION, [&] { return solver.plan(start, goal, held); }), "goal: kept link `gripper`"));
    held.keep = R"({"link": "gripper", "position": 10, "rotation": 4})";
    CHECK(solver.plan(start, goal, held));
    extricate::EscapeOptions gripping;
    gripping.keep = R"({"link": "gripper", "axis": [0, 0, 1], "position": null, "rotation": 0.3})";
    CHECK(solver.escape(rows[0], gripping) || solver.escape(rows[1], gripping) || solver.escape(rows[2], gripping));
    extricate::RepairOptions nowhere;
    nowhere.keep = "elbow";
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return solver.repair(free, nowhere); }), "elbow"));

    // A straight path through obstacles.
    std::vector<double> path(free);
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(nq), rows[0].begin(), rows[0].end());
    const extricate::Repaired repaired = solver.repair(path);
    if (repaired) {
        CHECK(repaired.places().size() == repaired.points().size() && repaired.deviation() > 0);
        CHECK(repaired.stretches() > 0 && repaired.length_before() > 0 && repaired.places()[0] == 0);
        for (std::size_t at = 0; at + 1 < repaired.points().size(); ++at)
            CHECK(solver.check_segment(repaired.points()[at], repaired.points()[at + 1]).is_free);
        CHECK(same(solver.repair(repaired.points()).points(), repaired.points()));
    }
    extricate::RepairOptions slow;
    slow.max_step = 0.1;
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return solver.repair(path, slow); }), "options.max_step"));

    const extricate::Escape alone = solver.escape(rows[0]);
    std::atomic<int> equal{0};
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 8; ++thread)
        threads.emplace_back([&] {
            equal += same(solver.escape(rows[0]).points(), alone.points()) && same(solver.plan(start, goal).points(), plan.points());
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(equal == 8);
}

static void geometry(const Scene& scene, const Rows& rows, const std::vector<Answer>& answers) {
    const Solver solver(scene);
    const std::vector<ExtricatePair> colliding = solver.colliding_pairs(rows[0]);
    CHECK(colliding.size() == answers[0].colliding().size() && colliding[0].first == answers[0].colliding()[0].first);
    CHECK(solver.colliding_pairs(answers[0].witness()).empty() && scene.pairs().size() == scene.pair_count());
    const std::vector<ExtricateContact> near = solver.contacts(rows[0], 0.05);
    CHECK(near.size() >= colliding.size());
    for (const ExtricateContact& contact : near) CHECK(contact.distance < 0.05 && contact.pair.first < contact.pair.second);
    const std::vector<extricate::DistanceRow> rows_near = solver.distance_rows(rows[0], 0.05);
    CHECK(!rows_near.empty() && rows_near.size() <= near.size());
    for (const extricate::DistanceRow& row : rows_near) CHECK(row.gradient.size() == scene.nv() && row.contact.distance < 0.05);
    CHECK(scene.always_colliding().empty());
    const std::vector<extricate::SignedDistance> signed_distances = solver.signed_distances(rows[0]);
    CHECK(signed_distances.size() == 1 && signed_distances[0].numbers.distance == -answers[0].depth());
    const auto nearest = answers[0].witness();
    CHECK(std::equal(nearest.begin(), nearest.end(), signed_distances[0].witness.begin(), signed_distances[0].witness.end()));
    CHECK(signed_distances[0].gradient.size() == scene.nv());
    CHECK(solver.free_radius(rows[0]) == 0);
    const std::vector<double> apart = scene.sample(2, extricate::Sample::free, 7);
    for (const extricate::SignedDistance& found : solver.signed_distances(apart)) {
        CHECK(found.numbers.distance > 0 && found.numbers.bound > 0 && found.numbers.bound <= found.numbers.distance);
        CHECK(solver.check(found.witness) && found.numbers.pair.first < found.numbers.pair.second);
    }
    const extricate::Config first(apart.data(), scene.nq());
    const double radius = solver.free_radius(first);
    CHECK(radius > 0 && std::isinf(solver.signed_distances(first, 0.5 * radius)[0].numbers.distance));
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return solver.signed_distances(first, -1); }), "within"));
    const std::vector<double> any = scene.sample(3, extricate::Sample::any, 7);
    const std::vector<double> hits = scene.sample(5, extricate::Sample::colliding, 7);
    CHECK(any.size() == 3 * scene.nq() && any == scene.sample(3, extricate::Sample::any, 7));
    for (bool free : scene.check(hits)) CHECK(!free);
    for (bool free : scene.check(scene.sample(5, extricate::Sample::free, 7))) CHECK(free);

    const std::vector<ExtricateSegment> segments = scene.check_segments(any, any);
    const ExtricateSegment one = solver.check_segment(extricate::Config(any.data(), scene.nq()), extricate::Config(any.data(), scene.nq()));
    CHECK(segments.size() == 3 && segments[0].is_free == one.is_free);

    const extricate::Positions positions = scene.positions(rows[0]);
    CHECK(positions.size() >= scene.joints().size() && positions[0].first == scene.joints()[0]);
    CHECK(scene.config(positions) == rows[0]);
    const Scene floating = Scene::builtin("free-box");
    std::vector<double> q = floating.sample(1);
    CHECK(floating.config(floating.positions(q)).size() == q.size() && floating.nq() > floating.joints().size());
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] {
        double out[7];
        const double values[1] = {0};
        const char* name = "base";
        const std::size_t size = 9;
        extricate::detail::succeeded(extricate_scene_config(floating.get(), &name, &size, 1, values, 1, out, 7));
    }), "position_count: got 1"));

    const auto poses = scene.poses(rows[0]);
    CHECK(poses.size() == scene.bodies().size() && poses[0][15] == 1 && poses[0][12] == 0);
    CHECK(scene.poses(any, {scene.bodies()[0]}).size() == 3 && scene.poses(any, {scene.bodies()[0]})[0].size() == 16);
    const extricate::Mesh mesh = scene.mesh(scene.bodies().size() - 1);
    CHECK(!mesh.points.empty() && mesh.points.size() % 3 == 0 && mesh.triangles.size() % 3 == 0);
    for (std::uint32_t corner : mesh.triangles) CHECK(corner < mesh.points.size() / 3);
    // The origin of a moving link lies in it or beside it; a point far away does not.
    const std::vector<double> points = {9, 9, 9, poses[1][3], poses[1][7], poses[1][11]};
    const std::vector<bool> keep = scene.robot_filter(points, rows[0], 0.2);
    CHECK(keep.size() == 2 && keep[0] && !keep[1]);

    const Scene ground = scene.without_obstacles().with_obstacles({{"ground", Shape::height_field({0, 0, 0, 1, 1, 1}, 3, 0.5), Pose(0, 0, -9)}});
    CHECK(ground.bodies().back() == "ground");

    Options options;
    options.free = {scene.joints()[0]};
    Solver held(scene, options);
    if (const auto answer = held.query(rows[0]))
        for (std::size_t k = 1; k < scene.nq(); ++k) CHECK(answer->witness()[k] == rows[0][k]);
    options.locked = {scene.joints()[1]};
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { held.set_options(options); }), "got both"));
    Options heavy;
    heavy.weights = {{scene.joints()[0], 100, 100}};
    CHECK(held.set_options(heavy) && held.query(rows[0])->depth() != answers[0].depth());
    CHECK(held.set_options(Options()) && same(*held.query(rows[0]), answers[0]));
    heavy.weights = {{"no such joint", 1, 1}};
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { held.set_options(heavy); }), "no such joint"));
}

static void grasps() {
    const Scene hand = Scene::builtin("hand").with_obstacles({{"ball", Shape::sphere(0.03), Pose(0, 0, 0.08)}});
    const extricate::Hand holding(hand, "ball");
    const auto grasp = holding.release({0.0, 0.4, 0.0, 0.4, 0.4});
    CHECK(grasp && grasp->verified() && grasp->summary().fingers_before == 3 && grasp->summary().fingers_kept == 3);
    CHECK(grasp->touched().size() >= grasp->kept().size() && !grasp->kept().empty() && grasp->moved() > 0);
    CHECK(!grasp->contacts().empty() && grasp->contacts()[0].link != nullptr && !std::isnan(grasp->summary().epsilon));
    CHECK(Solver(hand).check(grasp->config()));
    extricate::ReleaseOptions wrong;
    wrong.touch = -1;
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return holding.release({0, 0, 0, 0, 0}, wrong); }), "options.touch: got -1"));
}

#ifdef EXTRICATE_WITH_EIGEN
/// What lies in memory as the interface reads it is answered rightly; scripts/check-c.sh shows that nothing
/// else compiles.
static void matrices(const Scene& scene, const Rows& rows, const std::vector<Answer>& answers) {
    using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto nq = static_cast<Eigen::Index>(scene.nq());
    RowMatrix matrix(2, nq);
    Eigen::MatrixXd columns(nq, 2);
    for (Eigen::Index k = 0; k < 2; ++k)
        for (Eigen::Index at = 0; at < nq; ++at)
            matrix(k, at) = columns(at, k) = rows[static_cast<std::size_t>(k)][static_cast<std::size_t>(at)];
    const extricate::Batch batch = extricate::query_batch(scene, matrix);
    const Solver solver(scene);
    for (std::size_t k = 0; k < 2; ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        CHECK(batch.summaries[k].depth == answers[k].depth());
        CHECK(same(*solver.query(matrix.row(at)), answers[k]) && same(*solver.query(columns.col(at)), answers[k]));
        CHECK(same(*solver.query(Eigen::VectorXd(columns.col(at))), answers[k]));
    }
}
#endif

static void models(const Scene& scene, const std::vector<double>& q, const std::string& folder) {
    CHECK(!scene.is_learned());
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return scene.save(folder + "/none.model"); }), "nothing was learned"));
    const Scene model = scene.learn(2000, HUGE_VAL, 1, 1);
    CHECK(model.is_learned() && model.save(folder + "/arm.model"));
    CHECK(contains(model.statistics(), "\"boundary_samples\"") && scene.statistics().empty());
    CHECK(!model.samples().empty() && Solver(scene).check(model.samples()[0]) && scene.samples().empty());
    int heard = 0;
    const Scene ended = scene.learn(1000000, HUGE_VAL, 1, 1, [&heard](const ExtricateProgress& state) {
        CHECK(std::strlen(state.stage) > 0 && state.fraction >= 0);
        return ++heard < 3;
    });
    CHECK(ended.is_learned() && heard >= 3);
    extricate::LoadOptions little;
    little.limits = {{"text-bytes", 10}};
    CHECK(contains(refused(EXTRICATE_FILE, [&] { Scene(folder + "/cell/shelf-arm.toml", little); }), "text"));
    const Scene loaded(folder + "/arm.model");
    Solver first(model), second(loaded), changed(loaded.without_obstacles());
    CHECK(same(*first.query(q), *second.query(q)));
    CHECK(first.query(q) && changed.query(q));
    CHECK(loaded.is_learned() && !changed.scene().is_learned());
    CHECK(contains(refused(EXTRICATE_FILE, [&] { Scene("none.model"); }), "none.model"));
    for (const double seconds : {0.0, -1.0, std::nan("")})
        CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return scene.learn(1000, seconds); }), "seconds: got"));
    const std::string far(1 << 20, 'a');
    CHECK(refused(EXTRICATE_FILE, [&] { Scene none(far); }).size() < 2000);
    CHECK(refused(EXTRICATE_FILE, [&] { return model.save(far); }).size() < 2000);
    CHECK(refused(EXTRICATE_FILE, [&] { return model.save(far + "/a.model"); }).size() < 2000);
}

static void texts() {
    const std::string robot =
        "<robot name='r'><link name='a'/><link name='b'><collision><geometry><sphere radius='0.1'/></geometry></collision>"
        "</link><joint name='j' type='prismatic'><parent link='a'/><child link='b'/><axis xyz='1 0 0'/>"
        "<limit lower='0' upper='9' effort='1' velocity='1'/></joint></robot>";
    CHECK(Scene::from_text(robot).nq() == 1);
    const std::string scene = "[[robot]]\nurdf = 'r.urdf'\n[[obstacle]]\nname = 'box'\nshape = { box = [1, 1, 1] }\n";
    const Scene both = Scene::from_text(scene, "", {{"r.urdf", robot}});
    Solver solver(both);
    const Answer answer = *solver.query({0.0});
    CHECK(std::abs(answer.depth() - 0.6001) < 1e-4 && answer.lower_bound() <= answer.depth());
    CHECK(std::abs(solver.distance({5.0}) - 4.4) < 1e-9 && solver.pair_distances({5.0}).size() == 1);
    CHECK(solver.check_segment({1.0}, {9.0}).is_free);
    const ExtricateSegment hits = solver.check_segment({1.0}, {0.0});
    CHECK(hits.collides && hits.free_until < hits.at && both.names(hits.pair).second == "box");
    CHECK(both.config({"j"}, {0.5}) == std::vector<double>{0.5});
    CHECK(contains(refused(EXTRICATE_FILE, [&] { return Scene::from_text(scene); }), "r.urdf"));
    CHECK(contains(refused(EXTRICATE_INPUT, [&] { return Scene::from_text("x"); }), "line 1"));
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return Scene::from_text("\xff"); }), "UTF-8"));
    CHECK(contains(refused(EXTRICATE_ARGUMENT, [&] { return Scene().moved({}); }), "scene: got a null pointer"));
}

/// What C++ hides: null pointers, and handles that outlive the scene that they were made of.
static void pointers() {
    ExtricateScene* scene = nullptr;
    ExtricateSolver* solver = nullptr;
    ExtricateAnswer* answer = nullptr;
    CHECK(extricate_load(nullptr, nullptr, &scene) == EXTRICATE_ARGUMENT && extricate_load("a", nullptr, nullptr) == EXTRICATE_ARGUMENT);
    CHECK(extricate_scene_builtin("none", &scene) != EXTRICATE_OK && scene == nullptr);
    CHECK(extricate_scene_builtin("planar-arm", &scene) == EXTRICATE_OK);
    CHECK(extricate_solver_new(scene, nullptr, &solver) == EXTRICATE_OK);
    extricate_scene_free(scene);
    const double q[3] = {0.4, 0, 0};
    CHECK(extricate_query(solver, nullptr, 3, &answer) == EXTRICATE_ARGUMENT);
    CHECK(extricate_query(solver, q, SIZE_MAX, &answer) == EXTRICATE_ARGUMENT);
    CHECK(extricate_query(solver, q, 3, &answer) == EXTRICATE_OK);
    double witness[3] = {};
    CHECK(extricate_nearest_exit(solver, q, 3, nullptr) == EXTRICATE_ARGUMENT);
    CHECK(extricate_nearest_exit(solver, q, 2, witness) == EXTRICATE_CONFIGURATION && witness[0] == 0);
    CHECK(extricate_nearest_exit(solver, q, 3, witness) == EXTRICATE_OK && witness[0] != 0);
    extricate_solver_free(solver);
    const ExtricatePair* pairs = nullptr;
    CHECK(extricate_answer_colliding(answer, &pairs) > 0 && pairs != nullptr);
    CHECK(extricate_answer_colliding(nullptr, &pairs) == 0 && extricate_answer_summary(nullptr) == nullptr);
    extricate_answer_free(answer);
    extricate_scene_free(nullptr);
    extricate_solver_free(nullptr);
    extricate_answer_free(nullptr);
    extricate_stream_free(nullptr);
    CHECK(extricate_scene_nq(nullptr) == 0 && extricate_scene_joint_name(nullptr, 0) == nullptr);
    CHECK(extricate_scene_pair(nullptr, 0).first == SIZE_MAX && std::isnan(extricate_scene_clearance(nullptr)));
}

/// Makes a call that fails when its thread ends, after the library's own variables of the thread are gone.
struct AtTheEnd {
    std::atomic<bool>* passed = nullptr;
    ~AtTheEnd() {
        ExtricateScene* scene = nullptr;
        if (passed) *passed = extricate_load("none.toml", nullptr, &scene) == EXTRICATE_FILE && extricate_last_error() != nullptr;
    }
};

static thread_local AtTheEnd end;

static void thread_ends() {
    std::atomic<bool> passed{false};
    std::thread([&passed] {
        end.passed = &passed;
        ExtricateScene* scene = nullptr;
        CHECK(extricate_load("none.toml", nullptr, &scene) == EXTRICATE_FILE);
    }).join();
    CHECK(passed);
}

/// What docs/how-to/cpp.md tells programs that turn floating-point traps on.
static void traps(const Scene& scene, const std::vector<double>& q, const Answer& expected) {
#ifdef __GLIBC__
    Solver solver(scene);
    feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    std::fenv_t own;
    std::feholdexcept(&own);
    const Answer answer = *solver.query(q);
    const extricate::Batch batch = extricate::query_batch(scene, q);
    std::fesetenv(&own);
    CHECK(fegetexcept() == (FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW));
    fedisableexcept(FE_ALL_EXCEPT);
    CHECK(same(answer, expected) && batch.summaries[0].depth == expected.depth());
#else
    (void)scene, (void)q, (void)expected;
#endif
}

/// Layers over the interface refuse as it does.
static void layers() {
    CHECK(extricate_refuse("gripper: got 3 fingers") == EXTRICATE_ARGUMENT);
    CHECK(extricate::last_error() == "gripper: got 3 fingers");
    CHECK(extricate_refuse(nullptr) == EXTRICATE_ARGUMENT && contains(extricate::last_error(), "message: got a null pointer"));
    const Scene scene = Scene::builtin("planar-arm");
    const auto cloud = [&] { return scene.with_obstacles({{"cloud", Shape::points({1, 2, 3, 4}, 0.1)}}); };
    CHECK(contains(refused(EXTRICATE_ARGUMENT, cloud), "obstacle \"cloud\": points: got 4 numbers"));
    std::string umlauts;
    for (int k = 0; k < 1000; ++k) umlauts += "\u00e4";
    const auto long_name = [&] { return scene.with_obstacles({{"a" + umlauts, Shape::points({1, 2, 3, 4}, 0.1)}}); };
    const std::string said = refused(EXTRICATE_ARGUMENT, long_name);
    CHECK(said.size() < 300 && contains(said, "\": points: got 4 numbers"));
    const auto text = [&] { return scene.in_world_text("w.toml", std::string("# a\0b", 5)); };
    CHECK(contains(refused(EXTRICATE_ARGUMENT, text), "text: byte 3: got a zero"));
}

int main(int argc, char** argv) {
    if (argc != 4) return std::fprintf(stderr, "usage: interface SCENE QUERIES FOLDER\n"), 2;
    const Scene scene(argv[1]);
    const Rows rows = read(argv[2]);
    if (rows.size() < 6) return std::fprintf(stderr, "%s: got %zu queries, expected six or more\n", argv[2], rows.size()), 2;
    CHECK(extricate_abi() == EXTRICATE_ABI && std::strlen(extricate_version()) >= 5);
    Solver solver(scene);
    std::vector<Answer> answers;
    for (const auto& q : rows) answers.push_back(*solver.query(q));
    threads_share(scene, rows, answers);
    batches(scene, rows, answers);
    options(scene, rows[0]);
    streams(scene, rows[0]);
    worlds(scene, rows[0]);
    motions(scene, rows, answers, argv[3]);
    geometry(scene, rows, answers);
    grasps();
#ifdef EXTRICATE_WITH_EIGEN
    matrices(scene, rows, answers);
#endif
    models(scene, rows[0], argv[3]);
    texts();
    pointers();
    thread_ends();
    traps(scene, rows[0], answers[0]);
    layers();
    for (const Answer& answer : answers) print(answer);
    for (const auto& q : rows) print(solver.escape(q).points());
    extricate::PlanOptions some;
    some.max_checks = 20000;
    print(solver.plan(rows[1], rows[5], some).points());
    std::vector<double> path;
    for (std::size_t k = 0; k < 3; ++k) path.insert(path.end(), rows[k].begin(), rows[k].end());
    print(solver.repair(path).points());
    std::fprintf(stderr, "%d checks passed\n", checks);
}
