//! Parses a line of input: a configuration as JSON, as numbers or as positions by joint, or two of
//! them. Reads no files.

use std::collections::HashSet;

use extricate::{Config, Scene};
use serde_json::{Map, Value};

use super::unique;
use crate::args::Limits;

/// How lines are read, and the notes on those so far.
pub struct Reading {
    /// How configurations beyond the joint limits are treated.
    pub limits: Limits,
    /// Whether the next line may name the joints of columns of numbers.
    pub may_be_heading: bool,
    /// Joints of the columns of numbers, if a heading names them.
    columns: Option<Vec<String>>,
    notes: Vec<String>,
    told: HashSet<String>,
}

impl Default for Reading {
    fn default() -> Self {
        let (columns, notes, told) = (None, Vec::new(), HashSet::new());
        Self { limits: Limits::Refuse, may_be_heading: true, columns, notes, told }
    }
}

impl Reading {
    /// Returns the notes since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Adds a note, unless one was added under this key before.
    fn note(&mut self, key: &str, text: impl Into<String>) {
        if self.told.insert(key.to_string()) {
            self.notes.push(text.into());
        }
    }
}

/// Accepted contents of a line, for messages.
const EXPECTED: &str = "an array, an object with \"q\" or with \"name\" and \"position\", or numbers between commas";

/// Parses the object of a grasp: `{"q": [...], "object": "cup.obj", "scale": 0.1}`.
pub fn parse_object(text: &str) -> Result<(String, f64), String> {
    let value: Value = unique::parse(text).map_err(|error| explain_syntax(text, &error, EXPECTED))?;
    let file = value.get("object").and_then(Value::as_str).filter(|file| !file.is_empty());
    let file = file.ok_or("got no \"object\", expected the name of a mesh file")?;
    let is_inside = |part| matches!(part, std::path::Component::Normal(_) | std::path::Component::CurDir);
    if !std::path::Path::new(file).components().all(is_inside) {
        return Err(format!("\"object\": got {}, expected a file in the folder of --objects", shorten(file)));
    }
    let scale = value.get("scale").map_or(Some(1.0), Value::as_f64);
    let scale = scale.filter(|scale| *scale > 0.0 && scale.is_finite());
    Ok((file.to_string(), scale.ok_or("\"scale\": expected a positive number")?))
}

/// Parses a line: `{"q": [...]}` (other keys are ignored), a bare array, positions by joint as
/// `{"q": {name: position}}` or `{"name": [...], "position": [...]}`, or numbers between commas or
/// blanks. Returns `None` for a heading that names the joints of the columns below it.
pub fn parse_config(text: &str, scene: &Scene, reading: &mut Reading) -> Result<Option<Config>, String> {
    let may_be_heading = std::mem::replace(&mut reading.may_be_heading, false);
    if text.starts_with(['[', '{', '"']) {
        let value: Value = unique::parse(text).map_err(|error| explain_syntax(text, &error, EXPECTED))?;
        return config_of(&value, scene, reading).map(Some);
    }
    let words: Vec<&str> = text.split([',', ';', ' ', '\t']).filter(|word| !word.is_empty()).collect();
    let is_joint = |word: &&&str| scene.joints().iter().any(|joint| joint.name == **word);
    if may_be_heading && words.iter().filter(is_joint).count() > 0 {
        reading.columns = Some(words.into_iter().map(String::from).collect());
        return Ok(None);
    }
    let numbers = words.iter().map(|word| word.parse().map_err(|_| *word)).collect::<Result<Vec<f64>, &str>>();
    let numbers = numbers.map_err(|word| match words.len() {
        1 => format!("got {}, expected {EXPECTED}", shorten(text)),
        _ => format!("got {} in {}, expected {EXPECTED}", shorten(word), shorten(text)),
    })?;
    let Some(columns) = reading.columns.take() else { return checked(&numbers, scene, reading).map(Some) };
    let named = match columns.len() == numbers.len() {
        true => by_name(columns.iter().map(String::as_str).zip(numbers.chunks(1)), scene, reading),
        false => Err(format!("got {} numbers, expected {} as in the first line", numbers.len(), columns.len())),
    };
    reading.columns = Some(columns);
    named.map(Some)
}

