//! Many queries of every kind. Each answer is judged by itself and against other answers to the
//! same configuration. The long version is `cargo run --release --example soak`.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use extricate::geometry::{Body, Geometry, Pose};
use extricate::internals::cspace::sampling::Halton;
use extricate::internals::math::Vec3;
use extricate::{Answer, CheckScratch, Config, Effort, Label, QueryOptions, Scene, Solver, StreamOptions, Termination};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::judge::{Hearing, Judge};

/// Kinds of queries, the number of configurations of each per thousand, and their least number,
/// which is enough for streams of every sort.
pub const KINDS: [(&str, usize, usize); 7] = [
    ("refined", 500, 1),
    ("nearest", 150, 1),
    ("exits", 100, 1),
    ("streams", 100, 5 * MIN_WALKS),
    ("budgets", 75, 1),
    ("changed", 70, CHANGED_SCENES[0]),
    ("exhaustive", 5, 4),
];

/// Counts of one kind of queries, and the time that queries and judging took \[s\].
#[derive(Debug, Default, Clone, Copy)]
pub struct Count {
    pub configs: usize,
    pub answers: usize,
    pub colliding: usize,
    pub faults: usize,
    pub seconds: f64,
}

/// Faults of a run over one scene, in words, and counts by kind of query.
#[derive(Debug, Default)]
pub struct Findings {
    pub counts: BTreeMap<&'static str, Count>,
    pub faults: Vec<String>,
}

/// Configurations that are queried and judged at once.
const BLOCK_CONFIGS: usize = 1000;
/// Largest number of frames of one stream, and least number of streams.
const MAX_STREAM_FRAMES: usize = 50;
const MIN_WALKS: usize = 12;
/// Least and largest number of scenes made from the learned one, and configurations per scene: raw
/// meshes take long to prepare.
const CHANGED_SCENES: [usize; 3] = [2, 8, 1000];

/// Options to query with, one after the other. If `in_order`, no answer may be farther away than
/// the one before.
struct Questions {
    asked: Vec<QueryOptions>,
    in_order: bool,
}

/// Queries `model` about `count` configurations, in all kinds, and judges every answer. `tell`
/// receives the progress.
pub fn soak(model: &Solver, count: usize, tell: &mut dyn FnMut(&Findings)) -> Findings {
    let mut findings = Findings::default();
    let [fewest, most, each] = CHANGED_SCENES;
    let changes = (count / each).clamp(fewest, most);
    let changed: Vec<Solver> = (0..changes as u64).map(|seed| change(model, seed)).collect();
    let judge = Judge::new(model.scene(), false);
    let elsewhere: Vec<Judge> = changed.iter().map(|scene| Judge::new(scene.scene(), true)).collect();
    // Every kind has configurations of its own.
    let mut first = 0;
    for (kind, share, least) in KINDS {
        let of_kind = (count * share).div_ceil(1000).max(least);
        let (mut done, mut blocks) = (0, 0);
        while done < of_kind {
            let each = if kind == "changed" { of_kind.div_ceil(changed.len()) } else { of_kind };
            let configs = configs(model, first, BLOCK_CONFIGS.min(each).min(of_kind - done));
            (first, done) = (first + configs.len() as u64, done + configs.len());
            let started = std::time::Instant::now();
            let (answers, colliding, faults) = match kind {
                "streams" => streams(model, &changed, (&judge, &elsewhere), &configs),
                "changed" => {
                    let at = blocks % changed.len();
                    block(&changed[at], &elsewhere[at], &questions(kind), &configs)
                }
                _ => block(model, &judge, &questions(kind), &configs),
            };
            blocks += 1;
            let count = findings.counts.entry(kind).or_default();
            count.configs += configs.len();
            count.answers += answers;
            count.colliding += colliding;
            count.faults += faults.len();
            count.seconds += started.elapsed().as_secs_f64();
            findings.faults.extend(faults.into_iter().map(|fault| format!("{kind}: {fault}")));
            tell(&findings);
        }
    }
    findings
}

