// Messages of ROS 2 that the adapters read, as structs: moveit_msgs 2.6 (Jazzy), octomap_msgs 2.0, shape_msgs,
// geometry_msgs and std_msgs 5.3. Members that nothing here reads are left out.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace std_msgs::msg {
struct Header {
    std::string frame_id;
};
struct String {
    std::string data;
};
}  // namespace std_msgs::msg

namespace geometry_msgs::msg {
struct Point {
    double x = 0, y = 0, z = 0;
};
using Vector3 = Point;
struct Quaternion {
    double x = 0, y = 0, z = 0, w = 1;
};
struct Pose {
    Point position;
    Quaternion orientation;
};
struct Transform {
    Vector3 translation;
    Quaternion rotation;
};
struct TransformStamped {
    std_msgs::msg::Header header;
    std::string child_frame_id;
    Transform transform;
};
}  // namespace geometry_msgs::msg

namespace shape_msgs::msg {
struct SolidPrimitive {
    static constexpr std::uint8_t BOX = 1, SPHERE = 2, CYLINDER = 3, CONE = 4;
    std::uint8_t type = 0;
    std::vector<double> dimensions;
};
struct MeshTriangle {
    std::array<std::uint32_t, 3> vertex_indices{};
};
struct Mesh {
    std::vector<MeshTriangle> triangles;
    std::vector<geometry_msgs::msg::Point> vertices;
};
struct Plane {
    std::array<double, 4> coef{};
};
}  // namespace shape_msgs::msg

namespace octomap_msgs::msg {
struct Octomap {
    std_msgs::msg::Header header;
    bool binary = false;
    std::string id;
    double resolution = 0;
    std::vector<std::int8_t> data;
};
struct OctomapWithPose {
    std_msgs::msg::Header header;
    geometry_msgs::msg::Pose origin;
    Octomap octomap;
};
}  // namespace octomap_msgs::msg

namespace sensor_msgs::msg {
struct JointState {
    std::vector<std::string> name;
    std::vector<double> position;
};
struct MultiDOFJointState {
    std::vector<std::string> joint_names;
    std::vector<geometry_msgs::msg::Transform> transforms;
};
}  // namespace sensor_msgs::msg

namespace moveit_msgs::msg {
struct CollisionObject {
    static constexpr std::uint8_t ADD = 0, REMOVE = 1, APPEND = 2, MOVE = 3;
    std_msgs::msg::Header header;
    geometry_msgs::msg::Pose pose;
    std::string id;
    std::vector<shape_msgs::msg::SolidPrimitive> primitives;
    std::vector<geometry_msgs::msg::Pose> primitive_poses;
    std::vector<shape_msgs::msg::Mesh> meshes;
    std::vector<geometry_msgs::msg::Pose> mesh_poses;
    std::vector<shape_msgs::msg::Plane> planes;
    std::vector<geometry_msgs::msg::Pose> plane_poses;
    std::uint8_t operation = ADD;
};
struct AttachedCollisionObject {
    std::string link_name;
    CollisionObject object;
    std::vector<std::string> touch_links;
};
struct RobotState {
    sensor_msgs::msg::JointState joint_state;
    sensor_msgs::msg::MultiDOFJointState multi_dof_joint_state;
    std::vector<AttachedCollisionObject> attached_collision_objects;
    bool is_diff = false;
};
struct AllowedCollisionEntry {
    std::vector<bool> enabled;
};
struct AllowedCollisionMatrix {
    std::vector<std::string> entry_names;
    std::vector<AllowedCollisionEntry> entry_values;
    std::vector<std::string> default_entry_names;
    std::vector<bool> default_entry_values;
};
struct LinkPadding {
    std::string link_name;
    double padding = 0;
};
struct LinkScale {
    std::string link_name;
    double scale = 1;
};
struct PlanningSceneWorld {
    std::vector<CollisionObject> collision_objects;
    octomap_msgs::msg::OctomapWithPose octomap;
};
struct PlanningScene {
    RobotState robot_state;
    std::vector<geometry_msgs::msg::TransformStamped> fixed_frame_transforms;
    AllowedCollisionMatrix allowed_collision_matrix;
    std::vector<LinkPadding> link_padding;
    std::vector<LinkScale> link_scale;
    PlanningSceneWorld world;
    bool is_diff = false;
};
struct JointConstraint {
    std::string joint_name;
    double position = 0;
};
struct Constraints {
    std::vector<JointConstraint> joint_constraints;
};
struct MoveItErrorCodes {
    static constexpr int SUCCESS = 1, FAILURE = 99999, START_STATE_IN_COLLISION = -10;
    int val = 0;
    std::string message, source;
};
}  // namespace moveit_msgs::msg
