//! What the checkpoints of all kinds of runs have in common: a container of lists of
//! configurations, beside what a run says of itself.
//!
//! A safetensors container of lists (f64, rows x nq) and of bytes (u8). Its one metadata entry is
//! JSON: format version, what the run says of itself, and the BLAKE3 hash of everything.

use std::collections::HashMap;
use std::path::Path;

use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};

use super::hash;
use crate::error::{Error, Result};
use crate::scene::Scene;

/// A kind of run.
pub struct Kind {
    /// Of the metadata entry; that of learning, or that with something behind it.
    pub key: &'static str,
    /// What runs of this kind do.
    pub verb: &'static str,
    /// Version of the layout, and of the steps of the run.
    pub format: u32,
}

/// What the keys of all kinds begin with.
pub const KEY: &str = "extricate-checkpoint";

#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    checksum: String,
    /// JSON itself, for the hash to be over bytes that a reader has.
    run: String,
}

/// The bytes of a checkpoint; `run` is what the run says of itself.
pub fn encode(kind: &Kind, run: String, nq: usize, lists: &[(&str, &[f64])], others: &[(&str, &[u8])]) -> Vec<u8> {
    let in_memory = "plain data serialises into memory";
    let bytes = |list: &[f64]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let lists: Vec<(&str, Vec<u8>)> = lists.iter().map(|(name, list)| (*name, bytes(list))).collect();
    let mut parts = vec![run.as_bytes()];
    parts.extend(lists.iter().map(|(_, list)| &list[..]).chain(others.iter().map(|(_, bytes)| *bytes)));
    let checksum = hash(&parts);
    let header = serde_json::to_string(&Header { format: kind.format, checksum, run }).expect(in_memory);
    let view = |dtype, shape, data| TensorView::new(dtype, shape, data).expect("shape and length agree");
    let mut tensors: Vec<(&str, TensorView)> = Vec::new();
    tensors
        .extend(lists.iter().map(|(name, list)| (*name, view(Dtype::F64, vec![list.len() / 8 / nq, nq], &list[..]))));
    tensors.extend(others.iter().map(|(name, bytes)| (*name, view(Dtype::U8, vec![bytes.len()], *bytes))));
    serialize(tensors, Some(HashMap::from([(kind.key.to_string(), header)]))).expect(in_memory)
}

/// Whether `bytes` begin as a checkpoint does, of whatever kind.
pub fn is_checkpoint(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(4096)];
    head.get(8) == Some(&b'{') && head.windows(KEY.len()).any(|at| at == KEY.as_bytes())
}

/// What a run of this kind said of itself, and its arrays, which have to be those of `names` in the
/// order in which they were written; `path` is the file's name in messages.
///
/// # Errors
/// [`Error::Checkpoint`]: foreign, of another kind, truncated, altered, or of another version.
pub fn decode<'a>(kind: &Kind, path: &Path, bytes: &'a [u8], names: &[&str]) -> Result<(String, SafeTensors<'a>)> {
    let fault = |problem: String| Error::Checkpoint { path: path.into(), problem };
    let not_one = |e| fault(format!("not a checkpoint, or a truncated one ({e})"));
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(not_one)?;
    let entries = metadata.metadata().as_ref();
    let header = entries.and_then(|m| m.get(kind.key)).ok_or_else(|| {
        let of_another = entries.is_some_and(|m| m.keys().any(|key| key.starts_with(KEY)));
        let is = if of_another { "a checkpoint of another kind of run" } else { "a safetensors file" };
        fault(format!("{is}, but not a checkpoint of `{}`", kind.verb))
    })?;
    let format = serde_json::from_str::<serde_json::Value>(header).ok().and_then(|v| v.get("format")?.as_u64());
    if format != Some(kind.format.into()) {
        return Err(fault(format!(
            "its format is not version {}, which this program writes; {} without --resume",
            kind.format, kind.verb
        )));
    }
    let damaged = |what: String| fault(format!("altered or damaged: {what}"));
    let header: Header = serde_json::from_str(header).map_err(|e| damaged(e.to_string()))?;
    let tensors = SafeTensors::deserialize(bytes).map_err(not_one)?;
    let mut parts: Vec<&[u8]> = vec![header.run.as_bytes()];
    for name in names {
        parts.push(tensors.tensor(name).map_err(|_| damaged(format!("no tensor `{name}`")))?.data());
    }
    if hash(&parts) != header.checksum {
        return Err(damaged("the checksum does not match".into()));
    }
    Ok((header.run, tensors))
}

/// The numbers of a list.
pub fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
}

/// What tells scenes apart.
pub fn scene_hash(scene: &Scene) -> String {
    hash(&[&postcard::to_stdvec(scene).expect("plain data serialises into memory")])
}
