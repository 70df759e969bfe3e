//! Motions through colliding configurations, each frame answered by a stream and by a single query:
//! measures what starting from the last frame saves, and what it misses.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use extricate::internals::io;
use extricate::{Answer, Config, Solver, StreamOptions};
use serde_json::{Value, json};

use super::{WARM_UP, config};
use crate::clock::ThreadTime;

/// Longest time of a frame for haptic devices \[s\].
const SLOW_FRAME_S: f64 = 1e-3;
/// Shares by which an answer has to be farther than the other to be counted.
const EXCESS_SHARES: [f64; 2] = [0.05, 0.01];

#[derive(Debug, Clone, Copy)]
pub struct Walk {
    /// Frames of a full segment between two queries.
    pub steps: usize,
    /// Frames of each segment, at most `steps`. With fewer, the motion jumps to the next segment,
    /// and the stream restarts there.
    pub frames: usize,
    /// Number of times that the motion is walked; the shortest time of each frame counts.
    pub rounds: usize,
}

/// Results of the stream and of the single query for one colliding frame. The first colliding frame
/// of each motion is not counted.
struct Frame {
    depth: [f64; 2],
    checks: [usize; 2],
    /// Processor time \[s\].
    seconds: [f64; 2],
    verified: bool,
}

const STREAM: usize = 0;
const SINGLE: usize = 1;

/// Walks along the straight segments between successive lines of `queries` and writes one JSON
/// object. `frames` counts all frames, `colliding` those that are compared, and `motions` the
/// starts of the stream. `stream` and `single` hold times of this thread in microseconds, mean
/// checks and the share of frames over 1 ms. They also hold the shares of answers more than 5 % and
/// 1 % farther than the other's; `verified` is the stream's share.
pub fn compare(model: &str, queries: &str, walk: Walk, mut output: impl Write) -> Result<()> {
    let solver = Solver::of_model(io::load_model(Path::new(model))?);
    let text = std::fs::read_to_string(queries).with_context(|| queries.to_string())?;
    let corners = text.lines().map(|line| config(solver.scene().space(), line)).collect::<Result<Vec<_>>>()?;
    ensure!(corners.len() > 1, "{queries}: expected two configurations or more");
    ensure!((1..=walk.steps).contains(&walk.frames), "expected 1 to {} frames a segment", walk.steps);
    ensure!(walk.rounds > 0, "expected a round or more");
    let motions = motions(&solver, &corners, walk);
    let frames = walked(&solver, &motions, walk.rounds);
    ensure!(!frames.is_empty(), "no frame but the first of a motion collides");
    let mut line = json!({
        "frames": motions.iter().map(Vec::len).sum::<usize>(),
        "colliding": frames.len(),
        "motions": motions.len(),
        "verified": share(&frames, |f| f.verified),
    });
    for (name, side) in [("stream", STREAM), ("single", SINGLE)] {
        line[name] = figures(&frames, side);
    }
    Ok(writeln!(output, "{line}")?)
}

/// Frames in order; no list contains a jump.
fn motions(solver: &Solver, corners: &[Config], walk: Walk) -> Vec<Vec<Config>> {
    let space = solver.scene().space();
    let (mut motions, mut at) = (Vec::new(), vec![0.0; space.nq()]);
    for ends in corners.windows(2) {
        let segment = (0..walk.frames).map(|k| {
            space.interpolate(&ends[0], &ends[1], k as f64 / walk.steps as f64, &mut at);
            space.config(&at).expect("between two configurations lie configurations")
        });
        match motions.last_mut() {
            Some(motion) if walk.frames == walk.steps => Vec::extend(motion, segment),
            _ => motions.push(segment.collect()),
        }
    }
    motions
}

