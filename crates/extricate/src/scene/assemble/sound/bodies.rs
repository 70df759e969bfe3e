//! Checks bodies, their shapes, pairs and clearances.

use std::collections::HashSet;

use super::values::{index, length, pose};
use crate::scene::assemble::bodies::{LARGEST, radius};
use crate::scene::{Body, Scene};

/// Largest number of pairs of a moving body and any body; the broad phase keeps a number for each.
const MAX_BODY_PAIRS: usize = 1 << 27;
/// Largest number of pairs of parts of checked bodies; a check keeps memory for each.
const MAX_PART_PAIRS: usize = 1 << 25;

pub fn check(scene: &Scene) -> Result<(), String> {
    let Scene { clearance, frames, bodies, pairs, clearances, .. } = scene;
    length("clearance", *clearance)?;
    if let Some(own) = clearances.own {
        length("clearances: own", own)?;
    }
    for ([first, second], of_pair) in &clearances.pairs {
        length(&format!("clearances: of `{first}` and `{second}`"), *of_pair)?;
    }
    for (name, added) in &clearances.padding {
        length(&format!("clearances: padding of `{name}`"), *added)?;
    }
    let mut names = HashSet::new();
    for (number, body) in bodies.iter().enumerate() {
        let what = format!("body {number} (`{}`)", body.name);
        index(&format!("{what}: frame"), body.frame, frames.len())?;
        if !names.insert(&body.name) {
            return Err(format!("{what}: got a name that another body has"));
        }
        check_parts(body).map_err(|problem| format!("{what}: {problem}"))?;
    }
    let mut last = None;
    for (number, pair) in pairs.iter().enumerate() {
        let (first, second) = (pair.first, pair.second);
        let parts = first < second && second < bodies.len() && bodies[first].frame != bodies[second].frame;
        if !parts || last.is_some_and(|last| last >= pair) {
            let found = format!("got {first} and {second}");
            let expected = format!("ascending pairs of the {} bodies, on two frames", bodies.len());
            return Err(format!("pair {number}: {found}, expected {expected}"));
        }
        last = Some(pair);
    }
    let moving = bodies.iter().filter(|body| body.frame != 0).count();
    let parts = |body: usize| bodies[body].parts.len();
    let of_parts = pairs.iter().map(|pair| parts(pair.first).saturating_mul(parts(pair.second)));
    most("bodies: pairs with one that moves", moving.saturating_mul(bodies.len()), MAX_BODY_PAIRS)?;
    most("pairs: pairs of parts", of_parts.fold(0, usize::saturating_add), MAX_PART_PAIRS)
}

fn most(what: &str, found: usize, most: usize) -> Result<(), String> {
    if found <= most { Ok(()) } else { Err(format!("{what}: got {found}, expected at most {most}")) }
}

fn check_parts(body: &Body) -> Result<(), String> {
    for (number, part) in body.parts.iter().enumerate() {
        pose(&format!("part {number}: pose"), &part.pose_frame_part)?;
        part.geometry.check().map_err(|problem| format!("part {number}: {problem}"))?;
        if !part.geometry.is_scenery() && radius(&part.geometry) > LARGEST {
            return Err(format!(
                "part {number}: got a radius of {:e}, expected at most {LARGEST:e} [m]",
                radius(&part.geometry)
            ));
        }
        if body.frame != 0 && part.geometry.is_scenery() {
            return Err(format!("part {number}: got scenery, which does not move, on frame {}", body.frame));
        }
    }
    Ok(())
}
