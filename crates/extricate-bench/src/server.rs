//! Commands from a script, answers as JSON lines. Timed code runs in this process, and the script
//! alternates between it and the peers, so that all of them see the same state of the machine.
//! Words are separated by spaces; names and paths contain none.
//!
//! | command | does |
//! |---|---|
//! | `load NAME MESH` | prepares a mesh |
//! | `convert MESH OFF`, `make bumpy LEVEL OFF`, `make torus R r N M STL` | writes a mesh |
//! | `poses A B random\|contact LIMIT COUNT SEED OUT` | writes poses of B in the frame of A |
//! | `time A B POSES LIMIT [OUT]` | checks each pose; `OUT` receives the answers, a byte each |
//! | `truth A B POSES LIMIT INDEX` | one pose by brute force |
//! | `scene NAME TOML`, `chain NAME LINKS OBSTACLES` | prepares a scene |
//! | `configs NAME uniform\|boundary COUNT SEED OUT` | writes configurations |
//! | `label NAME CONFIGS [OUT]`, `batch NAME CONFIGS THREADS`, `contacts NAME CONFIGS MARGIN coarse\|exact` | times them |

use std::collections::HashMap;
use std::hint::black_box;
use std::io::{BufRead, Write};

use anyhow::{Context, Result, bail, ensure};
use extricate::internals::collision::PairScratch;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::clock::ThreadTime;
use crate::exact::drawn_poses::{Body, half_colliding, near_contact};
use crate::exact::{self, brute_force_meshes, meshes};
use crate::labels::Robot;
use crate::{files, robots};

#[derive(Default)]
struct Loaded {
    bodies: HashMap<String, Body>,
    robots: HashMap<String, Robot>,
}

/// Answers every line of `input`; a line that fails gives `{"error": ...}`.
pub fn serve(input: impl BufRead, mut output: impl Write) -> Result<()> {
    let mut loaded = Loaded::default();
    for line in input.lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = answer(&words, &mut loaded).unwrap_or_else(|error| json!({ "error": format!("{error:#}") }));
        writeln!(output, "{answer}")?;
        output.flush()?;
    }
    Ok(())
}

fn answer(words: &[&str], loaded: &mut Loaded) -> Result<Value> {
    Ok(match *words {
        ["load", name, path] => load(name, path, loaded)?,
        ["convert", from, to] => {
            files::write_off(&files::read_mesh(from)?, to)?;
            json!({})
        }
        ["make", "bumpy", level, path] => {
            files::write_off(&meshes::bumpy(level.parse()?, 0.0), path)?;
            json!({})
        }
        ["make", "torus", major, minor, around, across, path] => {
            let torus = meshes::torus(major.parse()?, minor.parse()?, around.parse()?, across.parse()?);
            std::fs::write(path, files::stl(&torus))?;
            json!({ "triangles": torus.triangles.len() })
        }
        ["poses", a, b, kind, limit, count, seed, path] => {
            let (a, b) = (loaded.body(a)?, loaded.body(b)?);
            let mut rng = ChaCha8Rng::seed_from_u64(seed.parse()?);
            let (limit, count) = (limit.parse()?, count.parse()?);
            let poses = match kind {
                "random" => half_colliding(a, b, limit, count, &mut rng),
                "contact" => near_contact(a, b, limit, count, &mut rng),
                _ => bail!("got `{kind}`, expected random or contact"),
            };
            files::write_numbers(&files::pose_numbers(&poses), path)?;
            json!({ "count": poses.len() })
        }
        ["time", a, b, poses, limit] => time(loaded.body(a)?, loaded.body(b)?, poses, limit.parse()?, None)?,
        ["time", a, b, poses, limit, out] => time(loaded.body(a)?, loaded.body(b)?, poses, limit.parse()?, Some(out))?,
        ["truth", a, b, poses, limit, index] => {
            let (a, b, limit): (_, _, f64) = (loaded.body(a)?, loaded.body(b)?, limit.parse()?);
            let pose = files::poses_of(&files::read_numbers(poses)?)[index.parse::<usize>()?];
            let truth = brute_force_meshes::truth(&a.mesh, &b.mesh, &pose, [0.0, limit + 1e-6], exact::TOLERANCE_M);
            json!({ "distance": truth.distance.is_finite().then_some(truth.distance), "contained": truth.contained,
                    "near": exact::expected(&truth, limit, exact::TOLERANCE_M) })
        }
        ["scene", name, path] => {
            let scene = extricate::internals::io::load_scene(path)?;
            loaded.add_robot(name, Robot::new(scene))
        }
        ["chain", name, links, obstacles] => {
            let scene = robots::chain(links.parse()?, obstacles.parse()?)?;
            loaded.add_robot(name, Robot::new(scene))
        }
        ["configs", name, kind, count, seed, path] => {
            let configs = loaded.robot(name)?.configs(kind, count.parse()?, seed.parse()?)?;
            files::write_numbers(&configs, path)?;
            json!({ "count": configs.len() })
        }
        ["label", name, configs] => loaded.robot(name)?.label(&files::read_numbers(configs)?, None)?,
        ["label", name, configs, out] => loaded.robot(name)?.label(&files::read_numbers(configs)?, Some(out))?,
        ["batch", name, configs, threads] => {
            loaded.robot(name)?.batch(&files::read_numbers(configs)?, threads.parse()?)?
        }
        ["contacts", name, configs, margin, search] => {
            loaded.robot(name)?.contacts(&files::read_numbers(configs)?, margin.parse()?, search)?
        }
        _ => bail!("got `{}`, expected a command of the list in server.rs", words.join(" ")),
    })
}

