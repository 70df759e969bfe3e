//! What a scene handle holds: a scene, perhaps with what a model learned, prepared when it is first
//! needed.

use std::ffi::CString;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use extricate::internals::io::check_regular;
use extricate::internals::io::model_file::is_model;
use extricate::internals::scene::units;
use extricate::{ChangedScene, Config, Model, Scene, View, World, load_model, load_scene};

use crate::status::{Result, c_string};

/// As much of a file as tells whether it is a model \[bytes\].
const HEAD: u64 = 4096;

/// A scene that queries are about. Immutable but for what is prepared once.
pub struct Asked {
    scene: Arc<Scene>,
    origin: Origin,
    prepared: OnceLock<Result<Prepared>>,
    names: OnceLock<Names>,
}

/// What is known before anything is prepared.
enum Origin {
    /// A scene alone, and the one that it was made from, to share what did not change; that one is
    /// let go once it is used, or a long row of small changes would keep all.
    Scene(Mutex<Option<Arc<Asked>>>),
    /// What was learned of this scene.
    Learned(Arc<Model>),
    /// What was learned of another one.
    Changed(Arc<Model>),
}

enum Prepared {
    World(World),
    Learned(Arc<Model>),
    Changed(Arc<Model>, ChangedScene),
}

/// Names as C reads them.
pub struct Names {
    /// Of joints.
    pub joints: Vec<CString>,
    /// Of bodies.
    pub bodies: Vec<CString>,
    /// What the user should know.
    pub warnings: Vec<CString>,
}

impl Asked {
    /// A scene of which nothing was learned.
    pub fn of_scene(scene: Scene) -> Self {
        Self::new(scene.into(), Origin::Scene(Mutex::default()))
    }

    /// A model, asked in its own scene.
    pub fn of_model(model: Model) -> Self {
        let scene = Arc::clone(model.checker().scene_arc());
        Self::new(scene, Origin::Learned(model.into()))
    }

    fn new(scene: Arc<Scene>, origin: Origin) -> Self {
        Self { scene, origin, prepared: OnceLock::new(), names: OnceLock::new() }
    }

    /// A scene file, a URDF or a model file.
    pub fn load(path: &Path) -> Result<Self> {
        let mut head = Vec::new();
        // What cannot be read, and a pipe, on which opening would wait, is refused below in the
        // library's words.
        if let Ok(file) = check_regular(path).and_then(|_| File::open(path)) {
            let _ = file.take(HEAD).read_to_end(&mut head);
        }
        if is_model(&head) {
            return Ok(Self::of_model(load_model(path)?));
        }
        Ok(Self::of_scene(load_scene(path)?))
    }

    /// This scene with something changed; what is prepared of the rest is shared.
    pub fn changed(self: &Arc<Self>, scene: Scene) -> Self {
        let origin = match &self.origin {
            Origin::Learned(model) | Origin::Changed(model) => Origin::Changed(Arc::clone(model)),
            Origin::Scene(before) => {
                let own = self.prepared.get().map(|_| Arc::clone(self));
                let before = || before.lock().unwrap_or_else(PoisonError::into_inner).clone();
                Origin::Scene(Mutex::new(own.or_else(before)))
            }
        };
        Self::new(scene.into(), origin)
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Whether anything was learned, of this scene or another one.
    pub fn model(&self) -> Option<&Arc<Model>> {
        match &self.origin {
            Origin::Scene(_) => None,
            Origin::Learned(model) | Origin::Changed(model) => Some(model),
        }
    }

    /// The model of this very scene.
    pub fn learned(&self) -> Option<&Model> {
        if let Origin::Learned(model) = &self.origin { Some(model) } else { None }
    }

    /// What queries are answered from; the first call prepares it.
    ///
    /// # Errors
    /// Where a model cannot be asked in the scene.
    pub fn view(&self) -> Result<View<'_>> {
        match self.prepared()? {
            Prepared::World(world) => Ok(world.view()),
            Prepared::Learned(model) => Ok(model.view()),
            Prepared::Changed(model, changed) => Ok(model.in_scene(changed)),
        }
    }