/// Parses a line: `{"from": .., "to": ..}` (other keys are ignored) or an array of two
/// configurations, each as [`parse_config`] takes it from JSON.
pub fn parse_segment(text: &str, scene: &Scene, reading: &mut Reading) -> Result<[Config; 2], String> {
    let keys = "\"from\" and \"to\"";
    let expected = format!("an array or an object with {keys}");
    let value: Value = unique::parse(text).map_err(|error| explain_syntax(text, &error, &expected))?;
    let ends = match value {
        Value::Object(mut map) => match (map.remove("from"), map.remove("to")) {
            (Some(from), Some(to)) => [from, to],
            (None, Some(_)) => return Err("got an object with \"to\" but without \"from\", expected both".into()),
            (Some(_), None) => return Err("got an object with \"from\" but without \"to\", expected both".into()),
            (None, None) => return Err(format!("{}, expected one with {keys}", list_keys(&map))),
        },
        Value::Array(ends) => <[Value; 2]>::try_from(ends)
            .map_err(|ends| format!("got an array of {}, expected one of two configurations", ends.len()))?,
        other => return Err(format!("got {}, expected two configurations", describe(&other))),
    };
    let [from, to] = ends;
    let from = config_of(&from, scene, reading).map_err(|fault| format!("from: {fault}"))?;
    let to = config_of(&to, scene, reading).map_err(|fault| format!("to: {fault}"))?;
    Ok([from, to])
}

pub(super) fn config_of(found: &Value, scene: &Scene, reading: &mut Reading) -> Result<Config, String> {
    let Value::Object(map) = found else { return coordinates(found, scene, reading) };
    match (map.get("q"), map.get("name"), map.get("position")) {
        (Some(Value::Object(positions)), ..) => {
            let read = |(name, value): (&String, &Value)| match value {
                Value::Array(values) => Ok((name.clone(), numbers(values, name)?)),
                value => Ok((name.clone(), numbers(std::slice::from_ref(value), name)?)),
            };
            let positions = positions.iter().map(read).collect::<Result<Vec<_>, String>>()?;
            by_name(positions.iter().map(|(name, values)| (name.as_str(), values.as_slice())), scene, reading)
        }
        (Some(q), ..) => coordinates(q, scene, reading),
        (None, Some(Value::Array(names)), Some(Value::Array(positions))) => {
            let (names, positions) = (strings(names)?, numbers(positions, "position")?);
            if names.len() != positions.len() {
                let (found, expected) = (positions.len(), names.len());
                return Err(format!("position: got {found} numbers, expected {expected}, one for each name"));
            }
            by_name(names.into_iter().zip(positions.chunks(1)), scene, reading)
        }
        (None, Some(names), Some(positions)) => {
            let (names, positions) = (describe(names), describe(positions));
            Err(format!("got the name {names} and the position {positions}, expected two arrays"))
        }
        _ => Err(format!("{}, expected one with \"q\", or with \"name\" and \"position\"", list_keys(map))),
    }
}

/// Reads all coordinates in order.
fn coordinates(found: &Value, scene: &Scene, reading: &mut Reading) -> Result<Config, String> {
    let expected = format!("an array of {} numbers", scene.space().nq());
    let Value::Array(elements) = found else { return Err(format!("got {}, expected {expected}", describe(found))) };
    if !elements.is_empty() && elements.iter().all(Value::is_array) {
        // A batch of one is accepted; each of several would need an answer of its own.
        return match &elements[..] {
            [one] => coordinates(one, scene, reading),
            many => Err(format!("got an array of {} configurations, expected one a line", many.len())),
        };
    }
    checked(&numbers(elements, "coordinate")?, scene, reading)
}

pub(super) fn numbers(elements: &[Value], what: &str) -> Result<Vec<f64>, String> {
    let number = |(index, element): (usize, &Value)| {
        let wrong = || format!("{what} {index}: got {}, expected a finite number", describe(element));
        element.as_f64().ok_or_else(wrong)
    };
    elements.iter().enumerate().map(number).collect()
}

pub(super) fn strings(elements: &[Value]) -> Result<Vec<&str>, String> {
    let string = |(index, element): (usize, &'_ Value)| {
        let wrong = || format!("name {index}: got {}, expected the name of a joint", describe(element));
        elements[index].as_str().ok_or_else(wrong)
    };
    elements.iter().enumerate().map(string).collect()
}

pub(super) fn by_name<'a>(
    positions: impl Iterator<Item = (&'a str, &'a [f64])>,
    scene: &Scene,
    reading: &mut Reading,
) -> Result<Config, String> {
    let named = scene.config_of(positions).map_err(|error| error.to_string())?;
    named.differing.into_iter().for_each(|(joint, text)| reading.note(&joint, text));
    checked(&named.values, scene, reading)
}

fn checked(values: &[f64], scene: &Scene, reading: &mut Reading) -> Result<Config, String> {
    let config = match reading.limits {
        Limits::Forgive => scene.space().config_anywhere(values),
        Limits::Refuse => scene.config(values),
    };
    let config = config.map_err(|error| error.to_string())?;
    if let Some(hint) = scene.degrees_hint(values) {
        reading.note("degrees", hint);
    }
    Ok(config)
}

