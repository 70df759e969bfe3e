//! Compares what C and C++ can do with what Python can. A table has each public call of the native
//! half of the Python package. It names the functions of `extricate.h` and the calls of
//! `extricate.hpp` that do the same, or says why there are none.

use std::collections::BTreeSet;

/// Where a call of Python is in C and C++.
enum There {
    /// Functions of `extricate.h`, and calls or members of `extricate.hpp`, `Class::name` or
    /// `name`.
    At(&'static [&'static str], &'static [&'static str]),
    /// The reason why there is none.
    Not(&'static str),
}
use There::{At, Not};

const TABLE: &[(&str, There)] = &[
    ("import_world", Not("it writes files, which the program `extricate import` does")),
    ("learn", At(&["extricate_learn"], &["Scene::learn"])),
    ("Joint.name", At(&["extricate_scene_joint_name"], &["Scene::joints"])),
    ("Joint.kind", Not("the number of coordinates and the limits tell it")),
    ("Joint.start", At(&["extricate_scene_joint_coordinates"], &[])),
    ("Joint.stop", At(&["extricate_scene_joint_coordinates"], &[])),
    ("Progress.stage", At(&["ExtricateProgress"], &["Scene::learn"])),
    ("Progress.fraction", At(&["ExtricateProgress"], &["Scene::learn"])),
    ("Progress.labels", At(&["ExtricateProgress"], &["Scene::learn"])),
    ("Progress.boundary_samples", At(&["ExtricateProgress"], &["Scene::learn"])),
    ("Progress.accuracy", At(&["ExtricateProgress"], &["Scene::learn"])),
    ("_Calls.query", At(&["extricate_query"], &["Solver::query"])),
    ("_Calls.signed_distance", At(&["extricate_signed_distances"], &["Solver::signed_distances"])),
    ("_Calls.free_radius", At(&["extricate_free_radius"], &["Solver::free_radius"])),
    ("_Calls.show", Not("the program `extricate view` writes the page")),
    ("_Calls.stream", At(&["extricate_stream_new"], &["Stream::Stream"])),
    ("_Calls.escape", At(&["extricate_escape"], &["Solver::escape"])),
    ("_Calls.plan", At(&["extricate_plan"], &["Solver::plan"])),
    ("_Calls.repair", At(&["extricate_repair"], &["Solver::repair"])),
    ("_Calls.release", At(&["extricate_hand_new", "extricate_release"], &["Hand::Hand", "Hand::release"])),
    ("Scene.__new__", At(&["extricate_scene_from_text"], &["Scene::from_text"])),
    ("Scene.load", At(&["extricate_load"], &["Scene::Scene"])),
    ("Scene.builtin", At(&["extricate_scene_builtin"], &["Scene::builtin"])),
    ("Scene.builtin_files", Not("the program writes them: `extricate demo --export`")),
    ("Scene.nq", At(&["extricate_scene_nq"], &["Scene::nq"])),
    ("Scene.nv", At(&["extricate_scene_nv"], &["Scene::nv"])),
    ("Scene.clearance", At(&["extricate_scene_clearance"], &["Scene::clearance"])),
    ("Scene.metric", At(&["extricate_scene_metric"], &["Scene::metric"])),
    ("Scene.joints", At(&["extricate_scene_joint_count"], &["Scene::joints"])),
    ("Scene.lower", At(&["extricate_scene_limits"], &["Scene::limits"])),
    ("Scene.upper", At(&["extricate_scene_limits"], &["Scene::limits"])),
    ("Scene.bodies", At(&["extricate_scene_body_count", "extricate_scene_body_name"], &["Scene::bodies"])),
    ("Scene.pairs", At(&["extricate_scene_pair_count", "extricate_scene_pair"], &["Scene::pairs"])),
    ("Scene.warnings", At(&["extricate_scene_warning_count", "extricate_scene_warning"], &["Scene::warnings"])),
    ("Scene.moved", At(&["extricate_scene_moved"], &["Scene::moved"])),
    ("Scene.with_obstacles", At(&["extricate_scene_with_obstacles"], &["Scene::with_obstacles"])),
    ("Scene.without", At(&["extricate_scene_without"], &["Scene::without"])),
    ("Scene.disabled", At(&["extricate_scene_disabled"], &["Scene::disabled"])),
    ("Scene.attach", At(&["extricate_scene_attached"], &["Scene::attached"])),
    ("Scene.in_world", At(&["extricate_scene_in_world"], &["Scene::in_world"])),
    ("Scene.config", At(&["extricate_scene_config"], &["Scene::config"])),
    ("Scene.positions", At(&["extricate_scene_positions"], &["Scene::positions"])),
    ("Scene.poses", At(&["extricate_scene_poses"], &["Scene::poses"])),
    ("Scene.mesh", At(&["extricate_scene_mesh"], &["Scene::mesh"])),
    ("Scene.check", At(&["extricate_check_batch"], &["Scene::check"])),
    ("Scene.distances", At(&["extricate_distance_batch"], &["Scene::distances"])),
    ("Scene.pair_distances", At(&["extricate_pair_distances"], &["Solver::pair_distances"])),
    ("Scene.contacts", At(&["extricate_contacts"], &["Solver::contacts"])),
    (
        "Scene.distance_jacobians",
        At(&["extricate_distance_rows", "extricate_contacts_gradients"], &["Solver::distance_rows"]),
    ),
    ("Scene.check_segments", At(&["extricate_check_segment_batch"], &["Scene::check_segments"])),
    ("Scene.robot_filter", At(&["extricate_scene_robot_filter"], &["Scene::robot_filter"])),
    ("Scene.colliding_pairs", At(&["extricate_colliding_pairs"], &["Solver::colliding_pairs"])),
    ("Scene.always_colliding", At(&["extricate_always_colliding"], &["Scene::always_colliding"])),
    ("Scene.sample", At(&["extricate_sample"], &["Scene::sample"])),
    ("Scene.query_batch", At(&["extricate_query_batch"], &["query_batch"])),
    ("Roadmap.__new__", At(&["extricate_roadmap_new"], &["Roadmap::Roadmap"])),
    ("Roadmap.load", At(&["extricate_roadmap_load"], &["Roadmap::load"])),
    ("Roadmap.save", At(&["extricate_roadmap_save"], &["Roadmap::save"])),
    ("Roadmap.__len__", At(&["extricate_roadmap_size"], &["Roadmap::size"])),
    ("Roadmap.edges", At(&["extricate_roadmap_edges"], &["Roadmap::edges"])),
    ("Roadmap.checks", At(&["extricate_roadmap_checks"], &["Roadmap::checks"])),
    ("Model.load", At(&["extricate_load"], &["Scene::Scene"])),
    ("Model.save", At(&["extricate_save"], &["Scene::save"])),
    ("Model.from_bytes", Not("models are read from files")),
    ("Model.to_bytes", Not("models are written to files")),
    ("Model.scene", Not("a model is a scene that was learned, and is used as one")),
    ("Model.boundary", At(&["extricate_scene_samples"], &["Scene::samples"])),
    ("Model.support_vectors", Not("they serve plots of what was learned, which are made in Python")),
    ("Model.statistics", At(&["extricate_scene_statistics"], &["Scene::statistics"])),
    ("Model.query", At(&["extricate_query"], &["Solver::query"])),
    ("Model.query_batch", At(&["extricate_query_batch"], &["query_batch"])),
    ("Model.in_world", At(&["extricate_scene_in_world", "extricate_scene_with_obstacles"], &["Scene::in_world"])),
    ("Model.in_scene", Not("a changed scene keeps the model of the one that it was made from")),
    ("Solver.__new__", At(&["extricate_solver_new"], &["Solver::Solver"])),
    ("Solver.scene", At(&[], &["Solver::scene"])),
    ("Solver.model", At(&["extricate_scene_is_learned"], &["Scene::is_learned"])),
    ("Solver.with_scene", At(&["extricate_solver_new"], &["Solver::Solver"])),
    ("Solver.nearest_exit", At(&["extricate_nearest_exit"], &["Solver::nearest_exit"])),
    ("Solver.check", At(&["extricate_check"], &["Solver::check"])),
    ("Solver.batch", At(&["extricate_query_batch"], &["query_batch"])),
    (
        "Stream.query",
        At(&["extricate_stream_query", "extricate_stream_set_scene"], &["Stream::query", "Stream::set_scene"]),
    ),
    ("Stream.restart", At(&["extricate_stream_restart"], &["Stream::restart"])),
];

