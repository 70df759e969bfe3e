//! SRDF: pairs of links that need no check, groups and virtual joints. Everything else in the file
//! is ignored.

use std::collections::{BTreeSet, HashMap, HashSet};

use roxmltree::Node;

use super::formats::xml::{children, document, elements, label, own_attribute, required, with_declared_prefixes};
use super::{Joint, LoadLimit, LoadLimits, Robot};
use crate::error::{Error, MOST_LISTED, Result, listed, quoted};

/// Pairs of links that need no check, and named sets of joints.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Srdf {
    /// Pairs of links, by name, that are never checked against each other.
    pub disabled: Vec<[String; 2]>,
    /// Links that are only checked in pairs of `enabled` (MoveIt 2: `disable_default_collisions`).
    pub disabled_by_default: Vec<String>,
    /// Pairs that are checked although `disabled_by_default` has one link of them
    /// (`enable_collisions`).
    pub enabled: Vec<[String; 2]>,
    /// All groups, in document order.
    pub groups: Vec<Group>,
    /// Names of joints that fix the robot to the world. Groups may name them; the URDF does not.
    pub virtual_joints: Vec<String>,
}

/// A named set of joints, as the file describes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Group {
    /// Name of the group; if several have it, the first counts.
    pub name: String,
    /// Names of joints in the group.
    pub joints: Vec<String>,
    /// Names of links, each standing for the joint above it.
    pub links: Vec<String>,
    /// Base link and tip link of each chain, which stands for the joints between them.
    pub chains: Vec<[String; 2]>,
    /// Names of other groups, whose joints belong to this one too.
    pub subgroups: Vec<String>,
}

/// Parses SRDF `text`; `file` is its name in messages. Names are not resolved: that takes a robot.
pub fn parse(file: &str, text: &str) -> Result<Srdf> {
    parse_within(file, text, &LoadLimits::default())
}

/// As [`parse`], within limits.
pub fn parse_within(file: &str, text: &str, limits: &LoadLimits) -> Result<Srdf> {
    limits.check(LoadLimit::TextBytes, text.len(), file, "file")?;
    let text = with_declared_prefixes(file, text, limits)?;
    let document = document(file, &text, "SRDF", limits)?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err(Error::input(file, "root", format!("got <{}>, expected <robot>", quoted(robot.tag_name().name()))));
    }
    let mut srdf = Srdf::default();
    for node in elements(robot) {
        let text = |attribute| attribute_of(file, node, node, attribute);
        match node.tag_name().name() {
            "disable_collisions" => srdf.disabled.push([text("link1")?, text("link2")?]),
            "enable_collisions" => srdf.enabled.push([text("link1")?, text("link2")?]),
            "disable_default_collisions" => srdf.disabled_by_default.push(text("link")?),
            "virtual_joint" => srdf.virtual_joints.push(text("name")?),
            "group" => {
                let names =
                    |tag, attribute| children(node, tag).map(move |child| attribute_of(file, node, child, attribute));
                srdf.groups.push(Group {
                    name: text("name")?,
                    joints: names("joint", "name").collect::<Result<_>>()?,
                    links: names("link", "name").collect::<Result<_>>()?,
                    chains: names("chain", "base_link")
                        .zip(names("chain", "tip_link"))
                        .map(|(base, tip)| Ok([base?, tip?]))
                        .collect::<Result<_>>()?,
                    subgroups: names("group", "name").collect::<Result<_>>()?,
                });
            }
            _ => {}
        }
    }
    Ok(srdf)
}

/// Returns an attribute of `child`, which is `node` or a child of it. A label without a name scans
/// the whole file for its line, so it is only made for messages.
fn attribute_of(file: &str, node: Node, child: Node, attribute: &str) -> Result<String> {
    match own_attribute(child, attribute) {
        Some(text) => Ok(text.to_owned()),
        None => required(file, &label(node), child, attribute).map(str::to_owned),
    }
}