fn questions(kind: &str) -> Questions {
    let plain = QueryOptions::default();
    let nearest = plain.clone().effort(Effort::Nearest);
    let segment = plain.clone().segment(true);
    let exits = segment.clone().exits(3);
    let termination = |checks: usize| Termination::after_checks(checks);
    let (asked, in_order) = match kind {
        "refined" => (vec![plain], false),
        "nearest" => (vec![nearest.clone(), nearest.contacts(true)], true),
        "exits" => (vec![exits.clone(), exits.exits(6).termination(termination(40))], false),
        "budgets" => {
            let few = [0, 3, 30].map(|checks| plain.clone().termination(termination(checks)));
            (few.into_iter().chain([segment]).collect(), true)
        }
        "changed" => (vec![nearest, segment, exits.starts(2)], false),
        "exhaustive" => (vec![nearest, plain, segment.effort(Effort::Exhaustive)], true),
        other => unreachable!("{other} is no kind of questions"),
    };
    Questions { asked, in_order }
}

/// Returns low-discrepancy configurations from index `first` on.
fn configs(model: &Solver, first: u64, count: usize) -> Vec<Config> {
    let space = model.scene().space();
    let (halton, mut q) = (Halton::new(space.nv(), 17), vec![0.0; space.nq()]);
    let config = |index: u64| {
        halton.config(space, index, &mut q);
        space.config(&q).expect("a sample is a configuration")
    };
    (first..first + count as u64).map(config).collect()
}

/// Number of answers, number of colliding configurations, and faults.
type Judged = (usize, usize, Vec<String>);

/// Answers all questions about all configurations, one batch each, and judges the answers.
fn block(solver: &Solver, judge: &Judge, questions: &Questions, configs: &[Config]) -> Judged {
    let mut faults = Vec::new();
    let answers: Vec<Vec<Option<Answer>>> = questions
        .asked
        .iter()
        .map(|options| {
            let mut answers = Vec::with_capacity(configs.len());
            let solver = solver.clone().options(options.clone()).unwrap();
            let given = solver.batch_each(configs.iter().cloned(), 0, &mut |answered| {
                answers.push(answered.answer);
                ControlFlow::Continue(())
            });
            if given != configs.len() || answers.len() != configs.len() {
                faults.push(format!("{given} answers to {} queries", configs.len()));
            }
            answers
        })
        .collect();
    let judged = configs.par_iter().enumerate().map_init(
        || judge.hearing(),
        |hearing, (row, q)| {
            let mut found = Vec::new();
            let mut known: Vec<&Answer> = Vec::new();
            for (options, answers) in questions.asked.iter().zip(&answers) {
                let Some(Some(answer)) = answers.get(row) else {
                    found.extend(unanswered(solver, hearing).map(|fault| format!("{fault}: query {:?}", &q[..])));
                    continue;
                };
                let wrong = hearing.faults(q, options, answer, false);
                found.extend(wrong.into_iter().map(|fault| told(&fault, q, options, answer)));
                if questions.in_order && known.last().is_some_and(|last| answer.depth > last.depth) {
                    found.push(told("more effort, and farther away", q, options, answer));
                }
                known.push(answer);
            }
            found.extend(bounds_disagree(&known).map(|fault| format!("{fault}: query {:?}", &q[..])));
            (known.len(), usize::from(known.first().is_some_and(|answer| answer.depth > 0.0)), found)
        },
    );
    let (mut answered, mut colliding) = (0, 0);
    for (count, collides, found) in judged.collect::<Vec<_>>() {
        (answered, colliding) = (answered + count, colliding + collides);
        faults.extend(found);
    }
    (answered, colliding, faults)
}

