//! The model file: bytes to [`Model`] and back, without file access.
//!
//! A safetensors container, so that NumPy reads the arrays: `boundary` (f64, samples x nq; the
//! first `stand_ins` of the statistics are stand-ins, the last `solved_samples` solved samples),
//! `scene` and `classifier` (postcard, u8), and those that `derived.rs` describes. Its one metadata
//! entry, `extricate`, is JSON: format version, statistics, and the BLAKE3 hash of everything else.
//!
//! The hash reveals damage, not malice: anyone can make one. So each structure checks, before it is
//! used, that what was read is what it would have written:
//!
//! | what is read | checked by |
//! |---|---|
//! | scene: every field of the tree, bodies, shapes, pairs, clearances | `scene/assemble/sound/`, `cspace/sound.rs`, `robot/sound.rs` |
//! | scene: names, kinds of joints, warnings | harmless: text that is only shown or compared |
//! | `boundary`, support configurations | `ConfigSpace::check_rows`: finite, within limits, unit |
//! | whether stored samples are free | nobody: `nearest` answers say that they are not verified, all others verify |
//! | `classifier` | `ObstacleClassifier::check` |
//! | statistics | `Statistics::check`; what they say of quality is believed |
//! | indices, planes, pieces | `derived.rs`: fitting and finite; radii and codes are measured anew |
//! | trees | `TreeLayout`: every triangle once; boxes are measured anew |
//!
//! Margins of indices are checked no further: wrong ones make queries longer, but no answer wrong.

mod array;
mod derived;
mod scene_bytes;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::collision::Checker;
use crate::error::{Error, Result};
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::metric::{Metric, relative};
use crate::model::{Model, Statistics};
use crate::scene::assemble::sound;
use array::Array;
use derived::numbers;

/// Version of the layout; of other versions, those of `READABLE_FORMATS` are read.
pub const FORMAT: u32 = 14;
/// Versions that are read. 5 holds nothing that can be made anew, so it takes longer to load. Up to
/// 9, solved samples were called exits. Up to 10 there were no trees. Up to 12, meshes had one list
/// of pieces for bodies of all sizes, which are made anew. Up to 13 there were three more figures,
/// which are not read: starts of a query, the origin of an adapted model, and `reaches`, distances
/// of held-out configurations to their nearest sample.
const READABLE_FORMATS: [u64; 10] = [5, 6, 7, 8, 9, 10, 11, 12, 13, FORMAT as u64];
/// First version that stores the trees of meshes.
const FIRST_WITH_TREES: u64 = 11;
/// First version that stores pieces by the size of the body beside them.
const FIRST_WITH_PIECE_SIZES: u64 = 13;

const KEY: &str = "extricate";

#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    /// Raw text, because other versions may have other keys.
    statistics: Box<RawValue>,
    checksum: String,
}

impl Model {
    /// Returns the bytes of a model file.
    pub fn to_bytes(&self) -> Vec<u8> {
        encode(self)
    }

    /// Reads the bytes of a model file; messages call them `name`.
    ///
    /// # Errors
    /// [`Error::Model`] for bytes that are truncated, altered, foreign or of another version.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self> {
        decode(Path::new(name), bytes)
    }

    /// Whether bytes, or the first of them, are those of a model file.
    pub fn is_model(bytes: &[u8]) -> bool {
        is_model(bytes)
    }
}

/// Returns the bytes of a model file. The same model gives the same bytes.
pub fn encode(model: &Model) -> Vec<u8> {
    let mut arrays = learned(model);
    arrays.extend(derived::arrays(model));
    container(FORMAT, model.statistics(), arrays)
}

/// Returns the arrays that were learned and cannot be made anew.
fn learned(model: &Model) -> Vec<Array> {
    let in_memory = "plain data serialises into memory";
    let scene = postcard::to_stdvec(model.scene()).expect(in_memory);
    let classifier = postcard::to_stdvec(&model.classifier()).expect(in_memory);
    let boundary: Vec<u8> = model.boundary().configs().iter().flat_map(|x| x.to_le_bytes()).collect();
    let nq = model.scene().space.nq();
    let array = |name, dtype, shape, bytes| Array { name, dtype, shape, bytes };
    vec![
        array("boundary", Dtype::F64, vec![boundary.len() / 8 / nq, nq], boundary),
        array("classifier", Dtype::U8, vec![classifier.len()], classifier),
        array("scene", Dtype::U8, vec![scene.len()], scene),
    ]
}

