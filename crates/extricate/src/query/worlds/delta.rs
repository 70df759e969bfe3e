//! What a changed scene leaves of what is known of samples: which checked pairs are those that were
//! learned with.

use crate::samples::contact_planes::Elsewhere;
use crate::scene::correspondence::bodies_in_both;
use crate::scene::{BodyPair, PairId, Scene};

/// How a scene differs from the one that was learned, pair by pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// For every checked pair of the learned scene, whether it is checked in this one too, its
    /// bodies are the same and it keeps as much beyond the scene's clearance.
    stays: Vec<bool>,
    /// Which pair of this scene that is.
    here: Vec<Option<usize>>,
    /// For every checked pair of this scene, whether the learned one had it not.
    came: Vec<bool>,
    /// By how much the clearance is larger in this one \[m\].
    wider: f64,
}

impl Change {
    /// From the scene that was learned to this one.
    pub fn between(learned: &Scene, scene: &Scene) -> Self {
        let place = bodies_in_both(learned, scene);
        let kept = |scene: &Scene| -> Vec<f64> {
            let kept = scene.pair_clearances();
            kept.iter().map(|pair| pair.over(scene.clearance) - scene.clearance).collect()
        };
        let (excess_then, excess_now) = (kept(learned), kept(scene));
        let index_here = |(at, pair): (usize, &BodyPair)| {
            let (a, b) = (place[pair.first]?, place[pair.second]?);
            // Pairs of a scene are sorted.
            let here = scene.pairs.binary_search(&BodyPair { first: a.min(b), second: a.max(b) }).ok()?;
            (excess_then[at] == excess_now[here]).then_some(here)
        };
        let here: Vec<Option<usize>> = learned.pairs.iter().enumerate().map(index_here).collect();
        let mut came = vec![true; scene.pairs.len()];
        here.iter().flatten().for_each(|pair| came[*pair] = false);
        let stays = here.iter().map(Option::is_some).collect();
        Self { stays, here, came, wider: scene.clearance - learned.clearance }
    }

    /// Of a scene that was learned with another clearance, less by `wider` \[m\].
    pub fn of_clearance(pairs: usize, wider: f64) -> Self {
        Self { stays: vec![true; pairs], here: (0..pairs).map(Some).collect(), came: vec![false; pairs], wider }
    }

    /// The same where the clearance is larger by `wider` \[m\] once more.
    pub fn widened(&self, wider: f64) -> Self {
        Self { wider: self.wider + wider, ..self.clone() }
    }

    /// What to make of planes that were noted in the learned scene.
    pub fn of_planes(&self) -> Elsewhere<'_> {
        Elsewhere { stays: &self.stays, wider: self.wider }
    }

    /// For every checked pair of the learned scene, which pair of this one it is.
    pub fn pairs_here(&self) -> &[Option<usize>] {
        &self.here
    }

    /// Whether the learned scene had this pair not.
    pub fn is_new(&self, pair: PairId) -> bool {
        self.came[pair.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn pairs_of_what_moved_are_told_from_those_that_stay() {
        let learned = builtin::scene("shelf-arm").unwrap();
        let obstacle = learned.bodies.iter().rposition(|body| body.robot.is_none()).unwrap();
        let meets = |pair: &BodyPair| pair.first == obstacle || pair.second == obstacle;
        let mut moved = learned.clone();
        moved.bodies[obstacle].parts[0].pose_frame_part.translation.x += 0.05;
        moved.clearance += 0.01;
        let change = Change::between(&learned, &moved);
        for (index, pair) in learned.pairs.iter().enumerate() {
            assert_eq!((change.stays[index], change.is_new(PairId::new(index))), (!meets(pair), meets(pair)));
        }
        assert!((change.of_planes().wider - 0.01).abs() < 1e-15);
        // What went shifts the indices of the others.
        let mut fewer = learned.clone();
        fewer.pairs.retain(|pair| !meets(pair));
        let change = Change::between(&learned, &fewer);
        assert!(learned.pairs.iter().zip(&change.stays).all(|(pair, stays)| *stays != meets(pair)));
        assert!((0..fewer.pairs.len()).all(|pair| !change.is_new(PairId::new(pair))));
        let change = Change::between(&fewer, &learned);
        assert!(change.stays.iter().all(|stays| *stays));
        assert!(learned.pairs.iter().enumerate().all(|(index, pair)| change.is_new(PairId::new(index)) == meets(pair)));
    }
}