/// Runs streams along walks that begin at some of the colliding `configs`, with one judged frame
/// for each of `configs`.
fn streams(model: &Solver, changed: &[Solver], judges: (&Judge, &[Judge]), configs: &[Config]) -> Judged {
    let mut check = CheckScratch::default();
    let mut collides = |q: &&Config| model.checker().label(q, &mut check) == Label::Colliding;
    let each = MAX_STREAM_FRAMES.min(configs.len().div_ceil(MIN_WALKS));
    let start = configs.chunks(each).map(|some| (some.iter().find(&mut collides).unwrap_or(&some[0]), some.len()));
    let walks: Vec<(usize, (&Config, usize))> = start.enumerate().collect();
    let judged = walks.par_iter().map(|(index, from)| walk(model, changed, judges, *index, *from));
    let (mut answered, mut colliding, mut faults) = (0, 0, Vec::new());
    for (count, collide, found) in judged.collect::<Vec<_>>() {
        (answered, colliding) = (answered + count, colliding + collide);
        faults.extend(found);
    }
    (answered, colliding, faults)
}

/// Runs a random walk; every fourth walk leads through scenes that change. Options differ from walk
/// to walk.
fn walk(
    model: &Solver,
    changed: &[Solver],
    (judge, elsewhere): (&Judge, &[Judge]),
    index: usize,
    (start, frames): (&Config, usize),
) -> Judged {
    let (mut hearing, mut hearings): (_, Vec<Hearing>) =
        (judge.hearing(), elsewhere.iter().map(Judge::hearing).collect());
    let space = model.scene().space();
    let mut rng = ChaCha8Rng::seed_from_u64(index as u64);
    let effort = if index % 8 == 5 { Effort::Nearest } else { Effort::Refined };
    let query =
        QueryOptions::default().effort(effort).segment(index.is_multiple_of(3)).contacts(index.is_multiple_of(2));
    let options =
        StreamOptions::default().hysteresis([0.0, 0.1, 0.5][index % 3]).starts_per_frame([4, 0, 1, 8][index % 4]);
    let with = |solver: &Solver| solver.clone().options(query.clone()).unwrap();
    let (here, changed) = (with(model), changed.iter().map(with).collect::<Vec<_>>());
    let mut stream = here.stream(options).unwrap();
    let (mut answered, mut colliding, mut faults) = (0, 0, Vec::new());
    let (mut q, mut step) = (start.clone(), vec![0.0; space.nv()]);
    for frame in 0..frames {
        if frame % 10 == 0 {
            step.iter_mut().for_each(|x| *x = rng.random_range(-0.01..0.01));
        }
        // Every fifth frame stands still.
        if frame % 5 != 4 {
            let mut moved = q.to_vec();
            space.integrate(&q, &step, &mut moved);
            q = space.config(&moved).expect("a step keeps the limits");
        }
        // The scene changes every three frames in some walks, and stays in the others.
        let there = (index % 4 == 3).then(|| (frame / 3) % changed.len());
        if frame == frames / 2 {
            stream.restart();
        }
        let (answer, single, hearing) = match there {
            None => (Some(stream.query(&q).unwrap()), Some(here.query(&q).unwrap()), &mut hearing),
            Some(at) => (stream.query_in(&changed[at], &q).unwrap(), changed[at].query(&q), &mut hearings[at]),
        };
        let (Some(answer), Some(single)) = (answer, single) else {
            faults.extend(unanswered(model, hearing).map(|fault| format!("{fault}: frame {frame} of walk {index}")));
            continue;
        };
        answered += 1;
        colliding += usize::from(answer.depth > 0.0);
        let mut wrong = hearing.faults(&q, &query, &answer, true);
        wrong.extend(bounds_disagree(&[&answer, &single]).map(String::from));
        if (frame == 0 || frame == frames / 2) && answer.depth != single.depth {
            wrong.push("a first frame is not answered as a query on its own".into());
        }
        let place = format!("frame {frame} of walk {index}");
        faults.extend(wrong.into_iter().map(|fault| told(&format!("{place}: {fault}"), &q, &query, &answer)));
    }
    (answered, colliding, faults)
}

