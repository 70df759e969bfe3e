//! Weights of a base that make moving the hand about as expensive as moving its fingers.

use super::hand::base_tangents;
use crate::cspace::Manifold;
use crate::metric::Metric;
use crate::scene::{MetricKind, Scene, SceneJoint};

/// Returns each robot's base with its weights for translations and the rotation.
pub fn base_weights(scene: &Scene) -> Vec<(String, [f64; 2])> {
    let (base, factors) = (base_tangents(scene), scene.space.factors());
    let is_weighted = factors.iter().any(|factor| base.contains(&factor.v) && factor.weight != 1.0);
    if base.is_empty() || is_weighted || scene.metric != MetricKind::Joint {
        return Vec::new();
    }
    let levers = Metric::of_kind(scene.clone().into(), MetricKind::ObjectNorm).levers(&middle(scene));
    let of_joints = (0..levers.len()).filter(|v| !base.contains(v)).map(|v| levers[v]);
    let Some(of_joint) = mean_square(of_joints) else { return Vec::new() };
    let own = |joint: &SceneJoint| factors.iter().filter(|factor| joint.q.contains(&factor.q)).collect::<Vec<_>>();
    let is_base = |joint: &&SceneJoint| own(joint).iter().any(|factor| base.contains(&factor.v));
    let weights = |joint: &SceneJoint| {
        let turn = own(joint).last().and_then(|factor| mean_square(factor.tangents().map(|v| levers[v])));
        (joint.name.clone(), [1.0, turn.unwrap_or(1.0)].map(|square| (square / of_joint).clamp(1e-9, 1e9)))
    };
    scene.joints.iter().filter(is_base).map(weights).collect()
}

/// Returns the mean square of the levers that move anything.
fn mean_square(levers: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = levers.filter(|lever| *lever > 0.0).fold((0.0, 0), |(sum, n), x| (sum + x * x, n + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Returns the middle of all limits, with angles and rotations at 0.
fn middle(scene: &Scene) -> Vec<f64> {
    let mut q = vec![0.0; scene.space.nq()];
    for factor in scene.space.factors() {
        match factor.manifold {
            Manifold::Interval { lower, upper } => q[factor.q] = 0.5 * (lower + upper),
            Manifold::Circle => {}
            Manifold::Rotation => q[factor.q + 3] = 1.0,
        }
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::applications::grasp::Hand;
    use crate::error::Error;
    use crate::scene::builtin;

    /// A radian of a floating base moves the built-in hand about as far as some finger lengths, and
    /// a metre moves it far more.
    #[test]
    fn a_base_is_dearer_than_fingers() {
        let scene = crate::applications::grasp::hand::tests::with_ball(0.03);
        assert!(base_weights(&scene).is_empty());
        let files = builtin::files("hand").unwrap();
        let toml = String::from_utf8(files.iter().find(|(name, _)| name.ends_with("toml")).unwrap().1.clone()).unwrap();
        let bounds = "base = \"floating\"\nbounds = { min = [-1, -1, -1], max = [1, 1, 1] }\n";
        let ball = "[[obstacle]]\nname = \"ball\"\nshape = { sphere = 0.03 }\npose = { xyz = [0, 0, 0.08] }\n";
        let toml = format!("{toml}{bounds}{ball}");
        let mut read = |path: &std::path::Path| {
            let found = files.iter().find(|(name, _)| path.ends_with(name));
            found
                .map(|(_, bytes)| bytes.clone())
                .ok_or_else(|| Error::input("scene.toml", "", format!("no file {path:?}")))
        };
        let scene = crate::scene::assemble::assemble(std::path::Path::new("scene.toml"), &toml, &mut read).unwrap();
        let hand = Hand::new(&scene, "ball").unwrap();
        assert_eq!(hand.finger_count(), 3);
        let [(name, [translation, rotation])] = &base_weights(&scene)[..] else { panic!("one base") };
        // A finger is 0.085 long: a radian moves its middle, or its tip, by 0.02 to 0.05.
        assert!(name == "base" && (400.0..3000.0).contains(translation), "{translation}");
        assert!((0.3..10.0).contains(rotation), "{rotation}");
        let weighted = Hand::weighted(&scene).unwrap();
        assert!(Hand::weighted(&weighted).is_none(), "what was chosen stays");
    }
}
