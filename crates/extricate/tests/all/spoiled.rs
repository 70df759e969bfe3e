//! Spoils one claim of an answer at a time: the judge of the soak test notices each.

use extricate::{Answer, Config, PairId, QueryOptions, builtin};

use crate::baselines::SPOILED_NOTICED_ANSWERS;
use crate::judge::Judge;
use crate::memory::learned;
use crate::query::colliding;

type Spoil = (&'static str, fn(&mut Answer, &Config));

const SPOILS: [Spoil; 21] = [
    ("the witness is not at the depth", |a, _| a.depth *= 1.01),
    ("the lower bound is above the depth", |a, _| a.lower_bound = 1.001 * a.depth),
    ("the witness collides", |a, q| a.witness = q.clone()),
    ("the witness is out of limits", |a, _| a.witness = far_from(&a.witness)),
    ("free or not, two parts disagree", |a, _| a.colliding.clear()),
    ("a pair that collides is left out", |a, _| a.colliding.clear()),
    ("a pair is called colliding that keeps the clearance", |a, _| a.colliding = (0..50).map(PairId::new).collect()),
    ("verified or not, against what the effort promises", |a, _| a.verified = false),
    ("a pair touches that is not told", |a, _| a.touching.clear()),
    ("contacts and touching pairs disagree", |a, _| a.contacts.clear()),
    ("the nearest contact is not at the distance of its pair", |a, _| a.contacts[0].distance += 1e-3),
    ("points of a contact are not at its distance", |a, _| a.contacts[0].point_first.x += 1e-3),
    ("a normal that is not of unit length", |a, _| a.contacts[0].normal *= 1.1),
    ("the gradient is not the slope of the distance", |a, _| a.gradient.iter_mut().for_each(|x| *x = -*x)),
    ("the gradient is not of unit length", |a, _| a.gradient.iter_mut().for_each(|x| *x *= 1.001)),
    ("a point moves farther than is told", |a, _| a.max_displacement *= 0.9),
    ("no point moves as far as is told", |a, _| a.max_displacement *= 1.5),
    ("the first exit is not the witness", |a, _| a.exits[0].depth += 1e-6),
    ("two exits are one", |a, _| a.exits.push(a.exits[a.exits.len() - 1].clone())),
    ("the parts of the segment are out of order", |a, _| a.segment.as_mut().unwrap().colliding_until = 1.1),
    ("the segment collides where it is proved free", |a, _| {
        let segment = a.segment.as_mut().unwrap();
        (segment.colliding_until, segment.free_from) = (0.0, 0.0);
    }),
];

/// Returns a configuration far beyond the limits of the second joint; the first has none.
fn far_from(witness: &Config) -> Config {
    let mut far = witness.to_vec();
    far[1] += 100.0;
    builtin::scene("planar-arm").unwrap().space().config_anywhere(&far).unwrap()
}

#[test]
fn every_claim_that_is_spoiled_is_noticed() {
    let options = QueryOptions::default().exits(3).segment(true);
    let model = learned(builtin::scene("planar-arm").unwrap(), 6_000, 7).options(options.clone()).unwrap();
    let judge = Judge::new(model.scene(), false);
    let mut hearing = judge.hearing();
    let mut noticed = [0; SPOILS.len()];
    for q in colliding(&model, 20) {
        let answer = model.query(&q).unwrap();
        assert_eq!(hearing.faults(&q, &options, &answer, false), [""; 0]);
        for ((fault, spoil), noticed) in SPOILS.iter().zip(&mut noticed) {
            let mut spoiled = answer.clone();
            spoil(&mut spoiled, &q);
            *noticed +=
                usize::from(hearing.faults(&q, &options, &spoiled, false).iter().any(|found| found.contains(fault)));
        }
    }
    for ((fault, _), noticed) in SPOILS.iter().zip(noticed) {
        println!("{fault}: {noticed} of 20");
        assert!(noticed >= SPOILED_NOTICED_ANSWERS, "{fault}: noticed in {noticed} of 20");
    }
}
