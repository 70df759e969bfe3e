//! One module per command: each takes its arguments, calls the library and reports.

pub mod check;
pub mod demo;
pub mod distance;
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

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use extricate::parts::disable_list;
use extricate::{Checker, Config, KeptLink, Label, Model, Sampler, Scene, Solver, files};

use crate::args::{Cli, Command, LoadArgs};
use crate::notice;
use crate::progress::busy;
use file_kind::{FileKind, kind_of};
pub use motion::{escape, plan, repair};
pub use pages::{report, view};

pub fn run(cli: Cli) -> anyhow::Result<()> {
    match cli.command {
        Command::Demo(args) => demo::run(&args, cli.json),
        Command::Import(args) => import::run(&args, cli.json),
        Command::Info(args) => info::run(&args, cli.json),
        Command::Check(args) => check::run(&args, cli.json),
        Command::Sample(args) => sample::run(&args),
        Command::Learn(args) => learn::run(&args, cli.json),
        Command::Query(args) => query::run(&args, cli.json),
        Command::Distance(args) => distance::run(&args, cli.json),
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

/// Line for the table `[pairs]` of the scene file that disables the pairs `names`.
fn disable_line(names: &[[&str; 2]]) -> String {
    format!("disable = {}", disable_list(names))
}

/// Appends to `problem` the pairs that collide in all tested configurations, if there are any.
/// `problem` states that nothing free was found.
fn with_advice(problem: &str, solver: &Solver) -> String {
    let advice = solver.checker().advice_if_never_free(|| false);
    advice.map_or_else(|| problem.to_owned(), |advice| format!("{problem}; {advice}"))
}

/// Loads the scene of a scene file, a URDF or a model file, which contains its scene.
fn load_scene(path: &Path, load: &LoadArgs) -> anyhow::Result<Scene> {
    if kind_of(path)? == FileKind::Model {
        return Ok(Scene::clone(load_model(path)?.scene()));
    }
    Ok(busy(&format!("loading {}", path.display()), || extricate::load_scene_with(path, &load.options()))?)
}

/// Puts `robots` into the world of a file; for a model file, returns its scene.
fn load_world(robots: &Scene, path: &Path, load: &LoadArgs) -> anyhow::Result<Scene> {
    if kind_of(path)? == FileKind::Model {
        return load_scene(path, load);
    }
    Ok(files::load_world(robots, path, &load.options())?)
}

fn load_model(path: &Path) -> extricate::Result<Model> {
    busy(&format!("loading {}", path.display()), || extricate::load_model(path))
}

/// Builds the exact checker, which takes long for large meshes.
fn prepare(scene: impl Into<Arc<Scene>>) -> Checker {
    busy("preparing the collision checker", || Checker::new(scene.into()))
}

/// Loads a scene or a model as a solver, in the world of another file if one is given. The solver
/// is prepared, so that no query has to prepare it.
fn load_solver(file: &Path, world: Option<&Path>, load: &LoadArgs) -> anyhow::Result<Solver> {
    let mut solver = match kind_of(file)? {
        FileKind::Scene => Solver::new(load_scene(file, load)?),
        FileKind::Model => Solver::of_model(load_model(file)?),
    };
    if let Some(path) = world {
        let scene = load_world(solver.scene(), path, load)?;
        let changed = solver.with_scene(scene);
        solver = changed.with_context(|| format!("{} does not fit the model", path.display()))?;
    }
    if solver.model().is_none() {
        tell_warnings(solver.scene());
    }
    busy("preparing the scene", || solver.prepare());
    Ok(solver)
}

fn draw_colliding(solver: &Solver, count: usize, seed: u64) -> anyhow::Result<Vec<Config>> {
    let mut sampler = Sampler::new(solver, Some(Label::Colliding), seed);
    let drawn = busy("drawing configurations", || sampler.draw(count, &mut |_, _| ControlFlow::Continue(())))?;
    Ok(drawn.iter().map(|q| solver.scene().config(q)).collect::<extricate::Result<_>>()?)
}

fn tell_warnings(scene: &Scene) {
    for warning in scene.warnings() {
        notice::warning(warning);
    }
}

/// Reads the links of `--keep`.
pub fn kept_links(text: Option<&str>, scene: &Scene) -> extricate::Result<Vec<KeptLink>> {
    text.map_or_else(|| Ok(Vec::new()), |text| KeptLink::from_text(scene, text))
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
