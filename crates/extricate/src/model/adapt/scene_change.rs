//! What differs between two scenes of the same robots: which bodies, which pairs, and the scene in
//! which only they are checked.

use crate::error::{Error, Result};
use crate::scene::clearances::Clearances;
use crate::scene::correspondence::bodies_in_both;
use crate::scene::{BodyPair, Scene};

/// Pairs of either scene that the other does not have, bodies and all.
#[derive(Debug, Clone)]
pub struct SceneChange {
    /// The new scene with the old one's changed bodies added, checking the changed pairs of both.
    pub affected: Scene,
    /// Names of bodies that moved, changed, came or went, sorted.
    pub bodies: Vec<String>,
}

/// Compares two scenes. `margin` \[m\] is added to the clearance of [`SceneChange::affected`].
///
/// # Errors
/// [`Error::Adapt`] where the robots, the coordinates or the metric differ: nothing learned then
/// holds.
pub fn compare(old: &Scene, new: &Scene, margin: f64) -> Result<SceneChange> {
    let refuse = |what: &str| Err(Error::Adapt { problem: format!("{what} differ from those it was learned with") });
    if old.space != new.space || old.joints != new.joints {
        return refuse("the coordinates or their limits");
    }
    if old.frames != new.frames {
        return refuse("the robots' joints");
    }
    if old.metric != new.metric {
        return refuse("the metrics");
    }
    let all_changed = old.clearance != new.clearance || old.clearances != new.clearances;
    let mut affected = new.clone();
    // Where each old body stands among those of `affected`, and whether it is the same there.
    let mut place = Vec::new();
    let mut bodies: Vec<String> = Vec::new();
    for (body, found) in old.bodies.iter().zip(bodies_in_both(old, new)) {
        match found {
            Some(at) => place.push(at),
            None => {
                bodies.push(body.name.clone());
                place.push(affected.bodies.len());
                affected.bodies.push(body.clone());
            }
        }
    }
    let in_both: Vec<usize> = place.iter().copied().filter(|at| *at < new.bodies.len()).collect();
    bodies.extend((0..new.bodies.len()).filter(|i| !in_both.contains(i)).map(|i| new.bodies[i].name.clone()));
    bodies.sort();
    bodies.dedup();
    let moved = |pair: &BodyPair| {
        let (a, b) = (place[pair.first], place[pair.second]);
        BodyPair { first: a.min(b), second: a.max(b) }
    };
    let before: Vec<BodyPair> = old.pairs.iter().map(moved).collect();
    let mut pairs: Vec<BodyPair> = before.iter().filter(|p| all_changed || !new.pairs.contains(p)).copied().collect();
    pairs.extend(new.pairs.iter().filter(|p| all_changed || !before.contains(p)));
    pairs.sort();
    pairs.dedup();
    affected.pairs = pairs;
    let kept = |scene: &Scene| {
        let of_pairs = scene.pair_clearances();
        of_pairs.iter().map(|pair| pair.over(scene.clearance)).fold(scene.clearance, f64::max)
    };
    affected.clearance = kept(old).max(kept(new)) + margin;
    affected.clearances = Clearances::default();
    Ok(SceneChange { affected, bodies })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn only_what_changed_is_checked() {
        let old = builtin::scene("planar-arm").unwrap();
        let obstacle = old.bodies.iter().position(|b| b.robot.is_none()).unwrap();
        let name = old.bodies[obstacle].name.clone();
        assert!(compare(&old, &old, 0.0).unwrap().affected.pairs.is_empty());
        let mut moved = old.clone();
        moved.bodies[obstacle].parts[0].pose_frame_part.translation.x += 0.01;
        let change = compare(&old, &moved, 0.1).unwrap();
        let with_it = old.pairs.iter().filter(|p| p.first == obstacle || p.second == obstacle).count();
        assert_eq!((change.affected.pairs.len(), change.bodies), (2 * with_it, vec![name.clone()]));
        assert!((change.affected.clearance - old.clearance - 0.1).abs() < 1e-12);
        let mut fewer = old.clone();
        fewer.pairs.retain(|p| p.first != obstacle && p.second != obstacle);
        let change = compare(&old, &fewer, 0.0).unwrap();
        assert_eq!((change.affected.pairs.len(), change.bodies.len()), (with_it, 0));
        let mut wider = old.clone();
        wider.clearance *= 2.0;
        assert_eq!(compare(&old, &wider, 0.0).unwrap().affected.pairs.len(), old.pairs.len());
    }

    #[test]
    fn another_robot_or_metric_is_refused() {
        let old = builtin::scene("planar-arm").unwrap();
        let refused = |new: &Scene| compare(&old, new, 0.0).unwrap_err().to_string();
        assert!(refused(&builtin::scene("hand").unwrap()).contains("coordinates"));
        let mut new = old.clone();
        new.frames[1].pose_parent_joint.translation.x += 0.1;
        assert!(refused(&new).contains("joints"));
        new = old.clone();
        new.metric = crate::scene::MetricKind::ObjectNorm;
        assert!(refused(&new).contains("metrics"));
    }
}