const PYTHON: &str = include_str!("../../extricate-python/python/extricate/_extricate.pyi");
const C: &str = include_str!("../include/extricate.h");
const CPP: &str = include_str!("../include/extricate.hpp");

/// Returns the public functions of the Python package, and `Class.name` of methods and properties.
fn calls_of_python() -> BTreeSet<String> {
    let (mut calls, mut class) = (BTreeSet::new(), "");
    for line in PYTHON.lines() {
        let name_after = |word: &str| line.trim_start().strip_prefix(word)?.split(['(', ':']).next();
        if let Some(name) = name_after("class ").filter(|_| line.starts_with("class ")) {
            class = name;
        } else if let Some(name) = name_after("def ") {
            let is_method = line.starts_with("    ");
            let is_public = !name.starts_with('_') || ["__new__", "__len__"].contains(&name);
            if is_public && is_method && class != "_JointState" {
                calls.insert(format!("{class}.{name}"));
            } else if is_public && !is_method {
                calls.insert(name.to_string());
            }
        }
    }
    calls
}

/// Whether `text` has `name` as a whole word, followed by `after`.
fn has_word(text: &str, name: &str, after: &str) -> bool {
    text.match_indices(&format!("{name}{after}")).any(|(at, _)| {
        let before = text[..at].chars().next_back().unwrap_or(' ');
        !(before.is_alphanumeric() || before == '_')
    })
}