pub(super) fn list_keys(map: &Map<String, Value>) -> String {
    let keys: Vec<_> = map.keys().map(|k| format!("\"{}\"", shorten(k))).take(MAX_KEYS).collect();
    let more = if map.len() > MAX_KEYS { " and more" } else { "" };
    let keys = if keys.is_empty() { "no keys".into() } else { keys.join(", ") + more };
    format!("got an object with {keys}")
}

/// Largest number of keys that a message lists.
const MAX_KEYS: usize = 4;

/// Names NaN and infinities, which JSON does not have: the parser only reports that it expected a
/// value.
pub(super) fn explain_syntax(text: &str, error: &serde_json::Error, expected: &str) -> String {
    let word = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '+' && c != '-').find(|word| {
        matches!(word.trim_start_matches(['+', '-']).to_ascii_lowercase().as_str(), "nan" | "inf" | "infinity")
    });
    match word {
        Some(word) => format!("got {word}, expected a finite number"),
        None => format!("not JSON ({error}), got {}, expected {expected}", shorten(text)),
    }
}

pub(super) fn describe(value: &Value) -> String {
    let kind = match value {
        Value::Null => return "null".into(),
        Value::Bool(_) => "a boolean",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    };
    format!("{} ({kind})", shorten(&value.to_string()))
}

