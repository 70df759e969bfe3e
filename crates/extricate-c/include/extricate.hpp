/* C++17 over extricate.h: objects that free themselves, and exceptions.
 *
 *     extricate::Scene scene("panda-box.toml");
 *     extricate::Solver solver(scene);
 *     std::vector<double> q(scene.nq());
 *     if (auto answer = solver.query(q)) use(answer.depth(), answer.witness());
 *
 * A configuration is anything with data() and size(): std::vector, std::array, Eigen::VectorXd. With
 * EXTRICATE_WITH_EIGEN defined, poses are made of Eigen's isometries, and witnesses can be read as
 * Eigen's vectors.
 *
 * If a call fails, it throws extricate::Error. Without exceptions (-fno-exceptions) it gives an empty
 * object, nan or false, and extricate::last_status() and last_error() say why; they belong to the
 * thread.
 *
 * Scene, Answer: never change, cheap to copy, used by any number of threads. Solver, Stream: moved, not
 * copied, one for each thread. */
#ifndef EXTRICATE_HPP
#define EXTRICATE_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "extricate.h"

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define EXTRICATE_HAS_EXCEPTIONS 1
#include <stdexcept>
#else
#define EXTRICATE_HAS_EXCEPTIONS 0
#endif

#ifdef EXTRICATE_WITH_EIGEN
#include <Eigen/Core>
#include <Eigen/Geometry>
#endif

