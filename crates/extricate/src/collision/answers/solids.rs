//! The bodies of a checker: which are the same solid, where their shapes reach, and which convex
//! pieces are missing. [`Checker`] documents the public functions at its methods of the same names.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use crate::collision::checker::Checker;
use crate::collision::prepared::{PreparedBody, PreparedPart, PreparedShape};
use crate::collision::shapes::ShapeKind;
use crate::math::{Pose, Vec3};
use crate::scene::correspondence::by_name;

pub fn same_solids(checker: &Checker, other: &Checker) -> Vec<Option<usize>> {
    let parts = |checker: &'_ Checker, body: usize| checker.bodies.bodies[body].parts.clone();
    let is_same = |(body, twin): (usize, Option<usize>)| {
        let (own, others) = (&checker.bodies.parts[parts(checker, body)], &other.bodies.parts[parts(other, twin?)]);
        let are_same = own.len() == others.len()
            && own.iter().zip(others).all(|(a, b)| {
                let stays = own.len() == 1 || a.pose_frame_part == b.pose_frame_part;
                Arc::ptr_eq(&a.prepared, &b.prepared) && stays
            });
        twin.filter(|_| are_same)
    };
    by_name(&other.scene, &checker.scene).into_iter().enumerate().map(is_same).collect()
}

pub fn first_of_equal_solids(checker: &Checker) -> Vec<usize> {
    let mut first = std::collections::HashMap::new();
    let of_body = |(at, body): (usize, &PreparedBody)| match &checker.bodies.parts[body.parts.clone()] {
        [part] => *first.entry(Arc::as_ptr(&part.prepared)).or_insert(at),
        _ => at,
    };
    checker.bodies.bodies.iter().enumerate().map(of_body).collect()
}

pub fn pose_frame_solid(checker: &Checker, body: usize) -> Pose {
    match &checker.bodies.parts[checker.bodies.bodies[body].parts.clone()] {
        [part] => part.pose_frame_part,
        _ => Pose::identity(),
    }
}

pub fn corners_of(checker: &Checker, body: usize, poses: &[Pose], each: &mut dyn FnMut(Vec3)) {
    let body = &checker.bodies.bodies[body];
    for part in &checker.bodies.parts[body.parts.clone()] {
        let pose = poses[body.frame].then(&part.pose_frame_part);
        part.shape().bounds.corners().iter().for_each(|corner| each(pose.point(corner)));
    }
}

pub fn is_convex(checker: &Checker, body: usize) -> bool {
    let parts = &checker.bodies.parts[checker.bodies.bodies[body].parts.clone()];
    parts.iter().all(|part| !matches!(part.shape().kind, ShapeKind::Mesh(_)))
}

pub fn lacks_pieces(checker: &Checker) -> bool {
    !checker.has_pieces() && (!without_cells(checker).is_empty() || !without_fine_pieces(checker).is_empty())
}

pub fn prepare_proposals(checker: &Checker) {
    if checker.has_pieces() {
        return;
    }
    // Work enters the pool only if there is any: a forked process has lost the threads of its pool.
    let coarse = without_cells(checker);
    if !coarse.is_empty() {
        coarse.par_iter().for_each(|shape| shape.make_cells());
    }
    let fine = without_fine_pieces(checker);
    if !fine.is_empty() {
        fine.par_iter().for_each(|(index, shape)| shape.make_fine(*index));
    }
    // Two threads that come at once both do the work, without a lock: a thread that waits for its
    // parts in a pool may be given this very work.
    checker.is_prepared.store(true, Ordering::Release);
}

pub fn parts_of(checker: &Checker, body: usize) -> &[PreparedPart] {
    &checker.bodies.parts[checker.bodies.bodies[body].parts.clone()]
}

/// Returns the shapes of checked bodies whose coarse pieces are not made yet, each once.
fn without_cells(checker: &Checker) -> Vec<&PreparedShape> {
    let mut wanted = vec![false; checker.bodies.bodies.len()];
    for pair in &*checker.pairs {
        (wanted[pair.first], wanted[pair.second]) = (true, true);
    }
    let bodies = (0..wanted.len()).filter(|body| wanted[*body]);
    let shapes = bodies.flat_map(|body| parts_of(checker, body)).map(|part| &*part.prepared);
    let mut coarse: Vec<&PreparedShape> = shapes.filter(|shape| !shape.has_cells()).collect();
    // Equal bodies share one shape.
    coarse.sort_by_key(|shape| std::ptr::from_ref(*shape));
    coarse.dedup_by(|a, b| std::ptr::eq(*a, *b));
    coarse
}

/// Returns the finer pieces that pairs of shapes need beside each other and that are not made yet,
/// each once. The coarse pieces have to be made before.
fn without_fine_pieces(checker: &Checker) -> Vec<(usize, &PreparedShape)> {
    let mut fine: HashMap<(*const PreparedShape, usize), &PreparedShape> = HashMap::new();
    for pair in &*checker.pairs {
        for a in parts_of(checker, pair.first) {
            for b in parts_of(checker, pair.second) {
                for (one, other) in [(&a.prepared, &b.prepared), (&b.prepared, &a.prepared)] {
                    if let Some(index) = one.missing_beside(other) {
                        fine.insert((Arc::as_ptr(one), index), one);
                    }
                }
            }
        }
    }
    fine.into_iter().map(|((_, index), shape)| (index, shape)).collect()
}
