/* C++17 over extricate.h: objects that free themselves, and exceptions.
 *
 *     extricate::Scene scene("panda-box.toml");
 *     extricate::Solver solver(scene);
 *     std::vector<double> q(scene.nq());
 *     if (auto answer = solver.query(q)) use(answer.depth(), answer.witness());
 *
 * A configuration is anything with data() and size(): std::vector, std::array, Eigen::VectorXd. With
 * EXTRICATE_WITH_EIGEN defined, Eigen's isometries convert to poses, and Answer::vector() returns the
 * witness as a vector of Eigen.
 *
 * If a call fails, it throws extricate::Error. Without exceptions (-fno-exceptions) it returns an empty
 * object, nan or false. extricate::last_status() and last_error() then report the reason; each thread
 * has its own.
 *
 * A Scene and an Answer never change and are cheap to copy. A Solver and a Stream are moved, not copied.
 * Any number of threads may use one Scene, Answer or Solver at the same time; only set_options() needs a
 * Solver for itself. A Stream is for one thread at a time. */
#ifndef EXTRICATE_HPP
#define EXTRICATE_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
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

/// The message of the last call that failed on this thread.
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
/// Exception of a call that failed: what() names file or argument, value and what was expected.
class Error : public std::runtime_error {
public:
    Error(Status status, const std::string& message) : std::runtime_error(message), status_(status) {}
    /// EXTRICATE_FILE or another code.
    Status status() const { return status_; }

private:
    Status status_;
};
#endif

namespace detail {
/// Returns whether a status is success. Throws any other status; without exceptions, keeps it for
/// last_status().
inline bool succeeded(Status status) {
    detail::status() = status;
#if EXTRICATE_HAS_EXCEPTIONS
    if (status != EXTRICATE_OK) throw Error(status, extricate_last_error());
#endif
    return status == EXTRICATE_OK;
}
/// Fails as a call of C does, so that last_status() and last_error() agree, and returns false.
/// Callers return at once: another call would replace the status.
inline bool refuse(const std::string& message) { return succeeded(extricate_refuse(message.c_str())); }
/// A name as messages show it: at most 200 bytes, never cut inside a character.
inline std::string shown(const std::string& name) {
    if (name.size() <= 200) return name;
    std::size_t end = 200;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    return name.substr(0, end) + " ..";
}
/// Refuses a text that contains a zero, because C would read nothing after it.
inline bool is_whole(const std::string& name, const std::string& text) {
    const std::size_t zero = text.find('\0');
    if (zero == std::string::npos) return true;
    return refuse(shown(name) + ": byte " + std::to_string(zero) + ": got a zero, expected text");
}
/// Refuses lengths that differ.
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

/// Consecutive values that a result holds. They live as long as the result.
template <class T>
using Range = detail::Range<T>;

/// Consecutive configurations that a result holds. They live as long as the result.
class Rows {
public:
    Rows() = default;
    Rows(const double* data, std::size_t size, std::size_t nq) : data_(data), size_(size), nq_(nq) {}
    /// Number of configurations.
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    /// Number of coordinates of a configuration.
    std::size_t nq() const { return nq_; }
    Range<double> operator[](std::size_t at) const { return {data_ + at * nq_, nq_}; }
    Range<double> front() const { return (*this)[0]; }
    Range<double> back() const { return (*this)[size_ - 1]; }
    /// All numbers, one configuration after the other.
    const double* data() const { return data_; }

    class Iterator {
    public:
        Iterator(const Rows* rows, std::size_t at) : rows_(rows), at_(at) {}
        Range<double> operator*() const { return (*rows_)[at_]; }
        Iterator& operator++() { return ++at_, *this; }
        bool operator!=(const Iterator& other) const { return at_ != other.at_; }

