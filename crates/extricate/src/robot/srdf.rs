//! SRDF: `disable_collisions` and groups. Everything else in the file is ignored.

use std::collections::{BTreeSet, HashMap};

use super::Robot;
use super::formats::xml::{children, document, elements, label, required, with_declared_prefixes};
use crate::error::{Error, Result};

/// Which pairs of links need no check, and named sets of joints.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Srdf {
    /// Names of two links that are never checked against each other.
    pub disabled: Vec<[String; 2]>,
    /// Links that are checked against no other one, but for `enabled` (MoveIt 2:
    /// `disable_default_collisions`).
    pub disabled_by_default: Vec<String>,
    /// Pairs that are checked although one of them is in `disabled_by_default`
    /// (`enable_collisions`).
    pub enabled: Vec<[String; 2]>,
    /// In document order.
    pub groups: Vec<Group>,
    /// Joints that fix the robot to the world; groups may name them, the URDF does not.
    pub virtual_joints: Vec<String>,
}

/// A named set of joints, as the file describes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Group {
    /// Unique within the file.
    pub name: String,
    /// Joints.
    pub joints: Vec<String>,
    /// Links, each standing for the joint above it.
    pub links: Vec<String>,
    /// Base link and tip link; the joints between them.
    pub chains: Vec<[String; 2]>,
    /// Other groups.
    pub subgroups: Vec<String>,
}

/// Parses SRDF `text`; `file` is its name in messages. Names are not looked up: that takes a robot.
pub fn parse(file: &str, text: &str) -> Result<Srdf> {
    let text = with_declared_prefixes(text);
    let document = document(file, &text, "SRDF")?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err(Error::input(file, "root", format!("got <{}>, expected <robot>", robot.tag_name().name())));
    }
    let mut srdf = Srdf::default();
    for node in elements(robot) {
        let element = &label(node);
        let text = |attribute| required(file, element, node, attribute).map(str::to_owned);
        match node.tag_name().name() {
            "disable_collisions" => srdf.disabled.push([text("link1")?, text("link2")?]),
            "enable_collisions" => srdf.enabled.push([text("link1")?, text("link2")?]),
            "disable_default_collisions" => srdf.disabled_by_default.push(text("link")?),
            "virtual_joint" => srdf.virtual_joints.push(text("name")?),
            "group" => {
                let names = |tag, attribute| {
                    children(node, tag).map(move |n| required(file, element, n, attribute).map(str::to_owned))
                };
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

impl Srdf {
    /// The joints of a group: indices into [`Robot::joints`], ascending, fixed and mimic joints
    /// among them.
    ///
    /// A link stands for the joint above it (the root link for none), a chain for all joints on the
    /// way from its base to its tip (by their common ancestor, as MoveIt has it), a subgroup for
    /// its own joints. Virtual joints are left out.
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
        let mut joints = BTreeSet::new();
        let mut state = vec![Visit::Ahead; self.groups.len()];
        // Groups on the way to the current one, each with how many of its subgroups are done: a
        // chain of them may be longer than the stack of a thread is deep.
        let mut path: Vec<(usize, usize)> = vec![(find("robot", group)?, 0)];
        while let Some((at, next)) = path.last_mut() {
            let group = &self.groups[*at];
            if *next == 0 {
                state[*at] = Visit::OnPath;
                group.add_own(file, &self.virtual_joints, robot, &mut joints)?;
            }
            let Some(subgroup) = group.subgroups.get(*next) else {
                state[*at] = Visit::Done;
                path.pop();
                continue;
            };
            *next += 1;
            let element = format!("group \"{}\"", group.name);
            let below = find(&element, subgroup)?;
            match state[below] {
                Visit::Ahead => path.push((below, 0)),
                Visit::Done => {}
                Visit::OnPath => {
                    let names = path.iter().take(SHOWN).map(|(at, _)| self.groups[*at].name.as_str());
                    let names = names.collect::<Vec<_>>().join(" > ");
                    let problem = format!("got itself among its subgroups ({names}), expected no cycle");
                    return Err(Error::input(file, format!("group \"{subgroup}\""), problem));
                }
            }
        }
        Ok(joints.into_iter().collect())
    }
}

/// Groups that a message about a cycle names, most.
const SHOWN: usize = 10;

/// How far the walk through subgroups is with a group.
#[derive(Clone, Copy)]
enum Visit {
    Ahead,
    OnPath,
    Done,
}

impl Group {
    /// Adds the joints that the group names itself.
    fn add_own(
        &self,
        file: &str,
        virtual_joints: &[String],
        robot: &Robot,
        joints: &mut BTreeSet<usize>,
    ) -> Result<()> {
        let element = &format!("group \"{}\"", self.name);
        let link_of =
            |name: &String| {
                robot.links.iter().position(|link| link.name == *name).ok_or_else(|| {
                    unknown(file, element, "link", name, robot.links.iter().map(|link| link.name.as_str()))
                })
            };
        let joint_above = |link: usize| robot.joints.iter().position(|joint| joint.child == link);
        for name in self.joints.iter().filter(|name| !virtual_joints.contains(name)) {
            let joint = robot.joints.iter().position(|joint| joint.name == *name).ok_or_else(|| {
                unknown(file, element, "joint", name, robot.joints.iter().map(|joint| joint.name.as_str()))
            })?;
            joints.insert(joint);
        }
        for name in &self.links {
            joints.extend(joint_above(link_of(name)?));
        }
        for [base, tip] in &self.chains {
            let way_up = |mut link: usize| {
                let mut way = BTreeSet::new();
                while let Some(joint) = joint_above(link) {
                    way.insert(joint);
                    link = robot.joints[joint].parent;
                }
                way
            };
            joints.extend(&way_up(link_of(base)?) ^ &way_up(link_of(tip)?));
        }
        Ok(())
    }
}

fn unknown<'a>(file: &str, element: &str, kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> Error {
    let known: Vec<&str> = known.collect();
    let list = if known.is_empty() { "none".into() } else { known.join(", ") };
    Error::input(file, element, format!("got {kind} \"{name}\", expected one of: {list}"))
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

    /// A thread's stack holds some ten thousand calls.
    #[test]
    fn chains_of_groups_may_be_long() {
        let robot =
            urdf::parse("r.urdf", ROBOT, urdf::Shapes::Collision, &mut |_| unreachable!(), &mut vec![]).unwrap();
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
            urdf::parse("r.urdf", ROBOT, urdf::Shapes::Collision, &mut |_| unreachable!(), &mut vec![]).unwrap();
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
