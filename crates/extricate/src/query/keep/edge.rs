//! Proofs that links are kept along a whole edge, not only at its ends.
//!
//! Along an edge every joint moves at a constant rate, so the offset of a link bends by a bounded
//! second derivative. Between two measured offsets it is then nowhere larger than their linear
//! interpolation plus an eighth of that bound.
//!
//! # Source
//! The remainder of linear interpolation: J. Stoer and R. Bulirsch, "Introduction to Numerical
//! Analysis", section 2.1.4, doi:10.1007/978-0-387-21738-3. The bound on the second derivative is
//! derived at [`Bend`].

use std::f64::consts::PI;

use super::LinkConstraint;
use crate::kinematics::forward;
use crate::math::Pose;
use crate::math::elementary::sin_cos;
use crate::scene::{Motion, Scene};

/// An edge is halved at most this often before the proof is given up: its parts then need only a
/// 64th of the room. More would cost more than the shorter edges that they save.
const MAX_HALVINGS: usize = 3;

/// Bounds on the second derivatives of a kept link along an edge, whose parameter runs from 0 to 1.
///
/// Let the joints between the base and the link be numbered from the base. A rotation `i` with rate
/// `w_i` contributes `w_i w_i r_i` to the second derivative of the link's origin, and together with
/// each joint `j` beyond it `2 w_i w_j r_j`. Here `r_j` is at least the distance of the origin from
/// the joint, or 1 if the joint is prismatic. Prismatic joints contribute nothing to what is beyond
/// them. The second derivative of a unit vector that is fixed to the link is at most the square of
/// the sum of all `w_i`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Bend {
    /// Bound for the link's origin in the base's coordinates \[m\].
    position: f64,
    /// Bound for a unit vector that is fixed to the link.
    direction: f64,
}

/// A place on an edge, and how far a link is off there.
#[derive(Clone, Copy)]
struct Place {
    at: f64,
    position: f64,
    /// Largest distance of a kept direction from where it should be, as of unit vectors.
    direction: f64,
}

/// Memory of proofs.
#[derive(Default)]
pub struct EdgeScratch {
    q: Vec<f64>,
    rates: Vec<f64>,
    poses: Vec<Pose>,
}

/// Whether all links are proved to be kept along the geodesic between two configurations. `false`
/// proves nothing.
pub fn keeps_edge(
    scene: &Scene,
    kept: &[LinkConstraint],
    (from, to): (&[f64], &[f64]),
    scratch: &mut EdgeScratch,
) -> bool {
    let EdgeScratch { q, rates, poses } = scratch;
    q.resize(from.len(), 0.0);
    rates.resize(scene.space.nv(), 0.0);
    scene.space.difference(from, to, rates);
    kept.iter().all(|link| {
        let bend = link.bend(scene, rates, [from, to]);
        let mut place = |at: f64| {
            scene.space.interpolate(from, to, at, q);
            forward(scene, q, poses);
            let error = link.error(poses);
            Place { at, position: error.position, direction: chord(error.rotation) }
        };
        let ends = [place(0.0), place(1.0)];
        link.keeps_between(ends, bend, MAX_HALVINGS, &mut place)
    })
}

impl LinkConstraint {
    /// Whether the link is proved to be kept between two places.
    fn keeps_between(
        &self,
        [a, b]: [Place; 2],
        bend: Bend,
        halvings: usize,
        place: &mut dyn FnMut(f64) -> Place,
    ) -> bool {
        // No rotation is farther than half a turn.
        let allowed = [self.position, self.rotation.filter(|angle| *angle < PI).map(chord)];
        let of = |place: &Place| [place.position, place.direction];
        let is_kept = |place: &Place| {
            let within = |(value, allowed): (f64, Option<f64>)| allowed.is_none_or(|most| value <= most);
            of(place).into_iter().zip(allowed).all(within)
        };
        if !is_kept(&a) || !is_kept(&b) {
            return false;
        }
        let length = b.at - a.at;
        let bends = [bend.position, bend.direction].map(|bend| bend * length * length);
        let ends = of(&a).into_iter().zip(of(&b));
        let is_within = |(((a, b), bend), allowed): (((f64, f64), f64), Option<f64>)| {
            allowed.is_none_or(|most| largest_between(a, b, bend) <= most)
        };
        if ends.zip(bends).zip(allowed).all(is_within) {
            return true;
        }
        if halvings == 0 {
            return false;
        }
        let middle = place(0.5 * (a.at + b.at));
        [[a, middle], [middle, b]].into_iter().all(|half| self.keeps_between(half, bend, halvings - 1, place))
    }

