//! State that the clones of a solver share: the scene, the model, and what is prepared of both.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::memory::Memory;
use super::preparing::{apart, fits, is_small_change};
use crate::error::Result;
use crate::model::Model;
use crate::query::prepared::Prepared;
use crate::scene::Scene;

pub struct Shared {
    pub scene: Arc<Scene>,
    pub learned: Option<Learned>,
    /// Scratch memory, shared with the states that are made from this one.
    pub memory: Arc<Memory>,
    /// State that this one was made from, whose prepared parts are reused. It is released
    /// afterwards; otherwise a long row of small changes would keep all states.
    before: Mutex<Option<Arc<Shared>>>,
    /// Checker, metric and the data that bounds need.
    prepared: OnceLock<Arc<Prepared>>,
    /// Set once the convex pieces around meshes are made too.
    pieces: OnceLock<()>,
}

/// A model, and whether the scene is its own.
#[derive(Clone)]
pub struct Learned {
    pub model: Arc<Model>,
    /// Whether the scene is the one that the model was learned in. In another one its samples are
    /// starts that may collide.
    pub is_at_home: bool,
}

impl Shared {
    /// Makes the state of a scene, which reuses what is prepared in `before`.
    pub fn new(scene: Arc<Scene>, learned: Option<Learned>, before: Option<Arc<Self>>) -> Self {
        let memory = before.as_ref().map(|before| Arc::clone(&before.memory)).unwrap_or_default();
        let (prepared, pieces) = (OnceLock::new(), OnceLock::new());
        Self { scene, learned, memory, before: Mutex::new(before), prepared, pieces }
    }

    /// Makes the state of a model in its own scene.
    pub fn at_home(model: Arc<Model>) -> Self {
        let scene = Arc::clone(model.prepared().scene());
        Self::new(scene, Some(Learned { model, is_at_home: true }), None)
    }

    /// Makes the state of a model in `scene`, which may be its own.
    ///
    /// # Errors
    /// Those of [`fits`].
    pub fn of_learned(self: &Arc<Self>, model: Arc<Model>, scene: Arc<Scene>) -> Result<Self> {
        let learned = model.prepared().scene();
        if Arc::ptr_eq(learned, &scene) || learned.is_like(&scene) {
            return Ok(Self::at_home(model));
        }
        fits(learned, &scene)?;
        Ok(Self::new(scene, Some(Learned { model, is_at_home: false }), self.passed_on()))
    }

    /// Returns the state whose prepared parts the next scene reuses: this one, or the one before if
    /// nothing is prepared here.
    pub fn passed_on(self: &Arc<Self>) -> Option<Arc<Self>> {
        match (self.prepared.get(), &self.learned) {
            (Some(_), _) | (None, Some(Learned { is_at_home: true, .. })) => Some(Arc::clone(self)),
            (None, Some(Learned { model, .. })) => {
                self.before().or_else(|| Some(Arc::new(Self::at_home(Arc::clone(model)))))
            }
            (None, None) => self.before(),
        }
    }

    fn before(&self) -> Option<Arc<Self>> {
        self.before.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns what is prepared of this scene, of the one before, or of the model's own scene.
    fn available(&self) -> Option<Arc<Prepared>> {
        let own = self.prepared.get().cloned();
        own.or_else(|| self.before()?.available())
            .or_else(|| self.learned.as_ref().map(|learned| Arc::clone(learned.model.prepared())))
    }

    /// Returns the checker, the metric and the data of bounds; the first call prepares them.
    pub fn prepared(&self) -> &Arc<Prepared> {
        if let Some(prepared) = self.prepared.get() {
            return prepared;
        }
        let prepare = || {
            let (before, scene) = (self.available(), &self.scene);
            let make = || match &before {
                Some(before) if Arc::ptr_eq(before.scene(), scene) => Arc::clone(before),
                Some(before) => before.with_scene(Arc::clone(scene)).into(),
                None => Prepared::new(Arc::clone(scene)).into(),
            };
            match &before {
                Some(before) if is_small_change(before.scene(), scene) => make(),
                _ => apart(&make),
            }
        };
        let prepared = self.prepared.get_or_init(prepare);
        *self.before.lock().unwrap_or_else(PoisonError::into_inner) = None;
        prepared
    }

    /// Does the same as [`Shared::prepared`], and prepares the convex pieces that queries start
    /// from.
    pub fn ready(&self) -> &Arc<Prepared> {
        let prepared = self.prepared();
        self.pieces.get_or_init(|| match prepared.checker().lacks_pieces() {
            true => apart(&|| prepared.checker().prepare_proposals()),
            false => prepared.checker().prepare_proposals(),
        });
        prepared
    }

    /// Returns whether [`Shared::prepared`] has nothing left to do.
    pub fn has_checker(&self) -> bool {
        self.prepared.get().is_some()
    }

    /// Returns whether [`Shared::ready`] has nothing left to do.
    pub fn is_ready(&self) -> bool {
        self.pieces.get().is_some()
    }
}
