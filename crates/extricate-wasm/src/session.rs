//! A scene or a model that is open, and the requests that it answers.

use std::path::Path;
use std::sync::Arc;

use extricate::geometry::{Mat3, Pose, Vec3};
use extricate::internals::io::model_file;
use extricate::internals::metric::Metric;
use extricate::internals::scene::assemble::sound;
use extricate::{ChangedScene, Model, QueryOptions, QueryScratch, Scene, View, World};
use extricate_view::{Detail, Inspector};
use serde::Deserialize;

/// Most cells to each side of a slice: more are finer than a screen.
const MOST_CELLS: usize = 512;
/// Most exits.
const MOST_EXITS: usize = 9;

/// What is open.
pub struct Session {
    base: Base,
    /// The scene with its obstacles where they were moved to.
    changed: Option<Changed>,
    metric: Arc<Metric>,
    scratch: QueryScratch,
}

#[expect(clippy::large_enum_variant, reason = "there is one")]
enum Base {
    World(World),
    Model(Model),
}

enum Changed {
    World(World),
    Model(ChangedScene),
}

/// A request.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
enum Request {
    /// The answer to a query, as [`extricate_view::AnswerData`].
    Query {
        q: Vec<f64>,
        /// How many distinct exits are wanted.
        exits: usize,
        /// Cells to each side of the slice; 0 for none.
        cells: usize,
    },
    /// Puts obstacles elsewhere: columns of the rotation, then the translation \[m\], world
    /// coordinates.
    Move { obstacles: Vec<(String, [f64; 12])> },
}

impl Session {
    /// Opens the bytes of a model file, or those of a scene as `postcard` writes them.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn open(bytes: &[u8]) -> Result<Self, String> {
        let base = if model_file::is_model(bytes) {
            let model = model_file::decode(Path::new("the page's model"), bytes).map_err(|error| error.to_string())?;
            Base::Model(model)
        } else {
            Base::World(World::new(scene_of(bytes)?))
        };
        let metric = Arc::new(Metric::new(base.view().checker().scene_arc().clone()));
        Ok(Self { base, changed: None, metric, scratch: QueryScratch::default() })
    }

    /// Asks in another scene, whose bytes are those of `postcard`; what a model has learned stays.
    ///
    /// # Errors
    /// What is wrong with the bytes, or why the scene does not fit the model.
    pub fn enter(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.change(scene_of(bytes)?)?;
        let entered = view(&self.base, self.changed.as_ref());
        self.metric = Arc::new(Metric::new(entered.checker().scene_arc().clone()));
        Ok(())
    }

    /// Answers a request, JSON for JSON.
    ///
    /// # Errors
    /// What is wrong with the request.
    pub fn call(&mut self, request: &[u8]) -> Result<String, String> {
        match serde_json::from_slice(request).map_err(|error| format!("request: {error}"))? {
            Request::Query { q, exits, cells } => self.query(&q, exits.min(MOST_EXITS), cells.min(MOST_CELLS)),
            Request::Move { obstacles } => self.move_to(&obstacles),
        }
    }

    fn query(&mut self, q: &[f64], exits: usize, cells: usize) -> Result<String, String> {
        let Self { base, changed, metric, scratch } = self;
        let view = view(base, changed.as_ref());
        let q = view.scene().space.config_anywhere(q).map_err(|error| error.to_string())?;
        let options = QueryOptions { exits, ..QueryOptions::default() };
        let answer = view.query_with(&q, &options, scratch);
        let mut inspector = Inspector::with_metric(view.checker(), metric.clone(), Detail { slice_cells: cells });
        let data = inspector.answer_data(&q, answer, None);
        serde_json::to_string(&data).map_err(|error| error.to_string())
    }

    fn move_to(&mut self, obstacles: &[(String, [f64; 12])]) -> Result<String, String> {
        let pose = |numbers: &[f64; 12]| Pose {
            rotation: Mat3::from_column_slice(&numbers[..9]),
            translation: Vec3::from_column_slice(&numbers[9..]),
        };
        let poses = obstacles.iter().map(|(name, numbers)| (name.as_str(), pose(numbers)));
        let here = view(&self.base, self.changed.as_ref()).scene();
        let scene = here.moved(poses).map_err(|error| error.to_string())?;
        self.change(scene)?;
        Ok("{}".into())
    }

    fn change(&mut self, scene: Scene) -> Result<(), String> {
        self.changed = Some(match (&self.base, &self.changed) {
            (_, Some(Changed::World(world))) => Changed::World(world.with_scene(scene)),
            (Base::World(world), _) => Changed::World(world.with_scene(scene)),
            (Base::Model(model), _) => {
                let changed = ChangedScene::new(model.world(), scene).map_err(|error| error.to_string())?;
                Changed::Model(changed)
            }
        });
        // What was remembered of pairs means nothing where they are elsewhere.
        self.scratch = QueryScratch::default();
        Ok(())
    }
}

fn scene_of(bytes: &[u8]) -> Result<Scene, String> {
    let wrong = |error: String| format!("got bytes that are no scene of this version ({error})");
    let scene: Scene = postcard::from_bytes(bytes).map_err(|error| wrong(error.to_string()))?;
    sound::check(&scene).map_err(wrong)?;
    Ok(scene)
}

