//! Decides which pairs of bodies are checked.

use std::collections::{HashMap, HashSet};

use crate::error::{Error, Result, quoted};
use crate::robot::srdf::Srdf;
use crate::scene::file::SceneFile;
use crate::scene::names::Named;
use crate::scene::{Body, BodyPair};

/// Returns all pairs of bodies in ascending order, except
/// - pairs on one frame (bodies that cannot move are all on that of the world),
/// - links of one robot whose frames are joined by one joint; `carriers` has for every frame the
///   one that carries its joint,
/// - pairs that `rules` disable.
///
/// Pairs that `rules` enable are checked, unless they are on one frame.
///
/// # Errors
/// The number of pairs when it exceeded `most`, which may be before all were counted.
pub fn checked(
    bodies: &[Body],
    carriers: &[usize],
    rules: &PairRules,
    most: usize,
) -> std::result::Result<Vec<BodyPair>, usize> {
    let moving: Vec<usize> = (0..bodies.len()).filter(|&body| bodies[body].frame != 0).collect();
    let mut pairs = Vec::new();
    for (first, a) in bodies.iter().enumerate() {
        let meets = |second: usize| {
            let b = &bodies[second];
            let joined = carriers[a.frame] == b.frame || carriers[b.frame] == a.frame;
            let one_robot = a.robot.is_some() && a.robot == b.robot;
            let pair = BodyPair { first, second };
            (a.frame != b.frame && !(one_robot && joined) && !rules.disable(bodies, pair)).then_some(pair)
        };
        match a.frame {
            // There may be hundreds of thousands of obstacles, so they skip each other.
            0 => {
                pairs.extend(moving[moving.partition_point(|&body| body <= first)..].iter().copied().filter_map(meets))
            }
            _ => pairs.extend((first + 1..bodies.len()).filter_map(meets)),
        }
        if pairs.len() > most {
            return Err(pairs.len());
        }
    }
    let put_back = rules.enabled.iter().filter(|pair| !rules.disabled.contains(pair));
    pairs.extend(put_back.filter(|pair| may_meet(bodies, **pair)));
    pairs.sort_unstable();
    pairs.dedup();
    if pairs.len() > most { Err(pairs.len()) } else { Ok(pairs) }
}

/// Returns whether the distance of two bodies can change.
fn may_meet(bodies: &[Body], pair: BodyPair) -> bool {
    bodies[pair.first].frame != bodies[pair.second].frame
}

/// Pairs of bodies that are disabled, and exceptions from that.
#[derive(Debug, Default)]
pub struct PairRules {
    disabled: HashSet<BodyPair>,
    /// Maps a body to the robots whose links it is not checked against, except pairs in `enabled`.
    by_default: HashMap<usize, HashSet<usize>>,
    /// Pairs that are checked unless `disabled` has them.
    enabled: HashSet<BodyPair>,
}

impl PairRules {
    fn disable(&self, bodies: &[Body], pair: BodyPair) -> bool {
        let by_default = |one: usize, other: usize| {
            let robots = self.by_default.get(&one);
            robots.is_some_and(|robots| bodies[other].robot.is_some_and(|robot| robots.contains(&robot)))
        };
        let BodyPair { first, second } = pair;
        self.disabled.contains(&pair) || by_default(first, second) || by_default(second, first)
    }

    /// Adds the pairs of the scene, which override those of SRDFs. No pair may be in both sets.
    pub fn add_scene(&mut self, disabled: HashSet<BodyPair>, enabled: HashSet<BodyPair>) {
        self.disabled.retain(|pair| !enabled.contains(pair));
        self.disabled.extend(disabled);
        self.enabled.extend(enabled);
    }