namespace extricate {

/// EXTRICATE_OK or another of the codes in extricate.h.
using Status = ExtricateStatus;

/// What the last call that failed on this thread says is wrong.
inline std::string last_error() { return extricate_last_error(); }

namespace detail {
inline Status& status() {
    static thread_local Status last = EXTRICATE_OK;
    return last;
}
}  // namespace detail

/// The code of the last call on this thread.
inline Status last_status() { return detail::status(); }

#if EXTRICATE_HAS_EXCEPTIONS
/// A call failed: what() names file or argument, value and what was expected.
class Error : public std::runtime_error {
public:
    Error(Status status, const std::string& message) : std::runtime_error(message), status_(status) {}
    /// EXTRICATE_FILE and so on.
    Status status() const { return status_; }

private:
    Status status_;
};
#endif

namespace detail {
/// Throws what is no success; without exceptions, remembers it and says so.
inline bool succeeded(Status status) {
    detail::status() = status;
#if EXTRICATE_HAS_EXCEPTIONS
    if (status != EXTRICATE_OK) throw Error(status, extricate_last_error());
#endif
    return status == EXTRICATE_OK;
}
/// Fails as a call of C does, so that last_status() and last_error() agree. Callers return at once:
/// another call would hide it. Always false.
inline bool refuse(const std::string& message) { return succeeded(extricate_refuse(message.c_str())); }
/// A name as messages repeat it: 200 bytes at most, and no part of a character.
inline std::string shown(const std::string& name) {
    if (name.size() <= 200) return name;
    std::size_t end = 200;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    return name.substr(0, end) + " ..";
}
/// Refuses a text that C would read to its first zero alone, and lengths that differ.
inline bool is_whole(const std::string& name, const std::string& text) {
    const std::size_t zero = text.find('\0');
    if (zero == std::string::npos) return true;
    return refuse(shown(name) + ": byte " + std::to_string(zero) + ": got a zero, expected text");
}
inline bool are_as_many(const char* names, std::size_t first, std::size_t second) {
    if (first == second) return true;
    return refuse(std::string(names) + ": got " + std::to_string(first) + " and " + std::to_string(second) +
                  ", expected the same number of both");
}

template <class T>
struct Range {
    const T* first = nullptr;
    std::size_t count = 0;
    const T* begin() const { return first; }
    const T* end() const { return first + count; }
    std::size_t size() const { return count; }
    bool empty() const { return count == 0; }
    const T& operator[](std::size_t at) const { return first[at]; }
    const T* data() const { return first; }
};
}  // namespace detail

/// Values that live in an answer.
template <class T>
using Range = detail::Range<T>;

/// A configuration of the caller, not copied.
class Config {
public:
    Config(const double* data, std::size_t size) : data_(data), size_(size) {}
    /// Of numbers in the call itself, which live as long as it.
    Config(std::initializer_list<double> values) : Config(values.begin(), values.size()) {}
    template <class Vector, class = decltype(std::declval<const Vector&>().data()[0] + 0.0)>
    Config(const Vector& vector) : data_(vector.data()), size_(static_cast<std::size_t>(vector.size())) {}
    const double* data() const { return data_; }
    std::size_t size() const { return size_; }

private:
    const double* data_;
    std::size_t size_;
};

/// Where something stands: position [m] and unit quaternion x, y, z, w.
struct Pose : ExtricatePose {
    Pose(double x = 0, double y = 0, double z = 0, double qx = 0, double qy = 0, double qz = 0, double qw = 1)
        : ExtricatePose{{x, y, z}, {qx, qy, qz, qw}} {}
#ifdef EXTRICATE_WITH_EIGEN
    Pose(const Eigen::Isometry3d& pose) : Pose(pose.translation().x(), pose.translation().y(), pose.translation().z()) {
        const Eigen::Quaterniond turned = Eigen::Quaterniond(pose.linear()).normalized();
        const double xyzw[4] = {turned.x(), turned.y(), turned.z(), turned.w()};
        for (int k = 0; k < 4; ++k) quaternion[k] = xyzw[k];
    }
#endif
};

/// One shape; lengths in metres. It holds its own numbers.
class Shape {
public:
    static Shape box(double x, double y, double z) { return Shape(EXTRICATE_BOX, x, y, z); }
    static Shape sphere(double radius) { return Shape(EXTRICATE_SPHERE, radius); }
    static Shape cylinder(double radius, double length) { return Shape(EXTRICATE_CYLINDER, radius, length); }
    static Shape capsule(double radius, double length) { return Shape(EXTRICATE_CAPSULE, radius, length); }
    /// Corners, three numbers each, and triangles, three indices each.
    static Shape mesh(std::vector<double> corners, std::vector<std::uint32_t> triangles, bool convex = false) {
        Shape shape(EXTRICATE_MESH);
        shape.points_ = std::move(corners);
        shape.triangles_ = std::move(triangles);
        shape.convex_ = convex;
        return shape;
    }
    /// A cloud, three numbers a point, with balls about the points. Of obstacles only.
    static Shape points(std::vector<double> points, double radius) {
        Shape shape(EXTRICATE_POINTS, radius);
        shape.points_ = std::move(points);
        return shape;
    }
    /// Occupied cells, three indices each, of this side. Of obstacles only.
    static Shape voxels(std::vector<std::int32_t> cells, double side) {
        Shape shape(EXTRICATE_VOXELS, side);
        shape.cells_ = std::move(cells);
        return shape;
    }
    /// All that lies behind a plane. Of obstacles only.
    static Shape half_space(double nx, double ny, double nz, double offset) {
        Shape shape(EXTRICATE_HALF_SPACE, nx, ny, nz);
        shape.offset_ = offset;
        return shape;
    }
    /// What is wrong with its numbers; empty if nothing is.
    std::string problem() const {
        const auto rest = [](const char* name, std::size_t count) {
            if (count % 3 == 0) return std::string();
            return std::string(name) + ": got " + std::to_string(count) + " numbers, expected three each";
        };
        for (const std::string& found :
             {rest("points", points_.size()), rest("triangles", triangles_.size()), rest("cells", cells_.size())})
            if (!found.empty()) return found;
        return "";
    }
    /// As C has it, for as long as this lives.
    ExtricateShape raw() const {
        return ExtricateShape{kind_,           {size_[0], size_[1], size_[2]}, offset_,        points_.data(),
                              points_.size() / 3, triangles_.data(),          triangles_.size() / 3, cells_.data(),
                              cells_.size() / 3,  convex_ ? 1u : 0u};
    }

private:
    explicit Shape(std::uint32_t kind, double x = 0, double y = 0, double z = 0) : kind_(kind), size_{x, y, z} {}
    std::uint32_t kind_;
    double size_[3];
    double offset_ = 0;
    std::vector<double> points_;
    std::vector<std::uint32_t> triangles_;
    std::vector<std::int32_t> cells_;
    bool convex_ = false;
};

/// An obstacle; or an object for a link to hold, whose pose is in the link's coordinates.
struct Obstacle {
    std::string name;
    Shape shape;
    Pose pose = Pose();
    ExtricateObstacle raw() const { return ExtricateObstacle{name.c_str(), shape.raw(), pose}; }
};

namespace detail {
inline std::vector<const char*> pointers(const std::vector<std::string>& texts) {
    std::vector<const char*> all;
    for (const std::string& text : texts) all.push_back(text.c_str());
    return all;
}
/// Refuses an obstacle of a shape whose last point, triangle or cell is not whole.
inline bool is_whole(const Obstacle& obstacle) {
    const std::string problem = obstacle.shape.problem();
    return problem.empty() || refuse("obstacle \"" + shown(obstacle.name) + "\": " + problem);
}
}  // namespace detail

/// A scene, or what was learned of one, in that scene or in a changed one.
class Scene {
public:
    /// None; only to be assigned to.
    Scene() = default;
    /// Loads a scene file (TOML), a URDF or a model.
    explicit Scene(const std::string& path) {
        take([&](ExtricateScene** out) { return extricate_load(path.c_str(), out); });
    }
    /// A scene of the text of a scene file or URDF. Paths start from `folder`; a path that is among `texts`
    /// is not read.
    static Scene from_text(const std::string& text, const std::string& folder = "",
                           const std::vector<std::pair<std::string, std::string>>& texts = {}) {
        if (!detail::is_whole("text", text)) return Scene();
        std::vector<ExtricateText> all;
        for (const auto& [path, content] : texts) {
            if (!detail::is_whole(path, content)) return Scene();
            all.push_back(ExtricateText{path.c_str(), content.c_str()});
        }
        return made([&](ExtricateScene** out) {
            return extricate_scene_from_text(text.c_str(), folder.empty() ? nullptr : folder.c_str(), all.data(), all.size(), out);
        });
    }
    /// A scene that comes with the library.
    static Scene builtin(const std::string& name) {
        return made([&](ExtricateScene** out) { return extricate_scene_builtin(name.c_str(), out); });
    }
    /// A model of the scene, which takes fewer checks a query; see extricate_learn().
    Scene learn(std::size_t labels = 0, double seconds = HUGE_VAL, std::uint64_t seed = 0, std::size_t threads = 0) const {
        return made([&](ExtricateScene** out) { return extricate_learn(get(), labels, seconds, seed, threads, out); });
    }
    /// Writes a model to a file.
    bool save(const std::string& path) const { return detail::succeeded(extricate_save(get(), path.c_str())); }
    /// Does now what the first solver would do.
    bool prepare() const { return detail::succeeded(extricate_scene_prepare(get())); }

