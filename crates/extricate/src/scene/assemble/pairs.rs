//! Which pairs of bodies are checked.

use std::collections::BTreeSet;

use crate::error::{Error, Result};
use crate::scene::names::{Named, find};
use crate::scene::{Body, BodyPair};

/// Every pair of bodies, sorted, but for
/// - those fixed to one frame (one rigid group; all that cannot move shares the world's frame),
/// - links of one robot whose frames are joined by one joint, where `carriers` names for every
///   frame the one that its joint hangs on,
/// - those that are `disabled`.
pub fn checked(bodies: &[Body], carriers: &[usize], disabled: &BTreeSet<BodyPair>) -> Vec<BodyPair> {
    let mut pairs = Vec::new();
    for first in 0..bodies.len() {
        for second in first + 1..bodies.len() {
            let (a, b) = (&bodies[first], &bodies[second]);
            let joined = carriers[a.frame] == b.frame || carriers[b.frame] == a.frame;
            let one_robot = a.robot.is_some() && a.robot == b.robot;
            let pair = BodyPair { first, second };
            if a.frame != b.frame && !(one_robot && joined) && !disabled.contains(&pair) {
                pairs.push(pair);
            }
        }
    }
    pairs
}

/// Something that `[pairs]` may name, and its body where it has geometry.
#[derive(Debug, Clone, Copy)]
pub struct PairName<'a> {
    /// How it is called.
    pub named: Named<'a>,
    /// Index of its body.
    pub body: Option<usize>,
}

/// The pairs that `[pairs] disable` and the like name; `element` is what messages call that.
///
/// # Errors
/// [`Error::Input`] for names that do not exist or that two robots share, with the candidates.
pub fn disabled_by_scene(
    file: &str,
    element: &str,
    entries: &[[String; 2]],
    all: &[PairName],
) -> Result<Vec<BodyPair>> {
    let names: Vec<Named> = all.iter().map(|entry| entry.named).collect();
    let mut pairs = Vec::new();
    for entry in entries {
        let element = format!("{element} [\"{}\", \"{}\"]", entry[0], entry[1]);
        let body = |name: &String| {
            let element = element.as_str();
            find(&names, name).map(|index| all[index].body).map_err(|problem| Error::input(file, element, problem))
        };
        let (first, second) = (body(&entry[0])?, body(&entry[1])?);
        if first.is_some() && first == second {
            let problem = "got one body twice, expected two bodies";
            return Err(Error::input(file, element, problem));
        }
        pairs.extend(ordered(first, second));
    }
    Ok(pairs)
}

/// The pairs that a robot's SRDF disables: its own links and obstacles by their plain names. What
/// does not exist is ignored, as SRDFs are shared between variants of a robot.
pub fn disabled_by_srdf(robot: &str, entries: &[[String; 2]], all: &[PairName]) -> Vec<BodyPair> {
    let body = |name: &String| {
        let is_meant = |entry: &&PairName| entry.named.name == name && entry.named.robot.is_none_or(|own| own == robot);
        all.iter().find(is_meant).and_then(|entry| entry.body)
    };
    entries.iter().filter_map(|[a, b]| ordered(body(a), body(b))).collect()
}

fn ordered(a: Option<usize>, b: Option<usize>) -> Option<BodyPair> {
    let (a, b) = (a?, b?);
    (a != b).then_some(BodyPair { first: a.min(b), second: a.max(b) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(robot: Option<usize>, frame: usize) -> Body {
        Body { name: String::new(), robot, frame, parts: Vec::new() }
    }

    fn pairs(bodies: &[Body], carriers: &[usize]) -> Vec<(usize, usize)> {
        let pairs = checked(bodies, carriers, &BTreeSet::new());
        pairs.iter().map(|pair| (pair.first, pair.second)).collect()
    }

    #[test]
    fn groups_and_neighbours_are_skipped() {
        // Base link, two links on frame 1, one on frame 2; an obstacle; a second robot's link on
        // frame 3, on the world.
        let bodies =
            [body(Some(0), 0), body(Some(0), 1), body(Some(0), 1), body(Some(0), 2), body(Some(1), 3), body(None, 0)];
        let carriers = [0, 0, 1, 0];
        assert_eq!(pairs(&bodies, &carriers), [(0, 3), (0, 4), (1, 4), (1, 5), (2, 4), (2, 5), (3, 4), (3, 5), (4, 5)]);
    }

    #[test]
    fn intermediate_frames_do_not_part_neighbours() {
        // Frames 2, 3 and 4 are one planar joint on frame 1.
        let bodies = [body(Some(0), 1), body(Some(0), 4), body(None, 0)];
        assert_eq!(pairs(&bodies, &[0, 0, 1, 1, 1]), [(0, 2), (1, 2)]);
    }

    #[test]
    fn names_disable_pairs() {
        let named = |robot, name| Named { robot, name };
        let all = [
            PairName { named: named(Some("a"), "hand"), body: Some(0) },
            PairName { named: named(Some("b"), "hand"), body: Some(1) },
            PairName { named: named(Some("b"), "frame"), body: None },
            PairName { named: named(None, "box"), body: Some(2) },
        ];
        let strings = |names: [&str; 2]| names.map(String::from);
        let by_scene = |names| disabled_by_scene("s.toml", "pairs: disable", &[strings(names)], &all);
        assert_eq!(by_scene(["box", "a/hand"]).unwrap(), [BodyPair { first: 0, second: 2 }]);
        assert_eq!(by_scene(["box", "frame"]).unwrap(), []);
        assert!(by_scene(["box", "box"]).unwrap_err().to_string().contains("got one body twice"));
        let ambiguous = by_scene(["hand", "box"]).unwrap_err().to_string();
        assert!(ambiguous.contains("`a/hand`, `b/hand`"), "{ambiguous}");
        let unknown = by_scene(["bux", "frame"]).unwrap_err().to_string();
        assert!(unknown.contains("got `bux`") && unknown.contains("`box`"), "{unknown}");
        let entries = [strings(["hand", "box"]), strings(["nowhere", "box"]), strings(["hand", "hand"])];
        assert_eq!(disabled_by_srdf("b", &entries, &all), [BodyPair { first: 1, second: 2 }]);
    }
}
