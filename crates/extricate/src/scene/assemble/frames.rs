//! Builds the kinematic tree: elementary frames for every joint that moves, and the seat of each
//! link.

use super::joint_roles::JointRole;
use crate::math::{Mat3, Pose, Vec3, axis_rotation};
use crate::robot::{JointKind, Robot};
use crate::scene::{Coordinate, Frame, Motion};

/// First coordinate and first tangent coordinate of a factor of the configuration space.
pub type FactorStart = (usize, usize);

/// The kinematic tree of all robots.
#[derive(Debug, Clone)]
pub struct Tree {
    /// `frames[0]` is the world; a parent precedes its children.
    pub frames: Vec<Frame>,
    /// For every frame, the frame that carries its whole joint, past the intermediate frames of a
    /// composite joint. Bodies on both are neighbours. 0 for the world.
    pub carriers: Vec<usize>,
}

/// The seat of a link: a frame, and the link's pose on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePlacement {
    /// Index of the frame that the link is fixed to.
    pub frame: usize,
    /// Maps link coordinates to frame coordinates.
    pub pose_frame_link: Pose,
}

/// A joint that moves, from which [`Tree::attach`] makes frames.
#[derive(Debug, Clone, Copy)]
pub struct Mover<'a> {
    /// Name of its frames.
    pub name: &'a str,
    /// Kind of the joint.
    pub kind: JointKind,
    /// Unit axis in the joint's frame.
    pub axis: Vec3,
    /// Places of its factors in the configuration space; a follower has those of its leader.
    pub places: &'a [FactorStart],
    /// Factor of a follower; 1 for other joints.
    pub multiplier: f64,
    /// Offset of a follower \[rad or m\]; 0 for other joints.
    pub offset: f64,
}

impl Default for Tree {
    fn default() -> Self {
        let world =
            Frame { name: "world".into(), parent: 0, pose_parent_joint: Pose::identity(), motion: Motion::World };
        Self { frames: vec![world], carriers: vec![0] }
    }
}

impl Tree {
    /// Adds the frames of a joint at `seat`, whose pose maps joint coordinates to frame
    /// coordinates. Returns the seat of the link that the joint moves.
    pub fn attach(&mut self, seat: FramePlacement, mover: &Mover) -> FramePlacement {
        let mut parent = seat.frame;
        let mut pose = seat.pose_frame_link;
        for motion in motions(mover) {
            self.frames.push(Frame { name: mover.name.into(), parent, pose_parent_joint: pose, motion });
            self.carriers.push(seat.frame);
            parent = self.frames.len() - 1;
            pose = Pose::identity();
        }
        FramePlacement { frame: parent, pose_frame_link: pose }
    }

    /// Adds the frames of a robot whose root link sits on `root`. Returns the seat of every link,
    /// or `None` for a link that no chain of joints connects to the root.
    ///
    /// `roles`, `names` and `places` are by joint in document order. The walk starts at the root,
    /// so that a parent's frame precedes its children's in any order of the document.
    pub fn add_robot(
        &mut self,
        robot: &Robot,
        root: FramePlacement,
        roles: &[JointRole],
        names: &[String],
        places: &[Vec<FactorStart>],
    ) -> Vec<Option<FramePlacement>> {
        let mut children = vec![Vec::new(); robot.links.len()];
        for (index, joint) in robot.joints.iter().enumerate().rev() {
            children[joint.parent].push(index);
        }
        let mut seats = vec![None; robot.links.len()];
        seats[robot.root] = Some(root);
        let mut open: Vec<(FramePlacement, usize)> = children[robot.root].iter().map(|&joint| (root, joint)).collect();
        while let Some((parent, index)) = open.pop() {
            let joint = &robot.joints[index];
            let at =
                FramePlacement { pose_frame_link: parent.pose_frame_link.then(&joint.pose_parent_joint), ..parent };
            let mover = |leader: usize, multiplier, offset| Mover {
                name: &names[index],
                kind: joint.kind,
                axis: joint.axis,
                places: &places[leader],
                multiplier,
                offset,
            };
            let seat = match roles[index] {
                JointRole::Locked(position) => {
                    let shift = rigid_motion(joint.kind, &joint.axis, position);
                    FramePlacement { pose_frame_link: at.pose_frame_link.then(&shift), ..at }
                }
                JointRole::Mimic { joint: leader, multiplier, offset } => {
                    self.attach(at, &mover(leader, multiplier, offset))
                }
                JointRole::Active(_) => self.attach(at, &mover(index, 1.0, 0.0)),
            };
            if seats[joint.child].is_none() {
                seats[joint.child] = Some(seat);
                open.extend(children[joint.child].iter().map(|&next| (seat, next)));
            }
        }
        seats
    }
}

