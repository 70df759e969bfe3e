/* C++17 over extricate.h: objects that free themselves, and exceptions.
 *
 *     extricate::Scene scene("panda-box.toml");
 *     extricate::Solver solver(scene);
 *     std::vector<double> q(scene.nq());
 *     if (auto answer = solver.query(q)) use(answer->depth(), answer->witness());
 *
 * A configuration is anything with data() and size(): std::vector, std::array, Eigen::VectorXd. Several
 * configurations follow one another, as in a row-major matrix; Eigen's matrices of columns, and strided
 * vectors of Eigen, do not compile. With EXTRICATE_WITH_EIGEN defined, Eigen's isometries convert to
 * poses, and Answer::vector() returns the witness as a vector of Eigen.
 *
 * If a call fails, it throws extricate::Error. Without exceptions (-fno-exceptions) it returns an empty
 * object, nothing, nan or false. extricate::last_status() and last_error() then report the reason; each
 * thread has its own.
 *
 * A Scene, a Hand and all results never change and are cheap to copy. A Solver, a Stream and a Roadmap
 * are moved, not copied. Any number of threads may use one Scene, Hand, result or Solver at the same
 * time; only set_options() needs a Solver for itself. A Stream and a Roadmap are for one thread at a
 * time. */
#ifndef EXTRICATE_HPP
#define EXTRICATE_HPP

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "extricate.h"

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define EXTRICATE_HAS_EXCEPTIONS 1
#include <stdexcept>
#else
#define EXTRICATE_HAS_EXCEPTIONS 0
#endif

/* Marks calls that return whether they succeeded. With exceptions they throw if they did not. */
#if EXTRICATE_HAS_EXCEPTIONS
#define EXTRICATE_MUST_CHECK
#else
#define EXTRICATE_MUST_CHECK [[nodiscard]]
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
    [[nodiscard]] Status status() const { return status_; }

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
    [[nodiscard]] const T* begin() const { return first; }
    [[nodiscard]] const T* end() const { return first + count; }
    [[nodiscard]] std::size_t size() const { return count; }
    [[nodiscard]] bool empty() const { return count == 0; }
    [[nodiscard]] const T& operator[](std::size_t at) const { return first[at]; }
    [[nodiscard]] const T* data() const { return first; }
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
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    /// Number of coordinates of a configuration.
    [[nodiscard]] std::size_t nq() const { return nq_; }
    [[nodiscard]] Range<double> operator[](std::size_t at) const { return {data_ + at * nq_, nq_}; }
    [[nodiscard]] Range<double> front() const { return (*this)[0]; }
    [[nodiscard]] Range<double> back() const { return (*this)[size_ - 1]; }
    /// All numbers, one configuration after the other.
    [[nodiscard]] const double* data() const { return data_; }

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
    [[nodiscard]] Iterator begin() const { return {this, 0}; }
    [[nodiscard]] Iterator end() const { return {this, size_}; }

private:
    const double* data_ = nullptr;
    std::size_t size_ = 0, nq_ = 0;
};

/// How hard to search; extricate.h explains each effort.
enum class Effort : std::uint32_t {
    nearest = EXTRICATE_NEAREST,
    quick = EXTRICATE_QUICK,
    refined = EXTRICATE_REFINED,
    exhaustive = EXTRICATE_EXHAUSTIVE,
    proved = EXTRICATE_PROVED,
};

/// The metric in which depths are measured.
enum class Metric : std::uint32_t {
    joint = EXTRICATE_METRIC_JOINT,
    object_norm = EXTRICATE_METRIC_OBJECT_NORM,
    max_displacement = EXTRICATE_METRIC_MAX_DISPLACEMENT,
};

/// Why no lower bound above 0 is proved.
enum class Unproved : std::uint32_t {
    no = EXTRICATE_IS_PROVED,
    surfaces = EXTRICATE_UNPROVED_SURFACES,
    shallow = EXTRICATE_UNPROVED_SHALLOW,
    off = EXTRICATE_UNPROVED_OFF,
};

/// What samples are.
enum class Sample : std::uint32_t {
    any = EXTRICATE_ANY,
    free = EXTRICATE_FREE,
    colliding = EXTRICATE_COLLIDING,
};

namespace detail {
/// How an expression of Eigen lies in memory; other types have none of this.
template <class Vector, class = void>
struct Layout {
    static constexpr bool is_consecutive = true;
    static constexpr bool is_row_by_row = true;
};
template <class Vector>
struct Layout<Vector, std::void_t<decltype(Vector::IsVectorAtCompileTime), decltype(Vector::InnerStrideAtCompileTime),
                                  decltype(Vector::IsRowMajor), typename Vector::PlainObject>> {
    static constexpr bool is_consecutive = int(Vector::InnerStrideAtCompileTime) == 1;
    static constexpr bool is_row_by_row =
        bool(Vector::IsVectorAtCompileTime) ||
        (bool(Vector::IsRowMajor) && std::is_same<Vector, typename Vector::PlainObject>::value);
};
}  // namespace detail

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
    Config(const Vector& vector) : data_(vector.data()), size_(static_cast<std::size_t>(vector.size())) {
        static_assert(detail::Layout<Vector>::is_consecutive,
                      "extricate: the numbers of this vector lie apart in memory; copy it to an Eigen::VectorXd first");
        static_assert(detail::Layout<Vector>::is_row_by_row,
                      "extricate: this matrix does not lie row by row in memory; copy it to a row-major Eigen::Matrix "
                      "first, with a configuration in each row");
    }
    [[nodiscard]] const double* data() const { return data_; }
    [[nodiscard]] std::size_t size() const { return size_; }

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
    [[nodiscard]] static Shape box(double x, double y, double z) { return Shape(EXTRICATE_BOX, x, y, z); }
    [[nodiscard]] static Shape sphere(double radius) { return Shape(EXTRICATE_SPHERE, radius); }
    /// A cylinder along z.
    [[nodiscard]] static Shape cylinder(double radius, double length) { return Shape(EXTRICATE_CYLINDER, radius, length); }
    /// A capsule along z; its cylindrical part has this `length`.
    [[nodiscard]] static Shape capsule(double radius, double length) { return Shape(EXTRICATE_CAPSULE, radius, length); }
    /// A mesh of corners, three numbers each, and triangles, three indices each; or its convex hull.
    [[nodiscard]] static Shape mesh(std::vector<double> corners, std::vector<std::uint32_t> triangles, bool convex = false) {
        Shape shape(EXTRICATE_MESH);
        shape.points_ = std::move(corners);
        shape.triangles_ = std::move(triangles);
        shape.convex_ = convex;
        return shape;
    }
    /// Balls of one radius around points, three numbers each. For obstacles only.
    [[nodiscard]] static Shape points(std::vector<double> points, double radius) {
        Shape shape(EXTRICATE_POINTS, radius);
        shape.points_ = std::move(points);
        return shape;
    }
    /// Occupied cells of one side, three indices each. For obstacles only.
    [[nodiscard]] static Shape voxels(std::vector<std::int32_t> cells, double side) {
        Shape shape(EXTRICATE_VOXELS, side);
        shape.cells_ = std::move(cells);
        return shape;
    }
    /// Everything behind the plane with this normal, at this offset along it. For obstacles only.
    [[nodiscard]] static Shape half_space(double nx, double ny, double nz, double offset) {
        Shape shape(EXTRICATE_HALF_SPACE, nx, ny, nz);
        shape.offset_ = offset;
        return shape;
    }
    /// Ground whose heights are given on a grid with cells of this side: rows along x, `columns` heights each.
    /// For obstacles only.
    [[nodiscard]] static Shape height_field(std::vector<double> heights, std::size_t columns, double side) {
        Shape shape(EXTRICATE_HEIGHT_FIELD, side);
        shape.heights_ = std::move(heights);
        shape.columns_ = columns;
        return shape;
    }
    /// Names the first array that does not hold three numbers per element; empty if there is none.
    [[nodiscard]] std::string problem() const {
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
    [[nodiscard]] ExtricateShape raw() const {
        return ExtricateShape{kind_,           {size_[0], size_[1], size_[2]}, offset_,        points_.data(),
                              points_.size() / 3, triangles_.data(),          triangles_.size() / 3, cells_.data(),
                              cells_.size() / 3,  convex_ ? 1u : 0u,               heights_.data(), heights_.size(), columns_};
    }

private:
    explicit Shape(std::uint32_t kind, double x = 0, double y = 0, double z = 0) : kind_(kind), size_{x, y, z} {}
    std::uint32_t kind_;
    double size_[3];
    double offset_ = 0;
    std::vector<double> points_;
    std::vector<std::uint32_t> triangles_;
    std::vector<std::int32_t> cells_;
    std::vector<double> heights_;
    std::size_t columns_ = 0;
    bool convex_ = false;
};