    /// The scene, without what was learned; the first call prepares it.
    ///
    /// # Errors
    /// As [`Asked::view`].
    pub fn world(&self) -> Result<&World> {
        match self.prepared()? {
            Prepared::World(world) => Ok(world),
            Prepared::Learned(model) => Ok(model.world()),
            Prepared::Changed(_, changed) => Ok(changed.world()),
        }
    }

    fn prepared(&self) -> Result<&Prepared> {
        self.prepared.get_or_init(|| self.prepare()).as_ref().map_err(Clone::clone)
    }

    fn prepare(&self) -> Result<Prepared> {
        let scene = || Arc::clone(&self.scene);
        let prepared = match &self.origin {
            Origin::Learned(model) => Prepared::Learned(Arc::clone(model)),
            Origin::Changed(model) => Prepared::Changed(Arc::clone(model), ChangedScene::new(model.world(), scene())?),
            Origin::Scene(before) => {
                let before = before.lock().unwrap_or_else(PoisonError::into_inner).take();
                match before.as_ref().and_then(|before| before.prepared.get()) {
                    Some(Ok(Prepared::World(world))) => Prepared::World(world.with_scene(scene())),
                    _ => Prepared::World(World::new(scene())),
                }
            }
        };
        Ok(prepared)
    }

    /// Names of joints and bodies, and warnings.
    pub fn names(&self) -> &Names {
        self.names.get_or_init(|| Names {
            joints: self.scene.joints.iter().map(|joint| c_string(&joint.name)).collect(),
            bodies: self.scene.bodies.iter().map(|body| c_string(&body.name)).collect(),
            warnings: self.scene.warnings.iter().map(|warning| c_string(warning)).collect(),
        })
    }

    /// A configuration; beyond the limits too, unless those are refused.
    ///
    /// # Errors
    /// Of the wrong length, not finite, or refused.
    pub fn config(&self, q: &[f64], refuse_outside: bool) -> Result<Config> {
        let config = match refuse_outside {
            true => units::config(&self.scene, q),
            false => self.scene.space.config_anywhere(q),
        };
        Ok(config?)
    }
}

#[cfg(test)]
mod tests {
    use extricate::builtin;

    use super::*;

    #[test]
    fn changes_share_and_let_go() {
        let first = Arc::new(Asked::of_scene(builtin::scene("planar-arm").unwrap()));
        let unprepared = Arc::new(first.changed(first.scene().without_obstacles()));
        assert!(first.view().is_ok() && unprepared.view().is_ok());
        let second = Arc::new(first.changed(first.scene().without_obstacles()));
        assert_eq!(Arc::strong_count(&first), 2, "kept until the second is prepared");
        let third = second.changed(first.scene().clone());
        assert_eq!(Arc::strong_count(&first), 3, "what was never prepared passes on what it has");
        let q = first.config(&[0.4, 0.0, 0.0], true).unwrap();
        let answers = [&*first, &second, &third].map(|asked| asked.view().unwrap().query(&q).unwrap());
        assert_eq!(Arc::strong_count(&first), 1);
        assert!(answers[0].depth > 0.0);
        assert_eq!(answers[0], answers[2]);
        assert_eq!(answers[1].depth, 0.0);
    }

    #[test]
    fn models_and_scenes_are_told_by_their_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm.model");
        let options = extricate::LearnOptions { labels: 2_000, ..Default::default() };
        let model = Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap();
        extricate::save_model(&model, &path).unwrap();
        let loaded = Arc::new(Asked::load(&path).unwrap());
        assert!(loaded.learned().is_some() && loaded.view().is_ok());
        let changed = loaded.changed(loaded.scene().without_obstacles());
        assert!(changed.learned().is_none() && changed.model().is_some() && changed.view().is_ok());
        let missing = Asked::load(&folder.path().join("none.toml")).map(drop).unwrap_err();
        assert!(missing.message.contains("none.toml"), "{missing:?}");
        assert!(Asked::load(folder.path()).map(drop).unwrap_err().message.contains("directory"));
        assert_eq!(loaded.names().joints.len(), 3);
        assert!(loaded.config(&[0.0, 9.0, 0.0], true).is_err() && loaded.config(&[0.0, 9.0, 0.0], false).is_ok());
    }
}
