//! Coordinate systems and triangles of bodies, for drawing a scene. `kinematics` computes where the
//! frames are at a configuration.

use super::{LinkAttachment, Scene};
use crate::math::Pose;

/// The frame of a body or link, and the pose of its own coordinates on that frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seated {
    /// Index of the frame.
    pub frame: usize,
    /// Maps its own coordinates to the frame's.
    pub pose_frame_own: Pose,
}

impl Scene {
    /// Returns the seat of a body. A link's own coordinates are those of the URDF; those of an
    /// obstacle or an attached object are those of its first shape.
    pub fn seat_of_body(&self, body: usize) -> Seated {
        let body = &self.bodies[body];
        let first = || body.parts.first().map_or(Pose::identity(), |part| part.pose_frame_part);
        let link = || self.links.iter().find(|link| link.name == body.name).map(|link| link.pose_frame_link);
        let pose_frame_own = match body.robot {
            // Models of earlier versions lack the links; the frame's coordinates stand in for them.
            Some(_) => link().unwrap_or_default(),
            None => first(),
        };
        Seated { frame: body.frame, pose_frame_own }
    }

    /// Returns the seat of the body or link of this name; the link needs no geometry.
    pub fn seat_named(&self, name: &str) -> Option<Seated> {
        let seat = |link: &LinkAttachment| Seated { frame: link.frame, pose_frame_own: link.pose_frame_link };
        let body = self.bodies.iter().position(|body| body.name == name);
        body.map(|body| self.seat_of_body(body)).or_else(|| self.links.iter().find(|link| link.name == name).map(seat))
    }

    /// Returns vertices \[m\] and triangles of all shapes of a body in its own coordinates, see
    /// [`Scene::seat_of_body`]. Round shapes get `segments` sides around their axis.
    pub fn mesh_of_body(&self, body: usize, segments: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let own = self.seat_of_body(body).pose_frame_own.inverse();
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for part in &self.bodies[body].parts {
            let (mesh, pose) = (part.geometry.tessellate(segments), own.then(&part.pose_frame_part));
            let first = vertices.len() as u32;
            vertices.extend(mesh.vertices.iter().map(|vertex| <[f64; 3]>::from(pose.point(vertex))));
            triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
        }
        (vertices, triangles)
    }
}

#[cfg(test)]
mod tests {
    use crate::kinematics::forward;
    use crate::math::Vec3;
    use crate::robot::JointKind::{Fixed, Revolute};
    use crate::scene::testing::{PLAIN, chain, scene};

    #[test]
    fn bodies_stand_where_their_links_do() {
        let held = "[[attached]]\nname = 'rod'\nlink = 'l2'\nshape = { box = [1, 1, 1] }\npose = { xyz = [0, 0, 2] }\n";
        let wall = "[[obstacle]]\nname = 'wall'\nshape = { box = [2, 2, 2] }\npose = { xyz = [9, 0, 0] }\n";
        let scene = scene(&format!("{PLAIN}{wall}{held}"), &[chain(&[Revolute, Fixed])]).unwrap();
        let mut poses = Vec::new();
        forward(&scene, &[std::f64::consts::FRAC_PI_2], &mut poses);
        // The joint is at x = 1 and rotates the links after it toward y.
        for (name, expected) in
            [("l0", [0.0, 0.0, 0.0]), ("l2", [1.0, 1.0, 0.0]), ("rod", [1.0, 1.0, 2.0]), ("wall", [9.0, 0.0, 0.0])]
        {
            let seat = scene.seat_named(name).unwrap();
            let pose = poses[seat.frame].then(&seat.pose_frame_own);
            assert!((pose.translation - Vec3::from(expected)).norm() < 1e-12, "{name}: {pose:?}");
        }
        assert_eq!(scene.seat_named("l3"), None);
        let body = scene.bodies.iter().position(|body| body.name == "rod").unwrap();
        let (vertices, triangles) = scene.mesh_of_body(body, 8);
        assert_eq!((vertices.len(), triangles.len()), (8, 12));
        assert!(vertices.iter().all(|vertex| vertex.iter().all(|x| (x.abs() - 0.5).abs() < 1e-12)), "{vertices:?}");
    }
}
