//! Parses a path in a line of input: its waypoints as JSON. Reads no files.

use extricate::{Config, Scene};
use serde_json::Value;

use super::line::{Reading, by_name, config_of, describe, explain_syntax, list_keys, numbers, parse_config, strings};
use super::unique;
use crate::report;

/// Accepted contents of a line, for messages.
const EXPECTED: &str = "an array of configurations, or an object with \"path\", or with \"joint_names\" and \"points\"";

/// Parses the waypoints of a line: a whole path, see [`parse_path`], or one configuration, see
/// [`parse_config`]. Returns `None` for a heading.
pub fn parse_waypoints(text: &str, scene: &Scene, reading: &mut Reading) -> Result<Option<Vec<Config>>, String> {
    if is_path(text) {
        let (first, rest) = parse_path(text, scene, reading)?;
        return Ok(Some(std::iter::once(first).chain(rest).collect()));
    }
    Ok(parse_config(text, scene, reading)?.map(|q| vec![q]))
}

/// Whether a line holds several configurations, or says that it is a path.
fn is_path(text: &str) -> bool {
    if !text.starts_with(['[', '{']) {
        return false;
    }
    match unique::parse(text) {
        Ok(Value::Array(all)) => all.len() > 1 && all.iter().all(|q| q.is_array() || q.is_object()),
        Ok(Value::Object(map)) => ["path", "joint_names", "points"].into_iter().any(|key| map.contains_key(key)),
        _ => false,
    }
}

/// Parses the first waypoint and those after it. A line is an array of configurations, as
/// [`super::line::parse_config`] takes them from JSON, `{"path": [...]}`, or a JointTrajectory,
/// `{"joint_names": [...], "points": [{"positions": [...]}, ...]}`. Other keys are ignored.
pub fn parse_path(text: &str, scene: &Scene, reading: &mut Reading) -> Result<(Config, Vec<Config>), String> {
    let value: Value = unique::parse(text).map_err(|error| explain_syntax(text, &error, EXPECTED))?;
    let mut waypoints = match &value {
        Value::Array(waypoints) => each(waypoints, |q| config_of(q, scene, reading))?,
        Value::Object(map) => match (map.get("path"), map.get("joint_names"), map.get("points")) {
            (Some(Value::Array(waypoints)), ..) => each(waypoints, |q| config_of(q, scene, reading))?,
            (None, Some(Value::Array(names)), Some(Value::Array(points))) => {
                let names = strings(names)?;
                each(points, |point| of_point(&names, point, scene, reading))?
            }
            _ => return Err(format!("{}, expected {EXPECTED}", list_keys(map))),
        },
        other => return Err(format!("got {}, expected {EXPECTED}", describe(other))),
    };
    match waypoints.len() {
        found @ (0 | 1) => Err(format!("got {}, expected at least 2", report::counted(found, "waypoint", "waypoints"))),
        _ => {
            let rest = waypoints.split_off(1);
            Ok((waypoints.remove(0), rest))
        }
    }
}

fn each(found: &[Value], mut read: impl FnMut(&Value) -> Result<Config, String>) -> Result<Vec<Config>, String> {
    let numbered = found.iter().enumerate();
    numbered.map(|(at, value)| read(value).map_err(|fault| format!("waypoint {}: {fault}", at + 1))).collect()
}

fn of_point(names: &[&str], point: &Value, scene: &Scene, reading: &mut Reading) -> Result<Config, String> {
    let Some(Value::Array(positions)) = point.get("positions") else {
        return Err(format!("got {}, expected an object with \"positions\"", describe(point)));
    };
    let positions = numbers(positions, "position")?;
    match positions.len() == names.len() {
        true => by_name(names.iter().copied().zip(positions.chunks(1)), scene, reading),
        false => Err(format!("got {} positions, expected {}, one for each name", positions.len(), names.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::super::line::tests::scene;
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec<f64>>, String> {
        let (first, rest) = parse_path(text, &scene(), &mut Reading::default())?;
        Ok(std::iter::once(first).chain(rest).map(|q| q.to_vec()).collect())
    }

    #[test]
    fn every_spelling_is_read() {
        for text in [
            "[[0.5, 1], [0, 2]]",
            r#"{"path": [[0.5, 1], {"q": {"turn": 2, "shoulder": 0}}], "id": 1}"#,
            r#"{"joint_names": ["turn", "shoulder"], "points": [{"positions": [1, 0.5]}, {"positions": [2, 0], "velocities": []}]}"#,
        ] {
            assert_eq!(read(text), Ok(vec![vec![0.5, 1.0], vec![0.0, 2.0]]), "{text}");
        }
    }

    #[test]
    fn a_line_is_a_path_or_one_waypoint() {
        let read = |text: &str| {
            let waypoints = parse_waypoints(text, &scene(), &mut Reading::default());
            waypoints.map(|waypoints| waypoints.into_iter().flatten().map(|q| q.to_vec()).collect::<Vec<_>>())
        };
        for one in ["[0.5, 1]", "0.5,1", "[[0.5, 1]]", r#"{"q": [0.5, 1]}"#] {
            assert_eq!(read(one), Ok(vec![vec![0.5, 1.0]]), "{one}");
        }
        for two in [
            "[[0.5, 1], [0, 2]]",
            r#"{"path": [[0.5, 1], [0, 2]]}"#,
            r#"{"joint_names": ["turn", "shoulder"], "points": [{"positions": [1, 0.5]}, {"positions": [2, 0]}]}"#,
        ] {
            assert_eq!(read(two), Ok(vec![vec![0.5, 1.0], vec![0.0, 2.0]]), "{two}");
        }
        assert!(read(r#"{"path": [[0, 0]]}"#).unwrap_err().contains("got 1 waypoint, expected"));
    }

    #[test]
    fn every_fault_names_the_waypoint_and_what_was_expected() {
        for (text, found, expected) in [
            ("[[0, 0]]", "got 1 waypoint,", "at least 2"),
            ("[]", "got 0 waypoints", "at least 2"),
            ("[0, 0]", "waypoint 1: got 0 (a number)", "array of 2 numbers"),
            ("[[0, 0], [9, 0]]", "waypoint 2: ", "[-1, 2]"),
            ("[[0, 0], [NaN, 0]]", "got NaN", "finite number"),
            (r#"{"q": [0, 0]}"#, "an object with \"q\"", "\"path\""),
            (r#"{"joint_names": ["turn"], "points": [[0]]}"#, "waypoint 1: got [0] (an array)", "\"positions\""),
            (
                r#"{"joint_names": ["turn"], "points": [{"positions": []}]}"#,
                "waypoint 1: got 0 positions",
                "expected 1",
            ),
            ("7", "7 (a number)", "an array of configurations"),
            ("hello", "hello", "an array of configurations"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(found), "{text}: {message}");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