    private:
        const Rows* rows_;
        std::size_t at_;
    };
    Iterator begin() const { return {this, 0}; }
    Iterator end() const { return {this, size_}; }

private:
    const double* data_ = nullptr;
    std::size_t size_ = 0, nq_ = 0;
};

/// A view of one or more consecutive configurations of the caller. Nothing is copied.
class Config {
public:
    Config(const double* data, std::size_t size) : data_(data), size_(size) {}
    /// A view of numbers that are written in the call itself, as in solver.query({0, 0.1}).
    Config(std::initializer_list<double> values) : Config(values.begin(), values.size()) {}
    /// A view of all numbers of several configurations.
    Config(const Rows& rows) : Config(rows.data(), rows.size() * rows.nq()) {}
    /// A view of anything with data() and size().
    template <class Vector, class = decltype(std::declval<const Vector&>().data()[0] + 0.0)>
    Config(const Vector& vector) : data_(vector.data()), size_(static_cast<std::size_t>(vector.size())) {}
    const double* data() const { return data_; }
    std::size_t size() const { return size_; }

private:
    const double* data_;
    std::size_t size_;
};

/// A pose: position [m] and unit quaternion x, y, z, w.
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

/// One shape, with lengths in metres. It holds its own numbers.
class Shape {
public:
    /// A box with these full sides.
    static Shape box(double x, double y, double z) { return Shape(EXTRICATE_BOX, x, y, z); }
    static Shape sphere(double radius) { return Shape(EXTRICATE_SPHERE, radius); }
    /// A cylinder along z.
    static Shape cylinder(double radius, double length) { return Shape(EXTRICATE_CYLINDER, radius, length); }
    /// A capsule along z; its cylindrical part has this `length`.
    static Shape capsule(double radius, double length) { return Shape(EXTRICATE_CAPSULE, radius, length); }
    /// A mesh of corners, three numbers each, and triangles, three indices each; or its convex hull.
    static Shape mesh(std::vector<double> corners, std::vector<std::uint32_t> triangles, bool convex = false) {
        Shape shape(EXTRICATE_MESH);
        shape.points_ = std::move(corners);
        shape.triangles_ = std::move(triangles);
        shape.convex_ = convex;
        return shape;
    }
    /// Balls of one radius around points, three numbers each. For obstacles only.
    static Shape points(std::vector<double> points, double radius) {
        Shape shape(EXTRICATE_POINTS, radius);
        shape.points_ = std::move(points);
        return shape;
    }
    /// Occupied cells of one side, three indices each. For obstacles only.
    static Shape voxels(std::vector<std::int32_t> cells, double side) {
        Shape shape(EXTRICATE_VOXELS, side);
        shape.cells_ = std::move(cells);
        return shape;
    }
    /// Everything behind the plane with this normal, at this offset along it. For obstacles only.
    static Shape half_space(double nx, double ny, double nz, double offset) {
        Shape shape(EXTRICATE_HALF_SPACE, nx, ny, nz);
        shape.offset_ = offset;
        return shape;
    }
    /// Names the first array that does not hold three numbers per element; empty if there is none.
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
    /// The shape as a structure of C, which points into this object.
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

/// An obstacle, or an object that a link holds. The pose of such an object is in the coordinates of the link.
struct Obstacle {
    std::string name;
    Shape shape;
    Pose pose = Pose();
    /// The obstacle as a structure of C, which points into this object.
    ExtricateObstacle raw() const { return ExtricateObstacle{name.c_str(), shape.raw(), pose}; }
};

namespace detail {
inline std::vector<const char*> pointers(const std::vector<std::string>& texts) {
    std::vector<const char*> all;
    for (const std::string& text : texts) all.push_back(text.c_str());
    return all;
}
/// Refuses an obstacle whose shape has an incomplete last point, triangle or cell.
inline bool is_whole(const Obstacle& obstacle) {
    const std::string problem = obstacle.shape.problem();
    return problem.empty() || refuse("obstacle \"" + shown(obstacle.name) + "\": " + problem);
}
}  // namespace detail

/// A scene, perhaps with a model that was learned from it or from a similar scene.
class Scene {
public:
    /// An empty object, to which a scene can be assigned.
    Scene() = default;
    /// Loads a scene file (TOML), a URDF or a model file.
    explicit Scene(const std::string& path) {
        take([&](ExtricateScene** out) { return extricate_load(path.c_str(), out); });
    }
    /// Makes a scene from the text of a scene file or of a URDF. Relative paths in the text start from
    /// `folder`. Each of `texts` is a path in the text and the content that replaces that file.
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
    /// Makes a scene that comes with the library.
    static Scene builtin(const std::string& name) {
        return made([&](ExtricateScene** out) { return extricate_scene_builtin(name.c_str(), out); });
    }
    /// Returns the same scene with a learned model: stored samples, which are additional starts of queries.
    /// See extricate_learn().
    Scene learn(std::size_t labels = 0, double seconds = HUGE_VAL, std::uint64_t seed = 0, std::size_t threads = 0) const {
        return made([&](ExtricateScene** out) { return extricate_learn(get(), labels, seconds, seed, threads, out); });
    }
    /// Writes the model that was learned from this scene to a file.
    bool save(const std::string& path) const { return detail::succeeded(extricate_save(get(), path.c_str())); }
    /// Prepares the scene now. Otherwise the first query or check does it.
    bool prepare() const { return detail::succeeded(extricate_scene_prepare(get())); }

