//! Parses YAML and JSON messages, and reads their values with errors that name the place.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value};

use super::message_pose::MessagePose;
use crate::error::{Error, Result, quoted};
use crate::robot::{LoadLimit, LoadLimits};
use crate::scene::file::pose_entry::QUATERNION_TOLERANCE;

/// Parses the first YAML document that is not empty; `ros2 topic echo` writes one for each message.
///
/// # Errors
/// [`Error::Input`] with the line.
pub fn of_yaml(file: &str, text: &str, limits: &LoadLimits) -> Result<Value> {
    let document = first_document(text);
    // The budget counts the target of an alias at every use.
    let nodes = limits.get(LoadLimit::Values);
    let budget = serde_saphyr::budget! {
        max_nodes: nodes,
        max_events: nodes.saturating_mul(2),
        max_total_scalar_bytes: limits.get(LoadLimit::TextBytes),
    };
    let options = serde_saphyr::options! { budget: budget };
    serde_saphyr::from_str_with_options(document, options).map_err(|error| {
        let before = text.len() - text[text.find(document).unwrap_or(0)..].len();
        let skipped = text[..before].lines().count();
        let line = error.location().map_or(0, |at| at.line() as usize + skipped);
        let said = error.without_snippet().to_string();
        Error::input(file, format!("line {line}"), format!("YAML: {}", quoted(said.lines().next().unwrap_or_default())))
    })
}

fn first_document(text: &str) -> &str {
    let mut start = 0;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_end() == "---" {
            if !text[start..at].trim().is_empty() {
                return &text[start..at];
            }
            start = at + line.len();
        }
        at += line.len();
    }
    &text[start..]
}

/// # Errors
/// [`Error::Input`] with line and column if the text is not JSON.
pub fn of_json(file: &str, text: &str) -> Result<Value> {
    serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        Error::input(file, place, format!("not JSON: {error}"))
    })
}

/// A value with the file and the path of keys that errors name.
#[derive(Debug, Clone)]
pub struct At<'a> {
    pub file: &'a str,
    pub path: String,
    pub value: &'a Value,
}

impl<'a> At<'a> {
    pub fn new(file: &'a str, path: impl Into<String>, value: &'a Value) -> Self {
        Self { file, path: path.into(), value }
    }

    /// Creates the error that this value is not what was `expected`.
    pub fn fault(&self, expected: &str) -> Error {
        let mut found = self.value.to_string();
        if found.chars().count() > 40 {
            found = found.chars().take(40).chain("..".chars()).collect();
        }
        let advice = match self.value {
            Value::String(text) if text.contains("...") => {
                " (`ros2 topic echo` cuts long arrays: give it --full-length)"
            }
            _ => "",
        };
        let element = if self.path.is_empty() { "message" } else { &self.path };
        Error::input(self.file, element, format!("got {found}, expected {expected}{advice}"))
    }

    fn inner(&self, key: &str, value: &'a Value) -> Self {
        let path = if self.path.is_empty() { key.into() } else { format!("{}.{key}", self.path) };
        Self { file: self.file, path, value }
    }