impl Loaded {
    fn body(&self, name: &str) -> Result<&Body> {
        self.bodies.get(name).with_context(|| format!("no mesh `{name}` was loaded"))
    }

    fn robot(&self, name: &str) -> Result<&Robot> {
        self.robots.get(name).with_context(|| format!("no scene `{name}` was loaded"))
    }

    fn add_robot(&mut self, name: &str, robot: Robot) -> Value {
        let answer = robot.describe();
        self.robots.insert(name.into(), robot);
        answer
    }
}

/// Prepares a mesh. Welding and sorting into components happen once per file; the tree is what a
/// scene adds for checks.
fn load(name: &str, path: &str, loaded: &mut Loaded) -> Result<Value> {
    let start = ThreadTime::now();
    let mesh = files::read_mesh(path)?;
    let read = start.elapsed();
    ensure!(!mesh.triangles.is_empty(), "{path}: got a mesh without triangles");
    let geometry = extricate::geometry::Geometry::Mesh(mesh.clone().into());
    let (before, start) = (resident(), ThreadTime::now());
    let shape = black_box(extricate::internals::collision::PreparedShape::new(&geometry));
    let (build, bytes) = (start.elapsed(), resident() - before);
    drop(shape);
    let (triangles, closed) = (mesh.triangles.len(), mesh.is_closed());
    loaded.bodies.insert(name.into(), Body::new(mesh));
    Ok(
        json!({ "triangles": triangles, "closed": closed, "read_seconds": read, "build_seconds": build, "bytes": bytes }),
    )
}

/// Resident memory of this process \[bytes\]; 0 if the system does not report it.
fn resident() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0) * 1024
}

fn time(a: &Body, b: &Body, poses: &str, limit: f64, out: Option<&str>) -> Result<Value> {
    let poses = files::poses_of(&files::read_numbers(poses)?);
    let mut scratch = PairScratch::default();
    let mut answers = Vec::with_capacity(poses.len());
    // Some checks first bring the meshes into the caches, for all sides alike.
    for pose in poses.iter().take(poses.len() / 10) {
        black_box(a.is_nearer(b, pose, limit, &mut scratch));
    }
    let start = ThreadTime::now();
    answers.extend(poses.iter().map(|pose| u8::from(a.is_nearer(b, pose, limit, &mut scratch))));
    let seconds = start.elapsed();
    if let Some(path) = out {
        std::fs::write(path, &answers)?;
    }
    let hits = answers.iter().filter(|hit| **hit == 1).count();
    Ok(json!({ "seconds": seconds, "count": poses.len(), "hits": hits }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_answers() {
        let folder = std::env::temp_dir().join(format!("extricate-bench-serve-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let commands = "make bumpy 2 D/m.off\nload m D/m.off\nconvert D/m.off D/n.off\nmake torus 0.2 0.1 8 6 D/t.stl\n\
            poses m m random 1e-4 40 1 D/r.bin\nposes m m contact 0 40 1 D/c.bin\ntime m m D/r.bin 1e-4 D/a.bin\n\
            time m m D/c.bin 0\ntruth m m D/c.bin 0 3\nchain c 4 5\nconfigs c uniform 100 1 D/q.bin\n\
            configs c boundary 20 1 D/b.bin\nlabel c D/q.bin D/l.bin\nbatch c D/q.bin 2\n\
            contacts c D/b.bin 0.01 exact\ncontacts c D/b.bin 0.01 coarse";
        let mut output = Vec::new();
        serve(commands.replace('D', folder.to_str().unwrap()).as_bytes(), &mut output).unwrap();
        let lines: Vec<Value> =
            String::from_utf8(output).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), commands.lines().count());
        assert!(lines.iter().all(|line| line.get("error").is_none()), "{lines:?}");
        assert_eq!(lines[6]["hits"], 20, "half of the random poses collide");
        assert!(
            (10..=30).contains(&lines[7]["hits"].as_u64().unwrap()),
            "about half of those next to contact: {}",
            lines[7]
        );
        assert!(lines[14]["contacts"].as_f64().unwrap() > 0.5, "{}", lines[14]);
        let mut output = Vec::new();
        serve("load x nowhere.off\nfly".as_bytes(), &mut output).unwrap();
        let text = String::from_utf8(output).unwrap();
        assert!(text.contains("nowhere.off") && text.contains("got `fly`"), "{text}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