/// An obstacle, or an object that a link holds. The pose of such an object is in the coordinates of the link.
struct Obstacle {
    std::string name;
    Shape shape;
    Pose pose = Pose();
    /// The obstacle as a structure of C, which points into this object.
    [[nodiscard]] ExtricateObstacle raw() const { return ExtricateObstacle{name.c_str(), shape.raw(), pose}; }
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

/// How files are loaded.
struct LoadOptions {
    /// Folders in which `package://NAME/...` is looked up first.
    std::vector<std::string> packages;
    /// Limits of what files may hold, in place of the default ones; docs/reference/limits.md lists their names.
    std::vector<std::pair<std::string, std::size_t>> limits;
};

namespace detail {
/// Load options as a structure of C, which points into those of C++.
class RawLoadOptions {
public:
    explicit RawLoadOptions(const LoadOptions& options) : packages_(pointers(options.packages)) {
        for (const auto& [name, most] : options.limits) limits_.push_back(ExtricateLoadLimit{name.c_str(), most});
        raw_ = ExtricateLoadOptions{packages_.data(), packages_.size(), limits_.data(), limits_.size()};
    }
    [[nodiscard]] const ExtricateLoadOptions* get() const { return &raw_; }

private:
    std::vector<const char*> packages_;
    std::vector<ExtricateLoadLimit> limits_;
    ExtricateLoadOptions raw_;
};
}  // namespace detail

/// Positions by joint [rad or m]: as many as the joint has coordinates.
using Positions = std::vector<std::pair<std::string, std::vector<double>>>;

/// The triangles of a body.
struct Mesh {
    /// Corners, three numbers each [m].
    std::vector<double> points;
    /// Indices of corners, three each, counterclockwise from outside.
    std::vector<std::uint32_t> triangles;
};

/// A scene, perhaps with a model that was learned from it or from a similar scene.
class Scene {
public:
    /// An empty object, to which a scene can be assigned.
    Scene() = default;
    /// Loads a scene file (TOML), a URDF or a model file.
    explicit Scene(const std::string& path, const LoadOptions& options = {}) {
        const detail::RawLoadOptions raw(options);
        take([&](ExtricateScene** out) { return extricate_load(path.c_str(), raw.get(), out); });
    }
    /// Makes a scene from the text of a scene file or of a URDF. Relative paths in the text start from
    /// `folder`. Each of `texts` is a path in the text and the content that replaces that file.
    [[nodiscard]] static Scene from_text(const std::string& text, const std::string& folder = "",
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
    [[nodiscard]] static Scene builtin(const std::string& name) {
        return made([&](ExtricateScene** out) { return extricate_scene_builtin(name.c_str(), out); });
    }
    /// Returns the same scene with a learned model: stored samples, which are additional starts of queries.
    /// See extricate_learn(). `progress` hears of the run, and ends it if it returns false.
    [[nodiscard]] Scene learn(std::size_t labels = 0, double seconds = HUGE_VAL, std::uint64_t seed = 0, std::size_t threads = 0,
                const std::function<bool(const ExtricateProgress&)>& progress = {}) const {
        using Hear = std::function<bool(const ExtricateProgress&)>;
        const auto tell = [](const ExtricateProgress* state, void* data) { return (*static_cast<const Hear*>(data))(*state); };
        return made([&](ExtricateScene** out) {
            return extricate_learn(get(), labels, seconds, seed, threads, progress ? +tell : nullptr,
                                   const_cast<Hear*>(&progress), out);
        });
    }
    /// Writes the model that was learned from this scene to a file.
    EXTRICATE_MUST_CHECK bool save(const std::string& path) const { return detail::succeeded(extricate_save(get(), path.c_str())); }
    /// Prepares the scene now. Otherwise the first query or check does it.
    EXTRICATE_MUST_CHECK bool prepare() const { return detail::succeeded(extricate_scene_prepare(get())); }

    /// The scene with obstacles at other poses.
    [[nodiscard]] Scene moved(const std::vector<std::pair<std::string, Pose>>& poses) const {
        std::vector<const char*> names;
        std::vector<ExtricatePose> all;
        for (const auto& [name, pose] : poses) {
            names.push_back(name.c_str());
            all.push_back(pose);
        }
        return made([&](ExtricateScene** out) { return extricate_scene_moved(get(), names.data(), all.data(), all.size(), out); });
    }
    /// The scene with additional obstacles.
    [[nodiscard]] Scene with_obstacles(const std::vector<Obstacle>& obstacles) const {
        std::vector<ExtricateObstacle> all;
        for (const Obstacle& obstacle : obstacles) {
            if (!detail::is_whole(obstacle)) return Scene();
            all.push_back(obstacle.raw());
        }
        return made([&](ExtricateScene** out) { return extricate_scene_with_obstacles(get(), all.data(), all.size(), out); });
    }
    /// The scene without the named obstacles or attached objects.
    [[nodiscard]] Scene without(const std::vector<std::string>& names) const {
        const auto all = detail::pointers(names);
        return made([&](ExtricateScene** out) { return extricate_scene_without(get(), all.data(), all.size(), out); });
    }
    /// The scene without any obstacle; attached objects stay.
    [[nodiscard]] Scene without_obstacles() const {
        return made([&](ExtricateScene** out) { return extricate_scene_without_obstacles(get(), out); });
    }
    /// The scene that does not check these pairs of bodies.
    [[nodiscard]] Scene disabled(const std::vector<std::pair<std::string, std::string>>& pairs) const {
        std::vector<const char*> all;
        for (const auto& [first, second] : pairs) all.insert(all.end(), {first.c_str(), second.c_str()});
        return made([&](ExtricateScene** out) { return extricate_scene_disabled(get(), all.data(), pairs.size(), out); });
    }
    /// The scene with an object that a link holds and that may touch the bodies in `touch`.
    [[nodiscard]] Scene attached(const Obstacle& object, const std::string& link, const std::vector<std::string>& touch = {}) const {
        if (!detail::is_whole(object)) return Scene();
        const ExtricateObstacle held = object.raw();
        const auto all = detail::pointers(touch);
        return made([&](ExtricateScene** out) {
            return extricate_scene_attached(get(), &held, link.c_str(), all.data(), all.size(), out);
        });
    }
    /// The robots of the scene in the world of a file, see extricate_scene_in_world().
    [[nodiscard]] Scene in_world(const std::string& path, const LoadOptions& options = {}) const {
        const detail::RawLoadOptions raw(options);
        return made([&](ExtricateScene** out) { return extricate_scene_in_world(get(), path.c_str(), raw.get(), out); });
    }
    /// The robots of the scene in the world of a text. The ending of `name` (.toml, .scene, .yaml, .json)
    /// sets the format.
    [[nodiscard]] Scene in_world_text(const std::string& name, const std::string& text) const {
        if (!detail::is_whole("text", text)) return Scene();
        return made([&](ExtricateScene** out) {
            return extricate_scene_in_world_text(get(), name.c_str(), text.c_str(), out);
        });
    }

    /// Number of coordinates of a configuration.
    [[nodiscard]] std::size_t nq() const { return extricate_scene_nq(get()); }
    /// Number of tangent coordinates: three for a rotation, which has four coordinates.
    [[nodiscard]] std::size_t nv() const { return extricate_scene_nv(get()); }
    /// Whether a model was learned from exactly this scene; save() writes that model.
    [[nodiscard]] bool is_learned() const { return extricate_scene_is_learned(get()); }
    /// Least distance that free configurations keep [m].
    [[nodiscard]] double clearance() const { return extricate_scene_clearance(get()); }
    /// The metric in which depths are measured.
    [[nodiscard]] Metric metric() const { return static_cast<Metric>(extricate_scene_metric(get())); }
    /// How the model was learned and its measured quality, as JSON; empty if there is no model.
    [[nodiscard]] std::string statistics() const {
        const char* text = extricate_scene_statistics(get());
        return text ? text : "";
    }
    /// The stored samples of the model: free configurations beside the boundary. They live as long as the scene.
    [[nodiscard]] Rows samples() const {
        const double* data = nullptr;
        const std::size_t size = extricate_scene_samples(get(), &data);
        return Rows(data, size, nq());
    }
    /// Names of the joints, in the order of coordinates.
    [[nodiscard]] std::vector<std::string> joints() const { return texts(extricate_scene_joint_count(get()), extricate_scene_joint_name); }
    /// Names of the bodies, in the order of their indices.
    [[nodiscard]] std::vector<std::string> bodies() const { return texts(extricate_scene_body_count(get()), extricate_scene_body_name); }
    /// Warnings about the scene, such as open meshes.
    [[nodiscard]] std::vector<std::string> warnings() const { return texts(extricate_scene_warning_count(get()), extricate_scene_warning); }
    /// Number of checked pairs of bodies.
    [[nodiscard]] std::size_t pair_count() const { return extricate_scene_pair_count(get()); }
    /// The checked pairs of bodies.
    [[nodiscard]] std::vector<ExtricatePair> pairs() const {
        std::vector<ExtricatePair> all;
        for (std::size_t at = 0; at < pair_count(); ++at) all.push_back(extricate_scene_pair(get(), at));
        return all;
    }
    /// Names of the bodies of a pair.
    [[nodiscard]] std::pair<std::string, std::string> names(const ExtricatePair& pair) const {
        const auto name = [&](std::size_t at) {
            const char* text = extricate_scene_body_name(get(), at);
            return std::string(text ? text : "");
        };
        return {name(pair.first), name(pair.second)};
    }
    /// Lower and upper limits of all coordinates.
    [[nodiscard]] std::pair<std::vector<double>, std::vector<double>> limits() const {
        std::vector<double> lower(nq()), upper(nq());
        if (!detail::succeeded(extricate_scene_limits(get(), lower.data(), upper.data(), nq()))) return {};
        return {lower, upper};
    }
    /// The configuration in which these joints have these positions, one number each [rad or m].
    [[nodiscard]] std::vector<double> config(const std::vector<std::string>& joints, const std::vector<double>& positions) const {
        std::vector<double> q(nq());
        const auto all = detail::pointers(joints);
        if (!detail::are_as_many("joints, positions", joints.size(), positions.size())) return {};
        const Status status = extricate_scene_config(get(), all.data(), nullptr, all.size(), positions.data(), positions.size(),
                                                     q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// The configuration in which these joints have these positions [rad or m].
    [[nodiscard]] std::vector<double> config(const Positions& positions) const {
        std::vector<double> q(nq()), values;
        std::vector<const char*> names;
        std::vector<std::size_t> sizes;
        for (const auto& [name, own] : positions) {
            names.push_back(name.c_str());
            sizes.push_back(own.size());
            values.insert(values.end(), own.begin(), own.end());
        }
        const Status status = extricate_scene_config(get(), names.data(), sizes.data(), names.size(), values.data(),
                                                     values.size(), q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// The positions by joint at a configuration, the inverse of config(); it includes mimic and locked joints.
    [[nodiscard]] Positions positions(Config q) const {
        ExtricatePositions* out = nullptr;
        if (!detail::succeeded(extricate_scene_positions(get(), q.data(), q.size(), &out))) return {};
        const std::unique_ptr<ExtricatePositions, void (*)(ExtricatePositions*)> held(out, extricate_positions_free);
        Positions all;
        for (std::size_t at = 0; at < extricate_positions_size(out); ++at) {
            const double* values = nullptr;
            const std::size_t count = extricate_positions_values(out, at, &values);
            all.emplace_back(extricate_positions_name(out, at), std::vector<double>(values, values + count));
        }
        return all;
    }
    /// Where bodies are in the world at each of several consecutive configurations: a 4 by 4 matrix for each
    /// configuration and name, row by row, see extricate_scene_poses(). No names mean all bodies.
    [[nodiscard]] std::vector<std::array<double, 16>> poses(Config rows, const std::vector<std::string>& names = {}) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        const auto of = detail::pointers(names);
        const std::size_t each = of.empty() ? extricate_scene_body_count(get()) : of.size();
        std::vector<std::array<double, 16>> all(count * each);
        const Status status = extricate_scene_poses(get(), of.data(), of.size(), rows.data(), count, nq(),
                                                    all.empty() ? nullptr : all[0].data(), all.size());
        return detail::succeeded(status) ? all : std::vector<std::array<double, 16>>();
    }
    /// The triangles of a body, to draw it at its place by poses(). Round shapes get `segments` sides.
    [[nodiscard]] Mesh mesh(std::size_t body, std::size_t segments = 32) const {
        ExtricateMesh* out = nullptr;
        if (!detail::succeeded(extricate_scene_mesh(get(), body, segments, &out))) return {};
        const std::unique_ptr<ExtricateMesh, void (*)(ExtricateMesh*)> held(out, extricate_mesh_free);
        const double* points = nullptr;
        const std::uint32_t* triangles = nullptr;
        const std::size_t point_count = extricate_mesh_points(out, &points);
        const std::size_t triangle_count = extricate_mesh_triangles(out, &triangles);
        return Mesh{std::vector<double>(points, points + 3 * point_count),
                    std::vector<std::uint32_t>(triangles, triangles + 3 * triangle_count)};
    }
    /// Which of these points, three numbers each [m], are not the robot's own: at `q`, no link is nearer to
    /// them than `padding` [m].
    [[nodiscard]] std::vector<bool> robot_filter(const std::vector<double>& points, Config q, double padding = 0) const {
        if (points.size() % 3 != 0) {
            detail::refuse("points: got " + std::to_string(points.size()) + " numbers, expected three each");
            return {};
        }
        const std::size_t count = points.size() / 3;
        std::unique_ptr<bool[]> keep(new bool[count ? count : 1]());
        const Status status =
            extricate_scene_robot_filter(get(), points.data(), count, q.data(), q.size(), padding, keep.get());
        if (!detail::succeeded(status)) return {};
        return std::vector<bool>(keep.get(), keep.get() + count);
    }
    /// Pairs of bodies that collide in at least this share of random configurations: most likely links that
    /// overlap by design, which disabled() takes off.
    [[nodiscard]] std::vector<ExtricatePair> always_colliding(std::size_t samples = 100, std::uint64_t seed = 0, double share = 1) const {
        std::vector<ExtricatePair> all(pair_count());
        std::size_t count = 0;
        const Status status = extricate_always_colliding(get(), samples, seed, share, all.data(), all.size(), &count);
        all.resize(detail::succeeded(status) ? count : 0);
        return all;
    }
    /// Uniformly random configurations within the limits, one after the other; see extricate_sample().
    [[nodiscard]] std::vector<double> sample(std::size_t count, Sample kind = Sample::any, std::uint64_t seed = 0) const {
        std::vector<double> all(count * nq());
        const Status status = extricate_sample(get(), static_cast<std::uint32_t>(kind), count, seed, all.data(), nq());
        return detail::succeeded(status) ? all : std::vector<double>();
    }
    /// Checks whether whole segments are free, by proof: from each of several consecutive configurations to the
    /// same one of `to`.
    [[nodiscard]] std::vector<ExtricateSegment> check_segments(Config from, Config to, double resolution = 1e-4, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(from, count) || !detail::are_as_many("from, to", from.size(), to.size())) return {};
        std::vector<ExtricateSegment> all(count);
        const Status status = extricate_check_segment_batch(get(), from.data(), to.data(), count, nq(), resolution, threads,
                                                            all.data());
        return detail::succeeded(status) ? all : std::vector<ExtricateSegment>();
    }
    /// The configuration in a message: a JointState, RobotState or PlanningScene. `name` ends in .yaml or
    /// .json.
    [[nodiscard]] std::vector<double> config_text(const std::string& name, const std::string& text) const {
        if (!detail::is_whole("text", text)) return {};
        std::vector<double> q(nq());
        const Status status = extricate_scene_config_text(get(), name.c_str(), text.c_str(), q.data(), q.size());
        return detail::succeeded(status) ? q : std::vector<double>();
    }
    /// Distance between two configurations, in the scene's metric.
    [[nodiscard]] double metric_distance(Config from, Config to) const {
        double distance = std::nan("");
        if (!detail::are_as_many("from, to", from.size(), to.size())) return distance;
        detail::succeeded(extricate_metric_distance(get(), from.data(), to.data(), to.size(), &distance));
        return distance;
    }
    /// Whether each of several consecutive configurations is free.
    [[nodiscard]] std::vector<bool> check(Config rows, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        std::unique_ptr<bool[]> free(new bool[count ? count : 1]());
        if (!detail::succeeded(extricate_check_batch(get(), rows.data(), count, nq(), threads, free.get()))) return {};
        return std::vector<bool>(free.get(), free.get() + count);
    }
    /// Least signed distance of any checked pair [m] at each of several consecutive configurations.
    [[nodiscard]] std::vector<double> distances(Config rows, std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!counts(rows, count)) return {};
        std::vector<double> all(count);
        const Status status = extricate_distance_batch(get(), rows.data(), count, nq(), threads, all.data());
        return detail::succeeded(status) ? all : std::vector<double>();
    }

    /// Number of configurations in `rows`; 0 if `rows` is refused, for example if the last one is incomplete.
    [[nodiscard]] std::size_t rows_of(Config rows) const {
        std::size_t count = 0;
        return counts(rows, count) ? count : 0;
    }
    /// Writes the number of configurations in `rows`; returns false if `rows` is refused.
    [[nodiscard]] bool counts(Config rows, std::size_t& count) const {
        const std::size_t size = nq();
        if (!scene_) return detail::refuse("scene: got none, expected one that was made");
        count = size ? rows.size() / size : 0;
        if (count * size == rows.size()) return true;
        count = 0;
        return detail::refuse("rows: got " + std::to_string(rows.size()) + " numbers, expected whole configurations of " +
                              std::to_string(size));
    }
    /// Whether there is a scene.
    [[nodiscard]] explicit operator bool() const { return scene_ != nullptr; }
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] const ExtricateScene* get() const { return scene_.get(); }

private:
    template <class Make>
    [[nodiscard]] static Scene made(Make make) {
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
    [[nodiscard]] std::vector<std::string> texts(std::size_t count, Name name) const {
        std::vector<std::string> all;
        for (std::size_t at = 0; at < count; ++at) all.emplace_back(name(get(), at));
        return all;
    }
    std::shared_ptr<ExtricateScene> scene_;
};

/// The weights of a joint in the joint metric: of its displacements, and of the rotation of a floating or planar
/// base. For other joints both are the same number.
struct Weight {
    std::string joint;
    double translation = 1, rotation = 1;
};

/// Options of a query: the members of ExtricateOptions in types of C++. extricate.h explains them.
struct Options {
    Effort effort = Effort::refined;
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
    std::vector<std::string> free;
    std::string keep;
    /// Pairs of bodies that have to touch at the witness, by their names: their distance is then at most 0.5 mm beyond the clearance.
    std::vector<std::array<std::string, 2>> touch;
    std::vector<Weight> weights;
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
    RawOptions(const Options& options, std::function<bool()>* stop) : locked_(pointers(options.locked)), free_(pointers(options.free)) {
        for (const auto& pair : options.touch)
            for (const std::string& name : pair) touch_.push_back(name.c_str());
        for (const Weight& one : options.weights)
            weights_.push_back(ExtricateWeight{one.joint.c_str(), one.translation, one.rotation});
        extricate_options_init(&raw_);
        raw_.effort = static_cast<std::uint32_t>(options.effort);
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
        raw_.free = free_.data();
        raw_.free_count = free_.size();
        raw_.keep = options.keep.empty() ? nullptr : options.keep.c_str();
        raw_.touch = touch_.data();
        raw_.touch_count = touch_.size();
        raw_.weights = weights_.data();
        raw_.weight_count = weights_.size();
        raw_.toward = options.toward.data();
        raw_.toward_count = options.toward.size();
        raw_.toward_share = options.toward_share;
        if (*stop) {
            raw_.stop = [](void* data) { return (*static_cast<std::function<bool()>*>(data))(); };
            raw_.stop_data = stop;
        }
    }
    [[nodiscard]] const ExtricateOptions* get() const { return &raw_; }

private:
    ExtricateOptions raw_;
    std::vector<const char*> locked_, free_, touch_;
    std::vector<ExtricateWeight> weights_;
};
}  // namespace detail

/// The answer to a query.
class Answer {
public:
    /// Takes ownership of an answer of C. Its scene has `nq` coordinates and `nv` tangent coordinates.
    Answer(ExtricateAnswer* answer, std::size_t nq, std::size_t nv) : answer_(answer, extricate_answer_free), nq_(nq), nv_(nv) {}
    /// All numbers of the answer.
    [[nodiscard]] const ExtricateSummary& summary() const { return *extricate_answer_summary(get()); }
    /// Distance from the query to the witness, in the scene's metric; 0 if the query is free.
    [[nodiscard]] double depth() const { return summary().depth; }
    /// Proved lower bound of the depth: no free configuration is nearer.
    [[nodiscard]] double lower_bound() const { return summary().lower_bound; }
    /// Share of the depth that is not proved.
    [[nodiscard]] double gap() const { return summary().gap; }
    /// Largest displacement of any point of the robot, from the query to the witness [m].
    [[nodiscard]] double max_displacement() const { return summary().max_displacement; }
    /// Whether the query itself is free.
    [[nodiscard]] bool is_free() const { return summary().is_free; }
    /// Whether the exact checker found the witness free during this query.
    [[nodiscard]] bool verified() const { return summary().verified; }
    /// Whether no other distinct exit within 1 % of the depth was found.
    [[nodiscard]] bool unique() const { return summary().unique; }
    /// Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    [[nodiscard]] bool cut_short() const { return summary().cut_short; }
    /// Why no lower bound above 0 is proved, if the query is not free.
    [[nodiscard]] Unproved unproved() const { return static_cast<Unproved>(summary().unproved); }
    /// Depth of the nearest exit, if the witness is the proxy of a continuous stream; nan if it is not.
    [[nodiscard]] double nearest() const { return summary().nearest; }
    /// Whether the proxy of a continuous stream goes back to the nearest exit along a path that was proved free.
    [[nodiscard]] bool detour() const { return summary().detour; }
    /// The free configuration.
    [[nodiscard]] Range<double> witness() const { return {extricate_answer_witness(get()), nq_}; }
    /// Gradient of the depth with respect to the query, in tangent coordinates.
    [[nodiscard]] Range<double> gradient() const { return {extricate_answer_gradient(get()), nv_}; }
    /// Pairs that collide at the query.
    [[nodiscard]] Range<ExtricatePair> colliding() const { return range<ExtricatePair>(extricate_answer_colliding); }
    /// Pairs that touch at the witness.
    [[nodiscard]] Range<ExtricatePair> touching() const { return range<ExtricatePair>(extricate_answer_touching); }
    /// Coordinates of the query that are beyond their limits.
    [[nodiscard]] Range<std::size_t> outside() const { return range<std::size_t>(extricate_answer_outside); }
    /// Kept links that are off at the query, as indices in the order of Options::keep.
    [[nodiscard]] Range<std::size_t> off() const { return range<std::size_t>(extricate_answer_off); }
    /// How far each kept link is off at the witness.
    [[nodiscard]] Range<ExtricateKeptError> kept() const { return range<ExtricateKeptError>(extricate_answer_kept); }
    /// Contacts of bodies at the witness.
    [[nodiscard]] Range<ExtricateContact> contacts() const { return range<ExtricateContact>(extricate_answer_contacts); }
    /// The distinct exits, nearest first, if the options request more than one.
    [[nodiscard]] Range<ExtricateExit> exits() const { return range<ExtricateExit>(extricate_answer_exits); }
    /// A copy of the witness.
    [[nodiscard]] std::vector<double> config() const { return {witness().begin(), witness().end()}; }
#ifdef EXTRICATE_WITH_EIGEN
    /// The witness as a vector of Eigen, which lives as long as the answer.
    [[nodiscard]] Eigen::Map<const Eigen::VectorXd> vector() const { return {witness().data(), static_cast<Eigen::Index>(nq_)}; }
#endif
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] const ExtricateAnswer* get() const { return answer_.get(); }

private:
    template <class T, class List>
    [[nodiscard]] Range<T> range(List list) const {
        Range<T> all;
        all.count = list(get(), &all.first);
        return all;
    }
    std::shared_ptr<ExtricateAnswer> answer_;
    std::size_t nq_ = 0, nv_ = 0;
};

namespace detail {
/// Whether a call found anything free. Throws any other failure.
inline bool found(Status status) {
    detail::status() = status;
    return status != EXTRICATE_NOTHING_FREE && succeeded(status);
}
template <class Ask>
std::optional<Answer> answered(const Scene& scene, Ask ask) {
    ExtricateAnswer* out = nullptr;
    if (!found(ask(&out))) return std::nullopt;
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
    std::string keep;
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
    std::string keep;
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
    std::string keep;
    bool frames = false;
    double max_step = HUGE_VAL;
    double touch = std::nan("");
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
    [[nodiscard]] explicit operator bool() const { return summary().found; }
    /// All numbers of the escape.
    [[nodiscard]] ExtricateEscapeSummary summary() const { return detail::numbers(extricate_escape_summary(get())); }
    /// Configurations of the path, the query first, joined by geodesics; none if no path was found.
    [[nodiscard]] Rows points() const { return detail::rows(extricate_escape_points, get(), nq_); }
    /// Index of the point from which on the path is proved free.
    [[nodiscard]] std::size_t free_from() const { return summary().free_from; }
    /// The step that found the path.
    [[nodiscard]] EscapeMethod method() const { return static_cast<EscapeMethod>(summary().method); }
    /// Pairs that collide at the query, and their signed distances there [m].
    [[nodiscard]] Range<ExtricatePairDistance> colliding() const {
        Range<ExtricatePairDistance> all;
        all.count = extricate_escape_colliding(get(), &all.first);
        return all;
    }
    /// Most that any of these pairs was found deeper than at the query [m]; at most the tolerance, by proof.
    [[nodiscard]] double deepening() const { return summary().deepening; }
    /// If no path was found: the least of 1, 2, 5 and 10 mm with which, as a larger tolerance, there is one
    /// [m]; nan if there is none.
    [[nodiscard]] double needed_tolerance() const { return summary().needed_tolerance; }
    /// Length of the path in the scene's metric.
    [[nodiscard]] double length() const { return summary().length; }
    /// Largest displacement of any point of the robot from the query to any point of the path [m].
    [[nodiscard]] double max_displacement() const { return summary().max_displacement; }
    /// Number of configurations at which the exact checker evaluated anything.
    [[nodiscard]] std::uint64_t checks() const { return summary().checks; }
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] const ExtricateEscape* get() const { return escape_.get(); }

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
    [[nodiscard]] explicit operator bool() const { return summary().found; }
    /// All numbers of the plan.
    [[nodiscard]] ExtricatePlanSummary summary() const { return detail::numbers(extricate_plan_summary(get())); }
    /// Configurations from start to goal, joined by geodesics; none if no path was found.
    [[nodiscard]] Rows points() const { return detail::rows(extricate_plan_points, get(), nq_); }
    /// Index of the point from which on the path is proved free; 0 if the start is free.
    [[nodiscard]] std::size_t free_from() const { return summary().free_from; }
    /// Index of the point up to which the path is proved free; the last one if the goal is free.
    [[nodiscard]] std::size_t free_to() const { return summary().free_to; }
    /// The step that found the free part.
    [[nodiscard]] PlanMethod method() const { return static_cast<PlanMethod>(summary().method); }
    /// The path from a colliding start to the free part; none if the start is free. If no path out of
    /// collision was found, it has no points and says why.
    [[nodiscard]] std::optional<Escape> start_escape() const { return escape(extricate_plan_start_escape(get())); }
    /// The same from a colliding goal, which the plan takes in reverse.
    [[nodiscard]] std::optional<Escape> goal_escape() const { return escape(extricate_plan_goal_escape(get())); }
    /// Length of the path in the scene's metric.
    [[nodiscard]] double length() const { return summary().length; }
    /// Number of configurations at which the exact checker evaluated anything.
    [[nodiscard]] std::uint64_t checks() const { return summary().checks; }
    /// Number of configurations in the roadmap.
    [[nodiscard]] std::size_t nodes() const { return summary().nodes; }
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] const ExtricatePlan* get() const { return plan_.get(); }

private:
    /// An escape that keeps the plan it is part of.
    [[nodiscard]] std::optional<Escape> escape(const ExtricateEscape* part) const {
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
    [[nodiscard]] explicit operator bool() const { return summary().found; }
    /// All numbers of the repaired path.
    [[nodiscard]] ExtricateRepairedSummary summary() const { return detail::numbers(extricate_repaired_summary(get())); }
    /// Configurations, joined by geodesics that are proved free; none if no path was found.
    [[nodiscard]] Rows points() const { return detail::rows(extricate_repaired_points, get(), nq_); }
    /// The place of each point on the old path: 2.25 is a quarter of the edge from row 2 to row 3. Places
    /// ascend, and are whole numbers for rows that stay.
    [[nodiscard]] Range<double> places() const {
        Range<double> all;
        all.count = extricate_repaired_places(get(), &all.first);
        return all;
    }
    /// Largest distance of a point from its place, in the scene's metric.
    [[nodiscard]] double deviation() const { return summary().deviation; }
    /// Length of the path in the scene's metric.
    [[nodiscard]] double length() const { return summary().length; }
    /// Length of the old path in the scene's metric.
    [[nodiscard]] double length_before() const { return summary().length_before; }
    /// Number of stretches of the old path that were replaced.
    [[nodiscard]] std::size_t stretches() const { return summary().stretches; }
    /// Number of gaps in these stretches that trees had to close.
    [[nodiscard]] std::size_t gaps() const { return summary().gaps; }
    /// Number of pairs that touch, summed over the rows; 0 without `touch`.
    [[nodiscard]] std::size_t touched() const { return summary().touched; }
    /// Number of these that touch in the result.
    [[nodiscard]] std::size_t kept() const { return summary().kept; }
    /// Number of configurations at which the exact checker evaluated anything.
    [[nodiscard]] std::uint64_t checks() const { return summary().checks; }
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] const ExtricateRepaired* get() const { return repaired_.get(); }

private:
    std::shared_ptr<const ExtricateRepaired> repaired_;
    std::size_t nq_ = 0;
};