fn written(statistics: &Statistics) -> Box<RawValue> {
    serde_json::value::to_raw_value(statistics).expect("plain data serialises into memory")
}

fn container(format: u32, statistics: &Statistics, mut arrays: Vec<Array>) -> Vec<u8> {
    let in_memory = "plain data serialises into memory";
    arrays.sort_by_key(|array| array.name);
    let statistics = written(statistics);
    let checksum = checksum(&statistics, &arrays.iter().map(|array| &array.bytes[..]).collect::<Vec<_>>());
    // There is only one entry: several would be written in random order.
    let header = serde_json::to_string(&Header { format, statistics, checksum }).expect(in_memory);
    let metadata = HashMap::from([(KEY.to_string(), header)]);
    let tensors = arrays.iter().map(|Array { name, dtype, shape, bytes }| {
        (*name, TensorView::new(*dtype, shape.clone(), bytes).expect("shape and length agree"))
    });
    serialize(tensors, Some(metadata)).expect(in_memory)
}

/// Whether `bytes` begin as a model file does: with the length of the header, and a header that
/// names this project.
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
    if !format.is_some_and(|format| READABLE_FORMATS.contains(&format)) {
        let found = format.map_or("an unreadable version".into(), |f| format!("version {f}"));
        return Err(fault(format!("its format is {found}, expected version {FORMAT}: learn it anew")));
    }
    let altered = |what: &str| fault(format!("altered or damaged: {what}"));
    let header: Header = serde_json::from_str(header).map_err(|e| altered(&format!("unreadable header ({e})")))?;
    let statistics: Statistics =
        serde_json::from_str(header.statistics.get()).map_err(|e| altered(&format!("unreadable statistics ({e})")))?;
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| fault(format!("truncated or damaged ({e})")))?;
    let data = |name: &str| tensors.tensor(name).map_err(|_| altered(&format!("no tensor `{name}`")));
    let (boundary, classifier, scene) = (data("boundary")?, data("classifier")?, data("scene")?);
    let mut names = tensors.names();
    names.sort_unstable();
    let parts = names.iter().map(|name| data(name).map(|tensor| tensor.data())).collect::<Result<Vec<_>>>()?;
    if checksum(&header.statistics, &parts) != header.checksum {
        return Err(altered("the checksum does not match"));
    }
    let stored = Stored {
        format: u64::from(header.format),
        statistics,
        scene: scene.data(),
        classifier: classifier.data(),
        boundary,
    };
    restore(stored, &tensors).map_err(|problem| altered(&problem))
}

/// Contents of a file, of which only the lengths were checked.
struct Stored<'a> {
    format: u64,
    statistics: Statistics,
    scene: &'a [u8],
    classifier: &'a [u8],
    boundary: TensorView<'a>,
}