    pub fn map(&self) -> Result<&'a Map<String, Value>> {
        self.value.as_object().ok_or_else(|| self.fault("a mapping"))
    }

    /// Returns the keys that are not `known`, so that mistyped ones can be reported.
    pub fn unknown(&self, known: &[&str]) -> Result<Vec<&'a str>> {
        Ok(self.map()?.keys().map(String::as_str).filter(|key| !known.contains(key)).collect())
    }

    /// Returns a field; `None` if it is missing or null.
    pub fn get(&self, key: &str) -> Result<Option<Self>> {
        Ok(self.map()?.get(key).filter(|value| !value.is_null()).map(|value| self.inner(key, value)))
    }

    /// Returns the elements of a field that is a list; none if the field is missing.
    pub fn list(&self, key: &str) -> Result<Vec<Self>> {
        self.get(key)?.map_or(Ok(Vec::new()), |list| list.elements())
    }

    pub fn elements(&self) -> Result<Vec<Self>> {
        let elements = self.value.as_array().ok_or_else(|| self.fault("a list"))?;
        let element = |(index, value)| Self { file: self.file, path: format!("{}[{index}]", self.path), value };
        Ok(elements.iter().enumerate().map(element).collect())
    }

    /// Returns the text of a field; empty if the field is missing.
    pub fn text(&self, key: &str) -> Result<&'a str> {
        match self.get(key)? {
            Some(at) => at.string(),
            None => Ok(""),
        }
    }

    pub fn string(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.fault("a text"))
    }

    pub fn number(&self) -> Result<f64> {
        self.value.as_f64().filter(|x| x.is_finite()).ok_or_else(|| self.fault("a finite number"))
    }

    pub fn truth(&self) -> Result<bool> {
        match self.value {
            Value::Bool(truth) => Ok(*truth),
            Value::Number(_) if self.number()? == 0.0 => Ok(false),
            Value::Number(_) if self.number()? == 1.0 => Ok(true),
            _ => Err(self.fault("true or false")),
        }
    }

    /// Returns the bytes of a list, signed or not, or of a text in base64, as rosbridge writes
    /// them.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        if let Some(text) = self.value.as_str() {
            return STANDARD.decode(text).map_err(|_| self.fault("bytes, as a list or in base64"));
        }
        let byte = |at: At| {
            let whole = at.value.as_i64().filter(|byte| (-128..256).contains(byte));
            // A negative byte keeps its bits.
            whole.map(|byte| byte as u8).ok_or_else(|| at.fault("a whole number from -128 to 255"))
        };
        self.elements()?.into_iter().map(byte).collect()
    }

    /// Returns the numbers of a list, or of a mapping with these keys.
    pub fn numbers<const N: usize>(&self, keys: [&str; N]) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        if self.value.is_object() {
            for (number, key) in numbers.iter_mut().zip(keys) {
                let at = self.get(key)?.ok_or_else(|| self.fault(&format!("a mapping with {}", keys.join(", "))))?;
                *number = at.number()?;
            }
            return Ok(numbers);
        }
        let elements = self.elements()?;
        if elements.len() != N {
            return Err(self.fault(&format!("{N} numbers {}", keys.join(", "))));
        }
        for (number, element) in numbers.iter_mut().zip(elements) {
            *number = element.number()?;
        }
        Ok(numbers)
    }

    /// Reads a `geometry_msgs/Pose` from a field; the identity if the field is missing.
    pub fn pose(&self, key: &str) -> Result<MessagePose> {
        self.get(key)?.map_or(Ok(MessagePose::IDENTITY), |pose| pose.as_pose())
    }

    /// Reads this value as a `geometry_msgs/Pose` or a `Transform`.
    pub fn as_pose(&self) -> Result<MessagePose> {
        let first = |keys: [&str; 2]| -> Result<Option<Self>> {
            Ok(match self.get(keys[0])? {
                Some(at) => Some(at),
                None => self.get(keys[1])?,
            })
        };
        let xyz = first(["position", "translation"])?.map_or(Ok([0.0; 3]), |at| at.numbers(["x", "y", "z"]))?;
        let Some(at) = first(["orientation", "rotation"])? else {
            return Ok(MessagePose { xyz, ..MessagePose::IDENTITY });
        };
        let quaternion = at.numbers(["x", "y", "z", "w"])?;
        if quaternion == [0.0; 4] {
            // Unset quaternions are zeros; MoveIt takes them for no rotation.
            return Ok(MessagePose { xyz, ..MessagePose::IDENTITY });
        }
        let quaternion = unit(quaternion).ok_or_else(|| at.fault("a quaternion of length 1"))?;
        Ok(MessagePose { xyz, quaternion })
    }
}

/// Scales a quaternion to unit length; `None` if its length is not near 1.
pub fn unit(quaternion: [f64; 4]) -> Option<[f64; 4]> {
    let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
    ((length - 1.0).abs() <= QUATERNION_TOLERANCE).then(|| quaternion.map(|c| c / length))
}