fn rigid_motion(kind: JointKind, axis: &Vec3, position: f64) -> Pose {
    match kind {
        JointKind::Revolute | JointKind::Continuous => {
            Pose { rotation: axis_rotation(axis, position), translation: Vec3::zeros() }
        }
        JointKind::Prismatic => Pose::translation(axis * position),
        JointKind::Fixed | JointKind::Planar | JointKind::Spherical | JointKind::Floating => Pose::identity(),
    }
}

/// Returns the elementary motions of a joint, outermost first.
fn motions(mover: &Mover) -> Vec<Motion> {
    let place = |k: usize| {
        let (q, v) = mover.places[k];
        Coordinate { q, v, multiplier: mover.multiplier, offset: mover.offset }
    };
    let ball = |k: usize| Motion::Ball { q: mover.places[k].0, v: mover.places[k].1 };
    let slide = |axis: Vec3, k: usize| Motion::Prismatic { axis, coordinate: place(k) };
    match mover.kind {
        JointKind::Fixed => Vec::new(),
        JointKind::Revolute | JointKind::Continuous => {
            vec![Motion::Revolute { axis: mover.axis, coordinate: place(0) }]
        }
        JointKind::Prismatic => vec![slide(mover.axis, 0)],
        JointKind::Planar => {
            let plane = plane_axes(&mover.axis);
            let turn = Motion::Revolute { axis: mover.axis, coordinate: place(2) };
            vec![slide(plane[0], 0), slide(plane[1], 1), turn]
        }
        JointKind::Spherical => vec![ball(0)],
        JointKind::Floating => vec![slide(Vec3::x(), 0), slide(Vec3::y(), 1), slide(Vec3::z(), 2), ball(3)],
    }
}

