//! `extricate import`: writes a world of another program as a scene file.

use std::path::PathBuf;

use clap::Args;
use extricate::files::{check_not_read, import_world, is_urdf};
use serde::Serialize;

use super::load_scene;
use crate::args::LoadArgs;
use crate::notice;
use crate::output::Output;
use crate::report::counted;

/// Arguments of `import`.
#[derive(Args)]
#[command(
    after_help = "FILE is MoveIt's .scene text, or a PlanningScene as YAML (`ros2 topic echo --full-length`, Robowflex) or JSON \
                        (rosbridge). The command imports obstacles, attached objects with the bodies that they may touch, \
                        allowed collisions and padding. It writes meshes and octomaps to a folder beside the scene file. It \
                        lists content that it skips, or imports as something else, on standard error and at the head of the scene file.\n\n\
                        Without --robot the scene file is a world, for `extricate query ROBOT --world WORLD`. Such a query \
                        also accepts FILE itself."
)]
pub struct ImportArgs {
    /// File that ends in .scene, .yaml, .yml or .json
    file: PathBuf,
    /// Scene file to write (TOML)
    #[arg(short = 'o', long = "output", value_name = "SCENE")]
    output: PathBuf,
    /// URDF of the robot, which the scene file then names; or a scene or model file, used only to
    /// look up links and frames
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Report {
    scene: String,
    meshes: Vec<String>,
    obstacles: usize,
    attached: usize,
    disabled: usize,
    notes: Vec<String>,
}

pub fn run(args: &ImportArgs, json: bool) -> anyhow::Result<()> {
    check_not_read(&args.output, args.robot.as_deref())?;
    let robots = args.robot.as_deref().map(|robot| load_scene(robot, &args.load)).transpose()?;
    let urdf = match &args.robot {
        Some(path) if is_urdf(path)? => Some(path.as_path()),
        _ => None,
    };
    let done = import_world(&args.file, &args.output, robots.as_ref(), urdf, &args.load.limits())?;
    for note in &done.notes {
        notice::warning(note);
    }
    let report = Report {
        scene: args.output.display().to_string(),
        meshes: done.meshes.iter().map(|path| path.display().to_string()).collect(),
        obstacles: done.entries.obstacle.len(),
        attached: done.entries.attached.len(),
        disabled: done.entries.pairs.disable.len(),
        notes: done.notes,
    };
    let mut out = Output::new(false);
    if json {
        out.json(&report)?;
    } else {
        out.line(format_args!(
            "wrote {}: {}, {}, {}",
            report.scene,
            counted(report.obstacles, "obstacle", "obstacles"),
            counted(report.attached, "attached object", "attached objects"),
            counted(report.disabled, "disabled pair", "disabled pairs")
        ))?;
        for mesh in &report.meshes {
            out.line(format_args!("wrote {mesh}"))?;
        }
    }
    out.finish()
}
