//! The model file: bytes to [`Model`] and back. No file access (see `store`).
//!
//! A safetensors container, so that NumPy reads the arrays: `boundary` (f64, samples x nq; the first `stand_ins` of the statistics are stand-ins, the last `exits` exits), `reaches` (f64, distances from
//! held-out colliding configurations to their nearest sample, ascending), `scene` and `classifier` (postcard, u8). Its one metadata entry, `extricate`, is JSON: format version, statistics, and the BLAKE3 hash of everything else.

pub mod checkpoint;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};

use crate::collision::Checker;
use crate::error::{Error, Result};
use crate::learning::union::UnionClassifier;
use crate::metric::Metric;
use crate::model::{Model, Statistics};
use crate::penetration::coverage::Coverage;
use crate::scene::Scene;

/// Version of the layout; a file of another version is refused.
pub const FORMAT: u32 = 5;

const KEY: &str = "extricate";

#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    statistics: Statistics,
    checksum: String,
}

/// The bytes of a model file. The same model gives the same bytes.
pub fn encode(model: &Model) -> Vec<u8> {
    let in_memory = "plain data serialises into memory";
    let scene = postcard::to_stdvec(model.scene()).expect(in_memory);
    let classifier = postcard::to_stdvec(&model.classifier()).expect(in_memory);
    let boundary: Vec<u8> = model.boundary().configs().iter().flat_map(|x| x.to_le_bytes()).collect();
    let reaches: Vec<u8> = model.coverage().distances().iter().flat_map(|x| x.to_le_bytes()).collect();
    let statistics = model.statistics().clone();
    let checksum = checksum(&statistics, &[&boundary, &classifier, &reaches, &scene]);
    let header = Header { format: FORMAT, statistics, checksum };
    // One entry only: a map of several would be written in random order.
    let metadata = HashMap::from([(KEY.to_string(), serde_json::to_string(&header).expect(in_memory))]);
    let nq = model.scene().space.nq();
    let view = |dtype, shape, data| TensorView::new(dtype, shape, data).expect("shape and length agree");
    let tensors = [
        ("boundary", view(Dtype::F64, vec![boundary.len() / 8 / nq, nq], &boundary)),
        ("classifier", view(Dtype::U8, vec![classifier.len()], &classifier)),
        ("reaches", view(Dtype::F64, vec![reaches.len() / 8], &reaches)),
        ("scene", view(Dtype::U8, vec![scene.len()], &scene)),
    ];
    serialize(tensors, Some(metadata)).expect(in_memory)
}

/// Whether `bytes` begin as a model file does: with the length of the header, and a header that names this project.
pub fn is_model(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(4096)];
    head.get(8) == Some(&b'{') && head.windows(11).any(|at| at == b"\"extricate\"")
}

/// Reads a model file's bytes; `path` is its name in messages.
///
/// # Errors
/// [`Error::Model`]: foreign, truncated, altered, or of another version.
pub fn decode(path: &Path, bytes: &[u8]) -> Result<Model> {
    let fault = |problem: String| Error::Model { path: path.into(), problem };
    if !bytes.is_empty() && !bytes.contains(&0) && std::str::from_utf8(bytes).is_ok() {
        return Err(fault("got text, expected a model file, which is learned from a scene".into()));
    }
    let (_, metadata) = SafeTensors::read_metadata(bytes)
        .map_err(|e| fault(format!("not an extricate model, or a truncated one ({e})")))?;
    let header = metadata.metadata().as_ref().and_then(|m| m.get(KEY));
    let header = header.ok_or_else(|| fault("a safetensors file, but not an extricate model".into()))?;
    let format = serde_json::from_str::<serde_json::Value>(header).ok().and_then(|v| v.get("format")?.as_u64());
    if format != Some(FORMAT.into()) {
        let found = format.map_or("an unreadable version".into(), |f| format!("version {f}"));
        return Err(fault(format!("its format is {found}, expected version {FORMAT}: learn it anew")));
    }
    let altered = |what: &str| fault(format!("altered or damaged: {what}"));
    let header: Header = serde_json::from_str(header).map_err(|e| altered(&format!("unreadable header ({e})")))?;
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| fault(format!("truncated or damaged ({e})")))?;
    let data = |name: &str| tensors.tensor(name).map_err(|_| altered(&format!("no tensor `{name}`")));
    let (boundary, classifier) = (data("boundary")?, data("classifier")?);
    let (reaches, scene) = (data("reaches")?, data("scene")?);
    let parts = [&boundary, &classifier, &reaches, &scene].map(|tensor| tensor.data());
    if checksum(&header.statistics, &parts) != header.checksum {
        return Err(altered("the checksum does not match"));
    }
    let scene: Scene = postcard::from_bytes(scene.data()).map_err(|e| altered(&format!("scene ({e})")))?;
    let classifier: Option<UnionClassifier> =
        postcard::from_bytes(classifier.data()).map_err(|e| altered(&format!("classifier ({e})")))?;
    let numbers = |bytes: &[u8]| -> Vec<f64> { bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect() };
    let (configs, coverage) = (numbers(boundary.data()), Coverage::new(numbers(reaches.data())));
    let rows = boundary.shape().first().copied().unwrap_or(0);
    if rows == 0
        || header.statistics.exits.saturating_add(header.statistics.stand_ins) > rows
        || boundary.shape().get(1) != Some(&scene.space.nq())
    {
        return Err(altered("boundary samples do not fit the scene"));
    }
    let scene = Arc::new(scene);
    let (checker, metric) = (Checker::new(scene.clone()), Metric::new(scene));
    Ok(Model::from_parts(checker, metric, configs, classifier, coverage, header.statistics))
}

fn checksum(statistics: &Statistics, parts: &[&[u8]]) -> String {
    let statistics = serde_json::to_vec(statistics).expect("plain data serialises into memory");
    hash(&[&[&statistics[..]], parts].concat())
}

/// BLAKE3 of the parts, each after its length.
fn hash(parts: &[&[u8]]) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    fn small(threads: usize) -> Model {
        let options = LearnOptions { labels: 20_000, seconds: None, seed: 3, threads, ..LearnOptions::default() };
        Model::learn(builtin::scene("planar-arm").unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn bytes_survive_and_do_not_depend_on_threads() {
        let bytes = encode(&small(1));
        assert!(bytes == encode(&small(2)), "the bytes depend on the number of threads");
        let back = decode(Path::new("m"), &bytes).unwrap();
        assert!(encode(&back) == bytes);
    }

    #[test]
    fn damaged_files_are_refused() {
        let bytes = encode(&small(0));
        let refused = |bytes: &[u8]| decode(Path::new("m.extricate"), bytes).err().map(|e| e.to_string());
        for length in [0, 1, 7, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            let message = refused(&bytes[..length]).expect("a truncated file is refused");
            assert!(message.contains("m.extricate"), "{message}");
        }
        for at in (0..bytes.len()).step_by(bytes.len() / 300) {
            let mut altered = bytes.clone();
            altered[at] ^= 0x10;
            assert!(refused(&altered).is_some(), "byte {at} altered without notice");
        }
        assert!(refused(b"\x89PNG\r\n").unwrap().contains("not an extricate model"));
        assert!(refused(b"clearance = 1e-4").unwrap().contains("got text, expected a model file"));
        assert!(is_model(&bytes) && !is_model(&bytes[..20]) && !is_model(b"solid cube"));
    }
}
