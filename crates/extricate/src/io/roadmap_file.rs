//! The roadmap file: bytes to [`Roadmap`] and back.
//!
//! A safetensors container, so that NumPy reads the arrays: `configs` (f64, nodes x nq), `edges`
//! (u32, edges x 2, indices of nodes), `narrow` (u32, indices of nodes). Its one metadata entry,
//! `extricate-roadmap`, is JSON: format version, seed and counts, and the BLAKE3 hash of
//! everything. The hash reveals damage, not malice, so `Roadmap::of_parts` checks every field. No
//! proof rests on the file: a path is proved before it is returned.

use std::collections::HashMap;
use std::path::Path;

use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};

use super::files::read;
use super::model_file::hash;
use super::writing::{check_output, write_atomically};
use crate::applications::motion::Roadmap;
use crate::applications::motion::roadmap::RoadmapParts;
use crate::cspace::ConfigSpace;
use crate::error::{Error, Result};
use crate::scene::Scene;

/// Version of the layout; a file of another version is refused.
const FORMAT: u32 = 1;
const KEY: &str = "extricate-roadmap";

#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    checksum: String,
    /// JSON as text, so that the hash covers bytes that a reader has.
    roadmap: String,
}

/// Writes a roadmap file, see [`write_atomically`]. It replaces only roadmaps and empty files.
///
/// # Errors
/// [`Error::Write`]; the old file, if any, is then untouched.
pub fn save_roadmap(roadmap: &Roadmap, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    check_roadmap_output(path)?;
    write_atomically(path, &encode(roadmap))
}

/// Checks that [`save_roadmap`] can be expected to succeed.
///
/// # Errors
/// As [`save_roadmap`].
pub fn check_roadmap_output(path: &Path) -> Result<()> {
    check_output(path, "roadmap", is_roadmap)
}

/// Loads a roadmap file, for plans in `scene`.
///
/// # Errors
/// [`Error::Read`], and [`Error::Input`] if the file is truncated, altered, foreign, of another
/// version or of other coordinates than those of the scene.
pub fn load_roadmap(path: impl AsRef<Path>, scene: &Scene) -> Result<Roadmap> {
    let path = path.as_ref();
    decode(path, &read(path)?, &scene.space)
}

/// Whether `bytes` begin as a roadmap file does.
pub fn is_roadmap(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(4096)];
    head.get(8) == Some(&b'{') && head.windows(KEY.len()).any(|at| at == KEY.as_bytes())
}

/// Returns the bytes of a roadmap file. The same roadmap gives the same bytes.
pub fn encode(roadmap: &Roadmap) -> Vec<u8> {
    let in_memory = "plain data serialises into memory";
    let RoadmapParts { nq, configs, edges, narrow, rest } = roadmap.parts();
    let rest = serde_json::to_string(&rest).expect(in_memory);
    let configs: Vec<u8> = configs.iter().flat_map(|x| x.to_le_bytes()).collect();
    let edges: Vec<u8> = edges.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let narrow: Vec<u8> = narrow.iter().flat_map(|x| x.to_le_bytes()).collect();
    let checksum = hash(&[rest.as_bytes(), &configs, &edges, &narrow]);
    let header = serde_json::to_string(&Header { format: FORMAT, checksum, roadmap: rest }).expect(in_memory);
    let view = |dtype, shape, data| TensorView::new(dtype, shape, data).expect("shape and length agree");
    let tensors = [
        ("configs", view(Dtype::F64, vec![configs.len() / 8 / nq, nq], &configs[..])),
        ("edges", view(Dtype::U32, vec![edges.len() / 8, 2], &edges[..])),
        ("narrow", view(Dtype::U32, vec![narrow.len() / 4], &narrow[..])),
    ];
    serialize(tensors, Some(HashMap::from([(KEY.to_string(), header)]))).expect(in_memory)
}

/// Reads the bytes of a roadmap file; `path` is its name in messages.
///
/// # Errors
/// [`Error::Input`]: foreign, truncated, altered, of another version, or of other coordinates.
pub fn decode(path: &Path, bytes: &[u8], space: &ConfigSpace) -> Result<Roadmap> {
    let fault = |element: &str, problem: String| Error::input(format!("roadmap {}", path.display()), element, problem);
    let not_one =
        |error| fault("file", format!("got no roadmap, or a truncated one ({error}), expected a roadmap file"));
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(not_one)?;
    let header = metadata.metadata().as_ref().and_then(|entries| entries.get(KEY));
    let header = header.ok_or_else(|| fault("file", "got another safetensors file, expected a roadmap file".into()))?;
    let damaged = |element: &str, problem: String| fault(element, format!("altered or damaged: {problem}"));
    let header: Header = serde_json::from_str(header).map_err(|error| damaged("header", error.to_string()))?;
    if header.format != FORMAT {
        return Err(fault("format", format!("got version {}, expected {FORMAT}: plan anew", header.format)));
    }
    let tensors = SafeTensors::deserialize(bytes).map_err(not_one)?;
    let data = |name: &str, dtype: Dtype| {
        let tensor = tensors.tensor(name).map_err(|_| damaged(name, "it is missing".into()))?;
        if tensor.dtype() != dtype {
            return Err(damaged(name, format!("got {:?}, expected {dtype:?}", tensor.dtype())));
        }
        Ok(tensor.data().to_vec())
    };
    let (configs, edges, narrow) =
        (data("configs", Dtype::F64)?, data("edges", Dtype::U32)?, data("narrow", Dtype::U32)?);
    if hash(&[header.roadmap.as_bytes(), &configs, &edges, &narrow]) != header.checksum {
        return Err(damaged("checksum", "it does not match".into()));
    }
    let parts = RoadmapParts {
        nq: space.nq(),
        configs: configs.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        edges: nodes(&edges).as_chunks::<2>().0.to_vec(),
        narrow: nodes(&narrow),
        rest: serde_json::from_str(&header.roadmap).map_err(|error| damaged("header", error.to_string()))?,
    };
    Roadmap::of_parts(parts, space).map_err(|problem| damaged("contents", problem))
}

fn nodes(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;
    use crate::solver::Solver;

    fn grown() -> (Solver, Roadmap) {
        let solver = Solver::new(builtin::scene("planar-arm").unwrap());
        let mut roadmap = Roadmap::new(&solver.scene().space, 3);
        solver.grow_roadmap(&mut roadmap, 500, &Default::default()).unwrap();
        (solver, roadmap)
    }

    #[test]
    fn roadmaps_are_read_as_they_were_written() {
        let (solver, roadmap) = grown();
        let space = &solver.scene().space;
        let bytes = encode(&roadmap);
        assert!(is_roadmap(&bytes) && roadmap.len() > 5);
        assert_eq!(decode(Path::new("r"), &bytes, space).unwrap(), roadmap);
        let other = builtin::scene("free-box").unwrap().space;
        assert!(decode(Path::new("r"), &bytes, &other).is_err());
    }

    #[test]
    fn every_altered_byte_is_noticed() {
        let (solver, roadmap) = grown();
        let space = &solver.scene().space;
        let bytes = encode(&roadmap);
        for at in 0..bytes.len() {
            let mut altered = bytes.clone();
            altered[at] ^= 0x20;
            // The case of a letter of a name that nobody reads may change, nothing else.
            let read = decode(Path::new("r"), &altered, space);
            assert!(read.is_err() || read.unwrap() == roadmap, "byte {at}");
            assert!(decode(Path::new("r"), &bytes[..at], space).is_err());
        }
    }
}
