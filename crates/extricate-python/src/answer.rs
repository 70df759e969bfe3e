//! Answers of queries: one as an object, many as rows of a structured array.

use extricate::{Effort, Scene};
use numpy::{PyArray1, PyArrayDescr};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

type NamePair = (String, String);

/// The nearest free configuration that was found, and what is known about it.
#[pyclass(frozen, get_all, module = "extricate._extricate")]
pub struct Answer {
    /// Distance from the query to the witness in the scene's metric; 0 where the query is free. An upper bound on the true
    /// penetration depth.
    depth: f64,
    /// Proved: no free configuration is nearer to the query than this.
    lower_bound: f64,
    /// A free configuration at distance `depth`, float64 (nq,).
    witness: Py<PyArray1<f64>>,
    /// Whether the exact checker called the witness free during this query; otherwise it did when the model was learned.
    verified: bool,
    /// Largest displacement [m] of any point of the robot between the query and the witness.
    max_displacement: f64,
    /// Pairs of bodies that collide at the query.
    colliding: Vec<NamePair>,
    /// Pairs of bodies that touch at the witness.
    touching: Vec<NamePair>,
    /// Collision and distance evaluations spent.
    checks: usize,
    /// "nearest", "refined" or "exhaustive".
    effort: String,
}

impl Answer {
    /// With the names that `scene` gives pairs.
    pub fn new(py: Python<'_>, answer: extricate::Answer, scene: &Scene) -> Self {
        let named =
            |pairs: &[usize]| pairs.iter().map(|&pair| scene.pair_names(pair).map(String::from).into()).collect();
        Self {
            depth: answer.depth,
            lower_bound: answer.lower_bound,
            verified: answer.verified,
            max_displacement: answer.max_displacement,
            colliding: named(&answer.colliding),
            touching: named(&answer.touching),
            checks: answer.checks,
            effort: name(answer.effort).into(),
            witness: PyArray1::from_vec(py, answer.witness).unbind(),
        }
    }
}

#[pymethods]
impl Answer {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn py_new(
        depth: f64,
        lower_bound: f64,
        witness: Py<PyArray1<f64>>,
        verified: bool,
        max_displacement: f64,
        colliding: Vec<NamePair>,
        touching: Vec<NamePair>,
        checks: usize,
        effort: String,
    ) -> Self {
        Self { depth, lower_bound, witness, verified, max_displacement, colliding, touching, checks, effort }
    }

    /// Whether the query itself is free.
    #[getter]
    fn free(&self) -> bool {
        self.colliding.is_empty()
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let witness = self.witness.bind(py);
        format!(
            "Answer(depth={:.6}, lower_bound={:.6}, witness={witness}, verified={}, effort='{}')",
            self.depth,
            self.lower_bound,
            if self.verified { "True" } else { "False" },
            self.effort
        )
    }

    #[allow(clippy::type_complexity)]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> (Bound<'py, PyAny>, (f64, f64, Py<PyArray1<f64>>, bool, f64, Vec<NamePair>, Vec<NamePair>, usize, String))
    {
        let Self { depth, lower_bound, verified, max_displacement, checks, .. } = *self;
        let (colliding, touching) = (self.colliding.clone(), self.touching.clone());
        let witness = self.witness.clone_ref(py);
        let fields =
            (depth, lower_bound, witness, verified, max_displacement, colliding, touching, checks, self.effort.clone());
        (py.get_type::<Self>().into_any(), fields)
    }
}

/// The effort of that name.
///
/// # Errors
/// `ValueError` with the known names.
pub fn effort(found: &str) -> PyResult<Effort> {
    let known = [Effort::Nearest, Effort::Refined, Effort::Exhaustive];
    known.into_iter().find(|effort| name(*effort) == found).ok_or_else(|| {
        PyValueError::new_err(format!("effort: got \"{found}\", expected \"nearest\", \"refined\" or \"exhaustive\""))
    })
}

fn name(effort: Effort) -> &'static str {
    match effort {
        Effort::Nearest => "nearest",
        Effort::Refined => "refined",
        Effort::Exhaustive => "exhaustive",
    }
}

/// How an answer is laid out in a row of a structured array: numbers of eight bytes, then truth values.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    nq: usize,
}

impl Layout {
    /// Of answers with witnesses of `nq` coordinates.
    pub fn new(nq: usize) -> Self {
        Self { nq }
    }

    /// Bytes of a row.
    pub fn size(self) -> usize {
        8 * (4 + self.nq) + 8
    }

    /// The NumPy type of a row.
    pub fn dtype(self, py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        let numpy = py.import("numpy")?;
        let format = |text: &str| numpy.call_method1("dtype", (text,));
        let after = 8 * (4 + self.nq);
        let fields = PyDict::new(py);
        fields
            .set_item("names", ["depth", "lower_bound", "max_displacement", "checks", "witness", "verified", "free"])?;
        let witness = numpy.call_method1("dtype", (("f8", (self.nq,)),))?;
        let formats = [format("f8")?, format("f8")?, format("f8")?, format("i8")?, witness, format("?")?, format("?")?];
        fields.set_item("formats", formats)?;
        fields.set_item("offsets", [0, 8, 16, 24, 32, after, after + 1])?;
        fields.set_item("itemsize", self.size())?;
        Ok(numpy.call_method1("dtype", (fields,))?.cast_into()?)
    }

    /// Writes an answer into the bytes of its row.
    pub fn write(self, answer: &extricate::Answer, row: &mut [u8]) {
        let mut words = row.chunks_exact_mut(8);
        let mut put = |bytes: [u8; 8]| words.next().expect("a row is as long as its layout").copy_from_slice(&bytes);
        [answer.depth, answer.lower_bound, answer.max_displacement].iter().for_each(|x| put(x.to_ne_bytes()));
        put((answer.checks as i64).to_ne_bytes());
        answer.witness.iter().for_each(|x| put(x.to_ne_bytes()));
        put([answer.verified.into(), answer.colliding.is_empty().into(), 0, 0, 0, 0, 0, 0]);
    }
}