/// Returns the beginning of a text, on one line.
pub fn shorten(text: &str) -> String {
    const MAX_CHARS: usize = 40;
    let printed = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.into() };
    let cut = if text.chars().nth(MAX_CHARS).is_some() { "..." } else { "" };
    text.chars().take(MAX_CHARS).map(printed).chain([cut.into()]).collect()
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A scene with two joints that have coordinates, one that follows the first, and one that is
    /// locked.
    pub fn scene() -> Scene {
        let joint = |name: &str, kind: &str, child: &str, rest: &str| {
            format!(
                "<link name='{child}'/><joint name='{name}' type='{kind}'><parent link='a'/><child link='{child}'/>\
                 <axis xyz='0 0 1'/><limit lower='-1' upper='2' effort='1' velocity='1'/>{rest}</joint>"
            )
        };
        let urdf = [
            "<robot name='r'><link name='a'/>".to_string(),
            joint("shoulder", "revolute", "b", ""),
            joint("turn", "continuous", "c", ""),
            joint("finger", "prismatic", "d", "<mimic joint='shoulder' multiplier='0.5'/>"),
            joint("lid", "revolute", "e", ""),
            "</robot>".into(),
        ];
        let entries = "[[robot]]\nurdf = 'r'\nlocked = { lid = 0.25 }";
        let entries = extricate::entries::parse("s", entries).unwrap();
        extricate::entries::assemble_scene("s", &entries, &[("r".into(), urdf.concat())]).unwrap()
    }

    fn read(text: &str) -> Result<(Vec<f64>, Vec<String>), String> {
        let (scene, mut reading) = (scene(), Reading::default());
        let config = parse_config(text, &scene, &mut reading)?;
        Ok((config.map_or(vec![], |q| q.to_vec()), reading.take_notes()))
    }

    #[test]
    fn every_spelling_is_read() {
        for text in [
            "[0.5, 1]",
            "[[0.5, 1]]",
            "0.5,1",
            "0.5, 1.0",
            "0.5 1",
            " 5e-1;\t1 ",
            r#"{"id": 3, "q": [0.5, 1]}"#,
            r#"{"q": [[0.5, 1]]}"#,
            r#"{"q": {"turn": 1, "shoulder": 0.5}}"#,
            r#"{"q": {"turn": [1], "shoulder": [0.5], "finger": 0.25, "lid": 0.25}}"#,
            r#"{"header": {}, "name": ["turn", "lid", "shoulder"], "position": [1, 0.25, 0.5], "velocity": []}"#,
        ] {
            assert_eq!(read(text), Ok((vec![0.5, 1.0], vec![])), "{text}");
        }
    }

    #[test]
    fn columns_may_have_the_names_of_joints() {
        let (scene, mut reading) = (scene(), Reading::default());
        let mut parse = |text: &str| parse_config(text, &scene, &mut reading).map(|q| q.map(|q| q.to_vec()));
        assert_eq!(parse("turn,finger,shoulder"), Ok(None));
        assert_eq!(parse("1,0.25,0.5"), Ok(Some(vec![0.5, 1.0])));
        assert_eq!(parse("1,0.5"), Err("got 2 numbers, expected 3 as in the first line".into()));
        assert_eq!(parse("1 0.1 0.2"), Ok(Some(vec![0.2, 1.0])));
        assert!(parse("turn,finger,shoulder").unwrap_err().contains("got turn in turn,finger,shoulder, expected"));
    }

    #[test]
    fn what_is_doubtful_is_told_once() {
        let (scene, mut reading) = (scene(), Reading { limits: Limits::Forgive, ..Reading::default() });
        let line = r#"{"name": ["turn", "lid", "shoulder"], "position": [1, 0.5, 45]}"#;
        for told in [2, 0] {
            parse_config(line, &scene, &mut reading).unwrap();
            let notes = reading.take_notes();
            assert_eq!(notes.len(), told, "{notes:?}");
            if told > 0 {
                assert_eq!(notes[0], "joint `lid` is locked: got 0.5, the scene has it at 0.25");
                assert!(notes[1].contains("if these were degrees"), "{}", notes[1]);
            }
        }
    }

    #[test]
    fn every_fault_names_the_value_and_what_was_expected() {
        for (text, found, expected) in [
            ("[NaN, 0]", "got NaN", "finite number"),
            ("[0, -Infinity]", "got -Infinity", "finite number"),
            ("0,nan", "`turn` (coordinate 1): got NaN", "finite number"),
            ("[1e999, 0]", "1e999", "not JSON"),
            ("[\"0.5\", 0]", "coordinate 0: got \"0.5\" (a string)", "finite number"),
            ("[0, [1]]", "coordinate 1: got [1] (an array)", "finite number"),
            ("[null, 0]", "got null", "finite number"),
            ("[true, 0]", "got true (a boolean)", "finite number"),
            ("[0]", "got 1", "2 coordinates"),
            ("0.5", "got 1", "2 coordinates"),
            ("[]", "got 0", "2 coordinates"),
            ("[2.4, 0]", "`shoulder` (coordinate 0): got 2.4", "[-1, 2]"),
            ("45,90", "`shoulder` (coordinate 0): got 45", "within [-1, 2] (angles are in rad: all of them would be"),
            ("[[0, 0], [1, 1]]", "got an array of 2 configurations", "expected one a line"),
            ("{\"p\": [0, 0]}", "an object with \"p\"", "one with \"q\", or with \"name\" and \"position\""),
            ("{}", "no keys", "one with \"q\""),
            ("{\"q\": [0, 0], \"q\": [1, 1]}", "got the key \"q\" twice", "an object with \"q\""),
            ("{\"q\": 7}", "got 7 (a number)", "array of 2 numbers"),
            ("{\"q\": {\"turn\": 0}}", "got none for `shoulder`", "one for each joint that moves"),
            ("{\"q\": {\"turn\": 0, \"elbow\": 1}}", "got `elbow`", "expected one of `shoulder`, `turn`"),
            ("{\"q\": {\"turn\": null}}", "turn 0: got null", "finite number"),
            ("{\"name\": [\"turn\"], \"position\": []}", "position: got 0 numbers", "expected 1, one for each name"),
            ("{\"name\": [1], \"position\": [1]}", "name 0: got 1 (a number)", "the name of a joint"),
            ("{\"name\": 1, \"position\": [1]}", "got the name 1 (a number)", "expected two arrays"),
            ("\"q\"", "got \"q\" (a string)", "array of 2 numbers"),
            ("[0, 0] [1, 1]", "[0, 0] [1, 1]", "not JSON"),
            ("hello", "got hello", "expected an array, an object with"),
            ("0.5,hello", "got hello in 0.5,hello", "or numbers between commas"),
            ("[0,0]\r[1,1]", "got [0,0]\\r[1,1]", "not JSON"),
            ("{\"a\":1,\"b\":1,\"c\":1,\"d\":1,\"e\":1}", "\"c\", \"d\" and more", "one with \"q\""),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(found), "{text}: {message}");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn segments_are_read_and_faults_name_the_end() {
        let scene = scene();
        let parse = |text: &str| parse_segment(text, &scene, &mut Reading::default());
        let by_name = r#"{"from": {"q": {"turn": 1, "shoulder": 0.5}}, "to": {"name": ["shoulder", "turn"], "position": [0, 2]}}"#;
        for text in ["[[0.5, 1], [0, 2]]", r#"{"to": [0, 2], "id": 3, "from": [0.5, 1]}"#, by_name] {
            let [from, to] = parse(text).unwrap();
            assert_eq!((&*from, &*to), (&[0.5, 1.0][..], &[0.0, 2.0][..]));
        }
        for (text, found, expected) in [
            ("[[0, 0]]", "an array of 1", "two configurations"),
            ("[0, 0]", "from: got 0 (a number)", "array of 2 numbers"),
            ("[[0, 0], [9, 0]]", "to: ", "[-1, 2]"),
            ("{\"from\": [0, 0]}", "without \"to\"", "both"),
            ("{\"to\": [0, 0]}", "without \"from\"", "both"),
            ("{\"q\": [0, 0]}", "an object with \"q\"", "\"from\" and \"to\""),
            ("7", "7 (a number)", "two configurations"),
            ("[[0, 0], [NaN, 0]]", "got NaN", "finite number"),
            ("hello", "hello", "\"from\" and \"to\""),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.contains(found), "{text}: {message}");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
