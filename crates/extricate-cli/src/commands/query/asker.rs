//! What queries are asked of: a scene, a model, or a model in another scene.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Context;
use extricate::internals::query::Answered;
use extricate::{
    Answer, ChangedScene, Config, Model, QueryOptions, QueryScratch, Scene, Stream, StreamOptions, View, World,
};

use crate::args::LoadArgs;
use crate::commands::file_kind::{FileKind, kind_of};
use crate::commands::{load_model, load_scene, load_world, tell_warnings, world_of};
use crate::progress::busy;

/// What is asked.
pub enum Asked {
    /// A scene of which nothing was learned.
    World(World),
    /// In the scene that was learned.
    Model(Model),
    /// A model in a scene that is not the one that was learned.
    Changed(Model, ChangedScene),
}

impl Asked {
    /// Loads a scene or a model; a model may be asked in another scene.
    pub fn load(file: &Path, other: Option<&Path>, load: &LoadArgs) -> anyhow::Result<Self> {
        match (kind_of(file)?, other) {
            (FileKind::Scene, None) => {
                let scene = load_scene(file, load)?;
                tell_warnings(&scene);
                Ok(Self::World(world_of(scene)))
            }
            (FileKind::Scene, Some(path)) => {
                let scene = load_world(&load_scene(file, load)?, path, load)?;
                tell_warnings(&scene);
                Ok(Self::World(world_of(scene)))
            }
            (FileKind::Model, None) => Ok(Self::Model(load_model(file)?)),
            (FileKind::Model, Some(path)) => {
                let model = load_model(file)?;
                let scene = load_world(model.scene(), path, load)?;
                let changed = busy("preparing the changed scene", || {
                    ChangedScene::new(model.world(), scene).inspect(|changed| {
                        changed.world().view();
                    })
                });
                let changed = changed.with_context(|| format!("{} does not fit the model", path.display()))?;
                Ok(Self::Changed(model, changed))
            }
        }
    }

    /// Another scene, without what was learned.
    pub fn in_scene(self, scene: Scene) -> Self {
        let world = match &self {
            Self::World(world) => world.with_scene(scene),
            Self::Model(model) => model.world().with_scene(scene),
            Self::Changed(_, changed) => changed.world().with_scene(scene),
        };
        Self::World(world)
    }

    /// What queries are answered from.
    pub fn view(&self) -> View<'_> {
        match self {
            Self::World(world) => world.view(),
            Self::Model(model) => model.view(),
            Self::Changed(model, changed) => model.in_scene(changed),
        }
    }

    /// In which scene it is asked.
    pub fn scene(&self) -> &Scene {
        self.view().scene()
    }
}

/// What is asked, how, and memory for it.
pub struct Asker<'a> {
    asked: &'a Asked,
    options: QueryOptions,
    scratch: QueryScratch,
    stream: Option<Stream>,
}

/// An answer, if anything free was found, and how long it took \[s\].
pub type Timed = (Option<Answer>, f64);

impl<'a> Asker<'a> {
    /// Where a stream is given, queries are its frames.
    pub fn new(asked: &'a Asked, options: QueryOptions, stream: Option<StreamOptions>) -> Self {
        Self { asked, options, scratch: QueryScratch::default(), stream: stream.map(Stream::new) }
    }

    /// So that the first answers do not take twice as long as the others.
    pub fn warm_up(&mut self, duration: Duration) {
        match self.asked {
            // Who asks without a model wants the first answer soon.
            Asked::World(_) => {}
            Asked::Model(model) => model.view().warm_up(&self.options, &mut self.scratch, duration),
            // What is remembered of pairs in one scene means nothing in another.
            Asked::Changed(model, _) => {
                model.view().warm_up(&self.options, &mut QueryScratch::default(), duration);
            }
        }
    }

    /// Answers in the order of the queries.
    pub fn ask(&mut self, queries: Vec<Config>, threads: usize) -> Vec<Timed> {
        if threads == 1 || queries.len() == 1 {
            return queries.iter().map(|q| self.ask_one(q)).collect();
        }
        let mut answers = Vec::with_capacity(queries.len());
        let mut each = |answered: Answered<Option<Answer>>| {
            answers.push((answered.answer, answered.seconds));
            ControlFlow::Continue(())
        };
        self.asked.view().query_batch(queries, &self.options, threads, &mut each);
        answers
    }

    fn ask_one(&mut self, q: &Config) -> Timed {
        let started = Instant::now();
        let view = self.asked.view();
        let answer = match &mut self.stream {
            None => view.query_with(q, &self.options, &mut self.scratch),
            Some(stream) => view.query_next(q, stream),
        };
        (answer, started.elapsed().as_secs_f64())
    }
}