/// Makes the model of a file's contents. Whoever changes a file can make its checksum right, so
/// everything is checked before it is used.
///
/// # Errors
/// The element, its value, and what was expected.
fn restore(stored: Stored, tensors: &SafeTensors) -> std::result::Result<Model, String> {
    let Stored { format, statistics, scene, classifier, boundary } = stored;
    let scene = scene_bytes::decode(format, scene).map_err(|e| format!("scene ({e})"))?;
    sound::check(&scene).map_err(|problem| format!("scene: {problem}"))?;
    let (space, pairs) = (&scene.space, scene.pairs.len());
    let classifier: Option<ObstacleClassifier> =
        postcard::from_bytes(classifier).map_err(|e| format!("classifier ({e})"))?;
    let fitting = classifier.iter().try_for_each(|classifier| classifier.check(space, pairs, relative::WIDTH));
    fitting.map_err(|problem| format!("classifier: {problem}"))?;
    let rows = boundary.shape().first().copied().unwrap_or(0);
    if rows == 0 || boundary.dtype() != Dtype::F64 || boundary.shape().get(1) != Some(&space.nq()) {
        let found = format!("got the shape {:?} of {:?}", boundary.shape(), boundary.dtype());
        return Err(format!("boundary samples do not fit the scene: {found}, expected rows of {} F64", space.nq()));
    }
    let configs = numbers(tensors, "boundary", Dtype::F64, f64::from_le_bytes)?;
    space.check_rows(&configs).map_err(|problem| format!("`boundary`: {problem}"))?;
    statistics.check(rows).map_err(|problem| format!("statistics: {problem}"))?;
    let scene = Arc::new(scene);
    let metric = Metric::new(scene.clone());
    let checker = if format < FIRST_WITH_TREES { Checker::new(scene) } else { derived::checker(tensors, scene)? };
    if format == READABLE_FORMATS[0] {
        return Ok(Model::from_parts(checker, metric, configs, classifier, statistics));
    }
    if format >= FIRST_WITH_PIECE_SIZES {
        derived::restore_pieces(tensors, &checker)?;
    } else {
        checker.prepare_proposals();
    }
    let boundary = derived::restore(tensors, &checker, &metric, configs, statistics.solved_samples)?;
    Ok(Model::with_boundary(checker, metric, boundary, classifier, statistics))
}

fn checksum(statistics: &RawValue, parts: &[&[u8]]) -> String {
    hash(&[&[statistics.get().as_bytes()], parts].concat())
}