impl Srdf {
    /// Returns the joints of a group: ascending indices into [`Robot::joints`], fixed and mimic
    /// joints included.
    ///
    /// A link stands for the joint above it (the root link for none), a subgroup for its own
    /// joints. A chain stands for all joints between its base and its tip (by their common
    /// ancestor, as in MoveIt). Virtual joints are left out.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that does not exist (with those that do), and for groups that
    /// contain each other.
    pub fn group_joints(&self, file: &str, group: &str, robot: &Robot) -> Result<Vec<usize>> {
        let index_of: HashMap<&str, usize> =
            self.groups.iter().enumerate().rev().map(|(index, group)| (group.name.as_str(), index)).collect();
        let find = |asked_by: &str, name: &str| {
            let known = self.groups.iter().map(|group| group.name.as_str());
            index_of.get(name).copied().ok_or_else(|| unknown(file, asked_by, "group", name, known))
        };
        let lookup = Lookup::of(robot, &self.virtual_joints);
        let mut joints = BTreeSet::new();
        let mut state = vec![Visit::Ahead; self.groups.len()];
        // Groups from the first to the current one, each with the number of subgroups that are
        // done. A chain of groups may be too long for recursion.
        let mut path: Vec<(usize, usize)> = vec![(find("robot", group)?, 0)];
        while let Some((at, next)) = path.last_mut() {
            let group = &self.groups[*at];
            if *next == 0 {
                state[*at] = Visit::OnPath;
                group.add_own(file, &lookup, &mut joints)?;
            }
            let Some(subgroup) = group.subgroups.get(*next) else {
                state[*at] = Visit::Done;
                path.pop();
                continue;
            };
            *next += 1;
            let element = format!("group \"{}\"", quoted(&group.name));
            let below = find(&element, subgroup)?;
            match state[below] {
                Visit::Ahead => path.push((below, 0)),
                Visit::Done => {}
                Visit::OnPath => {
                    let names = path.iter().take(MOST_LISTED).map(|(at, _)| quoted(&self.groups[*at].name));
                    let names = names.collect::<Vec<_>>().join(" > ");
                    let problem = format!("got itself among its subgroups ({names}), expected no cycle");
                    return Err(Error::input(file, format!("group \"{}\"", quoted(subgroup)), problem));
                }
            }
        }
        Ok(joints.into_iter().collect())
    }
}

#[derive(Clone, Copy)]
enum Visit {
    Ahead,
    OnPath,
    Done,
}

/// Maps from names of a robot to indices, since a file may use the names many times.
struct Lookup<'a> {
    robot: &'a Robot,
    links: HashMap<&'a str, usize>,
    joints: HashMap<&'a str, usize>,
    /// The joint above each link.
    above: Vec<Option<usize>>,
    virtual_joints: HashSet<&'a str>,
}

impl<'a> Lookup<'a> {
    fn of(robot: &'a Robot, virtual_joints: &'a [String]) -> Self {
        let mut above = vec![None; robot.links.len()];
        robot.joints.iter().enumerate().rev().for_each(|(joint, Joint { child, .. })| above[*child] = Some(joint));
        Self {
            robot,
            links: robot.links.iter().enumerate().map(|(index, link)| (link.name.as_str(), index)).collect(),
            joints: robot.joints.iter().enumerate().map(|(index, joint)| (joint.name.as_str(), index)).collect(),
            above,
            virtual_joints: virtual_joints.iter().map(String::as_str).collect(),
        }
    }

    /// The joints between a link and the root, nearest first.
    fn way_up(&self, link: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.above[link], |joint| self.above[self.robot.joints[*joint].parent])
    }
}

impl Group {
    /// Adds the joints of the group itself, without those of its subgroups.
    fn add_own(&self, file: &str, lookup: &Lookup, joints: &mut BTreeSet<usize>) -> Result<()> {
        let element = &format!("group \"{}\"", quoted(&self.name));
        let robot = lookup.robot;
        let link_of =
            |name: &String| {
                lookup.links.get(name.as_str()).copied().ok_or_else(|| {
                    unknown(file, element, "link", name, robot.links.iter().map(|link| link.name.as_str()))
                })
            };
        for name in self.joints.iter().filter(|name| !lookup.virtual_joints.contains(name.as_str())) {
            let joint = lookup.joints.get(name.as_str()).copied().ok_or_else(|| {
                unknown(file, element, "joint", name, robot.joints.iter().map(|joint| joint.name.as_str()))
            })?;
            joints.insert(joint);
        }
        for name in &self.links {
            joints.extend(lookup.above[link_of(name)?]);
        }
        let chains: HashSet<[usize; 2]> =
            self.chains.iter().map(|[base, tip]| Ok([link_of(base)?, link_of(tip)?])).collect::<Result<_>>()?;
        // A chain has the joints above exactly one of its two ends.
        let mut on_way = vec![false; robot.joints.len()];
        for [base, tip] in chains {
            lookup.way_up(base).for_each(|joint| on_way[joint] = true);
            let mut common = tip;
            for joint in lookup.way_up(tip).take_while(|joint| !on_way[*joint]) {
                joints.insert(joint);
                common = robot.joints[joint].parent;
            }
            let above = lookup.above[common];
            joints.extend(lookup.way_up(base).take_while(|joint| Some(*joint) != above));
            lookup.way_up(base).for_each(|joint| on_way[joint] = false);
        }
        Ok(())
    }
}

