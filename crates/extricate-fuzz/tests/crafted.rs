//! Files with a right checksum and one wrong number: every number of every structure is replaced by
//! each of some that make no sense. Each file is either refused with an error that names it, or its
//! content is used and the answers are right.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use extricate::Scene;
use extricate::internals::io::model_file;
use extricate::internals::learning::obstacle_classifier::ObstacleClassifier;
use extricate_fuzz::container::{Array, Container};
use extricate_fuzz::spoil::{REALS, Spoil, numbers, spoiled, spoils_of};
use extricate_fuzz::{model, roadmap};
use safetensors::tensor::Dtype;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Counts of files that were tried and refused, and the names of those that panicked.
#[derive(Debug, Default)]
struct Tried {
    files: usize,
    refused: usize,
    panicked: Vec<String>,
}

impl Tried {
    /// Reads and uses a file; `what` describes it if it panics.
    fn file(&mut self, what: &str, file: &Container, read: &dyn Fn(&[u8]) -> Result<(), String>) {
        self.files += 1;
        let sealed = file.sealed();
        match catch_unwind(AssertUnwindSafe(|| read(&sealed))) {
            Ok(Ok(())) => {}
            Ok(Err(message)) => {
                self.refused += 1;
                assert!(message.contains(" f: ") && message.len() < 4_000, "{what}: {message}");
            }
            Err(_) => self.panicked.push(what.to_string()),
        }
    }

    /// Panics if any file did. Also panics if too few files were tried, or less than one in `of`
    /// was refused, for the test to mean something.
    fn judge(&self, least: usize, of: usize) {
        println!("{} files, {} refused", self.files, self.refused);
        assert!(self.panicked.is_empty(), "panicked:\n{}", self.panicked.join("\n"));
        assert!(self.files > least && of * self.refused > self.files, "{} of {}", self.refused, self.files);
    }
}

fn read_model(bytes: &[u8]) -> Result<(), String> {
    model_file::decode(Path::new("f"), bytes).map(model::query).map_err(|error| error.to_string())
}

fn corpus(target: &str, name: &str) -> Container {
    let all = (extricate_fuzz::target(target).unwrap().corpus)();
    Container::open(&all.iter().find(|(found, _)| found == name).unwrap().1).unwrap()
}

/// Replaces every number of the structure that an array holds as bytes.
fn spoil_structure<T: Serialize + DeserializeOwned>(
    file: &Container,
    array: &str,
    read: &dyn Fn(&[u8]) -> Result<(), String>,
    tried: &mut Tried,
) {
    let bytes = file.arrays.iter().find(|found| found.name == array).unwrap().bytes.clone();
    let value = serde_json::to_value(postcard::from_bytes::<T>(&bytes).unwrap()).unwrap();
    let written = |value: Value| postcard::to_stdvec(&serde_json::from_value::<T>(value).ok()?).ok();
    for pointer in numbers(&value) {
        for spoil in spoils_of(value.pointer(&pointer).unwrap()) {
            let Some(bytes) = spoiled(&value, &pointer, spoil, written) else { continue };
            let mut file = file.clone();
            file.array(array).unwrap().bytes = bytes;
            tried.file(&format!("{array}: {pointer}: {spoil:?}"), &file, read);
        }
    }
}

/// Replaces every number in the file's own description.
fn spoil_text(file: &Container, read: &dyn Fn(&[u8]) -> Result<(), String>, tried: &mut Tried) {
    let value: Value = serde_json::from_str(&file.text).unwrap();
    for pointer in numbers(&value) {
        for spoil in spoils_of(value.pointer(&pointer).unwrap()) {
            let mut value = value.clone();
            *value.pointer_mut(&pointer).unwrap() = match spoil {
                Spoil::Whole(number) => number.into(),
                // JSON cannot express numbers that are not finite.
                Spoil::Real(number) if number.is_finite() => number.into(),
                Spoil::Real(_) => Value::Null,
            };
            let file = Container { text: value.to_string(), ..file.clone() };
            tried.file(&format!("{pointer}: {spoil:?}"), &file, read);
        }
    }
}

