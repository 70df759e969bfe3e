//! What queries in changed scenes cost and find: as much as before where nothing changed, and what
//! is new there.

use extricate::internals::scene::BodyPair;
use extricate::{Answer, ChangedScene, CheckScratch, Config, Label, Model, QueryOptions, QueryScratch, Scene, builtin};

use crate::memory::learn;
use crate::query::colliding;

/// Index of the last obstacle.
fn obstacle(scene: &Scene) -> usize {
    scene.bodies.iter().rposition(|body| body.robot.is_none()).expect("an obstacle")
}

/// The scene with another one like its last obstacle, that much away from it.
fn with_another(mut scene: Scene, by: [f64; 3]) -> Scene {
    let (old, new) = (obstacle(&scene), scene.bodies.len());
    let mut body = scene.bodies[old].clone();
    body.name = "another".into();
    body.parts.iter_mut().for_each(|part| part.pose_frame_part.translation += extricate::geometry::Vec3::from(by));
    scene.bodies.push(body);
    let beside = scene.pairs.iter().filter(|pair| pair.first == old || pair.second == old);
    let others: Vec<usize> = beside.map(|pair| if pair.first == old { pair.second } else { pair.first }).collect();
    scene.pairs.extend(others.into_iter().map(|first| BodyPair { first, second: new }));
    scene.pairs.sort();
    scene
}

/// The scene without its last obstacle.
fn without_one(mut scene: Scene) -> Scene {
    let gone = obstacle(&scene);
    scene.pairs.retain(|pair| pair.first != gone && pair.second != gone);
    scene
}

/// Answers in a changed scene, each verified there.
fn answers(model: &Model, scene: &Scene, queries: &[Config]) -> Vec<Answer> {
    let changed = ChangedScene::new(model.world(), scene.clone()).unwrap();
    let (mut scratch, mut check) = (QueryScratch::default(), CheckScratch::default());
    let mut ask = |q| {
        let answer =
            model.in_scene(&changed).query_with(q, &QueryOptions::default(), &mut scratch).expect("something is free");
        assert!(answer.verified && answer.lower_bound <= answer.depth);
        assert_eq!(changed.checker().label(&answer.witness, &mut check), Label::Free);
        answer
    };
    queries.iter().map(&mut ask).collect()
}

fn unchanged(model: &Model, queries: &[Config]) -> Vec<Answer> {
    let mut scratch = QueryScratch::default();
    queries.iter().map(|q| model.view().query_with(q, &QueryOptions::default(), &mut scratch).unwrap()).collect()
}

fn checks(answers: &[Answer]) -> usize {
    answers.iter().map(|answer| answer.checks).sum()
}

/// How many are as near as those they are compared with, but for a hundredth.
fn as_near(answers: &[Answer], others: &[Answer]) -> usize {
    answers.iter().zip(others).filter(|(answer, other)| answer.depth <= 1.01 * other.depth).count()
}

#[test]
fn a_change_far_away_costs_hardly_anything() {
    for (name, labels) in [("shelf-arm", 150_000), ("planar-arm", 60_000)] {
        let model = learn(builtin::scene(name).unwrap(), labels, 7);
        let queries = colliding(&model, 150);
        let before = unchanged(&model, &queries);
        let after = answers(&model, &with_another(builtin::scene(name).unwrap(), [50.0, 0.0, 0.0]), &queries);
        let (cost, was, found) = (checks(&after), checks(&before), as_near(&after, &before));
        println!("{name}: {cost} checks, {was} before, {found} of 150 as near");
        assert!(2 * cost < 3 * was, "{name}: {cost} checks, {was} before");
        assert!(found >= 145, "{name}: {found} of 150");
    }
}

#[test]
fn where_an_obstacle_went_the_nearer_way_out_is_found() {
    let model = learn(builtin::scene("shelf-arm").unwrap(), 150_000, 7);
    let scene = without_one(builtin::scene("shelf-arm").unwrap());
    let anew = learn(scene.clone(), 150_000, 8);
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
    assert!(nearer >= 3 && found >= 144, "{nearer} nearer than before, {found} of 150 as near as learned anew");
    assert!(checks(&after) < 2 * checks(&fresh), "{} checks, {} anew", checks(&after), checks(&fresh));
}

#[test]
fn samples_that_an_added_obstacle_took_are_not_trusted() {
    let model = learn(builtin::scene("shelf-arm").unwrap(), 150_000, 7);
    let scene = with_another(builtin::scene("shelf-arm").unwrap(), [0.0, 1.0, 0.0]);
    let anew = learn(scene.clone(), 150_000, 8);
    let changed = ChangedScene::new(model.world(), scene.clone()).unwrap();
    let queries = colliding(&anew, 150);
    let [before, fresh] = [&model, &anew].map(|model| unchanged(model, &queries));
    let mut check = CheckScratch::default();
    let taken = before.iter().filter(|a| changed.checker().label(&a.witness, &mut check) == Label::Colliding).count();
    let found = as_near(&answers(&model, &scene, &queries), &fresh);
    println!("{taken} of 150 taken, {found} as near as anew");
    assert!(taken >= 5 && found >= 141, "{taken} of 150 taken, {found} as near as learned anew");
}

/// Where next to all samples are too near to something, they are not all checked.
#[test]
fn a_larger_clearance_costs_a_descent() {
    for (name, labels) in [("shelf-arm", 150_000), ("planar-arm", 6_000)] {
        let model = learn(builtin::scene(name).unwrap(), labels, 7);
        let mut scene = builtin::scene(name).unwrap();
        scene.clearance = 5e-3;
        let queries = colliding(&model, 100);
        let (before, after) = (unchanged(&model, &queries), answers(&model, &scene, &queries));
        let (cost, was) = (checks(&after), checks(&before));
        println!("{name}: {cost} checks, {was} before");
        assert!(cost < 2 * was, "{name}: {cost} checks, {was} before");
    }
}
