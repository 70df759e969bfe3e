//! Takes model files and roadmaps apart, and puts them together again with a right checksum, as an
//! attacker would.
//!
//! The integration tests of the library use this file too.

use std::collections::HashMap;

use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde_json::json;
use serde_json::value::RawValue;

/// Metadata key of a model.
const MODEL_KEY: &str = "extricate";
/// Metadata key of a roadmap, and the order of its arrays under the checksum.
const ROADMAP_KEY: &str = "extricate-roadmap";
const ROADMAP_ARRAYS: [&str; 3] = ["configs", "edges", "narrow"];

/// A file taken apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Container {
    /// Metadata key, which differs by the kind of file.
    pub key: String,
    /// Version of the layout.
    pub format: u64,
    /// Statistics of a model, or the properties of a roadmap: JSON.
    pub text: String,
    /// Arrays in the order of their names.
    pub arrays: Vec<Array>,
}

/// One array of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Name in the file.
    pub name: String,
    /// Type of its numbers.
    pub dtype: Dtype,
    /// Number of rows, and of columns if there are any.
    pub shape: Vec<usize>,
    /// The numbers, least byte first.
    pub bytes: Vec<u8>,
}

impl Container {
    /// Takes a file apart, whatever its checksum is. Returns `None` for files of other kinds.
    pub fn open(file: &[u8]) -> Option<Self> {
        let (_, metadata) = SafeTensors::read_metadata(file).ok()?;
        let (key, header) = metadata.metadata().as_ref()?.iter().next()?;
        let parts: HashMap<String, Box<RawValue>> = serde_json::from_str(header).ok()?;
        let format = parts.get("format")?.get().parse().ok()?;
        let text = match parts.get("roadmap") {
            Some(text) => serde_json::from_str(text.get()).ok()?,
            None => parts.get("statistics")?.get().to_string(),
        };
        let tensors = SafeTensors::deserialize(file).ok()?;
        let mut names: Vec<String> = tensors.names().into_iter().map(str::to_string).collect();
        names.sort_unstable();
        let array = |name: String| {
            let found = tensors.tensor(&name).ok()?;
            Some(Array { dtype: found.dtype(), shape: found.shape().to_vec(), bytes: found.data().to_vec(), name })
        };
        let arrays = names.into_iter().map(array).collect::<Option<_>>()?;
        Some(Self { key: key.clone(), format, text, arrays })
    }

    /// Returns the file with a right checksum. Shapes follow from lengths; the bytes of an
    /// incomplete number at the end of an array are dropped.
    pub fn sealed(&self) -> Vec<u8> {
        let arrays: Vec<Array> = self.arrays.iter().map(Array::whole).collect();
        let named = |name: &str| arrays.iter().find(|array| array.name == name);
        let mut parts = vec![self.text.as_bytes()];
        if self.key == ROADMAP_KEY {
            parts.extend(ROADMAP_ARRAYS.iter().filter_map(|name| named(name)).map(|array| &array.bytes[..]));
        } else {
            parts.extend(arrays.iter().map(|array| &array.bytes[..]));
        }
        let mut hasher = blake3::Hasher::new();
        for part in parts {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
        let checksum = hasher.finalize().to_hex().to_string();
        let header = if self.key == MODEL_KEY {
            format!(r#"{{"format":{},"statistics":{},"checksum":"{checksum}"}}"#, self.format, self.text)
        } else {
            json!({"format": self.format, "checksum": checksum, "roadmap": self.text}).to_string()
        };
        let view = |array| {
            let Array { name, dtype, shape, bytes }: &Array = array;
            (name, TensorView::new(*dtype, shape.clone(), bytes).expect("shape and length agree"))
        };
        serialize(arrays.iter().map(view), Some(HashMap::from([(self.key.clone(), header)]))).expect("into memory")
    }

    /// Returns the array of this name.
    pub fn array(&mut self, name: &str) -> Option<&mut Array> {
        self.arrays.iter_mut().find(|array| array.name == name)
    }
}

impl Array {
    /// Number of bytes of one number.
    pub fn size(&self) -> usize {
        (self.dtype.bitsize() / 8).max(1)
    }

    /// Returns the array without incomplete numbers, and with the shape that follows.
    fn whole(&self) -> Self {
        let mut bytes = self.bytes.clone();
        bytes.truncate(bytes.len() / self.size() * self.size());
        let numbers = bytes.len() / self.size();
        let shape = match self.shape[..] {
            [_, columns] if columns > 0 && numbers.is_multiple_of(columns) => vec![numbers / columns, columns],
            _ => vec![numbers],
        };
        Self { name: self.name.clone(), dtype: self.dtype, shape, bytes }
    }
}
