//! Writes answers of many queries as rows of a structured array.

use extricate::{Answer, QueryOptions, Scene};
use numpy::PyArrayDescr;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Layout of an answer in a row: numbers of eight bytes, then booleans. Results that were not
/// requested have no field.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    nq: usize,
    nv: usize,
    segment: bool,
    free_radius: bool,
    /// Number of kept links, and of pairs that have to touch.
    kept: usize,
    /// Places for exits; 0 if only one was requested.
    exits: usize,
    /// Number of checked pairs of the scene; 0 if contacts were not requested.
    pairs: usize,
}

/// The name, type (`f8`, `i8` or `?`) and shape of a field.
type Field = (&'static str, &'static str, Vec<usize>);

impl Layout {
    /// Returns the layout of answers in `scene` to queries with `options`.
    pub fn new(scene: &Scene, options: &QueryOptions) -> Self {
        Self {
            nq: scene.space().nq(),
            nv: scene.space().nv(),
            segment: options.segment,
            free_radius: options.free_radius,
            kept: options.keep.len() + options.touch.len(),
            exits: if options.exits > 1 { options.exits } else { 0 },
            pairs: if options.contacts { scene.pairs().len() } else { 0 },
        }
    }

    /// Returns the fields of a row, in order.
    fn fields(self) -> Vec<Field> {
        let number = |name| (name, "f8", vec![]);
        let mut fields: Vec<Field> =
            ["depth", "lower_bound", "gap", "max_displacement", "clearance", "unseen"].map(number).into();
        fields.push(("checks", "i8", vec![]));
        fields.extend([("witness", "f8", vec![self.nq]), ("gradient", "f8", vec![self.nv])]);
        if self.segment {
            fields.push(("segment", "f8", vec![2]));
        }
        if self.free_radius {
            fields.push(("free_radius", "f8", vec![]));
        }
        if self.kept > 0 {
            fields.push(("kept", "f8", vec![self.kept, 2]));
        }
        if self.exits > 0 {
            fields.push(("exit_count", "i8", vec![]));
            let places = [("exit_depths", vec![self.exits]), ("exit_witnesses", vec![self.exits, self.nq])];
            fields.extend(places.map(|(name, shape)| (name, "f8", shape)));
        }
        fields.extend(["verified", "free", "unique"].map(|name| (name, "?", vec![])));
        if self.pairs > 0 {
            fields.extend(["colliding", "touching"].map(|name| (name, "?", vec![self.pairs])));
            if self.exits > 0 {
                fields.push(("exit_touching", "?", vec![self.exits, self.pairs]));
            }
        }
        fields
    }

    /// Returns the size of a row \[bytes\]; `None` if it overflows.
    pub fn size(self) -> Option<usize> {
        let add = |sum: usize, (_, kind, shape): Field| {
            let one = if kind == "?" { 1usize } else { 8 };
            let bytes = shape.into_iter().try_fold(one, usize::checked_mul)?;
            sum.checked_add(bytes)
        };
        self.fields().into_iter().try_fold(0, add)?.checked_next_multiple_of(8)
    }

    /// Returns the NumPy type of a row of `size` bytes.
    pub fn dtype(self, py: Python<'_>, size: usize) -> PyResult<Bound<'_, PyArrayDescr>> {
        let numpy = py.import("numpy")?;
        let (mut names, mut formats, mut offsets, mut at) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for (name, kind, shape) in self.fields() {
            names.push(name);
            offsets.push(at);
            at += if kind == "?" { 1 } else { 8 } * shape.iter().product::<usize>();
            let format = if shape.is_empty() {
                numpy.call_method1("dtype", (kind,))
            } else {
                numpy.call_method1("dtype", ((kind, shape),))
            };
            formats.push(format?);
        }
        let fields = PyDict::new(py);
        fields.set_item("names", names)?;
        fields.set_item("formats", formats)?;
        fields.set_item("offsets", offsets)?;
        fields.set_item("itemsize", size)?;
        Ok(numpy.call_method1("dtype", (fields,))?.cast_into()?)
    }

    /// Writes a row whose query was no configuration: its depth and its bound are NaN too.
    pub fn write_no_query(self, row: &mut [u8]) {
        self.write(None, row);
        row[..8].copy_from_slice(&f64::NAN.to_ne_bytes());
        row[8..16].copy_from_slice(&f64::NAN.to_ne_bytes());
    }

    /// Writes an answer into the bytes of its row, which are 0. Without an answer, the depth is
    /// infinite and most other numbers are NaN.
    pub fn write(self, answer: Option<&Answer>, row: &mut [u8]) {
        let mut at = 0;
        let mut put = |bytes: &[u8]| {
            row[at..at + bytes.len()].copy_from_slice(bytes);
            at += bytes.len();
        };
        let front = match answer {
            None => [f64::INFINITY, 0.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN],
            Some(a) => [a.depth, a.lower_bound, a.gap, a.max_displacement, a.clearance, a.unseen.unwrap_or(f64::NAN)],
        };
        front.iter().for_each(|x| put(&x.to_ne_bytes()));
        put(&answer.map_or(0, |a| a.checks as i64).to_ne_bytes());
        let mut numbers = |told: &[f64], length: usize| {
            told.iter().for_each(|x| put(&x.to_ne_bytes()));
            (told.len()..length).for_each(|_| put(&f64::NAN.to_ne_bytes()));
        };
        numbers(answer.map_or(&[], |a| &a.witness), self.nq);
        numbers(answer.map_or(&[], |a| &a.gradient), self.nv);
        if self.segment {
            let segment = answer.and_then(|a| a.segment).map(|segment| [segment.colliding_until, segment.free_from]);
            numbers(segment.as_ref().map_or(&[], |segment| segment), 2);
        }
        if self.free_radius {
            numbers(answer.and_then(|a| a.free_radius).as_slice(), 1);
        }
        let kept: Vec<f64> = answer.iter().flat_map(|a| &a.kept).flat_map(|one| [one.position, one.rotation]).collect();
        numbers(&kept, 2 * self.kept);
        let exits = answer.map_or(&[][..], |a| &a.exits[..a.exits.len().min(self.exits)]);
        if self.exits > 0 {
            put(&(exits.len() as i64).to_ne_bytes());
            let missing = self.exits - exits.len();
            exits.iter().for_each(|exit| put(&exit.depth.to_ne_bytes()));
            (0..missing).for_each(|_| put(&f64::NAN.to_ne_bytes()));
            exits.iter().flat_map(|exit| exit.witness.iter()).for_each(|x| put(&x.to_ne_bytes()));
            (0..missing * self.nq).for_each(|_| put(&f64::NAN.to_ne_bytes()));
        }
        put(&answer.map_or([0; 3], |a| [a.verified.into(), a.is_free().into(), a.unique.into()]));
        if self.pairs > 0 {
            let told = answer.map_or([&[][..]; 2], |a| [&a.colliding, &a.touching]);
            for pairs in told.into_iter().chain(exits.iter().map(|exit| &exit.touching[..])) {
                pairs.iter().for_each(|pair| row[at + pair.index()] = 1);
                at += self.pairs;
            }
        }
    }
}
