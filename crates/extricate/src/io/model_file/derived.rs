//! Arrays of a model file that could be made anew from the rest. They are stored because making
//! them takes most of the time of loading: indices of samples and solved samples, planes of solved
//! samples, trees and convex pieces of meshes.
//!
//! `index.lists`, `index.centres`, `index.margins`, `index.basis` (see [`IndexArrays`]), the same
//! of `exits`; `planes.counts`, `planes.pairs`, `planes.columns`, `planes.numbers` (see
//! [`ContactPlaneArrays`]); `pieces.counts`, `pieces.coarse`, `pieces.fine`, `pieces.sizes`,
//! `pieces.points` (see [`PieceArrays`]); `trees.counts`, `trees.elements`, `trees.order` (see
//! [`TreeArrays`]).
//!
//! No proof and no verification rests on any of it: wrong pieces could lower a bound, but never
//! raise one. Arrays that do not fit the rest are refused.

use std::sync::Arc;

use safetensors::tensor::{Dtype, SafeTensors};

use super::array::Array;
use crate::collision::{Checker, PieceArrays, TreeArrays};
use crate::metric::Metric;
use crate::model::Model;
use crate::samples::SampleSet;
use crate::samples::arrays::{IndexArrays, Mismatch, SampleArrays};
use crate::samples::contact_planes::ContactPlaneArrays;
use crate::scene::Scene;