/// Returns a fault if there is no answer although a sample is free.
fn unanswered(solver: &Solver, hearing: &mut Hearing) -> Option<&'static str> {
    let samples = solver.model().expect("one was learned").boundary().configs();
    let mut samples = samples.chunks_exact(solver.scene().space().nq());
    samples.any(|sample| hearing.is_free(sample)).then_some("no answer, though a sample is free")
}

/// Returns a fault if one answer's depth is below another's lower bound.
fn bounds_disagree(answers: &[&Answer]) -> Option<&'static str> {
    let least = answers.iter().map(|answer| answer.depth).fold(f64::INFINITY, f64::min);
    let proved = answers.iter().map(|answer| answer.lower_bound).fold(0.0, f64::max);
    (proved > least).then_some("the bound of one answer is above the depth of another")
}

fn told(fault: &str, q: &Config, options: &QueryOptions, answer: &Answer) -> String {
    format!("{fault}: query {:?}, {options:?}, {answer:?}", &q[..])
}

/// Stride through the stored samples that are checked after a change.
const SAMPLE_STRIDE: usize = 64;
/// Least share of the checked samples that a change leaves free.
const MIN_FREE_SHARE: f64 = 0.1;

/// Returns the scene with an obstacle moved by some centimetres (even seeds), or with an additional
/// one in the robot's reach that leaves enough samples free.
fn change(model: &Solver, seed: u64) -> Solver {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut check = CheckScratch::default();
    let scene = model.scene();
    let obstacles: Vec<&Body> = scene.bodies().iter().filter(|body| body.is_obstacle()).collect();
    let samples = model.model().expect("one was learned").boundary().configs();
    loop {
        let scene = if seed.is_multiple_of(2) && !obstacles.is_empty() {
            let by = Vec3::from_fn(|_, _| rng.random_range(-0.05..0.05));
            let moved = obstacles[rng.random_range(0..obstacles.len())];
            let pose = Pose::translation(by).then(&moved.parts[0].pose_frame_part);
            scene.moved([(moved.name.as_str(), pose)])
        } else {
            let q = &configs(model, rng.random_range(1 << 30..1 << 31), 1)[0];
            scene.with_obstacles([ball(scene, q, &mut rng)])
        };
        let changed = model.with_scene(scene.expect("an edit")).expect("obstacles alone differ");
        let samples = samples.chunks_exact(model.scene().space().nq()).step_by(SAMPLE_STRIDE);
        let (looked, checker) = (samples.len() as f64, changed.checker());
        let free = samples.filter(|q| checker.label(q, &mut check) == Label::Free).count();
        if free as f64 >= MIN_FREE_SHARE * looked {
            return changed;
        }
    }
}

/// Makes a ball where some part of the robot is at `q`.
fn ball(scene: &Scene, q: &Config, rng: &mut ChaCha8Rng) -> Body {
    let mut poses = Vec::new();
    scene.poses(q, &mut poses);
    let moving: Vec<usize> = (0..scene.bodies().len()).filter(|&body| scene.bodies()[body].frame != 0).collect();
    // Only the last links are candidates, since they move far.
    let body = &scene.bodies()[moving[rng.random_range(moving.len() / 2..moving.len())]];
    let center = poses[body.frame].then(&body.parts[0].pose_frame_part).translation;
    let radius = rng.random_range(0.02..0.08);
    Body::obstacle("added ball", Geometry::Sphere { radius }, Pose::translation(center))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::learned;
    use extricate::builtin;

    #[test]
    fn no_answer_is_wrong_or_missing() {
        for name in builtin::NAMES {
            let model = learned(builtin::scene(name).unwrap(), 6_000, 3);
            let Findings { counts, faults } = soak(&model, 100, &mut |_| {});
            assert!(faults.is_empty(), "{name}: {} faults, first: {}", faults.len(), faults[0]);
            assert_eq!(counts.len(), KINDS.len());
            println!("{name}: {counts:?}");
            let colliding: usize = counts.values().map(|count| count.colliding).sum();
            assert!(colliding > 10, "{name}: {counts:?}");
        }
    }
}