    /// Adds the pairs that a robot's SRDF disables and enables; it names the robot's links and
    /// obstacles by their plain names. Unknown names are ignored, because variants of a robot share
    /// SRDFs.
    pub fn add_srdf(&mut self, (index, robot): (usize, &str), srdf: &Srdf, names: &SrdfNames) {
        let body = |name: &String| names.body(robot, name);
        let pairs = |entries: &[[String; 2]]| -> Vec<BodyPair> {
            entries.iter().filter_map(|[a, b]| ordered(body(a), body(b))).collect()
        };
        self.disabled.extend(pairs(&srdf.disabled));
        self.enabled.extend(pairs(&srdf.enabled));
        for lonely in srdf.disabled_by_default.iter().filter_map(body) {
            self.by_default.entry(lonely).or_default().insert(index);
        }
    }
}

/// Finds bodies by the names that SRDFs use.
pub struct SrdfNames<'a> {
    bodies: HashMap<(Option<&'a str>, &'a str), Option<usize>>,
}

impl<'a> SrdfNames<'a> {
    /// Creates the map from everything that pairs may name.
    pub fn new(all: &[PairName<'a>]) -> Self {
        let key = |entry: &PairName<'a>| (entry.named.robot, entry.named.name);
        Self { bodies: all.iter().rev().map(|entry| (key(entry), entry.body)).collect() }
    }

    /// Returns the body of a link of the robot, or else of an obstacle.
    fn body(&self, robot: &str, name: &str) -> Option<usize> {
        let found = self.bodies.get(&(Some(robot), name)).or_else(|| self.bodies.get(&(None, name)));
        found.copied().flatten()
    }
}

/// A link, obstacle or attached object that `[pairs]` may name.
#[derive(Debug, Clone, Copy)]
pub struct PairName<'a> {
    /// Its name, and that of its robot.
    pub named: Named<'a>,
    /// Index of its body; `None` for a link without geometry.
    pub body: Option<usize>,
}

/// Returns the body that a name means, `None` for a link without geometry, or what is wrong with
/// the name.
pub type FindBody<'a> = dyn Fn(&str) -> std::result::Result<Option<usize>, String> + 'a;

/// Returns the pairs of bodies that a scene file disables, by `[pairs] disable` and by `touch` of
/// attached objects, and those that it enables, by `[pairs] enable`. Enabled pairs that can never
/// be checked are left out with a warning.
///
/// # Errors
/// [`Error::Input`] for unknown and ambiguous names, for one body twice, and for an enabled pair
/// that occurs twice or is disabled as well.
pub fn pairs_of_scene(
    file: &str,
    scene: &SceneFile,
    find: &FindBody,
    bodies: &[Body],
    warnings: &mut Vec<String>,
) -> Result<(HashSet<BodyPair>, HashSet<BodyPair>)> {
    let mut disabled = named_pairs(file, "pairs: disable", &scene.pairs.disable, find)?;
    for object in &scene.attached {
        let touched: Vec<[String; 2]> = object.touch.iter().map(|other| [object.name.clone(), other.clone()]).collect();
        disabled.extend(named_pairs(file, &format!("attached {:?}: touch", object.name), &touched, find)?);
    }
    let disabled: HashSet<BodyPair> = disabled.into_iter().flatten().collect();
    let (element, entries) = ("pairs: enable", &scene.pairs.enable);
    let mut enabled = HashSet::new();
    for (entry, pair) in entries.iter().zip(named_pairs(file, element, entries, find)?) {
        let entry = in_entry(element, entry);
        let Some(pair) = pair else {
            warnings.push(format!("{entry}: a link without geometry touches nothing: the pair is not checked"));
            continue;
        };
        if disabled.contains(&pair) {
            let problem = "got a pair that `disable` or `touch` takes out, expected it in one of them only";
            return Err(Error::input(file, entry, problem));
        }
        if !enabled.insert(pair) {
            return Err(Error::input(file, entry, "got the pair twice, expected it once"));
        }
        if !may_meet(bodies, pair) {
            warnings.push(format!("{entry}: nothing moves one against the other: the pair is not checked"));
        }
    }
    enabled.retain(|pair| may_meet(bodies, *pair));
    Ok((disabled, enabled))
}

