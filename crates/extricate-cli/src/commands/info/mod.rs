//! `extricate info`: describes a scene or a model file.

pub mod scene;

use std::path::PathBuf;

use clap::Args;
use extricate::Statistics;
use serde::Serialize;

use super::file_kind::{FileKind, kind_of};
use super::learn::statistics_rows;
use super::{load_model, load_scene, prepare};
use crate::args::LoadArgs;
use crate::output::Output;
use crate::report;
use scene::{OftenColliding, SceneInfo};

/// Number of configurations in which pairs are tested for collisions.
const SAMPLES: u64 = 1000;
/// Pairs that collide in at least this share of the configurations are reported.
const NEARLY_ALWAYS_SHARE: f64 = 0.95;

/// Arguments of `info`.
#[derive(Args)]
#[command(after_help = "Scene files end in .toml; anything else is recognised by its content.")]
pub struct InfoArgs {
    /// Scene file (TOML), URDF or model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// List every checked pair by name (with --json they are always listed)
    #[arg(long)]
    pairs: bool,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Info<'a> {
    kind: FileKind,
    file: String,
    #[serde(flatten)]
    scene: SceneInfo<'a>,
    #[serde(flatten)]
    colliding: Option<OftenColliding<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    statistics: Option<&'a Statistics>,
}

pub fn run(args: &InfoArgs, json: bool) -> anyhow::Result<()> {
    let file = args.file.display().to_string();
    match kind_of(&args.file)? {
        FileKind::Scene => {
            let checker = prepare(load_scene(&args.file, &args.load)?);
            let scene = checker.scene();
            let found = checker.pairs_nearly_always_colliding(SAMPLES, NEARLY_ALWAYS_SHARE);
            let found = found.into_iter().map(|(pair, count)| (scene.pair_names(pair), count as u64));
            let colliding = Some(OftenColliding::new(SAMPLES, NEARLY_ALWAYS_SHARE, found));
            let scene = SceneInfo::new(scene);
            print(&Info { kind: FileKind::Scene, file, scene, colliding, statistics: None }, args.pairs, json)
        }
        FileKind::Model => {
            let model = load_model(&args.file)?;
            let scene = SceneInfo::new(model.scene());
            let statistics = Some(model.statistics());
            print(&Info { kind: FileKind::Model, file, scene, colliding: None, statistics }, args.pairs, json)
        }
    }
}

fn print(info: &Info, list_pairs: bool, json: bool) -> anyhow::Result<()> {
    let mut out = Output::new(false);
    if json {
        out.json(info)?;
        return out.finish();
    }
    let kind = if info.kind == FileKind::Scene { "scene" } else { "model" };
    out.line(format_args!("{kind} {}", info.file))?;
    out.line(info.scene.text(list_pairs))?;
    if let Some(colliding) = &info.colliding {
        out.line(colliding.text())?;
    }
    if let Some(statistics) = info.statistics {
        out.line("learned:")?;
        out.line(report::two_columns(&statistics_rows(statistics, info.scene.metric_unit())))?;
    }
    out.finish()
}
