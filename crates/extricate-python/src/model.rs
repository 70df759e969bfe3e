//! The class `Model`: what was learned of a scene, and how it is asked.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use extricate::{QueryScratch, model_file, store};
use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rayon::prelude::*;

use crate::answer::{self, Layout};
use crate::arrays::{bad_row, configs, one_config};
use crate::error::{count, exception};
use crate::long_call;
use crate::scene::Scene;
use crate::stream::Stream;

/// Queries handed to a thread at once.
const CHUNK: usize = 32;
/// What a model that comes from memory is called in messages.
const IN_MEMORY: &str = "in memory";

/// What was learned of a scene: all that queries need, geometry included.
///
/// Immutable: any number of threads may ask it at once, and each query runs without the interpreter lock. Pickles as the
/// bytes of its file.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Model {
    model: extricate::Model,
    /// Memory that queries reuse: one for each thread that was ever at it at the same time.
    idle: Mutex<Vec<QueryScratch>>,
}

impl Model {
    pub fn of(model: extricate::Model) -> Self {
        Self { model, idle: Mutex::default() }
    }

    pub fn inner(&self) -> &extricate::Model {
        &self.model
    }

    /// Reading a model uses threads, for which a global pool would not survive `fork`.
    fn read(py: Python<'_>, read: impl FnOnce() -> extricate::Result<extricate::Model> + Send) -> PyResult<Self> {
        let pool = long_call::pool(0)?;
        Ok(Self::of(py.detach(|| pool.install(read)).map_err(exception)?))
    }

    fn with_scratch<T>(&self, work: impl FnOnce(&mut QueryScratch) -> T) -> T {
        let poisoned = "never poisoned: nothing panics while it is held";
        let mut scratch = self.idle.lock().expect(poisoned).pop().unwrap_or_default();
        let result = work(&mut scratch);
        self.idle.lock().expect(poisoned).push(scratch);
        result
    }
}

