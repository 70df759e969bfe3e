//! One file a command; each takes its arguments, calls the library and reports.

pub mod check;
pub mod demo;
mod file_kind;
pub mod grasp;
pub mod import;
pub mod info;
pub mod learn;
pub mod motion;
pub mod pages;
pub mod query;
pub mod sample;
pub mod shell;

use std::path::Path;
use std::sync::Arc;

use extricate::internals::collision::{advice_if_never_free, disable_list};
use extricate::internals::io;
use extricate::{Checker, Model, Scene, World};

use crate::args::{Cli, Command, LoadArgs};
use crate::notice;
use crate::progress::busy;
use file_kind::{FileKind, kind_of};
pub use motion::{escape, plan, repair};
pub use pages::{report, view};

/// Runs the command.
pub fn run(cli: Cli) -> anyhow::Result<()> {
    match cli.command {
        Command::Demo(args) => demo::run(&args, cli.json),
        Command::Import(args) => import::run(&args, cli.json),
        Command::Info(args) => info::run(&args, cli.json),
        Command::Check(args) => check::run(&args, cli.json),
        Command::Sample(args) => sample::run(&args),
        Command::Learn(args) => learn::run(&args, cli.json),
        Command::Query(args) => query::run(&args, cli.json),
        Command::Grasp(args) => grasp::run(&args, cli.json),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
        Command::Report(args) => report::run(&args, cli.json),
        Command::View(args) => view::run(&args, cli.json),
        Command::Escape(args) => escape::run(&args, cli.json),
        Command::Plan(args) => plan::run(&args, cli.json),
        Command::Repair(args) => repair::run(&args, cli.json),
    }
}

/// The line for the scene file's `[pairs]` table that takes `names` out of the checked pairs.
fn disable_line(names: &[[&str; 2]]) -> String {
    format!("disable = {}", disable_list(names))
}

/// `problem`, that nothing free was found, and which pairs are to blame, if some collide wherever
/// one looks.
fn with_advice(problem: &str, checker: &Checker) -> String {
    advice_if_never_free(checker, || false).map_or_else(|| problem.to_owned(), |advice| format!("{problem}; {advice}"))
}

/// Of a scene file, a URDF or a model file, which holds its scene.
fn load_scene(path: &Path, load: &LoadArgs) -> anyhow::Result<Scene> {
    if kind_of(path)? == FileKind::Model {
        return Ok(load_model(path)?.scene().clone());
    }
    Ok(busy(&format!("loading {}", path.display()), || io::load_scene_with(path, &load.options()))?)
}

/// The robots of `robots` in the world of a file, or in the scene of a model file.
fn load_world(robots: &Scene, path: &Path, load: &LoadArgs) -> anyhow::Result<Scene> {
    if kind_of(path)? == FileKind::Model {
        return load_scene(path, load);
    }
    Ok(io::load_world(robots, path, &load.options())?)
}

fn load_model(path: &Path) -> extricate::Result<Model> {
    busy(&format!("loading {}", path.display()), || io::load_model(path))
}

/// Builds the exact checker, which takes a while where meshes are large.
fn prepare(scene: impl Into<Arc<Scene>>) -> Checker {
    busy("preparing the collision checker", || Checker::new(scene.into()))
}

/// Prepares a scene for queries, which then take no time for that.
fn world_of(scene: Scene) -> World {
    busy("preparing the scene", || {
        let world = World::new(scene);
        world.view();
        world
    })
}

fn tell_warnings(scene: &Scene) {
    for warning in &scene.warnings {
        notice::warning(warning);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_to_add_is_toml() {
        let names = [["palm_link", "link_13.0"], ["a", "b/c"]];
        assert_eq!(disable_line(&names), r#"disable = [["palm_link", "link_13.0"], ["a", "b/c"]]"#);
    }
}