/// Returns the images of x and y under the smallest rotation that takes z to `normal`; for -z it is
/// the one about x.
fn plane_axes(normal: &Vec3) -> [Vec3; 2] {
    let rotation = nalgebra::Rotation3::rotation_between(&Vec3::z(), normal)
        .map_or(Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0)), |rotation| rotation.into_inner());
    [rotation * Vec3::x(), rotation * Vec3::y()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::forward;
    use crate::math::{quaternion_exp, quaternion_matrix};
    use crate::scene::Scene;
    use crate::scene::testing::{PLAIN, chain, joint, robot, scene};
    use JointKind::*;

    /// Returns the world poses of all bodies at `q`.
    fn bodies(scene: &Scene, q: &[f64]) -> Vec<Pose> {
        let mut poses = Vec::new();
        forward(scene, &scene.space.config(q).unwrap(), &mut poses);
        scene.bodies.iter().map(|body| poses[body.frame].then(&body.parts[0].pose_frame_part)).collect()
    }

    #[test]
    fn document_order_gives_coordinates_and_the_tree_gives_frames() {
        // The document has a child's joint before its parent's.
        let joints = vec![joint("tip", Prismatic, 2, 3), joint("side", Revolute, 0, 1), joint("root", Revolute, 0, 2)];
        let scene = scene(PLAIN, &[robot(joints)]).unwrap();
        let names: Vec<&str> = scene.joints.iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names, ["tip", "side", "root"]);
        assert!((1..scene.frames.len()).all(|k| scene.frames[k].parent < k));
        let poses = bodies(&scene, &[0.3, 0.0, 0.2]);
        assert!((poses[3].translation - Vec3::new(1.0 + 0.2f64.cos(), 0.2f64.sin(), 0.3)).norm() < 1e-12);
    }

    #[test]
    fn planar_base_moves_in_the_plane_of_its_pose() {
        let text = format!(
            "{PLAIN}base = 'planar'\nbounds = {{ min = [-9, -9], max = [9, 9] }}\npose = {{ xyz = [0, 0, 5], rpy = [0, 0, 1] }}"
        );
        let scene = scene(&text, &[chain(&[Revolute])]).unwrap();
        assert_eq!((scene.joints[0].name.as_str(), scene.joints[0].kind.as_str()), ("base", "planar"));
        assert_eq!(scene.joints[0].q, 0..3);
        let poses = bodies(&scene, &[2.0, 3.0, 0.5, 0.25]);
        let placed = Pose::from_xyz_rpy([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]);
        let base = placed.then(&Pose::from_xyz_rpy([2.0, 3.0, 0.0], [0.0, 0.0, 0.5]));
        assert!((poses[0].translation - base.translation).norm() < 1e-12);
        assert!((poses[0].rotation - base.rotation).norm() < 1e-12);
        let l1 = base.then(&Pose::from_xyz_rpy([1.0, 0.0, 0.0], [0.0, 0.0, 0.25]));
        assert!(
            (poses[1].rotation - l1.rotation).norm() < 1e-12 && (poses[1].translation - l1.translation).norm() < 1e-12
        );
    }

    #[test]
    fn floating_and_spherical_joints_turn_by_their_quaternion() {
        let text = format!("{PLAIN}base = 'floating'\nbounds = {{ min = [-9, -9, -9], max = [9, 9, 9] }}");
        let scene = scene(&text, &[chain(&[Spherical])]).unwrap();
        assert_eq!((scene.space.nq(), scene.space.nv()), (11, 9));
        let (a, b) = (quaternion_exp(&[0.3, -0.4, 0.5]), quaternion_exp(&[-1.0, 0.2, 0.1]));
        let q: Vec<f64> = [1.0, 2.0, 3.0].into_iter().chain(a).chain(b).collect();
        let poses = bodies(&scene, &q);
        let turn = quaternion_matrix(&a);
        assert!((poses[0].translation - Vec3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
        assert!((poses[0].rotation - turn).norm() < 1e-12);
        assert!((poses[1].translation - (Vec3::new(1.0, 2.0, 3.0) + turn * Vec3::x())).norm() < 1e-12);
        assert!((poses[1].rotation - turn * quaternion_matrix(&b)).norm() < 1e-12);
    }

    #[test]
    fn planar_joint_slides_across_its_axis() {
        let mut arm = chain(&[Planar]);
        arm.joints[0].axis = Vec3::x();
        arm.joints[0].limits = Some((-1.0, 1.0));
        let poses = bodies(&scene(PLAIN, &[arm]).unwrap(), &[0.5, 0.25, 0.1]);
        assert!((poses[1].translation - Vec3::new(1.0, 0.25, -0.5)).norm() < 1e-12);
        assert!((poses[1].rotation - axis_rotation(&Vec3::x(), 0.1)).norm() < 1e-12);
    }

    #[test]
    fn plane_axes_are_right_handed_and_x_y_for_z() {
        assert_eq!(plane_axes(&Vec3::z()), [Vec3::x(), Vec3::y()]);
        assert_eq!(plane_axes(&-Vec3::z()), [Vec3::x(), -Vec3::y()]);
        for normal in [Vec3::x(), Vec3::y(), Vec3::new(1.0, 2.0, -3.0).normalize(), -Vec3::z()] {
            let [a, b] = plane_axes(&normal);
            assert!((a.cross(&b) - normal).norm() < 1e-14, "{normal}");
        }
        let [a, b] = plane_axes(&Vec3::x());
        assert!((a + Vec3::z()).norm() < 1e-14 && (b - Vec3::y()).norm() < 1e-14);
    }
}
