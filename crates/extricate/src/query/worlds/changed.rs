//! Queries against a scene that is not the one that was learned: obstacles moved, appeared or went.

use std::sync::Arc;

use super::World;
use crate::collision::Checker;
use crate::error::{Error, Result};
use crate::query::context::{Context, Stored};
use crate::scene::{MetricKind, Scene};

/// A scene in which a model of another is queried: its checker, metric and what its bounds stand
/// on. Immutable; share it between threads.
pub struct ChangedScene {
    world: World,
}

impl ChangedScene {
    /// Prepares `scene` for a model that was learned for `world`, see [`crate::Model::world`];
    /// what is prepared of equal bodies is shared. Obstacles, checked pairs and clearance may
    /// differ; what stored configurations and distances between them mean must not.
    ///
    /// # Errors
    /// [`Error::Input`] where coordinates, limits, weights or the metric differ; for the metrics of
    /// displacement, also where what moves does.
    pub fn new(world: &World, scene: impl Into<Arc<Scene>>) -> Result<Self> {
        let (learned, scene) = (world.scene(), scene.into());
        let differs = |element: &str, problem: String| Err(Error::input("changed scene", element, problem));
        if scene.metric != learned.metric {
            let problem = format!("got {}, expected that of the model, {}", scene.metric.name(), learned.metric.name());
            return differs("metric", problem);
        }
        if scene.space != learned.space {
            let (new, old) = (scene.space.factors(), learned.space.factors());
            let at = new.iter().zip(old).position(|(a, b)| a != b).unwrap_or(new.len().min(old.len()));
            let name = new.get(at).or(old.get(at)).map_or("", |factor| &factor.name);
            let problem = "got other coordinates, limits or weights than the model's, expected the same: learn it anew";
            return differs(&format!("joint \"{name}\""), problem.into());
        }
        if scene.metric != MetricKind::Joint
            && (scene.frames != learned.frames || !scene.moving_bodies().eq(learned.moving_bodies()))
        {
            let problem = "got other moving bodies than the model's, by which its metric measures: learn it anew";
            return differs("robots", problem.into());
        }
        Ok(Self { world: world.with_scene(scene) })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.world.scene()
    }

    /// The same, ready to be queried without a model.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Its exact checker.
    pub fn checker(&self) -> &Checker {
        self.world.checker()
    }

    /// What queries stand on, with what a model of another scene has stored.
    pub(crate) fn context<'a>(&'a self, stored: Stored<'a>) -> Context<'a> {
        self.world.with(Some(stored)).elsewhere()
    }
}
