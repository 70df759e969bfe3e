//! `extricate info`: what a scene or a model file holds.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use extricate::Statistics;
use serde::Serialize;

use super::info_scene::{AlwaysColliding, SceneInfo};
use super::learn::statistics_rows;
use super::{load_model, load_scene, pairs_always_colliding, prepare};
use crate::output::Output;
use crate::report;

/// Configurations in which a pair must collide to be reported.
const SAMPLES: u64 = 500;

/// Arguments of `info`.
#[derive(Args)]
#[command(after_help = "Scene files end in .toml; anything else is recognised by its content.")]
pub struct InfoArgs {
    /// Scene file (TOML) or model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// List every checked pair by name (with --json they are always listed)
    #[arg(long)]
    pairs: bool,
}

/// What a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum FileKind {
    Scene,
    Model,
}

#[derive(Serialize)]
struct Info<'a> {
    kind: FileKind,
    file: String,
    #[serde(flatten)]
    scene: SceneInfo<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    always_colliding: Option<AlwaysColliding<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    statistics: Option<&'a Statistics>,
}

/// Runs the command.
pub fn run(args: &InfoArgs, json: bool) -> anyhow::Result<()> {
    let file = args.file.display().to_string();
    match kind_of(&args.file)? {
        FileKind::Scene => {
            let checker = prepare(load_scene(&args.file)?);
            let scene = checker.scene();
            let pairs = pairs_always_colliding(&checker, SAMPLES);
            let always_colliding = Some(AlwaysColliding::new(SAMPLES, report::pair_names(scene, &pairs)));
            let scene = SceneInfo::new(scene);
            print(&Info { kind: FileKind::Scene, file, scene, always_colliding, statistics: None }, args.pairs, json)
        }
        FileKind::Model => {
            let model = load_model(&args.file)?;
            let scene = SceneInfo::new(model.scene());
            let statistics = Some(model.statistics());
            print(&Info { kind: FileKind::Model, file, scene, always_colliding: None, statistics }, args.pairs, json)
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
    if let Some(always) = &info.always_colliding {
        out.line(always.text())?;
    }
    if let Some(statistics) = info.statistics {
        out.line("learned:")?;
        out.line(report::two_columns(&statistics_rows(statistics, info.scene.metric_unit())))?;
    }
    out.finish()
}

/// Text without NUL is a scene, for a model file begins with the length of its header as a binary number; the name decides
/// where a file is too short to tell.
fn kind_of(path: &Path) -> anyhow::Result<FileKind> {
    let extension = path.extension().and_then(|e| e.to_str());
    if extension == Some("toml") {
        return Ok(FileKind::Scene);
    }
    let mut head = Vec::new();
    File::open(path)
        .and_then(|file| file.take(512).read_to_end(&mut head))
        .with_context(|| format!("cannot read {}", path.display()))?;
    let binary = head.contains(&0) || (head.len() < 8 && extension == Some("model"));
    Ok(if binary { FileKind::Model } else { FileKind::Scene })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_told_from_models() {
        let folder = tempfile::tempdir().unwrap();
        let kind = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            kind_of(&path).unwrap()
        };
        assert_eq!(kind("a.toml", b"\0"), FileKind::Scene);
        assert_eq!(kind("a", b"clearance = 1e-4\n"), FileKind::Scene);
        assert_eq!(kind("b", b"\x40\x02\0\0\0\0\0\0{\"x\":1}"), FileKind::Model);
        assert_eq!(kind("short.model", b"\x40"), FileKind::Model);
        assert_eq!(kind("empty.model", b""), FileKind::Model);
        assert!(kind_of(&folder.path().join("missing")).unwrap_err().to_string().contains("missing"));
    }
}