/// Names of an index's lists, centres, margins and basis.
type Names = [&'static str; 4];

const SAMPLE_INDEX: Names = ["index.lists", "index.centres", "index.margins", "index.basis"];
const SOLVED_INDEX: Names = ["exits.lists", "exits.centres", "exits.margins", "exits.basis"];

pub fn arrays(model: &Model) -> Vec<Array> {
    let SampleArrays { all, solved, planes } = model.boundary().kept();
    let ContactPlaneArrays { counts, pairs, columns, numbers } = planes;
    let pieces = model.prepared().checker().kept_pieces();
    let trees = model.prepared().checker().kept_trees();
    let mut arrays = Vec::from(of_index(SAMPLE_INDEX, &all));
    arrays.extend(solved.iter().flat_map(|solved| of_index(SOLVED_INDEX, solved)));
    arrays.extend([
        array("planes.counts", Dtype::U8, &counts, u8::to_le_bytes),
        // Two bytes are enough as a rule, which makes the file smaller.
        match pairs.iter().map(|pair| u16::try_from(*pair)).collect::<Result<Vec<u16>, _>>() {
            Ok(pairs) => array("planes.pairs", Dtype::U16, &pairs, u16::to_le_bytes),
            Err(_) => array("planes.pairs", Dtype::U32, &pairs, u32::to_le_bytes),
        },
        array("planes.columns", Dtype::U8, &columns, u8::to_le_bytes),
        array("planes.numbers", Dtype::F32, &numbers, f32::to_le_bytes),
        array("pieces.counts", Dtype::U32, &pieces.counts, u32::to_le_bytes),
        array("pieces.coarse", Dtype::U8, &pieces.coarse, u8::to_le_bytes),
        array("pieces.fine", Dtype::U32, &pieces.fine, u32::to_le_bytes),
        array("pieces.sizes", Dtype::U32, &pieces.sizes, u32::to_le_bytes),
        array("pieces.points", Dtype::F64, &pieces.points, f64::to_le_bytes),
        array("trees.counts", Dtype::U32, &trees.counts, u32::to_le_bytes),
        array("trees.elements", Dtype::U8, &trees.elements, u8::to_le_bytes),
        array("trees.order", Dtype::U32, &trees.order, u32::to_le_bytes),
    ]);
    arrays
}

fn of_index([lists, centres, margins, basis]: Names, kept: &IndexArrays) -> [Array; 4] {
    [
        array(lists, Dtype::U16, &kept.lists, u16::to_le_bytes),
        array(centres, Dtype::F32, &kept.centres, f32::to_le_bytes),
        array(margins, Dtype::F32, &kept.margins, f32::to_le_bytes),
        array(basis, Dtype::F64, &kept.basis, f64::to_le_bytes),
    ]
}

fn array<T: Copy, const N: usize>(name: &'static str, dtype: Dtype, numbers: &[T], bytes: fn(T) -> [u8; N]) -> Array {
    let bytes = numbers.iter().flat_map(|x| bytes(*x)).collect();
    Array { name, dtype, shape: vec![numbers.len()], bytes }
}

/// Makes the checker of `scene` with its stored trees.
///
/// # Errors
/// The array that is missing or does not fit, and what was expected of it.
pub fn checker(tensors: &SafeTensors, scene: Arc<Scene>) -> Result<Checker, String> {
    let trees = TreeArrays {
        counts: numbers(tensors, "trees.counts", Dtype::U32, u32::from_le_bytes)?,
        elements: numbers(tensors, "trees.elements", Dtype::U8, u8::from_le_bytes)?,
        order: numbers(tensors, "trees.order", Dtype::U32, u32::from_le_bytes)?,
    };
    let expected = "`trees`: expected of every mesh a tree with each of its triangles once, of convex ones none";
    Checker::with_trees(scene, &trees).ok_or_else(|| expected.into())
}

/// Gives `checker` the stored pieces of its meshes.
///
/// # Errors
/// The array that is missing or does not fit, and what was expected of it.
pub fn restore_pieces(tensors: &SafeTensors, checker: &Checker) -> Result<(), String> {
    let pieces = PieceArrays {
        counts: numbers(tensors, "pieces.counts", Dtype::U32, u32::from_le_bytes)?,
        coarse: numbers(tensors, "pieces.coarse", Dtype::U8, u8::from_le_bytes)?,
        fine: numbers(tensors, "pieces.fine", Dtype::U32, u32::from_le_bytes)?,
        sizes: numbers(tensors, "pieces.sizes", Dtype::U32, u32::from_le_bytes)?,
        points: numbers(tensors, "pieces.points", Dtype::F64, f64::from_le_bytes)?,
    };
    if checker.take_pieces(&pieces) {
        return Ok(());
    }
    Err("`pieces`: expected hulls in the boxes of the meshes, around all of their vertices".into())
}

/// Makes the sample set of `configs`, the last `exits` of which are solved, and stored arrays.
///
/// # Errors
/// The array that is missing or does not fit, and what was expected of it.
pub fn restore(
    tensors: &SafeTensors,
    checker: &Checker,
    metric: &Metric,
    configs: Vec<f64>,
    exits: usize,
) -> Result<SampleSet, String> {
    let pairs = match tensors.tensor("planes.pairs").map(|found| found.dtype()) {
        Ok(Dtype::U16) => {
            let pairs: Vec<u16> = numbers(tensors, "planes.pairs", Dtype::U16, u16::from_le_bytes)?;
            pairs.into_iter().map(u32::from).collect()
        }
        _ => numbers(tensors, "planes.pairs", Dtype::U32, u32::from_le_bytes)?,
    };
    let planes = ContactPlaneArrays {
        counts: numbers(tensors, "planes.counts", Dtype::U8, u8::from_le_bytes)?,
        pairs,
        columns: numbers(tensors, "planes.columns", Dtype::U8, u8::from_le_bytes)?,
        numbers: numbers(tensors, "planes.numbers", Dtype::F32, f32::from_le_bytes)?,
    };
    let of_solved = (exits > 0).then(|| index(tensors, SOLVED_INDEX)).transpose()?;
    let kept = SampleArrays { all: index(tensors, SAMPLE_INDEX)?, solved: of_solved, planes };
    let scene = checker.scene();
    let sizes = [scene.space.nq(), scene.space.nv(), scene.pairs.len()];
    SampleSet::restored(metric, sizes, configs, exits, &kept)
        .map_err(|Mismatch { of, array, expected }| format!("`{of}.{array}`: expected {expected}"))
}

fn index(tensors: &SafeTensors, [lists, centres, margins, basis]: Names) -> Result<IndexArrays, String> {
    Ok(IndexArrays {
        lists: numbers(tensors, lists, Dtype::U16, u16::from_le_bytes)?,
        centres: numbers(tensors, centres, Dtype::F32, f32::from_le_bytes)?,
        margins: numbers(tensors, margins, Dtype::F32, f32::from_le_bytes)?,
        basis: numbers(tensors, basis, Dtype::F64, f64::from_le_bytes)?,
    })
}

/// Returns the numbers of an array.
///
/// # Errors
/// The array is missing or of another type.
pub fn numbers<T, const N: usize>(
    tensors: &SafeTensors,
    name: &str,
    dtype: Dtype,
    number: fn([u8; N]) -> T,
) -> Result<Vec<T>, String> {
    let found = tensors.tensor(name).map_err(|_| format!("no tensor `{name}`"))?;
    if found.dtype() != dtype {
        return Err(format!("`{name}`: got numbers of type {:?}, expected {dtype:?}", found.dtype()));
    }
    Ok(found.data().as_chunks().0.iter().map(|bytes| number(*bytes)).collect())
}