    /// Obstacles elsewhere.
    Scene moved(const std::vector<std::pair<std::string, Pose>>& poses) const {
        std::vector<const char*> names;
        std::vector<ExtricatePose> all;
        for (const auto& [name, pose] : poses) {
            names.push_back(name.c_str());
            all.push_back(pose);
        }
        return made([&](ExtricateScene** out) { return extricate_scene_moved(get(), names.data(), all.data(), all.size(), out); });
    }
    /// More obstacles.
    Scene with_obstacles(const std::vector<Obstacle>& obstacles) const {
        std::vector<ExtricateObstacle> all;
        for (const Obstacle& obstacle : obstacles) {
            if (!detail::is_whole(obstacle)) return Scene();
            all.push_back(obstacle.raw());
        }
        return made([&](ExtricateScene** out) { return extricate_scene_with_obstacles(get(), all.data(), all.size(), out); });
    }
    /// Fewer obstacles, or objects that links hold.
    Scene without(const std::vector<std::string>& names) const {
        const auto all = detail::pointers(names);
        return made([&](ExtricateScene** out) { return extricate_scene_without(get(), all.data(), all.size(), out); });
    }
    /// Without any obstacle.
    Scene without_obstacles() const {
        return made([&](ExtricateScene** out) { return extricate_scene_without_obstacles(get(), out); });
    }
    /// Pairs of bodies that are no longer checked.
    Scene disabled(const std::vector<std::pair<std::string, std::string>>& pairs) const {
        std::vector<const char*> all;
        for (const auto& [first, second] : pairs) all.insert(all.end(), {first.c_str(), second.c_str()});
        return made([&](ExtricateScene** out) { return extricate_scene_disabled(get(), all.data(), pairs.size(), out); });
    }
    /// An object that a link holds, which may touch these bodies.
    Scene attached(const Obstacle& object, const std::string& link, const std::vector<std::string>& touch = {}) const {
        if (!detail::is_whole(object)) return Scene();
        const ExtricateObstacle held = object.raw();
        const auto all = detail::pointers(touch);
        return made([&](ExtricateScene** out) {
            return extricate_scene_attached(get(), &held, link.c_str(), all.data(), all.size(), out);
        });
    }
    /// The robots in the world of a file.
    Scene in_world(const std::string& path) const {
        return made([&](ExtricateScene** out) { return extricate_scene_in_world(get(), path.c_str(), out); });
    }
    /// The same of a text; the end of `name` (.toml, .scene, .yaml, .json) tells what it is.
    Scene in_world_text(const std::string& name, const std::string& text) const {
        if (!detail::is_whole("text", text)) return Scene();
        return made([&](ExtricateScene** out) {
            return extricate_scene_in_world_text(get(), name.c_str(), text.c_str(), out);
        });
    }