    /// Bounds the second derivatives for an edge with these rates of the tangent coordinates.
    fn bend(&self, scene: &Scene, rates: &[f64], ends: [&[f64]; 2]) -> Bend {
        let paths = [self.base.0, self.link.0].map(|frame| path_to_world(scene, frame));
        let shared = paths[0].iter().rev().zip(paths[1].iter().rev()).take_while(|(a, b)| a == b).count();
        let [base, link] = paths.each_ref().map(|path| &path[..path.len() - shared]);
        // Farthest that the link's origin is from each joint, from the link on.
        let mut reach = self.link.1.translation.norm();
        let mut joints = Vec::new();
        for frame in link {
            joints.push((*frame, reach));
            reach += step_length(scene, *frame, ends);
        }
        // The base's joints lie between the base and where both paths meet.
        for frame in base.iter().rev() {
            reach += step_length(scene, *frame, ends);
            joints.push((*frame, reach));
        }
        let (mut bend, mut turning) = (Bend::default(), 0.0);
        for (frame, reach) in joints.into_iter().rev() {
            let (rate, is_rotation) = rate(&scene.frames[frame].motion, rates);
            if is_rotation {
                bend.position += reach * rate * (rate + 2.0 * turning);
                turning += rate;
            } else {
                bend.position += 2.0 * rate * turning;
            }
        }
        bend.direction = turning * turning;
        bend
    }
}

/// Returns the largest value between two ends of a function that is at most their linear
/// interpolation plus `bend s (1 - s) / 2`.
fn largest_between(a: f64, b: f64, bend: f64) -> f64 {
    let slope = b - a;
    if bend <= 2.0 * slope.abs() {
        return a.max(b);
    }
    let s = 0.5 + slope / bend;
    a + s * slope + 0.5 * bend * s * (1.0 - s)
}

/// Returns the distance between two unit vectors at an angle \[rad\].
fn chord(angle: f64) -> f64 {
    2.0 * sin_cos(0.5 * angle).0
}

/// Returns a frame, its parent and so on to the world.
fn path_to_world(scene: &Scene, frame: usize) -> Vec<usize> {
    let parent = |frame: &usize| (*frame != 0).then(|| scene.frames[*frame].parent);
    std::iter::successors(Some(frame), parent).collect()
}

/// Returns the largest distance of a frame's origin from its parent's along an edge.
fn step_length(scene: &Scene, frame: usize, ends: [&[f64]; 2]) -> f64 {
    let frame = &scene.frames[frame];
    let offset = frame.pose_parent_joint.translation.norm();
    match &frame.motion {
        Motion::Prismatic { coordinate, .. } => {
            let length = |q: &&[f64]| (coordinate.multiplier * q[coordinate.q] + coordinate.offset).abs();
            offset + ends.iter().map(length).fold(0.0, f64::max)
        }
        Motion::World | Motion::Revolute { .. } | Motion::Ball { .. } => offset,
    }
}

