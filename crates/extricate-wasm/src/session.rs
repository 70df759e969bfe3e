//! An open scene or model, and the requests that it answers.

use extricate::geometry::Pose;
use extricate::{Model, QueryOptions, Scene, Solver};
use extricate_view::{AnswerData, Detail, Inspector};
use serde::Deserialize;

/// Largest number of cells along each side of a slice; more are finer than a screen.
const MAX_CELLS: usize = 512;
/// Largest number of exits of a query.
const MAX_EXITS: usize = 9;

/// An open scene or model.
pub struct Session {
    solver: Solver,
}

#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
enum Request {
    /// Answers a query, as [`extricate_view::AnswerData`].
    Query {
        q: Vec<f64>,
        /// Number of distinct exits to find.
        exits: usize,
        /// Cells along each side of the slice; 0 for none.
        cells: usize,
    },
    /// Judges a path of straight segments from waypoint to waypoint, as
    /// [`extricate_view::AnswerData`].
    Path { path: Vec<Vec<f64>> },
    /// Moves obstacles to poses in world coordinates: columns of the rotation, then the translation
    /// \[m\].
    Move { obstacles: Vec<(String, [f64; 12])> },
}

impl Session {
    /// Opens the bytes of a model file or of a scene.
    ///
    /// # Errors
    /// Reports a fault of the bytes.
    pub fn open(bytes: &[u8]) -> Result<Self, String> {
        let solver = if Model::is_model(bytes) {
            Solver::of_model(Model::from_bytes("the page's model", bytes).map_err(in_words)?)
        } else {
            Solver::new(Scene::from_bytes(bytes).map_err(in_words)?)
        };
        Ok(Self { solver })
    }

    /// Enters another scene, given as bytes, and keeps what a model has learned.
    ///
    /// # Errors
    /// Reports a fault of the bytes, or why the scene does not fit the model.
    pub fn enter(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.change(Scene::from_bytes(bytes).map_err(in_words)?)
    }

    /// Answers a request in JSON with a reply in JSON.
    ///
    /// # Errors
    /// Reports a fault of the request.
    pub fn call(&mut self, request: &[u8]) -> Result<String, String> {
        match serde_json::from_slice(request).map_err(|error| format!("request: {error}"))? {
            Request::Query { q, exits, cells } => self.query(&q, exits.min(MAX_EXITS), cells.min(MAX_CELLS)),
            Request::Path { path } => self.path(&path),
            Request::Move { obstacles } => self.move_to(&obstacles),
        }
    }

    fn query(&self, q: &[f64], exits: usize, cells: usize) -> Result<String, String> {
        let solver = self.solver.clone().options(QueryOptions::default().exits(exits)).map_err(in_words)?;
        let q = solver.scene().space().config_anywhere(q).map_err(in_words)?;
        let answer = solver.query(&q);
        let detail = Detail { slice_cells: cells, ..Detail::default() };
        in_json(&Inspector::new(&solver, detail).answer_data(&q, answer, None))
    }

    fn path(&self, path: &[Vec<f64>]) -> Result<String, String> {
        let config = |q: &Vec<f64>| self.solver.scene().space().config_anywhere(q).map_err(in_words);
        let [first, rest @ ..] = &path.iter().map(config).collect::<Result<Vec<_>, _>>()?[..] else {
            return Err("path: got no waypoints, expected at least one".into());
        };
        in_json(&Inspector::new(&self.solver, Detail::default()).path_data(first, rest))
    }

    fn move_to(&mut self, obstacles: &[(String, [f64; 12])]) -> Result<String, String> {
        let pose = |numbers: &[f64; 12]| {
            let [x, y, z, origin] = [0, 3, 6, 9].map(|at| [numbers[at], numbers[at + 1], numbers[at + 2]]);
            Pose::new([x, y, z], origin)
        };
        let poses = obstacles.iter().map(|(name, numbers)| (name.as_str(), pose(numbers)));
        let scene = self.solver.scene().moved(poses).map_err(in_words)?;
        self.change(scene)?;
        Ok("{}".into())
    }

    fn change(&mut self, scene: Scene) -> Result<(), String> {
        self.solver = self.solver.with_scene(scene).map_err(in_words)?;
        Ok(())
    }
}

fn in_json(data: &AnswerData) -> Result<String, String> {
    serde_json::to_string(data).map_err(|error| error.to_string())
}

