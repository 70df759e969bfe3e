//! A cloud of points or a grid of voxels around the built-in arm: times of preparation, of a label,
//! and of a query without a model.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use extricate::geometry::{Geometry, PointCloud, Voxels};
use extricate::internals::cspace::sampling::Halton;
use extricate::internals::scene::assemble::assemble_entries;
use extricate::internals::scene::file::{self, GeometryKind, ObstacleEntry, ShapeEntry};
use extricate::{CheckScratch, Config, Error, Label, Scene, Solver, builtin};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use crate::clock::ThreadTime;

/// Radius of a ball about a point, and half the side of a voxel \[m\].
const POINT_RADIUS_M: f64 = 0.01;
/// Colliding configurations that are queried.
const QUERIES: usize = 200;
const LABELS: u64 = 20_000;

/// Writes one JSON line for `count` points, as `points` or `voxels`, around the arm with its
/// `meshes` or `hulls`.
pub fn measure(kind: &str, count: usize, links: &str, mut output: impl Write) -> Result<()> {
    let surroundings = match kind {
        "points" => Geometry::Points(Arc::new(PointCloud::new("bench", "points", POINT_RADIUS_M, &surfaces(count))?)),
        "voxels" => {
            let cell = |p: [f64; 3]| p.map(|x| (x / (2.0 * POINT_RADIUS_M)).floor() as i32);
            let cells = surfaces(count).into_iter().map(cell).collect();
            Geometry::Voxels(Arc::new(Voxels::new("bench", "voxels", 2.0 * POINT_RADIUS_M, cells)?))
        }
        _ => bail!("expected points or voxels, found {kind}"),
    };
    let links = match links {
        "meshes" => GeometryKind::Mesh,
        "hulls" => GeometryKind::ConvexHull,
        _ => bail!("expected meshes or hulls, found {links}"),
    };
    let (alone, _) = ready(None, links)?;
    let (seconds, world) = ready(Some(surroundings), links)?;
    let (label, colliding) = label(&world);
    let queries = queries(&world)?;
    let sorted = |column: usize| {
        let mut all: Vec<f64> = queries.iter().map(|row| row[column]).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let (times, checks) = (sorted(0), sorted(1));
    let line = json!({
        "count": count,
        "pairs": world.scene().pairs().len(),
        "ready_ms": 1e3 * seconds,
        "ready_without_ms": 1e3 * alone,
        "label_us": 1e6 * label,
        "colliding": colliding,
        "query_ms_median": 1e3 * times[times.len() / 2],
        "query_ms_90": 1e3 * times[times.len() * 9 / 10],
        "depth_mean": queries.iter().map(|row| row[2]).sum::<f64>() / queries.len() as f64,
        "checks_median": checks[checks.len() / 2],
        "bound_over_depth_median": sorted(3)[queries.len() / 2],
    });
    writeln!(output, "{line}")?;
    Ok(())
}

/// Draws points uniformly from the faces of boxes around the arm.
fn surfaces(count: usize) -> Vec<[f64; 3]> {
    let boxes = [
        ([0.55, 0.0, 0.35], [0.12, 0.3, 0.02]),
        ([0.6, 0.0, 0.75], [0.12, 0.3, 0.02]),
        ([-0.5, 0.35, 0.4], [0.1, 0.1, 0.4]),
        ([0.0, -0.65, 0.5], [0.4, 0.02, 0.5]),
        ([0.1, 0.6, 0.9], [0.25, 0.1, 0.1]),
    ];
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let area = |[x, y, z]: [f64; 3], axis: usize| [y * z, z * x, x * y][axis];
    let whole: f64 = boxes.iter().flat_map(|(_, half)| (0..3).map(|axis| area(*half, axis))).sum();
    let mut point = || {
        let mut at = rng.random::<f64>() * whole;
        let faces = boxes.iter().flat_map(|(center, half)| (0..3).map(move |axis| (center, half, axis)));
        let mut last = (&boxes[0].0, &boxes[0].1, 0);
        for face in faces {
            last = face;
            at -= area(*face.1, face.2);
            if at < 0.0 {
                break;
            }
        }
        let (center, half, axis) = last;
        let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
        [0, 1, 2].map(|k| center[k] + half[k] * if k == axis { side } else { 2.0 * rng.random::<f64>() - 1.0 })
    };
    (0..count).map(|_| point()).collect()
}

/// The arm, with surroundings or without, and the seconds from their numbers to a solver that is
/// ready.
fn ready(surroundings: Option<Geometry>, links: GeometryKind) -> Result<(f64, Solver)> {
    let files = builtin::files("shelf-arm").context("the built-in arm")?;
    let mut scene = file::parse(&files[0].0, &String::from_utf8_lossy(&files[0].1))?;
    scene.robot[0].geometry = links;
    scene.pairs.disable.clear();
    let shape = |scenery| ShapeEntry { scenery: Some(scenery), ..ShapeEntry::default() };
    let entry = |scenery| ObstacleEntry { name: "map".into(), shape: shape(scenery), pose: Default::default() };
    scene.obstacle = surroundings.map(entry).into_iter().collect();
    let mut read = |path: &Path| {
        let wanted: PathBuf = path.components().filter(|part| part.as_os_str() != ".").collect();
        match files.iter().find(|(name, _)| Path::new(name) == wanted) {
            Some((_, contents)) => Ok(contents.clone()),
            None => Err(Error::Read { path: path.into(), source: std::io::ErrorKind::NotFound.into() }),
        }
    };
    let started = Instant::now();
    let scene: Scene = assemble_entries(Path::new(&files[0].0), &scene, &mut read)?;
    let world = Solver::new(scene);
    world.prepare();
    Ok((started.elapsed().as_secs_f64(), world))
}

/// Seconds per label, and the share of colliding configurations.
fn label(world: &Solver) -> (f64, f64) {
    let space = world.scene().space();
    let halton = Halton::new(space.nv(), 1);
    let mut configs = vec![0.0; LABELS as usize * space.nq()];
    for (k, q) in (0..).zip(configs.chunks_exact_mut(space.nq())) {
        halton.config(space, k, q);
    }
    let mut check = CheckScratch::default();
    let mut pass = || {
        configs.chunks_exact(space.nq()).filter(|q| world.checker().label(q, &mut check) == Label::Colliding).count()
    };
    pass();
    let started = ThreadTime::now();
    let colliding = pass();
    (started.elapsed() / LABELS as f64, colliding as f64 / LABELS as f64)
}

/// For each query: seconds, checks, depth, and the ratio of lower bound to depth.
fn queries(world: &Solver) -> Result<Vec<[f64; 4]>> {
    let space = world.scene().space();
    let (halton, mut q, mut check) = (Halton::new(space.nv(), 2), vec![0.0; space.nq()], CheckScratch::default());
    let all = (0..).map(|k| {
        halton.config(space, k, &mut q);
        space.config(&q)
    });
    let configs: Vec<Config> =
        all.flatten().filter(|q| world.checker().label(q, &mut check) == Label::Colliding).take(QUERIES).collect();
    let ask = |q: &Config| {
        let started = ThreadTime::now();
        let answer = world.query(q).context("nothing free was found")?;
        Ok([started.elapsed(), answer.checks as f64, answer.depth, answer.lower_bound / answer.depth])
    };
    configs.iter().take(20).try_for_each(|q| ask(q).map(|_: [f64; 4]| ()))?;
    configs.iter().map(ask).collect()
}