/// Returns the absolute rate of a joint, and whether it is a rotation.
fn rate(motion: &Motion, rates: &[f64]) -> (f64, bool) {
    match motion {
        Motion::World => (0.0, true),
        Motion::Revolute { coordinate, .. } => ((coordinate.multiplier * rates[coordinate.v]).abs(), true),
        Motion::Prismatic { coordinate, .. } => ((coordinate.multiplier * rates[coordinate.v]).abs(), false),
        Motion::Ball { v, .. } => (rates[*v..*v + 3].iter().map(|rate| rate * rate).sum::<f64>().sqrt(), true),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::cspace::sampling::uniform;
    use crate::query::keep::KeptLink;
    use crate::scene::assemble::assemble;
    use crate::scene::builtin;

    /// A mast and a crane on one base, each with revolute and prismatic joints, some of which
    /// follow others; the crane has more joints.
    fn crane() -> Scene {
        let joint = |[name, kind, parent, child]: [&str; 4], [xyz, axis]: [&str; 2], mimic: &str| {
            format!(
                "<link name='{child}'/><joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
                 <origin xyz='{xyz}' rpy='0.3 -0.2 0.5'/><axis xyz='{axis}'/>\
                 <limit lower='-1' upper='1.5' effort='1' velocity='1'/>{mimic}</joint>"
            )
        };
        let urdf = [
            "<robot name='crane'><link name='base'/>".to_string(),
            joint(["a1", "revolute", "base", "m1"], ["0.2 0 0.1", "0 0 1"], ""),
            joint(["a2", "prismatic", "m1", "m2"], ["0.1 0.3 0", "1 0 0"], ""),
            joint(
                ["a3", "revolute", "m2", "mast"],
                ["0 0.2 0.2", "0 1 0"],
                "<mimic joint='a1' multiplier='-0.7' offset='0.2'/>",
            ),
            joint(["b1", "prismatic", "base", "c1"], ["-0.2 0 0", "0 1 0"], ""),
            joint(["b2", "revolute", "c1", "c2"], ["0.4 0 0.1", "1 0 0"], ""),
            joint(
                ["b3", "prismatic", "c2", "c3"],
                ["0 0 0.3", "0 0 1"],
                "<mimic joint='b1' multiplier='1.5' offset='-0.3'/>",
            ),
            joint(["b4", "revolute", "c3", "c4"], ["0.1 0.1 0", "0 0 1"], ""),
            joint(["b5", "revolute", "c4", "crane"], ["0.3 0 0", "0 1 0"], ""),
            "</robot>".to_string(),
        ];
        let toml = "[[robot]]\nurdf = 'r.urdf'\n[[obstacle]]\nname = 'b'\nshape = { sphere = 0.1 }\n";
        assemble(Path::new("scene.toml"), toml, &mut |_: &Path| Ok(urdf.concat().into_bytes())).unwrap()
    }

    fn scene(name: &str) -> Scene {
        if name == "crane" { crane() } else { builtin::scene(name).unwrap() }
    }

    /// Second differences along random edges, of positions and directions, are at most the bounds.
    /// The largest are more than a fifth of the bounds, so these are not idle.
    #[test]
    fn links_bend_by_no_more_than_the_bound() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for (name, link, base) in [
            ("shelf-arm", "gripper", None),
            ("dual-arm", "right/gripper", Some("left/gripper")),
            ("free-box", "body", None),
            ("crane", "crane", Some("mast")),
            ("crane", "mast", Some("crane")),
            ("crane", "crane", Some("c2")),
        ] {
            let scene = scene(name);
            let place = |name: &str| scene.link_named("keep", name).unwrap();
            let mut keep = KeptLink::link(place(link));
            keep.relative_to = base.map(place);
            let (space, mut largest) = (&scene.space, [0.0_f64; 2]);
            let (mut a, mut b, mut q) = (vec![0.0; space.nq()], vec![0.0; space.nq()], vec![0.0; space.nq()]);
            for _ in 0..300 {
                uniform(space, &mut rng, &mut a);
                uniform(space, &mut rng, &mut q);
                space.interpolate(&a, &q, 0.1, &mut b);
                let kept = &LinkConstraint::all(&scene, std::slice::from_ref(&keep), &a)[0];
                let (mut rates, mut poses) = (vec![0.0; space.nv()], Vec::new());
                space.difference(&a, &b, &mut rates);
                let bend = kept.bend(&scene, &rates, [&a, &b]);
                let mut relative = |s: f64| {
                    space.interpolate(&a, &b, s, &mut q);
                    forward(&scene, &q, &mut poses);
                    super::super::world(&kept.base, &poses).inverse().then(&super::super::world(&kept.link, &poses))
                };
                let (h, s) = (1e-3, rng.random_range(0.1..0.9));
                let [before, now, after] = [s - h, s, s + h].map(&mut relative);
                let position = (before.translation + after.translation - 2.0 * now.translation).norm() / (h * h);
                let direction = (0..3).map(|k| {
                    (before.rotation.column(k) + after.rotation.column(k) - 2.0 * now.rotation.column(k)).norm()
                });
                let direction = direction.fold(0.0, f64::max) / (h * h);
                assert!(position <= bend.position * 1.001 + 1e-6, "{name}: {position} {bend:?}");
                assert!(direction <= bend.direction * 1.001 + 1e-6, "{name}: {direction} {bend:?}");
                largest[0] = largest[0].max(position / bend.position.max(1e-12));
                largest[1] = largest[1].max(direction / bend.direction.max(1e-12));
            }
            assert!(largest[0] > 0.2 || name == "free-box", "{name}: {largest:?}");
            assert!(largest[1] > 0.3, "{name}: {largest:?}");
        }
    }

    /// Edges are drawn from a configuration that keeps the link to one nearby. None is called kept
    /// on which a sample is off, and most on which no sample comes near the tolerance are.
    #[test]
    fn no_edge_is_called_kept_on_which_the_link_is_off() {
        for (name, link, base) in [("shelf-arm", "gripper", None), ("crane", "crane", Some("mast"))] {
            let scene = scene(name);
            let place = |name: &str| scene.link_named("keep", name).unwrap();
            let mut keep = KeptLink::link(place(link));
            keep.relative_to = base.map(place);
            (keep.position, keep.rotation) = (Some(0.02), Some(0.05));
            let (space, mut rng) = (&scene.space, rand_chacha::ChaCha8Rng::seed_from_u64(8));
            let (mut a, mut b, mut far, mut q) =
                (vec![0.0; space.nq()], vec![0.0; space.nq()], vec![0.0; space.nq()], vec![0.0; space.nq()]);
            let (mut proved, mut off, mut missed, mut poses) = (0, 0, 0, Vec::new());
            for _ in 0..1000 {
                uniform(space, &mut rng, &mut a);
                uniform(space, &mut rng, &mut far);
                space.interpolate(&a, &far, rng.random_range(0.0..0.02), &mut b);
                let kept = LinkConstraint::all(&scene, std::slice::from_ref(&keep), &a);
                let is_kept = keeps_edge(&scene, &kept, (&a, &b), &mut EdgeScratch::default());
                let excess = (0..=200).map(|k| {
                    space.interpolate(&a, &b, f64::from(k) / 200.0, &mut q);
                    forward(&scene, &q, &mut poses);
                    kept[0].excess(&poses)
                });
                let worst = excess.fold(0.0, f64::max);
                assert!(!is_kept || worst <= 1.0 + 1e-9, "{name}: {worst}");
                proved += usize::from(is_kept);
                off += usize::from(worst > 1.0);
                missed += usize::from(!is_kept && worst < 0.95);
            }
            assert!(proved > 200 && off > 200 && missed == 0, "{name}: {proved} {off} {missed}");
        }
    }
}