#[pymethods]
impl Model {
    /// Loads a model file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::read(py, || store::load_model(&path))
    }

    /// Writes a model file: another reader sees the old one or the whole new one. Replaces nothing but models.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let save = || store::check_model_output(&path).and_then(|()| store::save_model(&self.model, &path));
        py.detach(save).map_err(exception)
    }

    /// The model from the bytes of its file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        Self::read(py, || model_file::decode(IN_MEMORY.as_ref(), data))
    }

    /// The bytes of the model's file; the same model gives the same bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = py.detach(|| model_file::encode(&self.model));
        PyBytes::new(py, &bytes)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((py.get_type::<Self>().getattr("from_bytes")?, (self.to_bytes(py),)))
    }

    /// The scene that it was learned for.
    #[getter]
    fn scene(&self) -> Scene {
        Scene::of(Arc::clone(self.model.checker().scene_arc()))
    }

    /// The verified free configurations beside the boundary that queries begin from, float64 (samples, nq).
    #[getter]
    fn boundary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let configs = self.model.boundary().configs();
        let nq = self.model.scene().space.nq();
        configs.to_pyarray(py).reshape([configs.len() / nq, nq])
    }

    /// How it was learned and how good it measured itself to be, see `extricate.Statistics`.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        crate::learning::statistics(py, self.model.statistics())
    }

    /// The nearest free configuration to q.
    ///
    /// q: float64 (nq,), within the limits.
    /// effort: "nearest" (the nearest boundary sample), "refined" (several improved, the best one verified) or "exhaustive".
    /// exits: how many distinct ways out are wanted, in `Answer.exits`.
    /// checks, seconds: where to stop early, with the best answer so far; more of either never gives a larger depth.
    /// way: whether to look at the straight way to the witness, see `Answer.way`; costs as much as many checks.
    ///
    /// Raises ValueError for a wrong shape, values that are not finite or beyond a limit.
    #[pyo3(signature = (q, *, effort = "refined", exits = 1, checks = None, seconds = None, way = false))]
    fn query<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        effort: &str,
        exits: i64,
        checks: Option<i64>,
        seconds: Option<f64>,
        way: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let options = answer::options(effort, exits, checks, seconds, way)?;
        let space = &self.model.scene().space;
        let values = one_config("q", q, space)?;
        let config = space.config(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let answer = py.detach(|| self.with_scratch(|scratch| self.model.query(&config, &options, scratch)));
        answer::object(py, answer, self.model.scene())
    }

    /// The nearest free configuration to each of Q, on many threads.
    ///
    /// Q: float64 (n, nq), within the limits. Not copied where it is C-contiguous; do not write to it meanwhile.
    /// effort, checks, seconds: as in `Model.query`, of each query.
    /// threads: 0 for one per core.
    /// Returns a structured array (n,) with the fields depth, lower_bound, max_displacement [m], checks, witness (nq,), gradient
    /// (nv,), verified, free and unique, which mean what they mean in `Answer`.
    ///
    /// Raises ValueError that names the row for a wrong shape, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, effort = "refined", checks = None, seconds = None, threads = 0))]
    #[allow(non_snake_case)]
    fn query_batch<'py>(
        &self,
        Q: &Bound<'py, PyAny>,
        effort: &str,
        checks: Option<i64>,
        seconds: Option<f64>,
        threads: i64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = Q.py();
        let options = answer::options(effort, 1, checks, seconds, false)?;
        let space = &self.model.scene().space;
        let (nq, layout) = (space.nq(), Layout::new(space.nq(), space.nv()));
        let q = configs("Q", Q, space)?;
        let (values, rows, single) = (q.values(), q.rows, q.single);
        let pool = long_call::pool(count("threads", threads, 0)?)?;
        // Written by the byte, because no type of Rust has the layout of a row; read through a view.
        let answers = PyArray1::<u8>::zeros(py, rows * layout.size(), false);
        {
            let mut answers = answers.readwrite();
            let answers = answers.as_slice_mut().expect("contiguous: it was just made");
            let chunk = |at: usize, values: &[f64], answers: &mut [u8]| -> PyResult<()> {
                self.with_scratch(|scratch| {
                    let rows = values.chunks_exact(nq).zip(answers.chunks_exact_mut(layout.size()));
                    for (row, (q, answer)) in rows.enumerate() {
                        let q = space.config(q).map_err(|error| bad_row("Q", at * CHUNK + row, single, error))?;
                        layout.write(&self.model.query(&q, &options, scratch), answer);
                    }
                    Ok(())
                })
            };
            long_call::run(
                py,
                |_, ()| Ok(()),
                |line| {
                    pool.install(|| {
                        let answers = answers.par_chunks_mut(CHUNK * layout.size());
                        values.par_chunks(CHUNK * nq).zip(answers).enumerate().try_for_each(
                            |(at, (values, answers))| {
                                if line.stopped() { Ok(()) } else { chunk(at, values, answers) }
                            },
                        )
                    })
                },
            )??;
        }
        answers.call_method1("view", (layout.dtype(py)?,))
    }

    /// For queries that follow each other closely, as from a simulation: each is warm-started from the one before.
    ///
    /// effort: as in `Model.query`.
    /// hysteresis: the way out of the last frame is kept until another one is nearer by more than this share of its depth; 0
    /// always takes the nearest.
    /// looks: how many boundary samples are looked at each frame for a nearer way out.
    #[pyo3(signature = (*, effort = "refined", hysteresis = 0.0, looks = 4))]
    fn stream(slf: Py<Self>, effort: &str, hysteresis: f64, looks: i64) -> PyResult<Stream> {
        Stream::new(slf, effort, hysteresis, looks)
    }

    fn __repr__(&self) -> String {
        let statistics = self.model.statistics();
        let (samples, labels) = (statistics.boundary_samples, statistics.labels);
        format!("<Model of {samples} boundary samples, {labels} labels>")
    }
}