/// Returns the BLAKE3 hash of the parts, each after its length.
pub(super) fn hash(parts: &[&[u8]]) -> String {
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
    use crate::model::evaluate::tests::of_model;
    use crate::query::prepared::tests::colliding;
    use crate::query::query;
    use crate::scene::{MetricKind, builtin};

    fn small(threads: usize) -> Model {
        let options = LearnOptions { labels: 20_000, seconds: None, seed: 3, threads };
        Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap()
    }

    #[test]
    fn bytes_survive_and_do_not_depend_on_threads() {
        let bytes = encode(&small(1));
        assert!(bytes == encode(&small(2)), "the bytes depend on the number of threads");
        let back = decode(Path::new("m"), &bytes).unwrap();
        assert!(encode(&back) == bytes);
    }

    /// Asserts that two models are the same, and that they give the same answers.
    fn assert_equal(a: &Model, b: &Model) {
        assert!(encode(a) == encode(b));
        assert_answers_equal(a, b);
    }

    fn assert_answers_equal(a: &Model, b: &Model) {
        for q in colliding(a.prepared(), 30) {
            let [x, y] =
                [a, b].map(|model| query(&of_model(model), &q, &Default::default(), &mut Default::default()).unwrap());
            assert_eq!((x.witness, x.lower_bound, x.checks), (y.witness, y.lower_bound, y.checks));
        }
    }

    /// Learns a model with solved samples.
    fn with_solved(name: &str, metric: Option<MetricKind>) -> Model {
        let mut scene = builtin::scene(name).unwrap();
        scene.metric = metric.unwrap_or(scene.metric);
        let options = LearnOptions { labels: 90_000, seconds: None, seed: 3, ..LearnOptions::default() };
        let model = Model::learn(scene, &options).unwrap();
        assert!(model.statistics().solved_samples > 20, "{:?}", model.statistics());
        model
    }

    #[test]
    fn what_is_loaded_answers_as_what_was_learned() {
        for (name, metric) in [("planar-arm", Some(MetricKind::ObjectNorm)), ("free-box", None)] {
            let model = with_solved(name, metric);
            assert_equal(&model, &decode(Path::new("m"), &encode(&model)).unwrap());
        }
    }

    #[test]
    fn statistics_of_versions_before_are_read() {
        let model = with_solved("planar-arm", None);
        let now = serde_json::to_string(model.statistics()).unwrap();
        let before = now.replace("\"solved_samples\"", "\"exits\"");
        assert_ne!(now, before);
        assert_eq!(&serde_json::from_str::<Statistics>(&before).unwrap(), model.statistics());
        for (now_gone, end) in [
            (r#"{"width":"wide","#, "memory"),
            (r#"{"starts_per_dof":{"stored":2.5,"around":0.25},"adapted":{"learned_labels":9,"times":1},"#, "quality"),
        ] {
            let before =
                now.replacen('{', now_gone, 1).replace(r#""ended_by":"labels""#, &format!(r#""ended_by":"{end}""#));
            assert_eq!(&serde_json::from_str::<Statistics>(&before).unwrap(), model.statistics(), "{before}");
        }
    }

    #[test]
    fn a_file_of_the_version_before_becomes_one_of_this() {
        let model = with_solved("free-box", None);
        for version in [5, 8] {
            let mut arrays = learned(&model);
            if version > 5 {
                arrays.extend(derived::arrays(&model));
            }
            let scene = scene_bytes::encode_old(version.into(), (**model.scene()).clone());
            let array = arrays.iter_mut().find(|array| array.name == "scene").unwrap();
            (array.shape, array.bytes) = (vec![scene.len()], scene);
            let before = container(version, model.statistics(), arrays);
            let read = decode(Path::new("m"), &before).unwrap();
            assert_eq!(read.scene().links.is_empty(), version < 8);
            assert!(read.scene().rigid.is_empty());
            assert_answers_equal(&model, &read);
        }
        let older = container(4, model.statistics(), learned(&model));
        let message = decode(Path::new("m"), &older).err().unwrap().to_string();
        assert!(message.contains("m: its format is version 4, expected version 14"), "{message}");
    }

    /// The checksum of each spoiled file is right.
    #[test]
    fn arrays_that_do_not_fit_are_refused_by_name() {
        let model = with_solved("free-box", None);
        let refused = |spoil: &dyn Fn(&mut Vec<Array>)| {
            let mut arrays = learned(&model);
            arrays.extend(derived::arrays(&model));
            spoil(&mut arrays);
            let bytes = container(FORMAT, model.statistics(), arrays);
            decode(Path::new("my.model"), &bytes).err().map(|e| e.to_string())
        };
        assert_eq!(refused(&|_| ()), None);
        for Array { name, .. } in derived::arrays(&model) {
            let message = refused(&|arrays| arrays.retain(|array| array.name != name)).unwrap();
            assert!(message.contains("my.model") && message.contains(name), "{name}: {message}");
            let message = refused(&|arrays| {
                let array = arrays.iter_mut().find(|array| array.name == name).unwrap();
                (array.dtype, array.shape) = (Dtype::I8, vec![array.bytes.len()]);
            });
            assert!(message.unwrap().contains("of type I8"), "{name}");
            let message = refused(&|arrays| {
                // One number too few, or one too many if there are none.
                let array = arrays.iter_mut().find(|array| array.name == name).unwrap();
                let size = array.dtype.bitsize() / 8;
                let len = if array.bytes.is_empty() { size } else { array.bytes.len() - size };
                array.bytes.resize(len, 0);
                array.shape = vec![len / size];
            });
            let of = name.split('.').next().unwrap();
            assert!(message.as_ref().is_some_and(|message| message.contains(of)), "{name}: {message:?}");
        }
    }

    /// Unlike the scenes above, this one has meshes.
    #[test]
    fn trees_are_kept_made_anew_or_refused() {
        let options = LearnOptions { labels: 3_000, seconds: None, seed: 3, ..LearnOptions::default() };
        let model = Model::learn(builtin::scene("shelf-arm").unwrap(), &options).unwrap();
        let with = |version: u32, change: &dyn Fn(&mut Vec<Array>)| {
            let mut arrays = learned(&model);
            arrays.extend(derived::arrays(&model));
            change(&mut arrays);
            decode(Path::new("my.model"), &container(version, model.statistics(), arrays))
        };
        assert_equal(&model, &with(FORMAT, &|_| ()).unwrap());
        assert_equal(&model, &with(10, &|arrays| arrays.retain(|array| !array.name.starts_with("trees"))).unwrap());
        let twice = |arrays: &mut Vec<Array>| {
            let order = arrays.iter_mut().find(|array| array.name == "trees.order").unwrap();
            assert!(order.bytes.len() > 400, "{} bytes", order.bytes.len());
            order.bytes.copy_within(0..4, 4);
        };
        let message = with(FORMAT, &twice).err().unwrap().to_string();
        assert!(message.contains("my.model: altered or damaged: `trees`: expected of every mesh"), "{message}");
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