/// Free configurations and proved edges between them, which the plans of one scene share. One thread at a time
/// may use it.
class Roadmap {
public:
    /// An empty roadmap of a scene.
    explicit Roadmap(const Scene& scene, std::uint64_t seed = 0) {
        ExtricateRoadmap* out = nullptr;
        if (detail::succeeded(extricate_roadmap_new(scene.get(), seed, &out))) roadmap_.reset(out);
    }
    /// Reads a roadmap file for a scene.
    [[nodiscard]] static Roadmap load(const std::string& path, const Scene& scene) {
        Roadmap roadmap;
        ExtricateRoadmap* out = nullptr;
        if (detail::succeeded(extricate_roadmap_load(path.c_str(), scene.get(), &out))) roadmap.roadmap_.reset(out);
        return roadmap;
    }
    /// Writes a roadmap file.
    EXTRICATE_MUST_CHECK bool save(const std::string& path) const { return detail::succeeded(extricate_roadmap_save(get(), path.c_str())); }
    /// Number of configurations.
    [[nodiscard]] std::size_t size() const { return extricate_roadmap_size(get()); }
    /// Number of proved edges.
    [[nodiscard]] std::size_t edges() const { return extricate_roadmap_edges(get()); }
    /// Number of configurations that were evaluated to make it.
    [[nodiscard]] std::size_t checks() const { return extricate_roadmap_checks(get()); }
    /// Whether there is a roadmap; without exceptions, there is none if it could not be made.
    [[nodiscard]] explicit operator bool() const { return roadmap_ != nullptr; }
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] ExtricateRoadmap* get() const { return roadmap_.get(); }