/// Returns the body of a class of `extricate.hpp`.
fn class_of_cpp(class: &str) -> Option<&'static str> {
    let from = ["class", "struct"].iter().find_map(|word| CPP.find(&format!("\n{word} {class} {{")))?;
    let body = &CPP[from..];
    Some(&body[..body.find("\n};")?])
}

#[test]
fn every_call_of_python_is_in_the_table() {
    let listed: BTreeSet<String> = TABLE.iter().map(|(name, _)| (*name).to_string()).collect();
    let calls = calls_of_python();
    assert!(calls.len() > 70, "{calls:?}");
    assert_eq!(listed.len(), TABLE.len(), "a call is in the table twice");
    assert_eq!(calls.difference(&listed).collect::<Vec<_>>(), Vec::<&String>::new(), "not in the table");
    assert_eq!(listed.difference(&calls).collect::<Vec<_>>(), Vec::<&String>::new(), "not in Python");
}

#[test]
fn what_the_table_names_is_there() {
    for (call, there) in TABLE {
        match there {
            Not(reason) => assert!(reason.len() > 10, "{call}"),
            At(c, cpp) => {
                assert!(!c.is_empty() || !cpp.is_empty(), "{call}");
                for name in *c {
                    let after = if name.starts_with("extricate_") { "(" } else { " {" };
                    assert!(has_word(C, name, after), "{call}: {name} is not in extricate.h");
                }
                for name in *cpp {
                    let found = match name.split_once("::") {
                        None => has_word(CPP, name, "("),
                        Some((class, member)) => class_of_cpp(class).is_some_and(|body| has_word(body, member, "(")),
                    };
                    assert!(found, "{call}: {name} is not in extricate.hpp");
                }
            }
        }
    }
}