fn named_pairs(file: &str, element: &str, entries: &[[String; 2]], find: &FindBody) -> Result<Vec<Option<BodyPair>>> {
    let pair = |entry: &[String; 2]| {
        let fault = |problem: String| Error::input(file, in_entry(element, entry), problem);
        let (first, second) = (find(&entry[0]).map_err(fault)?, find(&entry[1]).map_err(fault)?);
        if first.is_some() && first == second {
            return Err(fault("got one body twice, expected two bodies".into()));
        }
        Ok(ordered(first, second))
    };
    entries.iter().map(pair).collect()
}

fn in_entry(element: &str, [a, b]: &[String; 2]) -> String {
    format!("{element} [\"{}\", \"{}\"]", quoted(a), quoted(b))
}

fn ordered(a: Option<usize>, b: Option<usize>) -> Option<BodyPair> {
    let (a, b) = (a?, b?);
    (a != b).then_some(BodyPair { first: a.min(b), second: a.max(b) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::names::NameIndex;

    fn body(robot: Option<usize>, frame: usize) -> Body {
        Body { name: String::new(), robot, frame, parts: Vec::new() }
    }

    fn pairs(bodies: &[Body], carriers: &[usize]) -> Vec<(usize, usize)> {
        let pairs = checked(bodies, carriers, &PairRules::default(), 9).unwrap();
        pairs.iter().map(|pair| (pair.first, pair.second)).collect()
    }

    #[test]
    fn groups_and_neighbours_are_skipped() {
        // Base link, two links on frame 1, one on frame 2; a second robot's link on frame 3, which
        // the world carries; an obstacle.
        let bodies =
            [body(Some(0), 0), body(Some(0), 1), body(Some(0), 1), body(Some(0), 2), body(Some(1), 3), body(None, 0)];
        let carriers = [0, 0, 1, 0];
        assert_eq!(pairs(&bodies, &carriers), [(0, 3), (0, 4), (1, 4), (1, 5), (2, 4), (2, 5), (3, 4), (3, 5), (4, 5)]);
        assert_eq!(checked(&bodies, &carriers, &PairRules::default(), 6), Err(8), "it is counted body by body");
    }

    #[test]
    fn pairs_are_those_that_comparing_all_finds() {
        for (count, moving) in [(0, 1), (40, 7), (41, 2), (23, 1)] {
            let frame = |k: usize| if k.is_multiple_of(3) { 0 } else { 1 + k % moving };
            let bodies: Vec<Body> = (0..count).map(|k| body((k % 5 < 2).then_some(k % 2), frame(k))).collect();
            let carriers: Vec<usize> = (0..=moving).map(|frame| frame / 2).collect();
            let mut disabled = PairRules::default();
            disabled.disabled.extend((0..count / 2).map(|k| BodyPair { first: k, second: count - 1 - k }));
            let mut slow = Vec::new();
            for (first, a) in bodies.iter().enumerate() {
                for (second, b) in bodies.iter().enumerate().skip(first + 1) {
                    let joined = carriers[a.frame] == b.frame || carriers[b.frame] == a.frame;
                    let pair = BodyPair { first, second };
                    let own = a.robot.is_some() && a.robot == b.robot && joined;
                    if a.frame != b.frame && !own && !disabled.disabled.contains(&pair) {
                        slow.push(pair);
                    }
                }
            }
            assert_eq!(checked(&bodies, &carriers, &disabled, usize::MAX), Ok(slow));
        }
    }

    #[test]
    fn links_without_default_collisions_keep_what_is_enabled() {
        let names = |pairs: &[[&str; 2]]| pairs.iter().map(|pair| pair.map(String::from)).collect::<Vec<_>>();
        let srdf = Srdf {
            disabled: names(&[["l0", "l2"]]),
            disabled_by_default: vec!["l1".into(), "nowhere".into()],
            enabled: names(&[["l3", "l1"]]),
            ..Default::default()
        };
        let bodies = [body(Some(0), 1), body(Some(0), 3), body(Some(0), 5), body(Some(0), 7), body(None, 0)];
        let name = |k: usize| ["l0", "l1", "l2", "l3", "ball"][k];
        let named = |k: usize| Named { robot: bodies[k].robot.map(|_| "arm"), name: name(k) };
        let all: Vec<PairName> = (0..5).map(|k| PairName { named: named(k), body: Some(k) }).collect();
        let mut disabled = PairRules::default();
        disabled.add_srdf((0, "arm"), &srdf, &SrdfNames::new(&all));
        let kept = checked(&bodies, &[0; 8], &disabled, 99).unwrap();
        let kept: Vec<[&str; 2]> = kept.iter().map(|pair| [name(pair.first), name(pair.second)]).collect();
        let against_ball = [["l0", "ball"], ["l1", "l3"], ["l1", "ball"], ["l2", "l3"], ["l2", "ball"], ["l3", "ball"]];
        assert_eq!(kept, [&[["l0", "l3"]][..], &against_ball].concat());
    }

    #[test]
    fn an_srdf_enables_neighbours_but_not_what_it_disables_or_what_is_one_group() {
        let strings = |pairs: &[[&str; 2]]| pairs.iter().map(|pair| pair.map(String::from)).collect::<Vec<_>>();
        let enabled = strings(&[["l0", "l1"], ["l1", "l2"], ["l2", "l3"], ["l0", "gone"]]);
        let srdf = Srdf { disabled: strings(&[["l2", "l1"]]), enabled, ..Srdf::default() };
        // Three links in a chain, and a fourth one fixed to the third.
        let bodies = [body(Some(0), 0), body(Some(0), 1), body(Some(0), 2), body(Some(0), 2)];
        let names = ["l0", "l1", "l2", "l3"];
        let name = |k: usize| PairName { named: Named { robot: Some("arm"), name: names[k] }, body: Some(k) };
        let all: Vec<PairName> = (0..4).map(name).collect();
        let mut rules = PairRules::default();
        rules.add_srdf((0, "arm"), &srdf, &SrdfNames::new(&all));
        let pair = |first, second| BodyPair { first, second };
        assert_eq!(checked(&bodies, &[0, 0, 1], &rules, 9).unwrap(), [pair(0, 1), pair(0, 2), pair(0, 3)]);
        rules.add_scene(HashSet::from([pair(0, 1)]), HashSet::from([pair(1, 2)]));
        let scene_goes_first = [pair(0, 2), pair(0, 3), pair(1, 2)];
        assert_eq!(checked(&bodies, &[0, 0, 1], &rules, 9).unwrap(), scene_goes_first);
        assert_eq!(checked(&bodies, &[0, 0, 1], &rules, 2), Err(3));
    }

    #[test]
    fn intermediate_frames_do_not_part_neighbours() {
        // Frames 2, 3 and 4 belong to one planar joint on frame 1.
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
        let index = NameIndex::new(all.iter().map(|entry| entry.named).collect());
        let find = |name: &str| index.find(name).map(|at| all[at].body);
        let by_scene = |names| named_pairs("s.toml", "pairs: disable", &[strings(names)], &find);
        assert_eq!(by_scene(["box", "a/hand"]).unwrap(), [Some(BodyPair { first: 0, second: 2 })]);
        assert_eq!(by_scene(["box", "frame"]).unwrap(), [None]);
        assert!(by_scene(["box", "box"]).unwrap_err().to_string().contains("got one body twice"));
        let ambiguous = by_scene(["hand", "box"]).unwrap_err().to_string();
        assert!(ambiguous.contains("`a/hand`, `b/hand`"), "{ambiguous}");
        let unknown = by_scene(["bux", "frame"]).unwrap_err().to_string();
        assert!(unknown.contains("got `bux`") && unknown.contains("`box`"), "{unknown}");
        let disabled = vec![strings(["hand", "box"]), strings(["nowhere", "box"]), strings(["hand", "hand"])];
        let mut found = PairRules::default();
        found.add_srdf((1, "b"), &Srdf { disabled, ..Srdf::default() }, &SrdfNames::new(&all));
        assert_eq!(found.disabled, HashSet::from([BodyPair { first: 1, second: 2 }]));
    }
}