impl Base {
    fn view(&self) -> View<'_> {
        match self {
            Self::World(world) => world.view(),
            Self::Model(model) => model.view(),
        }
    }
}

fn view<'a>(base: &'a Base, changed: Option<&'a Changed>) -> View<'a> {
    match (base, changed) {
        (_, Some(Changed::World(world))) => world.view(),
        (Base::Model(model), Some(Changed::Model(changed))) => model.in_scene(changed),
        _ => base.view(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::internals::cspace::sampling::Halton;
    use extricate::{CheckScratch, Checker, LearnOptions, builtin};
    use serde_json::{Value, json};

    fn opened() -> (Session, Scene) {
        let scene = builtin::scene("planar-arm").unwrap();
        (Session::open(&postcard::to_stdvec(&scene).unwrap()).unwrap(), scene)
    }

    /// A configuration in collision.
    fn colliding(scene: &Scene) -> Vec<f64> {
        let checker = Checker::new(Arc::new(scene.clone()));
        let (halton, mut q) = (Halton::new(scene.space.nv(), 0), vec![0.0; scene.space.nq()]);
        let first = (1..).find(|&index| {
            halton.config(&scene.space, index, &mut q);
            checker.colliding_pair(&q, &mut CheckScratch::default()).is_some()
        });
        assert!(first.is_some());
        q
    }

    fn call(session: &mut Session, request: &Value) -> Value {
        serde_json::from_str(&session.call(request.to_string().as_bytes()).unwrap()).unwrap()
    }

    #[test]
    fn a_request_is_answered_as_the_library_does() {
        let (mut session, scene) = opened();
        let q = colliding(&scene);
        let found = call(&mut session, &json!({ "do": "query", "q": q, "exits": 3, "cells": 16 }));
        let world = World::new(scene);
        let options = QueryOptions { exits: 3, ..QueryOptions::default() };
        let expected = world.solver(options).query(&world.scene().config(&q).unwrap());
        assert_eq!(found["answer"], serde_json::to_value(expected).unwrap());
        assert_eq!(found["slice"]["cells"], 16);
    }

    #[test]
    fn an_obstacle_that_was_moved_stays_there() {
        let (mut session, scene) = opened();
        let query = json!({ "do": "query", "q": colliding(&scene), "exits": 1, "cells": 0 });
        let before = call(&mut session, &query);
        let names: Vec<&str> = scene.bodies.iter().filter(|b| b.is_obstacle()).map(|b| b.name.as_str()).collect();
        let far = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 50.0, 50.0, 50.0];
        let moved: Vec<(&str, [f64; 12])> = names.iter().map(|name| (*name, far)).collect();
        call(&mut session, &json!({ "do": "move", "obstacles": moved }));
        let after = call(&mut session, &query);
        assert!(before["answer"]["depth"].as_f64() > Some(0.0));
        assert_eq!(after["answer"]["depth"], 0.0);
    }

    #[test]
    fn a_model_is_asked_in_another_world_as_the_library_does() {
        let scene = builtin::scene("planar-arm").unwrap();
        let learned = Model::learn(scene.clone(), &LearnOptions { labels: 2000, ..LearnOptions::default() }).unwrap();
        let elsewhere = Pose { rotation: Mat3::identity(), translation: Vec3::new(0.57, 0.27, 0.0) };
        let other = scene.moved([("cylinder_1", elsewhere)]).unwrap();
        let mut session = Session::open(&model_file::encode(&learned)).unwrap();
        session.enter(&postcard::to_stdvec(&other).unwrap()).unwrap();
        let q = colliding(&other);
        let found = call(&mut session, &json!({ "do": "query", "q": q, "exits": 2, "cells": 0 }));
        let changed = ChangedScene::new(learned.world(), other).unwrap();
        let options = QueryOptions { exits: 2, ..QueryOptions::default() };
        let view = learned.in_scene(&changed);
        let expected = view.query_with(&view.scene().config(&q).unwrap(), &options, &mut QueryScratch::default());
        assert_eq!(found["answer"], serde_json::to_value(expected).unwrap());
        // The stored samples are used: without a model the same query takes other checks.
        let world = World::new(changed.scene().clone()).view().query_with(
            &view.scene().config(&q).unwrap(),
            &options,
            &mut QueryScratch::default(),
        );
        assert_ne!(found["answer"]["checks"], world.unwrap().checks);
        assert!(session.enter(b"nothing").unwrap_err().contains("no scene of this version"));
        let hand = postcard::to_stdvec(&builtin::scene("hand").unwrap()).unwrap();
        assert!(!session.enter(&hand).unwrap_err().is_empty());
    }

    #[test]
    fn what_cannot_be_done_is_said() {
        assert!(Session::open(b"nothing").err().unwrap().contains("no scene of this version"));
        let (mut session, _) = opened();
        for (request, part) in [
            ("{", "request"),
            (r#"{"do": "query", "q": [0], "exits": 1, "cells": 0}"#, "expected"),
            (r#"{"do": "move", "obstacles": [["nowhere", [1,0,0,0,1,0,0,0,1,0,0,0]]]}"#, "nowhere"),
            (r#"{"do": "fly"}"#, "fly"),
        ] {
            let error = session.call(request.as_bytes()).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
