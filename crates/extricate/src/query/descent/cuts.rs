//! Cuts: constraints from the contacts that a rejected step ran into.

use crate::collision::{Checker, Contact};
use crate::math::{Pose, Vec3};

/// Two contacts of a pair within this distance \[m\] on either body are the same.
const CONTACT_MERGE_M: f64 = 5e-4;

/// The constraints that the last rejected step added.
#[derive(Debug, Clone, Copy)]
pub struct Cut {
    /// Number of contacts before the cut; those after it are dropped with it.
    pub known_before: usize,
    /// Radius of the trust region after the cut is dropped.
    pub shorter: f64,
}

/// Adds to `contacts` those that a rejected step ran into (`hit`, at `hit_poses`), moved back to
/// `poses`: the same points of the same bodies, apart along the same normal. Returns whether any
/// was new. Skips overlaps of which the step caused at most half, since they say little about it.
pub fn add_cuts(
    checker: &Checker,
    (contacts, poses): (&mut Vec<Contact>, &[Pose]),
    (hit, hit_poses): (&[Contact], &[Pose]),
) -> bool {
    let (scene, clearance, known) = (checker.scene(), checker.base_clearance(), contacts.len());
    for contact in hit.iter().filter(|contact| contact.distance < clearance) {
        let pair = &scene.pairs[contact.pair.index()];
        let here = |body: usize, point: &Vec3| {
            let frame = scene.bodies[body].frame;
            poses[frame].point(&hit_poses[frame].inverse_point(point))
        };
        let point_first = here(pair.first, &contact.point_first);
        let point_second = here(pair.second, &contact.point_second);
        let same = |other: &Contact| {
            other.pair == contact.pair
                && (other.point_first - point_first).norm().min((other.point_second - point_second).norm())
                    < CONTACT_MERGE_M
        };
        let distance = contact.normal.dot(&(point_first - point_second)) - checker.excess(contact.pair.index());
        if 2.0 * (distance - contact.distance) > clearance - contact.distance && !contacts.iter().any(same) {
            contacts.push(Contact { distance, point_first, point_second, ..*contact });
        }
    }
    contacts.len() > known
}

#[cfg(test)]
mod tests {

    use std::path::Path;

    use crate::metric::Anchor;
    use crate::query::descent::prune::Pruning;
    use crate::query::descent::{DescentScratch, Start, descend};
    use crate::query::evaluate::Evaluator;
    use crate::query::plan::POLISH_MESHES;
    use crate::query::prepared::Prepared;
    use crate::scene::assemble::assemble;

    /// A block of 10 x 10 x 3 with a square hole of side 1.5, as OBJ.
    fn block() -> String {
        let mut text = String::new();
        for (z, side) in [(-1.5, 0.75), (-1.5, 5.0), (1.5, 0.75), (1.5, 5.0)] {
            for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
                text += &format!("v {} {} {z}\n", x * side, y * side);
            }
        }
        for k in 1..5 {
            let next = k % 4 + 1;
            for [a, b, c, d] in [
                [k + 4, next + 4, next + 12, k + 12],
                [next, k, k + 8, next + 8],
                [k + 12, next + 12, next + 8, k + 8],
                [next + 4, k + 4, k, next],
            ] {
                text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
            }
        }
        text
    }

    /// A peg lies below the block, sunk in by 0.2208, and a descent begins rotated and off to the
    /// side. Its long steps along the face end deep in the block. The cuts of these steps seemed to
    /// leave no way, and the descent used to end at 0.236.
    #[test]
    fn a_descent_along_a_face_does_not_end_for_what_a_deep_overlap_taught() {
        let toml = "metric = { kind = 'object-norm' }\n[[robot]]\nurdf = 'peg.urdf'\nbase = 'floating'\n\
                    bounds = { min = [-7, -7, -5], max = [7, 7, 5] }\n[[obstacle]]\nname = 'block'\nshape = { mesh = 'block.obj' }\n";
        let peg = "<robot name='peg'><link name='peg'><collision><geometry><box size='1 1 4.5'/></geometry></collision></link></robot>";
        let mut read = |path: &Path| {
            let is_block = path.extension().is_some_and(|extension| extension == "obj");
            Ok(if is_block { block().into_bytes() } else { peg.into() })
        };
        let world = Prepared::new(assemble(Path::new("scene.toml"), toml, &mut read).unwrap());
        let (context, mut anchor) = (world.context(), Anchor::default());
        let turn = [0.6941133784094932, 0.1349319010203283, 0.1349319010203283, 0.6941133784094932];
        let q = [&[-1.5123456790123457, 2.436, -1.77921875], &turn[..]].concat();
        let turned = [0.6909587225199086, 0.1502571550645641, 0.15025356892852149, 0.6909578106873107];
        let start = [&[-1.4883476776727274, 2.2462357738888414, -2.000208383311388], &turned[..]].concat();
        context.metric.anchor(&q, &mut anchor);
        let (mut scratch, mut evaluator) = (DescentScratch::default(), Evaluator::default());
        let pruning = Pruning { factor: 1.1, ..Pruning::alone(0.29814) };
        let start = Start::at(&start);
        let (depth, _) = descend(&context, &anchor, start, pruning, &POLISH_MESHES, &mut scratch, &mut evaluator);
        let depth = depth.unwrap();
        let exact = 0.22078125 + context.clearance;
        assert!(depth > exact - 1e-6 && depth < 1.005 * exact, "{depth}");
    }
}