private:
    Roadmap() = default;
    struct Free {
        void operator()(ExtricateRoadmap* roadmap) const { extricate_roadmap_free(roadmap); }
    };
    std::unique_ptr<ExtricateRoadmap, Free> roadmap_;
};

/// The distance of a pair of bodies, and how it changes.
struct DistanceRow {
    /// The nearest contact of the pair.
    ExtricateContact contact;
    /// Derivative of its distance over the tangent coordinates [m per rad or m].
    std::vector<double> gradient;
};

/// How far a configuration is from the boundary of the free ones.
struct SignedDistance {
    /// Distance, proved bound and pair.
    ExtricateSignedDistance numbers;
    /// The nearest free configuration, or the nearest in contact; nan if there is none.
    std::vector<double> witness;
    /// Derivative of the distance over the tangent coordinates.
    std::vector<double> gradient;
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
    EXTRICATE_MUST_CHECK bool set_options(const Options& options) {
        detail::Stop stop = detail::kept(options);
        const detail::RawOptions raw(options, stop.get());
        const bool done = detail::succeeded(extricate_solver_set_options(solver_.get(), raw.get()));
        if (done) stop_ = std::move(stop);
        return done;
    }
    /// The nearest free configuration; nothing if none was found.
    [[nodiscard]] std::optional<Answer> query(Config q) const {
        return detail::answered(scene_, [&](ExtricateAnswer** out) { return extricate_query(solver_.get(), q.data(), q.size(), out); });
    }
    /// The witness of a query alone, in less time: nothing is proved, unless the effort is EXTRICATE_PROVED
    /// or the options set a gap. Nothing if nothing free was found.
    [[nodiscard]] std::optional<std::vector<double>> nearest_exit(Config q) const {
        std::vector<double> witness(q.size());
        if (!detail::found(extricate_nearest_exit(solver_.get(), q.data(), q.size(), witness.data()))) return std::nullopt;
        return witness;
    }
    /// Runs queries for about this many seconds, so that the first real query is as fast as later ones.
    EXTRICATE_MUST_CHECK bool warm_up(double seconds = 0.03) const { return detail::succeeded(extricate_solver_warm_up(solver_.get(), seconds)); }
    /// Whether a configuration is within the limits and collides with nothing.
    [[nodiscard]] bool check(Config q) const {
        bool free = false;
        detail::succeeded(extricate_check(solver_.get(), q.data(), q.size(), &free));
        return free;
    }
    /// Least signed distance of any checked pair [m].
    [[nodiscard]] double distance(Config q) const {
        double distance = std::nan("");
        detail::succeeded(extricate_distance(solver_.get(), q.data(), q.size(), &distance));
        return distance;
    }
    /// Radius of a ball around a configuration, in the scene's metric, in which everything within the limits is
    /// proved free; 0 if the configuration is not free.
    [[nodiscard]] double free_radius(Config q) const {
        double radius = std::nan("");
        detail::succeeded(extricate_free_radius(solver_.get(), q.data(), q.size(), &radius));
        return radius;
    }
    /// How far each of the consecutive configurations in `rows` is from the boundary of the free ones, on several
    /// threads (0: one per core). Free configurations farther than `within` are far enough; see
    /// extricate_signed_distances().
    [[nodiscard]] std::vector<SignedDistance> signed_distances(Config rows, double within = std::numeric_limits<double>::infinity(),
                                                               std::size_t threads = 0) const {
        std::size_t count = 0;
        if (!scene_.counts(rows, count)) return {};
        const std::size_t nq = scene_.nq(), nv = scene_.nv();
        std::vector<ExtricateSignedDistance> found(count);
        std::vector<double> witnesses(count * nq), gradients(count * nv);
        const Status status = extricate_signed_distances(solver_.get(), rows.data(), count, nq, nv, within, threads, found.data(),
                                                         witnesses.data(), gradients.data());
        std::vector<SignedDistance> all;
        if (!detail::succeeded(status)) return all;
        for (std::size_t at = 0; at < count; ++at)
            all.push_back({found[at], std::vector<double>(&witnesses[at * nq], &witnesses[at * nq] + nq),
                           std::vector<double>(&gradients[at * nv], &gradients[at * nv] + nv)});
        return all;
    }
    /// Signed distances of all checked pairs [m], in their order.
    [[nodiscard]] std::vector<double> pair_distances(Config q) const {
        std::vector<double> all(scene_.pair_count());
        const Status status = extricate_pair_distances(solver_.get(), q.data(), q.size(), all.data(), all.size());
        return detail::succeeded(status) ? all : std::vector<double>();
    }
    /// The pairs of bodies that collide at a configuration within the limits.
    [[nodiscard]] std::vector<ExtricatePair> colliding_pairs(Config q) const {
        std::vector<ExtricatePair> all(scene_.pair_count());
        std::size_t count = 0;
        const Status status = extricate_colliding_pairs(solver_.get(), q.data(), q.size(), all.data(), all.size(), &count);
        all.resize(detail::succeeded(status) ? count : 0);
        return all;
    }
    /// The contacts of all bodies that are nearer to each other than `within` [m], see extricate_contacts().
    [[nodiscard]] std::vector<ExtricateContact> contacts(Config q, double within) const {
        ExtricateContacts* out = nullptr;
        if (!detail::succeeded(extricate_contacts(solver_.get(), q.data(), q.size(), within, &out))) return {};
        const std::unique_ptr<ExtricateContacts, void (*)(ExtricateContacts*)> held(out, extricate_contacts_free);
        const ExtricateContact* list = nullptr;
        const std::size_t count = extricate_contacts_list(out, &list);
        return std::vector<ExtricateContact>(list, list + count);
    }
    /// The nearest contact of every pair nearer than `within` [m], with the gradient of its distance: the rows that
    /// controllers take. See extricate_distance_rows().
    [[nodiscard]] std::vector<DistanceRow> distance_rows(Config q, double within) const {
        ExtricateContacts* out = nullptr;
        if (!detail::succeeded(extricate_distance_rows(solver_.get(), q.data(), q.size(), within, &out))) return {};
        const std::unique_ptr<ExtricateContacts, void (*)(ExtricateContacts*)> held(out, extricate_contacts_free);
        const ExtricateContact* list = nullptr;
        const std::size_t count = extricate_contacts_list(out, &list), nv = scene_.nv();
        const double* gradients = extricate_contacts_gradients(out);
        std::vector<DistanceRow> rows;
        for (std::size_t at = 0; at < count; ++at)
            rows.push_back({list[at], std::vector<double>(gradients + at * nv, gradients + (at + 1) * nv)});
        return rows;
    }
    /// Checks whether the whole straight segment is free, by proof, not by sampling.
    [[nodiscard]] ExtricateSegment check_segment(Config from, Config to, double resolution = 1e-4) const {
        ExtricateSegment segment{};
        if (!detail::are_as_many("from, to", from.size(), to.size())) return segment;
        detail::succeeded(extricate_check_segment(solver_.get(), from.data(), to.data(), to.size(), resolution, &segment));
        return segment;
    }
    /// A path out of collision, from `q` to a free configuration; see extricate_escape().
    [[nodiscard]] Escape escape(Config q, const EscapeOptions& options = {}) const {
        ExtricateEscapeOptions raw;
        extricate_escape_options_init(&raw);
        raw.aim = options.aim;
        raw.tolerance = options.tolerance;
        raw.keep = options.keep.empty() ? nullptr : options.keep.c_str();
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
    [[nodiscard]] Plan plan(Config start, Config goal, const PlanOptions& options = {}) const {
        return plan_in(nullptr, start, goal, options);
    }
    /// The same with a roadmap of earlier plans, which it extends.
    [[nodiscard]] Plan plan(Config start, Config goal, Roadmap& roadmap, const PlanOptions& options = {}) const {
        if (!roadmap.get()) {
            detail::refuse("roadmap: got none, expected one that was made or loaded");
            return Plan();
        }
        return plan_in(roadmap.get(), start, goal, options);
    }
    /// A path that is proved free, as near as it can to the path of the consecutive configurations in `rows`;
    /// see extricate_repair().
    [[nodiscard]] Repaired repair(Config rows, const RepairOptions& options = {}) const {
        std::size_t count = 0;
        if (!scene_.counts(rows, count)) return Repaired();
        ExtricateRepairOptions raw;
        extricate_repair_options_init(&raw);
        raw.aim = options.aim;
        raw.max_deviation = options.max_deviation;
        raw.keep = options.keep.empty() ? nullptr : options.keep.c_str();
        raw.frames = options.frames;
        raw.max_step = options.max_step;
        raw.touch = options.touch;
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
    [[nodiscard]] const Scene& scene() const { return scene_; }
    /// Whether there is a solver; without exceptions, there is none if it could not be made.
    [[nodiscard]] explicit operator bool() const { return solver_ != nullptr; }

private:
    [[nodiscard]] Plan plan_in(ExtricateRoadmap* roadmap, Config start, Config goal, const PlanOptions& options) const {
        if (!detail::are_as_many("start, goal", start.size(), goal.size())) return Plan();
        ExtricatePlanOptions raw;
        extricate_plan_options_init(&raw);
        raw.resolution = options.resolution;
        raw.tolerance = options.tolerance;
        raw.keep = options.keep.empty() ? nullptr : options.keep.c_str();
        raw.clearance = options.clearance;
        raw.shortcut = options.shortcut;
        raw.seed = options.seed;
        raw.threads = options.threads;
        raw.max_checks = options.max_checks;
        raw.max_seconds = options.max_seconds;
        detail::pass_stop(options.stop, raw);
        ExtricatePlan* out = nullptr;
        const Status status = extricate_plan(solver_.get(), start.data(), goal.data(), start.size(), &raw, roadmap, &out);
        return detail::succeeded(status) ? Plan(out, start.size()) : Plan();
    }
    struct Free {
        void operator()(ExtricateSolver* solver) const { extricate_solver_free(solver); }
    };
    Scene scene_;
    detail::Stop stop_;
    std::unique_ptr<ExtricateSolver, Free> solver_;
};

/// Options of a release: the members of ExtricateReleaseOptions, which extricate.h explains.
struct ReleaseOptions {
    enum class Keep : std::uint32_t { contacts = EXTRICATE_KEEP_CONTACTS, pose = EXTRICATE_KEEP_POSE };
    Keep keep = Keep::contacts;
    double touch = 2e-3;
    double friction = 0.8;
    std::vector<double> open;
    double clearance = std::nan("");
    std::vector<std::string> locked;
    std::size_t max_checks = SIZE_MAX;
    double max_seconds = HUGE_VAL;
    /// As in EscapeOptions.
    std::function<bool()> stop;
};

/// A hand that holds an object and penetrates nothing. It is cheap to copy.
class Grasp {
public:
    /// Takes ownership of a grasp of C. Its configuration has `nq` coordinates.
    Grasp(ExtricateGrasp* grasp, std::size_t nq) : grasp_(grasp, extricate_grasp_free), nq_(nq) {}
    /// All numbers of the grasp.
    [[nodiscard]] const ExtricateGraspSummary& summary() const { return *extricate_grasp_summary(get()); }
    /// The configuration of all joints.
    [[nodiscard]] Range<double> config() const { return {extricate_grasp_config(get()), nq_}; }
    /// Distance from the query, in the scene's metric.
    [[nodiscard]] double moved() const { return summary().moved; }
    /// Whether the exact checker called it free during this call.
    [[nodiscard]] bool verified() const { return summary().verified; }
    /// Contacts with the object, link by link.
    [[nodiscard]] Range<ExtricateGraspContact> contacts() const {
        Range<ExtricateGraspContact> all;
        all.count = extricate_grasp_contacts(get(), &all.first);
        return all;
    }
    /// Names of the links that touched the object, or were in it, at the query.
    [[nodiscard]] std::vector<std::string> touched() const { return names(extricate_grasp_touched); }
    /// Names of those links that still touch it.
    [[nodiscard]] std::vector<std::string> kept() const { return names(extricate_grasp_kept); }
    /// The handle, for the functions of extricate.h.
    [[nodiscard]] const ExtricateGrasp* get() const { return grasp_.get(); }

private:
    template <class Name>
    [[nodiscard]] std::vector<std::string> names(Name name) const {
        std::vector<std::string> all;
        for (std::size_t at = 0; const char* text = name(get(), at); ++at) all.emplace_back(text);
        return all;
    }
    std::shared_ptr<const ExtricateGrasp> grasp_;
    std::size_t nq_;
};

/// A hand that can hold one obstacle of a scene. Any number of threads may use it; it is cheap to copy.
class Hand {
public:
    /// Finds the fingers and prepares what releases need; see extricate_hand_new().
    Hand(const Scene& scene, const std::string& object, bool scene_weights = false) : nq_(scene.nq()) {
        ExtricateHand* out = nullptr;
        if (detail::succeeded(extricate_hand_new(scene.get(), object.c_str(), scene_weights, &out)))
            hand_.reset(out, extricate_hand_free);
    }
    /// The nearest configuration at which nothing penetrates and the hand still holds the object; nothing if
    /// nothing free was found.
    [[nodiscard]] std::optional<Grasp> release(Config q, const ReleaseOptions& options = {}) const {
        const auto locked = detail::pointers(options.locked);
        ExtricateReleaseOptions raw;
        extricate_release_options_init(&raw);
        raw.keep = static_cast<std::uint32_t>(options.keep);
        raw.touch = options.touch;
        raw.friction = options.friction;
        raw.open = options.open.data();
        raw.open_count = options.open.size();
        raw.clearance = options.clearance;
        raw.locked = locked.data();
        raw.locked_count = locked.size();
        raw.max_checks = options.max_checks;
        raw.max_seconds = options.max_seconds;
        detail::pass_stop(options.stop, raw);
        ExtricateGrasp* out = nullptr;
        if (!detail::found(extricate_release(hand_.get(), q.data(), q.size(), &raw, &out))) return std::nullopt;
        return Grasp(out, nq_);
    }
    /// Whether there is a hand; without exceptions, there is none if it could not be made.
    [[nodiscard]] explicit operator bool() const { return hand_ != nullptr; }

private:
    std::shared_ptr<ExtricateHand> hand_;
    std::size_t nq_;
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

/// Options of a stream: the members of ExtricateStreamOptions, which extricate.h explains.
struct StreamOptions {
    double hysteresis = 0;
    std::size_t starts_per_frame = 2;
    bool continuous = false;
};

/// Answers queries that are near each other, such as the frames of one motion; see extricate_stream_new().
/// One thread at a time may use it.
class Stream {
public:
    /// Makes a stream, which keeps the scene.
    explicit Stream(Scene scene, const Options& options = Options(), const StreamOptions& stream_options = {})
        : scene_(std::move(scene)), stop_(detail::kept(options)) {
        const detail::RawOptions raw(options, stop_.get());
        ExtricateStream* out = nullptr;
        const ExtricateStreamOptions own{stream_options.hysteresis, stream_options.starts_per_frame, stream_options.continuous};
        const Status status = extricate_stream_new(scene_.get(), raw.get(), &own, &out);
        if (detail::succeeded(status)) stream_.reset(out);
    }
    /// Answers the next frame; nothing if nothing free was found.
    [[nodiscard]] std::optional<Answer> query(Config q) {
        return detail::answered(scene_, [&](ExtricateAnswer** out) { return extricate_stream_query(stream_.get(), q.data(), q.size(), out); });
    }
    /// Sets the scene of the frames that follow; it must have the same coordinates.
    EXTRICATE_MUST_CHECK bool set_scene(Scene scene) {
        const bool done = detail::succeeded(extricate_stream_set_scene(stream_.get(), scene.get()));
        if (done) scene_ = std::move(scene);
        return done;
    }
    /// Forgets the frames so far; the next frame is answered as a single query.
    EXTRICATE_MUST_CHECK bool restart() { return detail::succeeded(extricate_stream_restart(stream_.get())); }
    /// Whether there is a stream; without exceptions, there is none if it could not be made.
    [[nodiscard]] explicit operator bool() const { return stream_ != nullptr; }

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