fn walked(solver: &Solver, motions: &[Vec<Config>], rounds: usize) -> Vec<Frame> {
    let mut stream = solver.stream(StreamOptions::default()).expect("defaults");
    solver.warm_up(WARM_UP);
    let mut frames: Vec<Frame> = Vec::new();
    for round in 0..rounds {
        let mut counted = 0;
        for motion in motions {
            stream.restart();
            let mut is_followed = false;
            for (k, q) in motion.iter().enumerate() {
                let mut followed = None;
                if (k + round) % 2 == 0 {
                    followed = Some(timed(|| stream.query(q).expect("nothing is locked")));
                }
                let (single, alone) = timed(|| solver.query(q).expect("nothing is locked"));
                let (answer, seconds) =
                    followed.unwrap_or_else(|| timed(|| stream.query(q).expect("nothing is locked")));
                // The stream answers the first colliding frame like a single query, so it is not
                // compared.
                if answer.is_free() || !std::mem::replace(&mut is_followed, true) {
                    continue;
                }
                if round == 0 {
                    frames.push(Frame {
                        depth: [answer.depth, single.depth],
                        checks: [answer.checks, single.checks],
                        seconds: [seconds, alone],
                        verified: answer.verified,
                    });
                } else {
                    let shortest = &mut frames[counted].seconds;
                    *shortest = [shortest[STREAM].min(seconds), shortest[SINGLE].min(alone)];
                }
                counted += 1;
            }
        }
    }
    frames
}

fn timed(ask: impl FnOnce() -> Answer) -> (Answer, f64) {
    let started = ThreadTime::now();
    let answer = ask();
    let seconds = started.elapsed();
    (answer, seconds)
}

fn figures(frames: &[Frame], side: usize) -> Value {
    let mut us: Vec<f64> = frames.iter().map(|f| 1e6 * f.seconds[side]).collect();
    us.sort_by(f64::total_cmp);
    // The least value that the given share of frames does not exceed.
    let quantile = |share: f64| us[(share * us.len() as f64).ceil() as usize - 1];
    let [over_5pct, over_1pct] =
        EXCESS_SHARES.map(|excess| share(frames, |f| f.depth[side] > (1.0 + excess) * f.depth[1 - side]));
    json!({
        "us": quantile(0.5),
        "us_95": quantile(0.95),
        "us_99": quantile(0.99),
        "us_max": quantile(1.0),
        "over_1ms": share(frames, |f| f.seconds[side] > SLOW_FRAME_S),
        "checks": frames.iter().map(|f| f.checks[side] as f64).sum::<f64>() / frames.len() as f64,
        "over_5pct": over_5pct,
        "over_1pct": over_1pct,
    })
}

fn share(frames: &[Frame], of: impl Fn(&Frame) -> bool) -> f64 {
    frames.iter().filter(|f| of(f)).count() as f64 / frames.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::queries::learned_arm;

    #[test]
    fn frames_that_collide_are_compared_and_nonsense_an_error() {
        let folder = learned_arm("streams");
        let at = |name: &str| folder.join(name).to_str().unwrap().to_string();
        std::fs::write(at("queries"), "{\"q\": [0.5, 0, 0]}\n{\"q\": [0.6, 0.1, 0]}\n{\"q\": [0.4, 0, 0.1]}\n")
            .unwrap();
        std::fs::write(at("one"), "{\"q\": [0.5, 0, 0]}\n").unwrap();
        let ask = |queries: &str, steps, frames, rounds| {
            let mut out = Vec::new();
            compare(&at("arm.model"), &at(queries), Walk { steps, frames, rounds }, &mut out)
                .map(|()| serde_json::from_slice::<Value>(&out).unwrap())
        };
        for (frames, motions) in [(10, 1), (5, 2)] {
            let found = ask("queries", 10, frames, 2).unwrap();
            assert_eq!(found["frames"], 2 * frames);
            assert_eq!(found["motions"], motions);
            // All frames collide; the first of each motion is left out.
            assert_eq!(found["colliding"], 2 * frames - motions);
            assert_eq!(found["verified"], 1.0);
            for side in ["stream", "single"] {
                let times = ["us", "us_95", "us_99", "us_max"].map(|key| found[side][key].as_f64().unwrap());
                assert!(times.is_sorted() && times[0] > 0.0, "{found}");
                assert!(found[side]["checks"].as_f64().unwrap() >= 1.0);
                assert!(found[side]["over_5pct"].as_f64() <= found[side]["over_1pct"].as_f64());
            }
        }
        for (queries, steps, frames, rounds) in
            [("one", 10, 10, 1), ("queries", 10, 11, 1), ("queries", 10, 0, 1), ("queries", 10, 10, 0)]
        {
            assert!(ask(queries, steps, frames, rounds).is_err(), "{queries} {steps} {frames} {rounds}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
