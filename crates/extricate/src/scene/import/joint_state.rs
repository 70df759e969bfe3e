//! Reads joint positions from a `sensor_msgs/JointState` in a message.

use std::path::Path;

use super::value::{At, of_json, of_yaml};
use super::{Kind, kind};
use crate::error::{Error, Result};
use crate::robot::{LoadLimit, LoadLimits};
use crate::scene::file::most_values;

/// Keys that may lead to a JointState, from outside in, in a PlanningScene, a planning request or a
/// RobotState.
const WRAPPER_KEYS: [&str; 6] = ["msg", "values", "scene", "robot_state", "start_state", "joint_state"];

/// Reads names and positions of joints \[rad or m\] from a JointState, alone or in a RobotState, a
/// PlanningScene or a request. The extension of `path` selects YAML or JSON. Joints with several
/// coordinates (`multi_dof_joint_state`) are left out.
///
/// # Errors
/// [`Error::Input`] that names the file, the field, what is in it and what was expected.
pub fn joint_positions(path: &Path, text: &str, limits: &LoadLimits) -> Result<Vec<(String, f64)>> {
    let file = path.display().to_string();
    limits.check(LoadLimit::TextBytes, text.len(), &file, "file")?;
    limits.check(LoadLimit::Values, most_values(text), &file, "message")?;
    let value = match kind(path) {
        Some(Kind::Yaml) => of_yaml(&file, text, limits)?,
        Some(Kind::Json) => of_json(&file, text)?,
        Some(Kind::SceneText) | None => {
            let problem = "got a name that tells no format, expected one that ends in .yaml, .yml or .json";
            return Err(Error::input(file, "name", problem));
        }
    };
    let mut at = At::new(&file, "", &value);
    for around in WRAPPER_KEYS {
        if let Some(inner) = at.get(around)?.filter(|inner| inner.value.is_object()) {
            at = inner;
        }
    }
    let (names, positions) = (at.list("name")?, at.list("position")?);
    if names.is_empty() || names.len() != positions.len() {
        let problem = format!("got {} names and {} positions, expected as many", names.len(), positions.len());
        let element = if at.path.is_empty() { "joint_state".to_string() } else { at.path.clone() };
        return Err(Error::input(&file, element, problem));
    }
    names.iter().zip(&positions).map(|(name, position)| Ok((name.string()?.to_string(), position.number()?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str) -> Result<Vec<(String, f64)>> {
        joint_positions(Path::new(name), text, &LoadLimits::default())
    }

    #[test]
    fn states_are_found_wherever_they_stand() {
        let expected = vec![("a".to_string(), 0.5), ("b".to_string(), -1.0)];
        let state = r#"{"header": {}, "name": ["a", "b"], "position": [0.5, -1.0], "velocity": []}"#;
        for text in [
            state.to_string(),
            format!(r#"{{"joint_state": {state}}}"#),
            format!(r#"{{"msg": {{"world": {{}}, "robot_state": {{"joint_state": {state}}}}}}}"#),
            format!(r#"{{"group_name": "arm", "start_state": {{"joint_state": {state}}}}}"#),
        ] {
            assert_eq!(read("m.json", &text).unwrap(), expected, "{text}");
        }
        let yaml = "robot_state:\n  joint_state:\n    name: [a, b]\n    position:\n    - 0.5\n    - -1\n";
        assert_eq!(read("m.yaml", yaml).unwrap(), expected);
    }

    #[test]
    fn faults_name_the_field() {
        let refused = |name: &str, text: &str| read(name, text).unwrap_err().to_string();
        assert!(refused("m.json", r#"{"name": ["a"], "position": []}"#).contains("got 1 names and 0 positions"));
        assert!(refused("m.json", r#"{"name": ["a"], "position": ["b"]}"#).contains("position"));
        assert!(refused("m.json", "{").starts_with("m.json: line 1"));
        assert!(refused("m.scene", "").contains("expected one that ends in .yaml"));
        assert!(refused("m.json", "{}").contains("joint_state: got 0 names"));
    }
}