/// Replaces the first, the last, or all numbers of every array, and changes its length.
fn spoil_arrays(file: &Container, read: &dyn Fn(&[u8]) -> Result<(), String>, tried: &mut Tried) {
    for at in 0..file.arrays.len() {
        let Array { name, dtype, bytes, .. } = &file.arrays[at];
        let (size, numbers) = (file.arrays[at].size(), bytes.len() / file.arrays[at].size());
        let mut with = |what: &str, bytes: Vec<u8>| {
            let mut file = file.clone();
            file.arrays[at].bytes = bytes;
            tried.file(&format!("{name}: {what}"), &file, read);
        };
        with("empty", Vec::new());
        with("one number less", bytes[..bytes.len().saturating_sub(size)].to_vec());
        with("twice", [&bytes[..], bytes].concat());
        let values: Vec<Vec<u8>> = match dtype {
            Dtype::F64 => REALS.iter().chain(&[100.0]).map(|x| x.to_le_bytes().to_vec()).collect(),
            Dtype::F32 => REALS.iter().map(|x| (*x as f32).to_le_bytes().to_vec()).collect(),
            _ => [0x00, 0x01, 0x7f, 0xff].iter().map(|byte| vec![*byte; size]).collect(),
        };
        for value in values.iter().filter(|_| numbers > 0) {
            for (what, places) in [("first", 0..1), ("last", numbers - 1..numbers), ("all", 0..numbers)] {
                let mut bytes = bytes.clone();
                places.for_each(|place| bytes[place * size..][..size].copy_from_slice(value));
                with(&format!("{what} {value:?}"), bytes);
            }
        }
    }
}

#[test]
fn no_number_of_a_model_breaks_it() {
    let mut tried = Tried::default();
    let file = corpus("model", "many-300");
    spoil_structure::<Scene>(&file, "scene", &read_model, &mut tried);
    let solved = corpus("model", "few-12000");
    spoil_structure::<Option<ObstacleClassifier>>(&solved, "classifier", &read_model, &mut tried);
    for file in [file, solved] {
        spoil_text(&file, &read_model, &mut tried);
        spoil_arrays(&file, &read_model, &mut tried);
    }
    tried.judge(2_000, 3);
}

/// Messages name the file, the element, the value and the expectation.
#[test]
fn messages_name_what_is_wrong() {
    let file = corpus("model", "few-300");
    let mut outside = file.clone();
    let all = outside.array("boundary").unwrap();
    all.bytes = 100.0_f64.to_le_bytes().repeat(all.bytes.len() / 8);
    let message = read_model(&outside.sealed()).unwrap_err();
    let expected = "model f: altered or damaged: `boundary`: row 0: `a` (coordinate 0): got [100.0], expected an angle";
    assert!(message.starts_with(expected), "{message}");
    let said = |change: &dyn Fn(&mut Value)| {
        let mut value: Value = serde_json::from_str(&file.text).unwrap();
        change(&mut value);
        read_model(&Container { text: value.to_string(), ..file.clone() }.sealed()).unwrap_err()
    };
    let message = said(&|value| value["colliding_share"] = 1.5.into());
    assert!(message.contains("statistics: colliding_share: got 1.5, expected 0 to 1"), "{message}");
    let message = said(&|value| value["solved_samples"] = u64::MAX.into());
    assert!(message.contains("solved_samples and stand_ins: got 18446744073709551615"), "{message}");
}

#[test]
fn no_number_of_a_roadmap_breaks_it() {
    let mut tried = Tried::default();
    for (_, bytes) in roadmap::corpus() {
        let file = Container::open(&bytes).unwrap();
        spoil_text(&file, &roadmap::read, &mut tried);
        spoil_arrays(&file, &roadmap::read, &mut tried);
    }
    // Most numbers of a roadmap count what was spent.
    tried.judge(200, 6);
}
