//! Finds the bodies of one scene in another one.

use std::collections::{BTreeMap, HashMap};

use super::Scene;

/// Returns for every body of `old` the index of the same body in `new`: one with the same name and
/// shapes, carried by the same joints. `None` means that `new` has no such body.
pub fn bodies_in_both(old: &Scene, new: &Scene) -> Vec<Option<usize>> {
    let mut carried_alike: Vec<bool> = Vec::with_capacity(old.frames.len());
    for (index, frame) in old.frames.iter().enumerate() {
        // A parent precedes its children, and the world has no parent.
        let parent = index == 0 || carried_alike[frame.parent];
        carried_alike.push(parent && new.frames.get(index) == Some(frame));
    }
    let named: BTreeMap<&str, usize> = new.bodies.iter().enumerate().map(|(i, body)| (body.name.as_str(), i)).collect();
    let found = |body: usize| {
        let at = *named.get(old.bodies[body].name.as_str())?;
        (carried_alike[old.bodies[body].frame] && old.bodies[body] == new.bodies[at]).then_some(at)
    };
    (0..old.bodies.len()).map(found).collect()
}

/// Returns for every body of `new` the index of the body with the same name in `old`, if any.
pub fn by_name(old: &Scene, new: &Scene) -> Vec<Option<usize>> {
    let mut named: Option<HashMap<&str, usize>> = None;
    let mut find = |name: &str| {
        let named = named.get_or_insert_with(|| old.bodies.iter().zip(0..).map(|(b, at)| (&*b.name, at)).collect());
        named.get(name).copied()
    };
    let body = |(at, name): (usize, &str)| match old.bodies.get(at) {
        // Scenes mostly have the same bodies in the same order, which needs no map of names.
        Some(body) if body.name == name => Some(at),
        _ => find(name),
    };
    new.bodies.iter().map(|body| body.name.as_str()).enumerate().map(body).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn bodies_are_found_where_nothing_of_them_changed() {
        let old = builtin::scene("shelf-arm").unwrap();
        let all: Vec<Option<usize>> = (0..old.bodies.len()).map(Some).collect();
        assert_eq!(bodies_in_both(&old, &old), all);
        let obstacle = old.bodies.iter().position(|body| body.robot.is_none()).unwrap();
        let mut new = old.clone();
        new.bodies[obstacle].parts[0].pose_frame_part.translation.x += 0.01;
        let mut expected = all.clone();
        expected[obstacle] = None;
        assert_eq!(bodies_in_both(&old, &new), expected);
        new.bodies.remove(obstacle);
        expected[obstacle + 1..].iter_mut().for_each(|at| *at = at.map(|at| at - 1));
        assert_eq!(bodies_in_both(&old, &new), expected);
    }

    #[test]
    fn what_a_changed_joint_carries_is_not_the_same() {
        let old = builtin::scene("shelf-arm").unwrap();
        let mut new = old.clone();
        new.frames[3].pose_parent_joint.translation.x += 0.01;
        for (body, found) in old.bodies.iter().zip(bodies_in_both(&old, &new)) {
            assert_eq!(found.is_some(), body.frame < 3, "{}", body.name);
        }
    }
}