fn unknown<'a>(file: &str, element: &str, kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> Error {
    let list = listed(known);
    let list = if list.is_empty() { "none".into() } else { list };
    Error::input(file, element, format!("got {kind} \"{}\", expected one of: {list}", quoted(name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::urdf;

    const ROBOT: &str = "<robot name='r'><link name='base'/><link name='a'/><link name='b'/><link name='c'/>\
        <joint name='ja' type='continuous'><parent link='base'/><child link='a'/></joint>\
        <joint name='jb' type='fixed'><parent link='a'/><child link='b'/></joint>\
        <joint name='jc' type='continuous'><parent link='a'/><child link='c'/></joint></robot>";

    const TEXT: &str = "<?xml version='1.0'?><robot name='r'>\
        <virtual_joint name='world' type='fixed' parent_frame='w' child_link='base'/>\
        <group name='arm'><chain base_link='base' tip_link='c'/></group>\
        <group name='hand'><link name='b'/><link name='base'/></group>\
        <group name='all'><group name='arm'/><group name='hand'/><group name='arm'/><joint name='world'/></group>\
        <group name='one'><joint name='jc'/></group><group name='none'/>\
        <group name='x'><group name='y'/></group><group name='y'><group name='x'/></group>\
        <group name='bad joint'><joint name='jd'/></group><group name='bad link'><link name='d'/></group>\
        <group name='side'><chain base_link='b' tip_link='c'/></group><group name='bad group'><group name='z'/></group>\
        <disable_collisions link1='a' link2='b' reason='Adjacent'/><disable_default_collisions link='c'/>\
        <enable_collisions link1='c' link2='base'/><end_effector name='e' parent_link='b' group='hand'/></robot>";

    /// Recursion would overflow here: a thread's stack holds some ten thousand calls.
    #[test]
    fn chains_of_groups_may_be_long() {
        let robot =
            urdf::parse("r.urdf", ROBOT, urdf::Shapes::Collision, &mut |_, _| unreachable!(), &mut vec![]).unwrap();
        let mut text = String::from("<robot name='r'>");
        for k in 0..50_000 {
            text += &format!("<group name='g{k}'><group name='g{}'/></group>", k + 1);
        }
        let last = "<group name='g50000'><joint name='jc'/></group></robot>";
        let srdf = parse("s", &(text.clone() + last)).unwrap();
        assert_eq!(srdf.group_joints("s", "g0", &robot).unwrap().len(), 1);
        let again = parse("s", &(text + "<group name='g50000'><group name='g7'/></group></robot>")).unwrap();
        let message = again.group_joints("s", "g0", &robot).unwrap_err().to_string();
        assert!(
            message.contains("group \"g7\": got itself among its subgroups (g0 > g1") && message.len() < 300,
            "{message}"
        );
    }

    #[test]
    fn groups_resolve_to_joints() {
        let robot =
            urdf::parse("r.urdf", ROBOT, urdf::Shapes::Collision, &mut |_, _| unreachable!(), &mut vec![]).unwrap();
        let srdf = parse("r.srdf", TEXT).unwrap();
        let joints = |group| srdf.group_joints("r.srdf", group, &robot);
        assert_eq!(joints("arm").unwrap(), [0, 2]);
        assert_eq!(joints("side").unwrap(), [1, 2]);
        assert_eq!(joints("hand").unwrap(), [1]);
        assert_eq!(joints("all").unwrap(), [0, 1, 2]);
        assert_eq!(joints("one").unwrap(), [2]);
        assert!(joints("none").unwrap().is_empty());
        let message = |group| joints(group).unwrap_err().to_string();
        assert_eq!(message("x"), "r.srdf: group \"x\": got itself among its subgroups (x > y), expected no cycle");
        assert_eq!(message("bad joint"), "r.srdf: group \"bad joint\": got joint \"jd\", expected one of: ja, jb, jc");
        assert_eq!(message("bad link"), "r.srdf: group \"bad link\": got link \"d\", expected one of: base, a, b, c");
        assert!(message("bad group").contains("got group \"z\", expected one of: arm, hand"));
        assert!(message("zz").starts_with("r.srdf: robot: got group \"zz\""));
    }

    #[test]
    fn pairs_are_read() {
        let srdf = parse("r.srdf", TEXT).unwrap();
        assert_eq!(srdf.disabled, [["a".to_owned(), "b".to_owned()]]);
        assert_eq!(srdf.disabled_by_default, ["c"]);
        assert_eq!(srdf.enabled, [["c".to_owned(), "base".to_owned()]]);
        let message = |text: &str| parse("r.srdf", text).unwrap_err().to_string();
        assert!(message("<robot><disable_collisions link1='a'/></robot>").contains("without the attribute `link2`"));
        assert!(message("<sdf/>").contains("got <sdf>, expected <robot>"));
        assert!(message("disable").contains("expected SRDF"));
    }
}
