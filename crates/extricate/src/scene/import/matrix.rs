//! Converts a `moveit_msgs/AllowedCollisionMatrix` to disabled pairs.

use std::collections::{BTreeSet, HashSet};

use super::objects::Objects;
use super::value::At;
use crate::error::{Result, quoted};
use crate::robot::LoadLimit;
use crate::scene::Scene;

/// Name of the octomap in MoveIt.
pub const OCTOMAP: &str = "<octomap>";

/// Adds the allowed pairs to the disabled ones. An entry for a pair overrides defaults.
pub fn allowed(matrix: &At, robots: Option<&Scene>, objects: &mut Objects) -> Result<()> {
    let (names, rows) = (matrix.list("entry_names")?, matrix.list("entry_values")?);
    if rows.len() != names.len() {
        let problem = format!("got {} names and {} rows, expected as many", names.len(), rows.len());
        return Err(crate::error::Error::input(matrix.file, format!("{}.entry_values", matrix.path), problem));
    }
    let names = names.iter().map(At::string).collect::<Result<Vec<&str>>>()?;
    let mut table = Vec::with_capacity(rows.len());
    for row in &rows {
        let enabled = if row.value.is_object() { row.list("enabled")? } else { row.elements()? };
        if enabled.len() != names.len() {
            return Err(row.fault(&format!("{} values, one for each name", names.len())));
        }
        table.push(enabled.iter().map(At::truth).collect::<Result<Vec<bool>>>()?);
    }
    let (mut pairs, mut explicit) = (BTreeSet::new(), HashSet::new());
    for first in 0..names.len() {
        for second in first + 1..names.len() {
            explicit.insert(ordered(names[first], names[second]));
            if table[first][second] {
                pairs.insert(ordered(names[first], names[second]));
            }
            if table[first][second] != table[second][first] {
                let (a, b) = (names[first], names[second]);
                objects.note(format!("{}: {a} and {b} have two values: that of the first is taken", matrix.path));
            }
        }
    }
    let others = objects.all();
    let links = robots.map_or(Vec::new(), |robots| robots.links.iter().map(|link| link.name.clone()).collect());
    let known: BTreeSet<&str> = names
        .iter()
        .copied()
        .chain(others.iter().map(String::as_str))
        .chain(links.iter().map(String::as_str))
        .collect();
    defaults(matrix, &known, &explicit, &mut pairs, robots.is_some(), objects)?;
    objects.entries().limits.check(LoadLimit::Pairs, pairs.len(), matrix.file, &matrix.path)?;
    write(matrix, &pairs, robots, objects)
}

/// Adds the pairs of names that may touch everything by default. Entries for a pair, and a default
/// that forbids contact of the other name, override it.
fn defaults<'a>(
    matrix: &At<'a>,
    known: &BTreeSet<&'a str>,
    explicit: &HashSet<[&str; 2]>,
    pairs: &mut BTreeSet<[&'a str; 2]>,
    has_links: bool,
    objects: &mut Objects,
) -> Result<()> {
    let (names, values) = (matrix.list("default_entry_names")?, matrix.list("default_entry_values")?);
    if names.len() != values.len() {
        let problem = format!("got {} names and {} values, expected as many", names.len(), values.len());
        let path = format!("{}.default_entry_values", matrix.path);
        return Err(crate::error::Error::input(matrix.file, path, problem));
    }
    let names = names.iter().map(At::string).collect::<Result<Vec<&str>>>()?;
    let values = values.iter().map(At::truth).collect::<Result<Vec<bool>>>()?;
    let refused: HashSet<&str> =
        names.iter().zip(&values).filter(|(_, allowed)| !**allowed).map(|(name, _)| *name).collect();
    let most = objects.entries().limits.get(LoadLimit::Pairs);
    let mut seen = HashSet::new();
    for (name, _) in names.iter().zip(&values).filter(|(_, allowed)| **allowed) {
        if !has_links && (*name != OCTOMAP || objects.is_obstacle(name)) {
            objects.note(format!(
                "{}: `{name}` may touch everything: of the robot, what the matrix names is written; with --robot all \
                 of its links are",
                matrix.path
            ));
        }
        if pairs.len() > most || !seen.insert(*name) {
            continue;
        }
        for other in known.iter().filter(|other| *other != name && !refused.contains(*other)) {
            let pair = ordered(name, other);
            if !explicit.contains(&pair) {
                pairs.insert(pair);
            }
        }
    }
    Ok(())
}

fn write(matrix: &At, pairs: &BTreeSet<[&str; 2]>, robots: Option<&Scene>, objects: &mut Objects) -> Result<()> {
    let links: Option<HashSet<&str>> =
        robots.map(|robots| robots.links.iter().map(|link| link.name.as_str()).collect());
    let mut unknown = BTreeSet::new();
    for [a, b] in pairs {
        // Obstacles are never checked against each other. Every matrix of MoveIt names the octomap.
        let is_absent = |name: &str| name == OCTOMAP && !objects.is_obstacle(name);
        if (objects.is_obstacle(a) && objects.is_obstacle(b)) || is_absent(a) || is_absent(b) {
            continue;
        }
        let names = |name: &str| match objects.names_of(name) {
            Some(names) => names.to_vec(),
            None => vec![name.to_string()],
        };
        let (first, second) = (names(a), names(b));
        let is_known =
            |name: &str| objects.names_of(name).is_some() || links.as_ref().is_none_or(|links| links.contains(name));
        if let Some(name) = [a, b].into_iter().find(|name| !is_known(name)) {
            unknown.insert(name.to_string());
            continue;
        }
        let entries = objects.entries();
        let count = entries.pairs.disable.len().saturating_add(first.len().saturating_mul(second.len()));
        entries.limits.check(LoadLimit::Pairs, count, matrix.file, &matrix.path)?;
        let all = first.iter().flat_map(|a| second.iter().map(move |b| [a.clone(), b.clone()]));
        entries.pairs.disable.extend(all);
    }
    for name in unknown {
        objects.note(format!("{}: neither the robot nor the world has `{}`", matrix.path, quoted(&name)));
    }
    Ok(())
}

fn ordered<'a>(a: &'a str, b: &'a str) -> [&'a str; 2] {
    if a < b { [a, b] } else { [b, a] }
}