fn in_words(error: extricate::Error) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::{Answer, Label, LearnOptions, Sampler, builtin};
    use serde_json::{Value, json};
    use std::ops::ControlFlow;

    fn opened() -> (Session, Scene) {
        let scene = builtin::scene("planar-arm").unwrap();
        (Session::open(&scene.to_bytes()).unwrap(), scene)
    }

    /// A link is inside an obstacle at this configuration.
    const COLLIDING: [f64; 3] = [0.4, 0.0, 0.0];

    fn colliding(scene: &Scene) -> Vec<f64> {
        let solver = Solver::new(scene.clone());
        let drawn = Sampler::new(&solver, Some(Label::Colliding), 0).draw(1, &mut |_, _| ControlFlow::Continue(()));
        drawn.unwrap().remove(0)
    }

    fn ask(solver: &Solver, q: &[f64], exits: usize) -> Option<Answer> {
        let q = solver.scene().config(q).unwrap();
        solver.clone().options(QueryOptions::default().exits(exits)).unwrap().query(&q)
    }

    fn call(session: &mut Session, request: &Value) -> Value {
        serde_json::from_str(&session.call(request.to_string().as_bytes()).unwrap()).unwrap()
    }

    #[test]
    fn a_request_is_answered_as_the_library_does() {
        let (mut session, scene) = opened();
        let found = call(&mut session, &json!({ "do": "query", "q": COLLIDING, "exits": 3, "cells": 16 }));
        assert_eq!(found["answer"], serde_json::to_value(ask(&Solver::new(scene), &COLLIDING, 3)).unwrap());
        assert_eq!(found["slice"]["cells"], 16);
    }

    #[test]
    fn a_path_is_judged_as_in_a_written_page() {
        let (mut session, scene) = opened();
        let far = [1.4, 0.3, -0.2];
        let found = call(&mut session, &json!({ "do": "path", "path": [COLLIDING, far, COLLIDING] }));
        let solver = Solver::new(scene);
        let [hit, free] = [COLLIDING, far].map(|q| solver.scene().config(&q).unwrap());
        let data = Inspector::new(&solver, Detail::default()).path_data(&hit, &[free, hit.clone()]);
        // Numbers of single precision are equal once both are read from text.
        let expected: Value = serde_json::from_str(&serde_json::to_string(&data).unwrap()).unwrap();
        assert_eq!(found, expected);
        assert_eq!(
            (&found["played"]["path"]["waypoints"], found["exits"][0]["distances"].as_array().unwrap().len()),
            (&3.into(), 101)
        );
    }

    #[test]
    fn an_obstacle_that_was_moved_stays_there() {
        let (mut session, scene) = opened();
        let query = json!({ "do": "query", "q": COLLIDING, "exits": 1, "cells": 0 });
        let before = call(&mut session, &query);
        let names: Vec<&str> = scene.bodies().iter().filter(|b| b.is_obstacle()).map(|b| b.name.as_str()).collect();
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
        let learned = Model::learn(scene.clone(), &LearnOptions::default().labels(2000)).unwrap();
        let elsewhere = Pose::at([0.57, 0.27, 0.0]);
        let other = scene.moved([("cylinder_1", elsewhere)]).unwrap();
        let mut session = Session::open(&learned.to_bytes()).unwrap();
        session.enter(&other.to_bytes()).unwrap();
        let q = colliding(&other);
        let found = call(&mut session, &json!({ "do": "query", "q": q, "exits": 2, "cells": 0 }));
        let solver = Solver::of_model(learned).with_scene(other).unwrap();
        assert_eq!(found["answer"], serde_json::to_value(ask(&solver, &q, 2)).unwrap());
        // The stored samples are used: without a model the same query takes a different number of
        // checks.
        assert_ne!(found["answer"]["checks"], ask(&solver.without_model(), &q, 2).unwrap().checks);
        assert!(session.enter(b"nothing").unwrap_err().contains("no scene of this version"));
        assert!(!session.enter(&builtin::scene("hand").unwrap().to_bytes()).unwrap_err().is_empty());
    }

    #[test]
    fn what_cannot_be_done_is_said() {
        assert!(Session::open(b"nothing").err().unwrap().contains("no scene of this version"));
        let (mut session, _) = opened();
        for (request, part) in [
            ("{", "request"),
            (r#"{"do": "query", "q": [0], "exits": 1, "cells": 0}"#, "expected"),
            (r#"{"do": "move", "obstacles": [["nowhere", [1,0,0,0,1,0,0,0,1,0,0,0]]]}"#, "nowhere"),
            (r#"{"do": "path", "path": []}"#, "waypoints"),
            (r#"{"do": "path", "path": [[0, 0, 0], [0]]}"#, "expected"),
            (r#"{"do": "fly"}"#, "fly"),
        ] {
            let error = session.call(request.as_bytes()).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
