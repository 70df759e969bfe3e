//! Links that every configuration of a set keeps, as [`super::prover::Prover`] asks of them.

use crate::query::keep::{EdgeScratch, LinkConstraint, Projection, keeps_edge};
use crate::scene::Scene;

/// Links that every configuration of a set keeps.
#[derive(Default)]
pub struct Held {
    kept: Vec<LinkConstraint>,
    /// The same links with narrower tolerances, for projected configurations.
    narrow: Vec<LinkConstraint>,
    projection: Projection,
    edge: EdgeScratch,
}

impl Held {
    pub fn new(kept: &[LinkConstraint]) -> Self {
        let narrow = kept.iter().map(|link| link.narrowed()).collect();
        Self { kept: kept.to_vec(), narrow, ..Self::default() }
    }

    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Whether `q` keeps the links.
    pub fn keeps(&mut self, scene: &Scene, q: &[f64]) -> bool {
        self.is_empty() || self.projection.keeps(scene, &self.kept, q)
    }

    /// Whether the whole edge is proved to keep the links.
    pub fn keeps_edge(&mut self, scene: &Scene, a: &[f64], b: &[f64]) -> bool {
        self.is_empty() || keeps_edge(scene, &self.kept, (a, b), &mut self.edge)
    }

    /// Moves `q` to a configuration nearby that keeps the links, with room for edges to bend.
    /// Returns whether there is one.
    pub fn project(&mut self, scene: &Scene, q: &mut Vec<f64>) -> bool {
        self.is_empty() || self.projection.project(scene, &self.narrow, &[], q)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use crate::applications::motion::prover::Prover;
    use crate::applications::motion::testing::{along, labelled};
    use crate::applications::motion::{EscapeOptions, PlanOptions};
    use crate::collision::CheckScratch;
    use crate::cspace::sampling::uniform;
    use crate::cspace::{Config, Label};
    use crate::math::Pose;
    use crate::query::keep::{KeptLink, LinkConstraint, Projection};
    use crate::query::{Deadline, Termination};
    use crate::scene::builtin;
    use crate::solver::Solver;

    const HELD: [(&str, &str); 4] = [
        ("shelf-arm", r#"{"link": "gripper"}"#),
        ("shelf-arm", r#"{"link": "gripper", "rotation": null}"#),
        ("shelf-arm", r#"{"link": "gripper", "axis": [0, 0, 1], "position": null, "rotation": 0.1}"#),
        ("dual-arm", r#"{"link": "right/gripper", "relative_to": "left/gripper"}"#),
    ];

    /// Asserts that samples of a path keep the links, and are free from a point on.
    fn assert_kept(solver: &Solver, keep: &[KeptLink], points: &[Vec<f64>], free_from: usize) {
        let scene = solver.scene();
        let kept = LinkConstraint::all(scene, keep, &points[0]);
        let (mut projection, mut scratch) = (Projection::default(), CheckScratch::default());
        along(solver.checker(), points, |q| assert!(projection.keeps(scene, &kept, q)));
        along(solver.checker(), &points[free_from..], |q| {
            assert_eq!(solver.checker().label(q, &mut scratch), Label::Free);
        });
    }

    /// Walks from a free configuration along what keeps the links, in legs toward random
    /// configurations, so that a path back exists.
    fn random_walk(solver: &Solver, keep: &[KeptLink], from: &Config, rng: &mut ChaCha8Rng) -> Config {
        let scene = solver.scene();
        let kept = LinkConstraint::all(scene, keep, from);
        let mut prover = Prover::new(solver.checker(), 1e-4, Deadline::default()).holding(&kept);
        let (mut q, mut target) = (from.to_vec(), from.to_vec());
        for _ in 0..8 {
            uniform(&scene.space, rng, &mut target);
            if prover.project(&mut target) {
                q = prover.advance(&q, &target).0.pop().unwrap_or(q);
            }
        }
        scene.space.config(&q).unwrap()
    }

    #[test]
    fn plans_keep_links_all_along() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for (name, keep) in HELD {
            let solver = Solver::new(builtin::scene(name).unwrap());
            let keep = KeptLink::from_text(solver.scene(), keep).unwrap();
            for from in labelled(solver.checker(), Label::Free, 12, 3) {
                let to = random_walk(&solver, &keep, &from, &mut rng);
                let options = PlanOptions::default().keep(keep.clone()).termination(Termination::after_checks(50_000));
                let plan = solver.plan(&from, &to, &options).unwrap();
                assert!(plan.is_found(), "{name} {keep:?}: {} checks", plan.checks);
                assert_eq!((&plan.points[0][..], &plan.points[plan.free_to][..]), (&from[..], &to[..]));
                assert_kept(&solver, &keep, &plan.points, 0);
            }
        }
    }

    #[test]
    fn escapes_keep_links_all_along() {
        for ((name, keep), least) in HELD.into_iter().zip([1, 3, 5, 6]) {
            let solver = Solver::new(builtin::scene(name).unwrap());
            let keep = KeptLink::from_text(solver.scene(), keep).unwrap();
            let mut found = 0;
            for q in labelled(solver.checker(), Label::Colliding, 10, 3) {
                let escape = solver.escape(&q, &EscapeOptions::default().keep(keep.clone())).unwrap();
                if escape.is_found() {
                    found += 1;
                    assert_kept(&solver, &keep, &escape.points, escape.free_from);
                }
            }
            assert!(found >= least, "{name} {keep:?}: {found}");
        }
    }

    /// An edge that bends takes hundreds of checks, and a limit ends it in the middle.
    #[test]
    fn limits_end_an_edge_that_bends() {
        let solver = Solver::new(builtin::scene("shelf-arm").unwrap());
        let keep = KeptLink::from_text(solver.scene(), HELD[1].1).unwrap();
        let (from, mut rng) = (&labelled(solver.checker(), Label::Free, 1, 3)[0], ChaCha8Rng::seed_from_u64(3));
        let (to, kept) =
            (random_walk(&solver, &keep, from, &mut rng), LinkConstraint::all(solver.scene(), &keep, from));
        let advance = |limit: Termination| {
            let mut prover = Prover::new(solver.checker(), 1e-4, Deadline::of(&limit)).holding(&kept);
            let (way, is_there) = prover.advance(from, &to);
            (way.len(), is_there, prover.checks)
        };
        let whole = advance(Termination::default());
        assert!(whole.1 && whole.2 > 100, "{whole:?}");
        let part = advance(Termination::after_checks(whole.2 / 2));
        assert!(!part.1 && part.0 > 0 && part.0 < whole.0 && part.2 <= whole.2 / 2 + 2, "{part:?} {whole:?}");
        let none = advance(Termination { max_seconds: Some(1e-9), ..Termination::default() });
        assert!(!none.1 && none.2 <= 2, "{none:?}");
    }

    #[test]
    fn ends_at_which_a_link_is_off_are_named() {
        let solver = Solver::new(builtin::scene("shelf-arm").unwrap());
        let keep = KeptLink::from_text(solver.scene(), r#"{"link": "gripper"}"#).unwrap();
        let free = labelled(solver.checker(), Label::Free, 2, 3);
        let options = PlanOptions::default().keep(keep.clone());
        let message = solver.plan(&free[0], &free[1], &options).unwrap_err().to_string();
        assert!(message.contains("goal: kept link `gripper`") && message.contains("off by"), "{message}");
        let message = solver.plan(&free[0], &free[1], &options.clearance(0.01)).unwrap_err().to_string();
        assert!(message.contains("clearance: got 0.01, expected none with `keep`"), "{message}");
        let away = vec![keep[0].clone().pose(Pose::identity())];
        let message = solver.escape(&free[0], &EscapeOptions::default().keep(away)).unwrap_err().to_string();
        assert!(message.contains("q: kept link `gripper`"), "{message}");
        let nowhere = vec![KeptLink::link(99)];
        let message = solver.escape(&free[0], &EscapeOptions::default().keep(nowhere)).unwrap_err().to_string();
        assert!(message.contains("keep: got link 99"), "{message}");
    }
}