    /// The scene with obstacles at other poses.
    Scene moved(const std::vector<std::pair<std::string, Pose>>& poses) const {
        std::vector<const char*> names;
        std::vector<ExtricatePose> all;
        for (const auto& [name, pose] : poses) {
            names.push_back(name.c_str());
            all.push_back(pose);
        }
        return made([&](ExtricateScene** out) { return extricate_scene_moved(get(), names.data(), all.data(), all.size(), out); });
    }
    /// The scene with additional obstacles.
    Scene with_obstacles(const std::vector<Obstacle>& obstacles) const {
        std::vector<ExtricateObstacle> all;
        for (const Obstacle& obstacle : obstacles) {
            if (!detail::is_whole(obstacle)) return Scene();
            all.push_back(obstacle.raw());
        }
        return made([&](ExtricateScene** out) { return extricate_scene_with_obstacles(get(), all.data(), all.size(), out); });
    }
    /// The scene without the named obstacles or attached objects.
    Scene without(const std::vector<std::string>& names) const {
        const auto all = detail::pointers(names);
        return made([&](ExtricateScene** out) { return extricate_scene_without(get(), all.data(), all.size(), out); });
    }
    /// The scene without any obstacle; attached objects stay.
    Scene without_obstacles() const {
        return made([&](ExtricateScene** out) { return extricate_scene_without_obstacles(get(), out); });
    }
    /// The scene that does not check these pairs of bodies.
    Scene disabled(const std::vector<std::pair<std::string, std::string>>& pairs) const {
        std::vector<const char*> all;
        for (const auto& [first, second] : pairs) all.insert(all.end(), {first.c_str(), second.c_str()});
        return made([&](ExtricateScene** out) { return extricate_scene_disabled(get(), all.data(), pairs.size(), out); });
    }
    /// The scene with an object that a link holds and that may touch the bodies in `touch`.
    Scene attached(const Obstacle& object, const std::string& link, const std::vector<std::string>& touch = {}) const {
        if (!detail::is_whole(object)) return Scene();
        const ExtricateObstacle held = object.raw();
        const auto all = detail::pointers(touch);
        return made([&](ExtricateScene** out) {
            return extricate_scene_attached(get(), &held, link.c_str(), all.data(), all.size(), out);
        });
    }
    /// The robots of the scene in the world of a file, see extricate_scene_in_world().
    Scene in_world(const std::string& path) const {
        return made([&](ExtricateScene** out) { return extricate_scene_in_world(get(), path.c_str(), out); });
    }
    /// The robots of the scene in the world of a text. The ending of `name` (.toml, .scene, .yaml, .json)
    /// sets the format.
    Scene in_world_text(const std::string& name, const std::string& text) const {
        if (!detail::is_whole("text", text)) return Scene();
        return made([&](ExtricateScene** out) {
            return extricate_scene_in_world_text(get(), name.c_str(), text.c_str(), out);
        });
    }

