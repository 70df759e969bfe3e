//! Reads rows of numbers of a glTF accessor, plain, strided, normalised or sparse; checks every
//! range.

use std::rc::Rc;

use gltf::Accessor;
use gltf::accessor::DataType;
use gltf::accessor::sparse::IndexType;
use gltf::buffer::View;

use crate::error::{Error, Result};
use crate::robot::{LoadLimit, LoadLimits};

/// Reads all rows of an accessor. A sparse one without a view is zero in the other rows.
pub(crate) fn rows<const N: usize>(
    file: &str,
    buffers: &[Rc<[u8]>],
    limits: &LoadLimits,
    accessor: &Accessor,
) -> Result<Vec<[f64; N]>> {
    let fault = |problem: String| Error::input(file, format!("accessors[{}]", accessor.index()), problem);
    if accessor.dimensions().multiplicity() != N {
        return Err(fault(format!("got {:?}, expected {N} numbers a row", accessor.dimensions())));
    }
    let (kind, count) = (accessor.data_type(), accessor.count());
    // Sparse rows may take no bytes in the file, so their number is checked first.
    limits.check(LoadLimit::Vertices, count / if N == 1 { 3 } else { 1 }, file, "accessors")?;
    let row = |bytes: &[u8]| -> [f64; N] {
        std::array::from_fn(|k| number(kind, accessor.normalized(), &bytes[k * kind.size()..]))
    };
    let cut = || fault(format!("got a buffer that ends before its {count} rows, expected them in it"));
    let mut rows: Vec<[f64; N]> = match accessor.view() {
        Some(view) => {
            let chunks = chunks(buffers, &view, accessor.offset(), count, N * kind.size()).ok_or_else(cut)?;
            chunks.map(row).collect()
        }
        None if accessor.sparse().is_some() => vec![[0.0; N]; count],
        None => return Err(fault("got no bufferView, expected one".into())),
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let width = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let at = chunks(buffers, &indices.view(), indices.offset(), sparse.count(), width).ok_or_else(cut)?;
        let new = chunks(buffers, &values.view(), values.offset(), sparse.count(), N * kind.size()).ok_or_else(cut)?;
        for (at, new) in at.zip(new) {
            let at = at.iter().rev().fold(0, |all, &byte| all << 8 | usize::from(byte));
            *rows.get_mut(at).ok_or_else(|| fault(format!("got the sparse index {at}, expected one of {count}")))? =
                row(new);
        }
    }
    Ok(rows)
}

/// Returns the bytes of `count` elements of `size` bytes from `offset` of a view; `None` if not all
/// are there.
fn chunks<'a>(
    buffers: &'a [Rc<[u8]>],
    view: &View,
    offset: usize,
    count: usize,
    size: usize,
) -> Option<impl Iterator<Item = &'a [u8]> + use<'a>> {
    let buffer = buffers.get(view.buffer().index())?;
    let bytes = buffer.get(view.offset()..view.offset().checked_add(view.length())?)?.get(offset..)?;
    let stride = view.stride().unwrap_or(size);
    let fits = match count.checked_sub(1) {
        Some(last) => last.checked_mul(stride)?.checked_add(size)? <= bytes.len(),
        None => true,
    };
    (fits && stride >= size).then(|| (0..count).map(move |k| &bytes[k * stride..k * stride + size]))
}

/// Decodes the first number of `bytes`. Normalised integers are shares of the greatest one.
fn number(kind: DataType, normalized: bool, bytes: &[u8]) -> f64 {
    let share = |value: f64, greatest: f64| if normalized { (value / greatest).max(-1.0) } else { value };
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    match kind {
        DataType::I8 => share((bytes[0] as i8).into(), i8::MAX.into()),
        DataType::U8 => share(bytes[0].into(), u8::MAX.into()),
        DataType::I16 => share(i16::from_le_bytes(two()).into(), i16::MAX.into()),
        DataType::U16 => share(u16::from_le_bytes(two()).into(), u16::MAX.into()),
        DataType::U32 => u32::from_le_bytes(four()).into(),
        DataType::F32 => f32::from_le_bytes(four()).into(),
    }
}
