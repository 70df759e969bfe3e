//! Costs and answers of queries in changed scenes: about as before if nothing changed nearby, and
//! new exits elsewhere.

use extricate::geometry::Body;
use extricate::internals::math::Vec3;
use extricate::{Answer, CheckScratch, Config, Label, Scene, Solver, builtin};

use crate::baselines::{
    FAR_CHANGE_AS_NEAR_ANSWERS, FAR_CHANGE_CHECKS_RATIO, LARGER_CLEARANCE_CHECKS_RATIO, OBSTACLE_ADDED_AS_NEAR_ANSWERS,
    OBSTACLE_ADDED_TAKEN_EXITS, OBSTACLE_GONE_AS_NEAR_ANSWERS, OBSTACLE_GONE_CHECKS_RATIO,
    OBSTACLE_GONE_NEARER_ANSWERS,
};
use crate::memory::learned;
use crate::query::colliding;

/// Returns the last obstacle of a scene.
pub fn obstacle(scene: &Scene) -> &Body {
    scene.bodies().iter().rfind(|body| body.is_obstacle()).expect("an obstacle")
}

/// Returns the scene with a copy of its last obstacle, that much away from it.
pub fn with_another(scene: Scene, by: [f64; 3]) -> Scene {
    let mut body = obstacle(&scene).clone();
    body.name = "another".into();
    body.parts.iter_mut().for_each(|part| part.pose_frame_part.translation += Vec3::from(by));
    scene.with_obstacles([body]).unwrap()
}

fn without_one(scene: Scene) -> Scene {
    scene.without([obstacle(&scene).name.as_str()]).unwrap()
}

/// Returns answers in a changed scene, each verified there.
fn answers(model: &Solver, scene: &Scene, queries: &[Config]) -> Vec<Answer> {
    let changed = model.with_scene(scene.clone()).unwrap();
    let mut check = CheckScratch::default();
    let mut ask = |q| {
        let answer = changed.query(q).expect("something is free");
        assert!(answer.verified && answer.lower_bound <= answer.depth);
        assert_eq!(changed.checker().label(&answer.witness, &mut check), Label::Free);
        answer
    };
    queries.iter().map(&mut ask).collect()
}

fn unchanged(model: &Solver, queries: &[Config]) -> Vec<Answer> {
    queries.iter().map(|q| model.query(q).unwrap()).collect()
}

fn checks(answers: &[Answer]) -> usize {
    answers.iter().map(|answer| answer.checks).sum()
}

/// Counts the answers that are at most 1 % farther than the others.
fn as_near(answers: &[Answer], others: &[Answer]) -> usize {
    answers.iter().zip(others).filter(|(answer, other)| answer.depth <= 1.01 * other.depth).count()
}

#[test]
fn a_change_far_away_costs_hardly_anything() {
    for (name, labels) in [("shelf-arm", 150_000), ("planar-arm", 60_000)] {
        let model = learned(builtin::scene(name).unwrap(), labels, 7);
        let queries = colliding(&model, 150);
        let before = unchanged(&model, &queries);
        let after = answers(&model, &with_another(builtin::scene(name).unwrap(), [50.0, 0.0, 0.0]), &queries);
        let (cost, was, found) = (checks(&after), checks(&before), as_near(&after, &before));
        println!("{name}: {cost} checks, {was} before, {found} of 150 as near");
        assert!((cost as f64) < FAR_CHANGE_CHECKS_RATIO * was as f64, "{name}: {cost} checks, {was} before");
        assert!(found >= FAR_CHANGE_AS_NEAR_ANSWERS, "{name}: {found} of 150");
    }
}

#[test]
fn where_an_obstacle_went_the_nearer_way_out_is_found() {
    let model = learned(builtin::scene("shelf-arm").unwrap(), 150_000, 7);
    let scene = without_one(builtin::scene("shelf-arm").unwrap());
    let anew = learned(scene.clone(), 150_000, 8);
    let queries = colliding(&anew, 150);
    let [before, fresh] = [&model, &anew].map(|model| unchanged(model, &queries));
    let after = answers(&model, &scene, &queries);
    let nearer = after.iter().zip(&before).filter(|(after, before)| after.depth < 0.99 * before.depth).count();
    let found = as_near(&after, &fresh);
    println!(
        "{nearer} nearer than before, {found} of 150 as near as anew, {} checks, {}",
        checks(&after),
        checks(&fresh)
    );
    let are_found = nearer >= OBSTACLE_GONE_NEARER_ANSWERS && found >= OBSTACLE_GONE_AS_NEAR_ANSWERS;
    assert!(are_found, "{nearer} nearer than before, {found} of 150 as near as learned anew");
    let (cost, anew) = (checks(&after), checks(&fresh));
    assert!((cost as f64) < OBSTACLE_GONE_CHECKS_RATIO * anew as f64, "{cost} checks, {anew} anew");
}

#[test]
fn samples_that_an_added_obstacle_took_are_not_trusted() {
    let model = learned(builtin::scene("shelf-arm").unwrap(), 150_000, 7);
    let scene = with_another(builtin::scene("shelf-arm").unwrap(), [0.0, 1.0, 0.0]);
    let anew = learned(scene.clone(), 150_000, 8);
    let changed = model.with_scene(scene.clone()).unwrap();
    let queries = colliding(&anew, 150);
    let [before, fresh] = [&model, &anew].map(|model| unchanged(model, &queries));
    let mut check = CheckScratch::default();
    let taken = before.iter().filter(|a| changed.checker().label(&a.witness, &mut check) == Label::Colliding).count();
    let found = as_near(&answers(&model, &scene, &queries), &fresh);
    println!("{taken} of 150 taken, {found} as near as anew");
    let are_found = taken >= OBSTACLE_ADDED_TAKEN_EXITS && found >= OBSTACLE_ADDED_AS_NEAR_ANSWERS;
    assert!(are_found, "{taken} of 150 taken, {found} as near as learned anew");
}

/// If nearly all samples are too near to something, not all of them are checked.
#[test]
fn a_larger_clearance_costs_a_descent() {
    for (name, labels) in [("shelf-arm", 150_000), ("planar-arm", 6_000)] {
        let model = learned(builtin::scene(name).unwrap(), labels, 7);
        let scene = builtin::scene(name).unwrap().with_clearance(5e-3).unwrap();
        let queries = colliding(&model, 100);
        let (before, after) = (unchanged(&model, &queries), answers(&model, &scene, &queries));
        let (cost, was) = (checks(&after), checks(&before));
        println!("{name}: {cost} checks, {was} before");
        assert!((cost as f64) < LARGER_CLEARANCE_CHECKS_RATIO * was as f64, "{name}: {cost} checks, {was} before");
    }
}
