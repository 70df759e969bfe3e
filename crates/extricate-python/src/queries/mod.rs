//! What is asked, a scene or a model or a model in another scene, and the calls that they share.

pub mod answer;
pub mod batch;
pub mod layout;
pub mod options;
pub mod page;

use std::sync::atomic::{AtomicBool, Ordering};

use extricate::{Answer, ChangedScene, Config, Model, QueryOptions, QueryScratch, Scene, Termination, View, World};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Advice;
use crate::long_call;
use batch::{Scratches, answers};
use options::{Asked, BATCH, QUERY, Weighted};

/// What calls on one owner, a scene or a model, leave for later ones.
#[derive(Default)]
pub struct Memory {
    pub scratches: Scratches,
    /// The scene with the weights that were asked for last.
    pub weighted: Weighted,
    pub advice: Advice,
}

/// What is asked.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// A scene of which nothing was learned.
    World(&'a World),
    Model(&'a Model),
    /// A model in a scene that is not the one that was learned.
    Changed(&'a Model, &'a ChangedScene),
}

impl<'a> Source<'a> {
    /// The scene that is asked in, without what was learned.
    pub fn world(self) -> &'a World {
        match self {
            Self::World(world) => world,
            Self::Model(model) => model.world(),
            Self::Changed(_, changed) => changed.world(),
        }
    }

    pub fn scene(self) -> &'a Scene {
        self.world().scene()
    }

    /// What queries are answered from.
    pub fn view(self) -> View<'a> {
        match self {
            Self::World(world) => world.view(),
            Self::Model(model) => model.view(),
            Self::Changed(model, changed) => model.in_scene(changed),
        }
    }

    fn ask(self, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
        self.view().query_with(q, options, scratch)
    }
}

/// The answer of `owner` for one configuration as an object; `None` where nothing free was found,
/// with a warning if that is because some pairs collide wherever one looks.
pub fn query<'py>(
    source: Source,
    q: &Bound<'py, PyAny>,
    given: Option<&Bound<'py, PyDict>>,
    Memory { scratches, weighted, advice }: &Memory,
    owner: &Bound<'py, PyAny>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let (py, scene) = (q.py(), source.scene());
    let asked = Asked::read(given, scene, QUERY)?;
    let config = asked.config(q, scene)?;
    let other = asked.other_weights(py, source, weighted)?;
    let source = other.as_deref().map_or(source, Source::World);
    let watch = long_call::Watch::new();
    let options = QueryOptions {
        termination: Termination { stop: Some(watch.stop()), ..asked.options.termination.clone() },
        ..asked.options
    };
    let ask = || scratches.with(|scratch| source.ask(&config, &options, scratch));
    let Some(answer) = py.detach(|| watch.over(ask))? else {
        advice.warn(py, source.view().checker())?;
        return Ok(None);
    };
    let object = answer::object(py, answer, scene)?;
    // For `Answer.show`, which asks once more.
    object.setattr("_asked", (owner, PyArray1::from_slice(py, &config), given))?;
    Ok(Some(object))
}

/// The answers for many as a structured array.
pub fn query_batch<'py>(
    source: Source,
    queries: &Bound<'py, PyAny>,
    given: Option<&Bound<'py, PyDict>>,
    Memory { scratches, weighted, advice }: &Memory,
) -> PyResult<Bound<'py, PyAny>> {
    let asked = Asked::read(given, source.scene(), BATCH)?;
    let other = asked.other_weights(queries.py(), source, weighted)?;
    let source = other.as_deref().map_or(source, Source::World);
    let lacks_answers = AtomicBool::new(false);
    let ask = |q: &Config, options: &QueryOptions, scratch: &mut QueryScratch| {
        let answer = source.ask(q, options, scratch);
        lacks_answers.fetch_or(answer.is_none(), Ordering::Relaxed);
        answer
    };
    let all = answers(queries, source.scene(), scratches, asked, &ask)?;
    if lacks_answers.into_inner() {
        advice.warn(queries.py(), source.view().checker())?;
    }
    Ok(all)
}