    /// Number of coordinates of a configuration.
    std::size_t nq() const { return extricate_scene_nq(get()); }
    /// Number of tangent coordinates: three for a rotation, which has four coordinates.
    std::size_t nv() const { return extricate_scene_nv(get()); }
    /// Whether a model was learned from exactly this scene; save() writes that model.
    bool is_learned() const { return extricate_scene_is_learned(get()); }
    /// Least distance that free configurations keep [m].
    double clearance() const { return extricate_scene_clearance(get()); }
    /// The metric in which depths are measured: EXTRICATE_METRIC_JOINT or another.
    std::uint32_t metric() const { return extricate_scene_metric(get()); }
    /// Names of the joints, in the order of coordinates.
    std::vector<std::string> joints() const { return texts(extricate_scene_joint_count(get()), extricate_scene_joint_name); }
    /// Names of the bodies, in the order of their indices.
    std::vector<std::string> bodies() const { return texts(extricate_scene_body_count(get()), extricate_scene_body_name); }
    /// Warnings about the scene, such as open meshes.
    std::vector<std::string> warnings() const { return texts(extricate_scene_warning_count(get()), extricate_scene_warning); }
    /// Number of checked pairs of bodies.
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
    /// The configuration in which these joints have these positions, one number each [rad or m].
    std::vector<double> config(const std::vector<std::string>& joints, const std::vector<double>& positions) const {
        std::vector<double> q(nq());
        const auto all = detail::pointers(joints);
        if (!detail::are_as_many("joints, positions", joints.size(), positions.size())) return {};
        const Status status = extricate_scene_config(get(), all.data(), positions.data(), all.size(), q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// The configuration in a message: a JointState, RobotState or PlanningScene. `name` ends in .yaml or
    /// .json.
    std::vector<double> config_text(const std::string& name, const std::string& text) const {
        if (!detail::is_whole("text", text)) return {};
        std::vector<double> q(nq());
        const Status status = extricate_scene_config_text(get(), name.c_str(), text.c_str(), q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// Distance between two configurations, in the scene's metric.
    double metric_distance(Config from, Config to) const {
        double distance = std::nan("");
        if (!detail::are_as_many("from, to", from.size(), to.size())) return distance;
        detail::succeeded(extricate_metric_distance(get(), from.data(), to.data(), to.size(), &distance));
        return distance;
    }
    /// Whether each of several consecutive configurations is free.
    std::vector<bool> check(Config rows, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        std::unique_ptr<bool[]> free(new bool[count ? count : 1]());
        if (!detail::succeeded(extricate_check_batch(get(), rows.data(), count, nq(), threads, free.get()))) return {};
        return std::vector<bool>(free.get(), free.get() + count);
    }
    /// Least signed distance of any checked pair [m] at each of several consecutive configurations.
    std::vector<double> distances(Config rows, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        std::vector<double> all(count);
        const Status status = extricate_distance_batch(get(), rows.data(), count, nq(), threads, all.data());
        return detail::succeeded(status) ? all : std::vector<double>();
    }

    /// Number of configurations in `rows`; 0 if `rows` is refused, for example if the last one is incomplete.
    std::size_t rows_of(Config rows) const {
        std::size_t count = 0;
        counts(rows, count);
        return count;
    }
    /// Writes the number of configurations in `rows`; returns false if `rows` is refused.
    bool counts(Config rows, std::size_t& count) const {
        const std::size_t size = nq();
        if (!scene_) return detail::refuse("scene: got none, expected one that was made");
        count = size ? rows.size() / size : 0;
        if (count * size == rows.size()) return true;
        count = 0;
        return detail::refuse("rows: got " + std::to_string(rows.size()) + " numbers, expected whole configurations of " +
                              std::to_string(size));
    }
    /// Whether there is a scene.
    explicit operator bool() const { return scene_ != nullptr; }
    /// The handle, for the functions of extricate.h.
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

/// Options of a query: the members of ExtricateOptions in types of C++. extricate.h explains them.
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
    /// Ends a query early if it returns true. Queries call it on any thread, and on several at once. It must
    /// not throw.
    std::function<bool()> stop;
};

namespace detail {
/// Options as a structure of C. It points into the options of C++ while C reads them, and to `stop` for as
/// long as queries may call it.
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

/// The answer to a query; empty if nothing free was found.
class Answer {
public:
    /// An empty answer.
    Answer() = default;
    /// Takes ownership of an answer of C. Its scene has `nq` coordinates and `nv` tangent coordinates.
    Answer(ExtricateAnswer* answer, std::size_t nq, std::size_t nv) : answer_(answer, extricate_answer_free), nq_(nq), nv_(nv) {}
    /// Whether there is a witness. If there is none, no other function of the answer may be called.
    explicit operator bool() const { return answer_ != nullptr; }
    /// All numbers of the answer.
    const ExtricateSummary& summary() const { return *extricate_answer_summary(get()); }
    /// Distance from the query to the witness, in the scene's metric; 0 if the query is free.
    double depth() const { return summary().depth; }
    /// Proved lower bound of the depth: no free configuration is nearer.
    double lower_bound() const { return summary().lower_bound; }
    /// Share of the depth that is not proved.
    double gap() const { return summary().gap; }
    /// Largest displacement of any point of the robot, from the query to the witness [m].
    double max_displacement() const { return summary().max_displacement; }
    /// Whether the query itself is free.
    bool is_free() const { return summary().is_free; }
    /// Whether the exact checker found the witness free during this query.
    bool verified() const { return summary().verified; }
    /// Whether no other distinct exit within 1 % of the depth was found.
    bool unique() const { return summary().unique; }
    /// Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    bool cut_short() const { return summary().cut_short; }
    /// The free configuration.
    Range<double> witness() const { return {extricate_answer_witness(get()), nq_}; }
    /// Gradient of the depth with respect to the query, in tangent coordinates.
    Range<double> gradient() const { return {extricate_answer_gradient(get()), nv_}; }
    /// Pairs that collide at the query.
    Range<ExtricatePair> colliding() const { return range<ExtricatePair>(extricate_answer_colliding); }
    /// Pairs that touch at the witness.
    Range<ExtricatePair> touching() const { return range<ExtricatePair>(extricate_answer_touching); }
    /// Coordinates of the query that are beyond their limits.
    Range<std::size_t> outside() const { return range<std::size_t>(extricate_answer_outside); }
    /// Contacts of bodies at the witness.
    Range<ExtricateContact> contacts() const { return range<ExtricateContact>(extricate_answer_contacts); }
    /// The distinct exits, nearest first, if the options request more than one.
    Range<ExtricateExit> exits() const { return range<ExtricateExit>(extricate_answer_exits); }
    /// A copy of the witness.
    std::vector<double> config() const { return {witness().begin(), witness().end()}; }
#ifdef EXTRICATE_WITH_EIGEN
    /// The witness as a vector of Eigen, which lives as long as the answer.
    Eigen::Map<const Eigen::VectorXd> vector() const { return {witness().data(), static_cast<Eigen::Index>(nq_)}; }
#endif
    /// The handle, for the functions of extricate.h.
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
/// A copy of `stop` with a fixed address.
using Stop = std::unique_ptr<std::function<bool()>>;
inline Stop kept(const Options& options) { return Stop(new std::function<bool()>(options.stop)); }
}  // namespace detail

/// The step that found the path of an escape.
enum class EscapeMethod : std::uint32_t {
    none = EXTRICATE_ESCAPE_NONE,
    free = EXTRICATE_ESCAPE_FREE,
    nearest = EXTRICATE_ESCAPE_NEAREST,
    exit = EXTRICATE_ESCAPE_EXIT,
    pushed = EXTRICATE_ESCAPE_PUSHED,
    grown = EXTRICATE_ESCAPE_GROWN,
};

/// The step that found the free part of a plan.
enum class PlanMethod : std::uint32_t {
    none = EXTRICATE_PLAN_NONE,
    straight = EXTRICATE_PLAN_STRAIGHT,
    trees = EXTRICATE_PLAN_TREES,
    roadmap = EXTRICATE_PLAN_ROADMAP,
};

/// Options of an escape: the members of ExtricateEscapeOptions, which extricate.h explains.
struct EscapeOptions {
    double aim = std::nan("");
    double tolerance = 1e-3;
    std::vector<double> toward;
    std::size_t exits = 6;
    double resolution = 1e-4;
    std::size_t tree_checks = 20000;
    std::uint64_t seed = 0;
    std::size_t max_checks = SIZE_MAX;
    double max_seconds = HUGE_VAL;
    /// Ends the call early if it returns true. It is called on any thread, on several at once, and must not
    /// throw.
    std::function<bool()> stop;
};

/// Options of a plan: the members of ExtricatePlanOptions, which extricate.h explains.
struct PlanOptions {
    double resolution = 1e-4;
    double tolerance = 1e-3;
    double clearance = std::nan("");
    bool shortcut = true;
    std::uint64_t seed = 0;
    std::size_t threads = 0;
    std::size_t max_checks = 1000000;
    double max_seconds = HUGE_VAL;
    /// As in EscapeOptions.
    std::function<bool()> stop;
};

/// Options of a repair: the members of ExtricateRepairOptions, which extricate.h explains.
struct RepairOptions {
    double aim = std::nan("");
    double max_deviation = HUGE_VAL;
    bool frames = false;
    double max_step = HUGE_VAL;
    double resolution = 1e-4;
    std::uint64_t seed = 0;
    std::size_t max_checks = 100000;
    double max_seconds = HUGE_VAL;
    /// As in EscapeOptions.
    std::function<bool()> stop;
};

namespace detail {
/// Makes C call `stop` during a call. `stop` outlives the call.
template <class RawOptions>
void pass_stop(const std::function<bool()>& stop, RawOptions& raw) {
    if (!stop) return;
    raw.stop = [](void* data) { return (*static_cast<const std::function<bool()>*>(data))(); };
    raw.stop_data = const_cast<std::function<bool()>*>(&stop);
}
/// Copies the numbers of a result of C. If the call that should make it failed, they are all zero.
template <class Summary>
Summary numbers(const Summary* summary) {
    return summary ? *summary : Summary{};
}
template <class Handle>
Rows rows(std::size_t (*list)(const Handle*, const double**), const Handle* handle, std::size_t nq) {
    const double* data = nullptr;
    const std::size_t size = list(handle, &data);
    return Rows(data, size, nq);
}
}  // namespace detail

/// A path out of collision. It is cheap to copy.
class Escape {
public:
    /// An empty escape.
    Escape() = default;
    /// Shares an escape of C. Its points have `nq` coordinates.
    Escape(std::shared_ptr<const ExtricateEscape> escape, std::size_t nq) : escape_(std::move(escape)), nq_(nq) {}
    /// Whether a path was found.
    explicit operator bool() const { return summary().found; }
    /// All numbers of the escape.
    ExtricateEscapeSummary summary() const { return detail::numbers(extricate_escape_summary(get())); }
    /// Configurations of the path, the query first, joined by geodesics; none if no path was found.
    Rows points() const { return detail::rows(extricate_escape_points, get(), nq_); }
    /// Index of the point from which on the path is proved free.
    std::size_t free_from() const { return summary().free_from; }
    /// The step that found the path.
    EscapeMethod method() const { return static_cast<EscapeMethod>(summary().method); }
    /// Pairs that collide at the query, and their signed distances there [m].
    Range<ExtricatePairDistance> colliding() const {
        Range<ExtricatePairDistance> all;
        all.count = extricate_escape_colliding(get(), &all.first);
        return all;
    }
    /// Most that any of these pairs was found deeper than at the query [m]; at most the tolerance, by proof.
    double deepening() const { return summary().deepening; }
    /// If no path was found: the least of 1, 2, 5 and 10 mm with which, as a larger tolerance, there is one
    /// [m]; nan if there is none.
    double needed_tolerance() const { return summary().needed_tolerance; }
    /// Length of the path in the scene's metric.
    double length() const { return summary().length; }
    /// Largest displacement of any point of the robot from the query to any point of the path [m].
    double max_displacement() const { return summary().max_displacement; }
    /// Number of configurations at which the exact checker evaluated anything.
    std::uint64_t checks() const { return summary().checks; }
    /// The handle, for the functions of extricate.h.
    const ExtricateEscape* get() const { return escape_.get(); }

private:
    std::shared_ptr<const ExtricateEscape> escape_;
    std::size_t nq_ = 0;
};

/// A path between two configurations. It is cheap to copy.
class Plan {
public:
    /// An empty plan.
    Plan() = default;
    /// Takes ownership of a plan of C. Its points have `nq` coordinates.
    Plan(ExtricatePlan* plan, std::size_t nq) : plan_(plan, extricate_plan_free), nq_(nq) {}
    /// Whether a path was found.
    explicit operator bool() const { return summary().found; }
    /// All numbers of the plan.
    ExtricatePlanSummary summary() const { return detail::numbers(extricate_plan_summary(get())); }
    /// Configurations from start to goal, joined by geodesics; none if no path was found.
    Rows points() const { return detail::rows(extricate_plan_points, get(), nq_); }
    /// Index of the point from which on the path is proved free; 0 if the start is free.
    std::size_t free_from() const { return summary().free_from; }
    /// Index of the point up to which the path is proved free; the last one if the goal is free.
    std::size_t free_to() const { return summary().free_to; }
    /// The step that found the free part.
    PlanMethod method() const { return static_cast<PlanMethod>(summary().method); }
    /// The path from a colliding start to the free part; none if the start is free. If no path out of
    /// collision was found, it has no points and says why.
    std::optional<Escape> start_escape() const { return escape(extricate_plan_start_escape(get())); }
    /// The same from a colliding goal, which the plan takes in reverse.
    std::optional<Escape> goal_escape() const { return escape(extricate_plan_goal_escape(get())); }
    /// Length of the path in the scene's metric.
    double length() const { return summary().length; }
    /// Number of configurations at which the exact checker evaluated anything.
    std::uint64_t checks() const { return summary().checks; }
    /// Number of configurations in the roadmap.
    std::size_t nodes() const { return summary().nodes; }
    /// The handle, for the functions of extricate.h.
    const ExtricatePlan* get() const { return plan_.get(); }

private:
    /// An escape that keeps the plan it is part of.
    std::optional<Escape> escape(const ExtricateEscape* part) const {
        if (!part) return std::nullopt;
        return Escape(std::shared_ptr<const ExtricateEscape>(plan_, part), nq_);
    }
    std::shared_ptr<const ExtricatePlan> plan_;
    std::size_t nq_ = 0;
};

/// A free path in place of one that collides. It is cheap to copy.
class Repaired {
public:
    /// An empty path.
    Repaired() = default;
    /// Takes ownership of a repaired path of C. Its points have `nq` coordinates.
    Repaired(ExtricateRepaired* repaired, std::size_t nq) : repaired_(repaired, extricate_repaired_free), nq_(nq) {}
    /// Whether a path was found.
    explicit operator bool() const { return summary().found; }
    /// All numbers of the repaired path.
    ExtricateRepairedSummary summary() const { return detail::numbers(extricate_repaired_summary(get())); }
    /// Configurations, joined by geodesics that are proved free; none if no path was found.
    Rows points() const { return detail::rows(extricate_repaired_points, get(), nq_); }
    /// The place of each point on the old path: 2.25 is a quarter of the edge from row 2 to row 3. Places
    /// ascend, and are whole numbers for rows that stay.
    Range<double> places() const {
        Range<double> all;
        all.count = extricate_repaired_places(get(), &all.first);
        return all;
    }
    /// Largest distance of a point from its place, in the scene's metric.
    double deviation() const { return summary().deviation; }
    /// Length of the path in the scene's metric.
    double length() const { return summary().length; }
    /// Length of the old path in the scene's metric.
    double length_before() const { return summary().length_before; }
    /// Number of stretches of the old path that were replaced.
    std::size_t stretches() const { return summary().stretches; }
    /// Number of gaps in these stretches that trees had to close.
    std::size_t gaps() const { return summary().gaps; }
    /// Number of configurations at which the exact checker evaluated anything.
    std::uint64_t checks() const { return summary().checks; }
    /// The handle, for the functions of extricate.h.
    const ExtricateRepaired* get() const { return repaired_.get(); }

private:
    std::shared_ptr<const ExtricateRepaired> repaired_;
    std::size_t nq_ = 0;
};

/// Answers queries of a scene with options that stay between calls, and checks configurations. Any number of
/// threads may use one solver; only set_options() needs a solver for itself.
class Solver {
public:
    /// Makes a solver, which keeps the scene.
    explicit Solver(Scene scene, const Options& options = Options()) : scene_(std::move(scene)), stop_(detail::kept(options)) {
        const detail::RawOptions raw(options, stop_.get());
        ExtricateSolver* out = nullptr;
        if (detail::succeeded(extricate_solver_new(scene_.get(), raw.get(), &out))) solver_.reset(out);
    }
    /// Sets the options of the queries that follow.
    bool set_options(const Options& options) {
        detail::Stop stop = detail::kept(options);
        const detail::RawOptions raw(options, stop.get());
        const bool done = detail::succeeded(extricate_solver_set_options(solver_.get(), raw.get()));
        if (done) stop_ = std::move(stop);
        return done;
    }
    /// The nearest free configuration; empty if nothing free was found.
    Answer query(Config q) const {
        return detail::answered(scene_, [&](ExtricateAnswer** out) { return extricate_query(solver_.get(), q.data(), q.size(), out); });
    }
    /// The witness of a query alone, in less time: nothing is proved, unless the effort is EXTRICATE_PROVED
    /// or the options set a gap. Empty if nothing free was found.
    std::vector<double> nearest_exit(Config q) const {
        std::vector<double> witness(q.size());
        const bool found = detail::succeeded(extricate_nearest_exit(solver_.get(), q.data(), q.size(), witness.data()));
        return found ? witness : std::vector<double>();
    }
    /// Runs queries for about this many seconds, so that the first real query is as fast as later ones.
    bool warm_up(double seconds = 0.03) const { return detail::succeeded(extricate_solver_warm_up(solver_.get(), seconds)); }
    /// Whether a configuration is within the limits and collides with nothing.
    bool check(Config q) const {
        bool free = false;
        detail::succeeded(extricate_check(solver_.get(), q.data(), q.size(), &free));
        return free;
    }
    /// Least signed distance of any checked pair [m].
    double distance(Config q) const {
        double distance = std::nan("");
        detail::succeeded(extricate_distance(solver_.get(), q.data(), q.size(), &distance));
        return distance;
    }
    /// Signed distances of all checked pairs [m], in their order.
    std::vector<double> pair_distances(Config q) const {
        std::vector<double> all(scene_.pair_count());
        const Status status = extricate_pair_distances(solver_.get(), q.data(), q.size(), all.data(), all.size());
        return detail::succeeded(status) ? all : std::vector<double>();
    }
    /// Checks whether the whole straight segment is free, by proof, not by sampling.
    ExtricateSegment check_segment(Config from, Config to, double resolution = 1e-4) const {
        ExtricateSegment segment{};
        if (!detail::are_as_many("from, to", from.size(), to.size())) return segment;
        detail::succeeded(extricate_check_segment(solver_.get(), from.data(), to.data(), to.size(), resolution, &segment));
        return segment;
    }
    /// A path out of collision, from `q` to a free configuration; see extricate_escape().
    Escape escape(Config q, const EscapeOptions& options = {}) const {
        ExtricateEscapeOptions raw;
        extricate_escape_options_init(&raw);
        raw.aim = options.aim;
        raw.tolerance = options.tolerance;
        raw.toward = options.toward.data();
        raw.toward_count = options.toward.size();
        raw.exits = options.exits;
        raw.resolution = options.resolution;
        raw.tree_checks = options.tree_checks;
        raw.seed = options.seed;
        raw.max_checks = options.max_checks;
        raw.max_seconds = options.max_seconds;
        detail::pass_stop(options.stop, raw);
        ExtricateEscape* out = nullptr;
        if (!detail::succeeded(extricate_escape(solver_.get(), q.data(), q.size(), &raw, &out))) return Escape();
        return Escape(std::shared_ptr<const ExtricateEscape>(out, extricate_escape_free), q.size());
    }
    /// A path from `start` to `goal`, with every edge proved; see extricate_plan().
    Plan plan(Config start, Config goal, const PlanOptions& options = {}) const {
        if (!detail::are_as_many("start, goal", start.size(), goal.size())) return Plan();
        ExtricatePlanOptions raw;
        extricate_plan_options_init(&raw);
        raw.resolution = options.resolution;
        raw.tolerance = options.tolerance;
        raw.clearance = options.clearance;
        raw.shortcut = options.shortcut;
        raw.seed = options.seed;
        raw.threads = options.threads;
        raw.max_checks = options.max_checks;
        raw.max_seconds = options.max_seconds;
        detail::pass_stop(options.stop, raw);
        ExtricatePlan* out = nullptr;
        const Status status = extricate_plan(solver_.get(), start.data(), goal.data(), start.size(), &raw, &out);
        return detail::succeeded(status) ? Plan(out, start.size()) : Plan();
    }
    /// A path that is proved free, as near as it can to the path of the consecutive configurations in `rows`;
    /// see extricate_repair().
    Repaired repair(Config rows, const RepairOptions& options = {}) const {
        std::size_t count = 0;
        if (!scene_.counts(rows, count)) return Repaired();
        ExtricateRepairOptions raw;
        extricate_repair_options_init(&raw);
        raw.aim = options.aim;
        raw.max_deviation = options.max_deviation;
        raw.frames = options.frames;
        raw.max_step = options.max_step;
        raw.resolution = options.resolution;
        raw.seed = options.seed;
        raw.max_checks = options.max_checks;
        raw.max_seconds = options.max_seconds;
        detail::pass_stop(options.stop, raw);
        ExtricateRepaired* out = nullptr;
        const std::size_t nq = scene_.nq();
        const Status status = extricate_repair(solver_.get(), rows.data(), count, nq, &raw, &out);
        return detail::succeeded(status) ? Repaired(out, nq) : Repaired();
    }
    /// The scene.
    const Scene& scene() const { return scene_; }
    /// Whether there is a solver; without exceptions, there is none if it could not be made.
    explicit operator bool() const { return solver_ != nullptr; }

private:
    struct Free {
        void operator()(ExtricateSolver* solver) const { extricate_solver_free(solver); }
    };
    Scene scene_;
    detail::Stop stop_;
    std::unique_ptr<ExtricateSolver, Free> solver_;
};

/// Answers to many queries, in the order of the queries.
struct Batch {
    /// The witnesses one after another, each with as many numbers as a query; nan if nothing free was found.
    std::vector<double> witnesses;
    /// The numbers of each answer.
    std::vector<ExtricateSummary> summaries;
};

/// Queries the consecutive configurations in `rows` on several threads (0: one per core).
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

/// Answers queries that are near each other, such as the frames of one motion; see extricate_stream_new().
/// One thread at a time may use it.
class Stream {
public:
    /// Makes a stream, which keeps the scene.
    explicit Stream(Scene scene, const Options& options = Options(), double hysteresis = 0, std::size_t starts_per_frame = 2)
        : scene_(std::move(scene)), stop_(detail::kept(options)) {
        const detail::RawOptions raw(options, stop_.get());
        ExtricateStream* out = nullptr;
        const Status status = extricate_stream_new(scene_.get(), raw.get(), hysteresis, starts_per_frame, &out);
        if (detail::succeeded(status)) stream_.reset(out);
    }
    /// Answers the next frame.
    Answer query(Config q) {
        return detail::answered(scene_, [&](ExtricateAnswer** out) { return extricate_stream_query(stream_.get(), q.data(), q.size(), out); });
    }
    /// Sets the scene of the frames that follow; it must have the same coordinates.
    bool set_scene(Scene scene) {
        const bool done = detail::succeeded(extricate_stream_set_scene(stream_.get(), scene.get()));
        if (done) scene_ = std::move(scene);
        return done;
    }
    /// Forgets the frames so far; the next frame is answered as a single query.
    bool restart() { return detail::succeeded(extricate_stream_restart(stream_.get())); }
    /// Whether there is a stream; without exceptions, there is none if it could not be made.
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
