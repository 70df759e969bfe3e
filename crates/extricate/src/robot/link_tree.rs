//! Checks what makes links and joints a robot: one tree of links, and mimic joints that follow
//! independent ones.

use std::collections::HashMap;

use super::{Joint, JointKind, Link, Mimic};
use crate::error::{Error, Result, listed, quoted};
use crate::math::FARTHEST;

/// A `<mimic>` element before the name of the followed joint is resolved.
pub(crate) struct NamedMimic {
    pub joint: usize,
    pub followed: String,
    pub multiplier: f64,
    pub offset: f64,
}

/// Returns the index of the root link.
///
/// # Errors
/// A link with two parents, no link at all, several roots, a cycle.
pub(crate) fn root(file: &str, links: &[Link], joints: &[Joint]) -> Result<usize> {
    let mut parent_joint: Vec<Option<usize>> = vec![None; links.len()];
    for (index, joint) in joints.iter().enumerate() {
        if let Some(other) = parent_joint[joint.child].replace(index) {
            let problem = format!(
                "got two parent joints, \"{}\" and \"{}\", expected at most one: a tree",
                joints[other].name, joint.name
            );
            return Err(Error::input(file, format!("link \"{}\"", links[joint.child].name), problem));
        }
    }
    let roots: Vec<usize> = (0..links.len()).filter(|&link| parent_joint[link].is_none()).collect();
    let names = |found: &[usize]| listed(found.iter().map(|link| format!("\"{}\"", links[*link].name)));
    let root = match roots[..] {
        [root] => root,
        [] if links.is_empty() => return Err(Error::input(file, "robot", "got no links, expected at least one")),
        [] => return Err(Error::input(file, "robot", "got a cycle through all links, expected a tree with one root")),
        _ => {
            let problem = format!("got {} root links ({}), expected one", roots.len(), names(&roots));
            return Err(Error::input(file, "robot", problem));
        }
    };
    // Each link has one parent, so those that the root does not reach are on or below a cycle.
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    joints.iter().for_each(|joint| children[joint.parent].push(joint.child));
    let mut is_reached = vec![false; links.len()];
    let mut open = vec![root];
    while let Some(link) = open.pop() {
        is_reached[link] = true;
        open.extend(&children[link]);
    }
    let lost: Vec<usize> = (0..links.len()).filter(|&link| !is_reached[link]).collect();
    if !lost.is_empty() {
        let lost = names(&lost);
        let problem = format!("got a cycle of joints ({lost}), expected every link below \"{}\"", links[root].name);
        return Err(Error::input(file, "robot", problem));
    }
    Ok(root)
}

/// Checks that a follower stays within 1e9 rad or m, as far as its leader's limits show.
///
/// # Errors
/// A composed multiplier or offset beyond that, or a translation that goes beyond it.
fn check_range(file: &str, joints: &[Joint], follower: usize, mimic: &Mimic) -> Result<()> {
    let leader = &joints[mimic.joint];
    let reach = match (joints[follower].kind, leader.limits) {
        (JointKind::Prismatic, Some((lower, upper))) => lower.abs().max(upper.abs()),
        _ => 0.0,
    };
    let farthest = [mimic.multiplier, mimic.offset, mimic.multiplier.abs() * reach + mimic.offset.abs()];
    if let Some(beyond) = farthest.into_iter().find(|value| value.is_nan() || value.abs() > FARTHEST) {
        let problem = format!(
            "got a position of {} times that of joint \"{}\" and {} more, mimic joints followed to the end, which comes \
             to {beyond}, expected numbers up to {FARTHEST}",
            mimic.multiplier, leader.name, mimic.offset
        );
        return Err(Error::input(file, format!("joint \"{}\"", joints[follower].name), problem));
    }
    Ok(())
}

/// Composes chains in `joints`, so that every mimic joint follows an independent one. A leader may
/// be fixed: its followers stay at their offsets.
///
/// # Errors
/// An unknown joint, a cycle, a follower or leader that has several coordinates, a range beyond
/// 1e9.
pub(crate) fn resolve_mimics(file: &str, mimics: &[NamedMimic], joints: &mut [Joint]) -> Result<()> {
    let index_of: HashMap<&str, usize> = joints.iter().enumerate().map(|(k, joint)| (joint.name.as_str(), k)).collect();
    let mut direct: HashMap<usize, Mimic> = HashMap::new();
    for mimic in mimics {
        let element = format!("joint \"{}\"", joints[mimic.joint].name);
        let Some(&followed) = index_of.get(mimic.followed.as_str()) else {
            let problem = format!("got mimic joint=\"{}\", expected a joint of this robot", quoted(&mimic.followed));
            return Err(Error::input(file, element, problem));
        };
        for (role, joint) in [("mimic on", mimic.joint), ("mimic of", followed)] {
            let kind = joints[joint].kind;
            if matches!(kind, JointKind::Planar | JointKind::Spherical | JointKind::Floating) {
                let name = &joints[joint].name;
                let problem =
                    format!("got {role} the {kind:?} joint \"{name}\", expected one with a single coordinate");
                return Err(Error::input(file, element, problem));
            }
        }
        direct.insert(mimic.joint, Mimic { joint: followed, multiplier: mimic.multiplier, offset: mimic.offset });
    }
    let mut resolved: HashMap<usize, Mimic> = HashMap::with_capacity(mimics.len());
    for mimic in mimics {
        // Go down to a joint that is independent or resolved, then compose on the way back up.
        let mut chain = vec![mimic.joint];
        while let Some(next) = chain.last().and_then(|joint| direct.get(joint)).map(|next| next.joint) {
            if !direct.contains_key(&next) || resolved.contains_key(&next) {
                break;
            }
            if chain.len() > direct.len() {
                let problem = format!(
                    "got mimic joint=\"{}\" in a cycle, expected an independent joint",
                    quoted(&mimic.followed)
                );
                return Err(Error::input(file, format!("joint \"{}\"", joints[mimic.joint].name), problem));
            }
            chain.push(next);
        }
        for joint in chain.into_iter().rev() {
            let own = direct[&joint];
            let total = resolved.get(&own.joint).map_or(own, |next| Mimic {
                joint: next.joint,
                multiplier: own.multiplier * next.multiplier,
                offset: own.multiplier * next.offset + own.offset,
            });
            resolved.insert(joint, total);
        }
    }
    for mimic in mimics {
        check_range(file, joints, mimic.joint, &resolved[&mimic.joint])?;
    }
    for (joint, mimic) in resolved {
        joints[joint].mimic = Some(mimic);
    }
    Ok(())
}