    std::size_t nq() const { return extricate_scene_nq(get()); }
    std::size_t nv() const { return extricate_scene_nv(get()); }
    bool is_learned() const { return extricate_scene_is_learned(get()); }
    double clearance() const { return extricate_scene_clearance(get()); }
    std::uint32_t metric() const { return extricate_scene_metric(get()); }
    std::vector<std::string> joints() const { return texts(extricate_scene_joint_count(get()), extricate_scene_joint_name); }
    std::vector<std::string> bodies() const { return texts(extricate_scene_body_count(get()), extricate_scene_body_name); }
    std::vector<std::string> warnings() const { return texts(extricate_scene_warning_count(get()), extricate_scene_warning); }
    std::size_t pair_count() const { return extricate_scene_pair_count(get()); }
    /// Names of the bodies of a pair.
    std::pair<std::string, std::string> names(const ExtricatePair& pair) const {
        const auto name = [&](std::size_t at) {
            const char* text = extricate_scene_body_name(get(), at);
            return std::string(text ? text : "");
        };
        return {name(pair.first), name(pair.second)};
    }
    /// Lower and upper limits of all coordinates.
    std::pair<std::vector<double>, std::vector<double>> limits() const {
        std::vector<double> lower(nq()), upper(nq());
        if (!detail::succeeded(extricate_scene_limits(get(), lower.data(), upper.data(), nq()))) return {};
        return {lower, upper};
    }
    /// The configuration in which these joints have these positions.
    std::vector<double> config(const std::vector<std::string>& joints, const std::vector<double>& positions) const {
        std::vector<double> q(nq());
        const auto all = detail::pointers(joints);
        if (!detail::are_as_many("joints, positions", joints.size(), positions.size())) return {};
        const Status status = extricate_scene_config(get(), all.data(), positions.data(), all.size(), q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// The configuration of a message: a JointState, RobotState or PlanningScene; the end of `name` is .yaml or .json.
    std::vector<double> config_text(const std::string& name, const std::string& text) const {
        if (!detail::is_whole("text", text)) return {};
        std::vector<double> q(nq());
        const Status status = extricate_scene_config_text(get(), name.c_str(), text.c_str(), q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// How far two configurations are from each other, in the scene's metric.
    double metric_distance(Config from, Config to) const {
        double distance = std::nan("");
        if (!detail::are_as_many("from, to", from.size(), to.size())) return distance;
        detail::succeeded(extricate_metric_distance(get(), from.data(), to.data(), to.size(), &distance));
        return distance;
    }
    /// Whether configurations, one after another, are free.
    std::vector<bool> check(Config rows, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        std::unique_ptr<bool[]> free(new bool[count ? count : 1]());
        if (!detail::succeeded(extricate_check_batch(get(), rows.data(), count, nq(), threads, free.get()))) return {};
        return std::vector<bool>(free.get(), free.get() + count);
    }
    /// Least signed distances at configurations, one after another [m].
    std::vector<double> distances(Config rows, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        std::vector<double> all(count);
        const Status status = extricate_distance_batch(get(), rows.data(), count, nq(), threads, all.data());
        return detail::succeeded(status) ? all : std::vector<double>();
    }

    /// How many configurations stand in a row of numbers; 0 of one that is refused.
    std::size_t rows_of(Config rows) const {
        std::size_t count = 0;
        counts(rows, count);
        return count;
    }
    /// Writes how many; false if they are refused.
    bool counts(Config rows, std::size_t& count) const {
        const std::size_t size = nq();
        if (!scene_) return detail::refuse("scene: got none, expected one that was made");
        count = size ? rows.size() / size : 0;
        if (count * size == rows.size()) return true;
        count = 0;
        return detail::refuse("rows: got " + std::to_string(rows.size()) + " numbers, expected whole configurations of " +
                              std::to_string(size));
    }
    explicit operator bool() const { return scene_ != nullptr; }
    /// For the functions of extricate.h.
    const ExtricateScene* get() const { return scene_.get(); }

private:
    template <class Make>
    static Scene made(Make make) {
        Scene scene;
        scene.take(make);
        return scene;
    }
    template <class Make>
    void take(Make make) {
        ExtricateScene* out = nullptr;
        if (detail::succeeded(make(&out))) scene_.reset(out, extricate_scene_free);
    }
    template <class Name>
    std::vector<std::string> texts(std::size_t count, Name name) const {
        std::vector<std::string> all;
        for (std::size_t at = 0; at < count; ++at) all.emplace_back(name(get(), at));
        return all;
    }
    std::shared_ptr<ExtricateScene> scene_;
};

/// What is asked of a query: the members of ExtricateOptions, with C++'s own types.
struct Options {
    std::uint32_t effort = EXTRICATE_REFINED;
    std::size_t exits = 1;
    std::size_t starts = 0;
    double gap = std::nan("");
    double clearance = std::nan("");
    std::size_t max_checks = SIZE_MAX;
    double max_seconds = HUGE_VAL;
    bool refuse_outside = false;
    bool free_radius = false;
    bool segment = false;
    bool contacts = false;
    std::vector<std::string> locked;
    std::vector<double> toward;
    double toward_share = 0.25;
    /// Ends queries where it says true; called on any thread, and must not throw.
    std::function<bool()> stop;
};

namespace detail {
/// Options as C has them; lives while they are read, but for `stop`, which is kept.
class RawOptions {
public:
    RawOptions(const Options& options, std::function<bool()>* stop) : locked_(pointers(options.locked)) {
        extricate_options_init(&raw_);
        raw_.effort = options.effort;
        raw_.refuse_outside = options.refuse_outside;
        raw_.free_radius = options.free_radius;
        raw_.segment = options.segment;
        raw_.contacts = options.contacts;
        raw_.exits = options.exits;
        raw_.starts = options.starts;
        raw_.gap = options.gap;
        raw_.clearance = options.clearance;
        raw_.max_checks = options.max_checks;
        raw_.max_seconds = options.max_seconds;
        raw_.locked = locked_.data();
        raw_.locked_count = locked_.size();
        raw_.toward = options.toward.data();
        raw_.toward_count = options.toward.size();
        raw_.toward_share = options.toward_share;
        if (*stop) {
            raw_.stop = [](void* data) { return (*static_cast<std::function<bool()>*>(data))(); };
            raw_.stop_data = stop;
        }
    }
    const ExtricateOptions* get() const { return &raw_; }

private:
    ExtricateOptions raw_;
    std::vector<const char*> locked_;
};
}  // namespace detail

/// An answer; empty where nothing free was found.
class Answer {
public:
    Answer() = default;
    Answer(ExtricateAnswer* answer, std::size_t nq, std::size_t nv) : answer_(answer, extricate_answer_free), nq_(nq), nv_(nv) {}
    /// Whether there is a witness; nothing else may be asked where there is none.
    explicit operator bool() const { return answer_ != nullptr; }
    const ExtricateSummary& summary() const { return *extricate_answer_summary(get()); }
    double depth() const { return summary().depth; }
    double lower_bound() const { return summary().lower_bound; }
    double gap() const { return summary().gap; }
    /// [m]
    double max_displacement() const { return summary().max_displacement; }
    bool is_free() const { return summary().is_free; }
    bool verified() const { return summary().verified; }
    bool unique() const { return summary().unique; }
    bool cut_short() const { return summary().cut_short; }
    Range<double> witness() const { return {extricate_answer_witness(get()), nq_}; }
    Range<double> gradient() const { return {extricate_answer_gradient(get()), nv_}; }
    Range<ExtricatePair> colliding() const { return range<ExtricatePair>(extricate_answer_colliding); }
    Range<ExtricatePair> touching() const { return range<ExtricatePair>(extricate_answer_touching); }
    Range<std::size_t> outside() const { return range<std::size_t>(extricate_answer_outside); }
    Range<ExtricateContact> contacts() const { return range<ExtricateContact>(extricate_answer_contacts); }
    Range<ExtricateExit> exits() const { return range<ExtricateExit>(extricate_answer_exits); }
    /// The witness, copied.
    std::vector<double> config() const { return {witness().begin(), witness().end()}; }
#ifdef EXTRICATE_WITH_EIGEN
    /// The witness, which lives as long as the answer.
    Eigen::Map<const Eigen::VectorXd> vector() const { return {witness().data(), static_cast<Eigen::Index>(nq_)}; }
#endif
    const ExtricateAnswer* get() const { return answer_.get(); }

private:
    template <class T, class List>
    Range<T> range(List list) const {
        Range<T> all;
        all.count = list(get(), &all.first);
        return all;
    }
    std::shared_ptr<ExtricateAnswer> answer_;
    std::size_t nq_ = 0, nv_ = 0;
};

namespace detail {
template <class Ask>
Answer answered(const Scene& scene, Ask ask) {
    ExtricateAnswer* out = nullptr;
    const Status status = ask(&out);
    detail::status() = status;
    if (status == EXTRICATE_NOTHING_FREE || !succeeded(status)) return Answer();
    return Answer(out, scene.nq(), scene.nv());
}
/// A copy of `stop` whose address stays.
using Stop = std::unique_ptr<std::function<bool()>>;
inline Stop kept(const Options& options) { return Stop(new std::function<bool()>(options.stop)); }
}  // namespace detail

/// Queries and checks of a scene, with options and memory that stay. One for each thread.
class Solver {
public:
    explicit Solver(Scene scene, const Options& options = Options()) : scene_(std::move(scene)), stop_(detail::kept(options)) {
        const detail::RawOptions raw(options, stop_.get());
        ExtricateSolver* out = nullptr;
        if (detail::succeeded(extricate_solver_new(scene_.get(), raw.get(), &out))) solver_.reset(out);
    }
    /// Other options for the queries that follow.
    bool set_options(const Options& options) {
        detail::Stop stop = detail::kept(options);
        const detail::RawOptions raw(options, stop.get());
        const bool done = detail::succeeded(extricate_solver_set_options(solver_.get(), raw.get()));
        if (done) stop_ = std::move(stop);
        return done;
    }
    /// The nearest free configuration; empty where nothing free was found.
    Answer query(Config q) {
        return detail::answered(scene_, [&](ExtricateAnswer** out) { return extricate_query(solver_.get(), q.data(), q.size(), out); });
    }
    /// So that the first query that counts takes as long as those that follow.
    bool warm_up(double seconds = 0.03) { return detail::succeeded(extricate_solver_warm_up(solver_.get(), seconds)); }
    /// Whether a configuration is within the limits and collides with nothing.
    bool check(Config q) {
        bool free = false;
        detail::succeeded(extricate_check(solver_.get(), q.data(), q.size(), &free));
        return free;
    }
    /// Least signed distance of any checked pair [m].
    double distance(Config q) {
        double distance = std::nan("");
        detail::succeeded(extricate_distance(solver_.get(), q.data(), q.size(), &distance));
        return distance;
    }
    /// Signed distances of all checked pairs [m].
    std::vector<double> pair_distances(Config q) {
        std::vector<double> all(scene_.pair_count());
        const Status status = extricate_pair_distances(solver_.get(), q.data(), q.size(), all.data(), all.size());
        return detail::succeeded(status) ? all : std::vector<double>();
    }
    /// Whether the whole segment is free: proved.
    ExtricateSegment check_segment(Config from, Config to, double resolution = 1e-4) {
        ExtricateSegment segment{};
        if (!detail::are_as_many("from, to", from.size(), to.size())) return segment;
        detail::succeeded(extricate_check_segment(solver_.get(), from.data(), to.data(), to.size(), resolution, &segment));
        return segment;
    }
    const Scene& scene() const { return scene_; }
    explicit operator bool() const { return solver_ != nullptr; }

private:
    struct Free {
        void operator()(ExtricateSolver* solver) const { extricate_solver_free(solver); }
    };
    Scene scene_;
    detail::Stop stop_;
    std::unique_ptr<ExtricateSolver, Free> solver_;
};

/// Answers to many queries, one after another.
struct Batch {
    /// nq numbers a query; nan where nothing free was found.
    std::vector<double> witnesses;
    std::vector<ExtricateSummary> summaries;
};

/// Queries configurations, one after another in `rows`, on many threads (0: one a core).
inline Batch query_batch(const Scene& scene, Config rows, const Options& options = Options(), std::size_t threads = 0) {
    Batch batch;
    const std::size_t nq = scene.nq();
    std::size_t count = 0;
    if (!scene.counts(rows, count)) return batch;
    batch.witnesses.resize(count * nq);
    batch.summaries.resize(count);
    const detail::Stop stop = detail::kept(options);
    const detail::RawOptions raw(options, stop.get());
    const Status status = extricate_query_batch(scene.get(), raw.get(), rows.data(), count, nq, threads, batch.witnesses.data(),
                                                batch.summaries.data());
    return detail::succeeded(status) ? batch : Batch();
}

/// Queries that follow each other closely. One for each thread.
class Stream {
public:
    explicit Stream(Scene scene, const Options& options = Options(), double hysteresis = 0, std::size_t starts_per_frame = 2)
        : scene_(std::move(scene)), stop_(detail::kept(options)) {
        const detail::RawOptions raw(options, stop_.get());
        ExtricateStream* out = nullptr;
        const Status status = extricate_stream_new(scene_.get(), raw.get(), hysteresis, starts_per_frame, &out);
        if (detail::succeeded(status)) stream_.reset(out);
    }
    /// The answer for the next frame.
    Answer query(Config q) {
        return detail::answered(scene_, [&](ExtricateAnswer** out) { return extricate_stream_query(stream_.get(), q.data(), q.size(), out); });
    }
    /// Another scene of the same coordinates for the frames that follow.
    bool set_scene(Scene scene) {
        const bool done = detail::succeeded(extricate_stream_set_scene(stream_.get(), scene.get()));
        if (done) scene_ = std::move(scene);
        return done;
    }
    /// Forgets the frames so far.
    bool restart() { return detail::succeeded(extricate_stream_restart(stream_.get())); }
    explicit operator bool() const { return stream_ != nullptr; }

private:
    struct Free {
        void operator()(ExtricateStream* stream) const { extricate_stream_free(stream); }
    };
    Scene scene_;
    detail::Stop stop_;
    std::unique_ptr<ExtricateStream, Free> stream_;
};

}  // namespace extricate

#endif
