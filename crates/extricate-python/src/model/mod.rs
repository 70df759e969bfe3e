//! The class `Model`: what was learned of a scene, and how it is asked.

pub mod changed;
pub mod learning;
pub mod motion;
pub mod progress;
pub mod statistics;
pub mod stream;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use extricate::internals::io::{self, model_file};
use numpy::{PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::exception;
use crate::long_call;
use crate::queries::page::{self, Shown};
use crate::queries::{self, Memory, Source};
use crate::scene::{Scene, edit};
use changed::ChangedScene;
use stream::Stream;

/// What a model that comes from memory is called in messages.
const IN_MEMORY: &str = "in memory";

/// What was learned of a scene: all that queries need, geometry included.
///
/// Immutable: any number of threads may ask it at once, and each query runs without the interpreter
/// lock. Pickles as the bytes of its file.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Model {
    model: extricate::Model,
    memory: Memory,
}

impl Model {
    pub fn of(model: extricate::Model) -> Self {
        Self { model, memory: Memory::default() }
    }

    pub fn inner(&self) -> &extricate::Model {
        &self.model
    }

    fn read(
        py: Python<'_>,
        read: impl FnOnce() -> extricate::Result<extricate::Model> + Send + 'static,
    ) -> PyResult<Self> {
        Ok(Self::of(long_call::apart(py, read)?.map_err(exception)?))
    }
}

#[pymethods]
impl Model {
    /// Loads a model file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::read(py, move || io::load_model(&path))
    }

    /// Writes a model file: another reader sees the old one or the whole new one. Replaces nothing
    /// but models.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let save = || io::check_model_output(&path).and_then(|()| io::save_model(&self.model, &path));
        py.detach(save).map_err(exception)
    }

    /// The model from the bytes of its file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let data = data.to_vec();
        Self::read(py, move || model_file::decode(IN_MEMORY.as_ref(), &data))
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

    /// The verified free configurations beside the boundary that queries begin from, float64
    /// (samples, nq).
    #[getter]
    fn boundary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let configs = self.model.boundary().configs();
        let nq = self.model.scene().space.nq();
        configs.to_pyarray(py).reshape([configs.len() / nq, nq])
    }

    /// Configurations that the classifier rests on: free and colliding ones on either side of the
    /// boundary that it predicts, float64 (n, nq), each once, those of the pairs that collide most
    /// often first. Which are free `Scene.check` tells. `n` is 0 where only one label was ever
    /// seen, and less than `statistics["support_vectors"]` where several pairs share one.
    #[getter]
    fn support_vectors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let nq = self.model.scene().space.nq();
        let svms = self.model.classifier().map_or(&[][..], |classifier| classifier.svms());
        let mut seen = HashSet::new();
        let mut rows = Vec::new();
        for q in svms.iter().flat_map(|machine| machine.support.chunks_exact(nq)) {
            if seen.insert(q.iter().map(|x| x.to_bits()).collect::<Vec<u64>>()) {
                rows.extend_from_slice(q);
            }
        }
        rows.to_pyarray(py).reshape([rows.len() / nq, nq])
    }

    /// How it was learned and how good it measured itself to be, with the keys that
    /// docs/reference/statistics.md describes; None where something was not measured.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        statistics::statistics(py, self.model.statistics())
    }

    /// The nearest free configuration to q.
    ///
    /// q: float64 (nq,). Beyond limits it is not free; it is measured from where it is,
    /// `Answer.outside` names the joints.
    /// options: a `QueryOptions` that holds these keywords; one that stands beside it counts more.
    /// effort: "nearest" (the nearest boundary sample, or one nearly as near), "quick" (fewer
    /// starts than refined), "refined" (descents from several starts, the nearest exit verified),
    /// "exhaustive", or "proved": as refined, then until the gap is proved or the budget is spent;
    /// give max_seconds.
    /// exits: how many distinct exits are wanted, in `Answer.exits`.
    /// gap: stop as soon as it is proved that nothing free is nearer by more than this share of the
    ///     depth; effort "proved" works for it. None is 0.15 with "quick" and "refined", 0.05 with
    ///     "proved", and no reason to stop with "exhaustive"; 0 searches on. Not with several
    ///     exits.
    /// starts: from how many boundary samples and configurations around q descents start, None for
    /// what the effort takes: fewer are faster and miss the nearest exit more often. Not with
    /// effort "nearest".
    /// max_checks, max_seconds: where to stop early, with the best answer so far; more of either
    /// never gives a larger depth.
    /// segment: whether to look at the straight segment to the witness, see `Answer.segment`; costs
    /// as much as many checks.
    /// contacts: with effort "nearest", whether to tell every colliding pair, not one alone, and
    /// the contacts at the witness; both take longer than to find it. The other efforts always tell
    /// them.
    /// clearance: aim at this one [m] in place of the scene's, for pairs without one of their own;
    ///     a witness that would be more than ten times as far as the nearest at the scene's
    ///     clearance keeps less, see `Answer.clearance`.
    /// locked: names of joints that stay where q has them; or free: the names of those that may
    ///     move. None is then returned where nothing free was found.
    /// weights: by joint, of squared displacements, in place of the scene's, in the metric of the
    ///     joints; asked without what was learned.
    /// toward, toward_share: a configuration and a share; of exits that are farther than the
    ///     nearest by at most that share of its depth, the one nearest to the configuration is
    ///     taken.
    /// free_radius: whether to prove how far around the witness nothing touches, see
    ///     `Answer.free_radius`; costs as much as many checks.
    /// limits: "forgive" answers what is beyond them, "refuse" raises ValueError.
    ///
    /// Raises ValueError for a wrong shape, values that are not finite.
    #[pyo3(signature = (q, **options), text_signature = "($self, q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive')")]
    fn query<'py>(
        slf: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Self { model, memory } = slf.get();
        queries::query(Source::Model(model), q, options, memory, slf)
    }

    /// Shows configurations and their answers as a page, in a browser; see `Scene.show`.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; 5 random ones in collision where None.
    /// path: the file that is written; a temporary one where None.
    /// open: whether a browser opens it; where None, unless this is a notebook, which shows the
    ///     page that is returned.
    /// live: whether joints can be dragged in the page.
    /// All other keywords: as in `Model.query`; exits is 3 where the effort finds several.
    #[pyo3(signature = (Q = None, *, path = None, open = None, live = false, **options))]
    #[allow(non_snake_case)]
    fn show<'py>(
        &self,
        py: Python<'py>,
        Q: Option<&Bound<'py, PyAny>>,
        path: Option<PathBuf>,
        open: Option<bool>,
        live: bool,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        page::show(py, Source::Model(&self.model), Q, options, (Shown { path, open, live }, &self.memory.weighted))
    }

    /// The nearest free configuration to each of Q, on many threads.
    ///
    /// Q: float64 (n, nq); beyond limits as in `Model.query`. Not copied where it is C-contiguous;
    /// do not write to it meanwhile.
    /// options, effort, gap, starts, max_checks, max_seconds: as in `Model.query`, of each query.
    /// exits: how many distinct exits are wanted.
    /// segment: whether to look at the straight ways to the witnesses; costs as much as many
    /// checks.
    /// contacts: whether to tell the pairs that collide and that touch; with effort "nearest" that
    /// takes longer than to find the witness.
    /// clearance, locked, free, weights, toward, toward_share, free_radius, limits: as in
    ///     `Model.query`, of each query.
    /// errors: "raise", or "mask": a row that is no configuration is answered as such, with a depth
    ///     of nan, and the others as ever.
    /// threads: 0 for one per core. Returns a structured array (n,) with the fields depth,
    /// lower_bound, gap, max_displacement [m], clearance, checks, witness
    /// (nq,), gradient (nv,), verified, free and unique, which mean what they mean in `Answer`, and
    /// with exits of more than one: exit_count, how many were found (0 where the query is free),
    /// exit_depths (exits,) and exit_witnesses (exits, nq), nearest first, the witness before
    /// others, nan from exit_count on; segment: segment (2,), nan where the query is free;
    /// free_radius: free_radius, nan where the query is free; contacts: colliding and touching,
    /// bool (pairs,), in the order of `Scene.pairs`; with several exits also exit_touching, (exits,
    /// pairs). Points and normals of contacts `Model.query` tells.
    ///
    /// Raises ValueError that names the row for a wrong shape, values that are not finite, before
    /// any is answered.
    #[pyo3(signature = (Q, **options), text_signature = "($self, Q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive', errors='raise', threads=0)")]
    #[allow(non_snake_case)]
    fn query_batch<'py>(
        &self,
        Q: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        queries::query_batch(Source::Model(&self.model), Q, options, &self.memory)
    }

    /// To ask this model in another world.
    ///
    /// world: a list of obstacles, which take the place of those that the model knows; or a scene
    ///     of the same joints, such as one by `Scene.moved`. Objects that links hold, other
    ///     fingers, a moved base and other geometry of links leave a model of the metric of the
    ///     joints usable.
    ///
    /// Raises ValueError where the joints, their limits or the metric differ.
    fn in_world(slf: Py<Self>, py: Python<'_>, world: &Bound<'_, PyAny>) -> PyResult<ChangedScene> {
        if let Ok(scene) = world.cast::<Scene>() {
            return ChangedScene::new(py, slf, scene.get());
        }
        let bare = slf.get().model.scene().without_obstacles();
        let scene = Scene::of(edit::with_obstacles(py, &bare, world)?.into());
        ChangedScene::new(py, slf, &scene)
    }

    /// To ask this model in another scene of the same joints: obstacles moved, added or gone, other
    /// pairs or clearance.
    ///
    /// Raises ValueError where the joints, their limits or the metric differ.
    fn in_scene(slf: Py<Self>, py: Python<'_>, scene: &Scene) -> PyResult<ChangedScene> {
        ChangedScene::new(py, slf, scene)
    }

    /// For queries that follow each other closely, as from a simulation: each is warm-started from
    /// the one before.
    ///
    /// options, effort, gap, starts, max_checks, max_seconds, segment, contacts, clearance, locked,
    /// free,
    /// weights, free_radius, limits: as in `Model.query`, of each frame.
    /// hysteresis: the exit of the last frame is kept until another one is nearer by more than this
    /// share of its depth; 0 always takes the nearest.
    /// starts_per_frame: how many starts are tried each frame for a nearer exit, beside those that
    /// cost no check.
    /// continuous: whether the witness never jumps: from frame to frame it only moves where every
    /// configuration on its way is proved free. It may then be held behind something while another
    /// exit is nearer (`Answer.nearest`), or while the query is free. It aims at `clearance`, by
    /// default 0.5 mm more than the scene's; hysteresis has no effect.
    #[pyo3(signature = (**options), text_signature = "($self, *, options=None, effort='refined', hysteresis=0.0, starts_per_frame=2, continuous=False, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, free_radius=False, limits='forgive')")]
    fn stream(slf: Py<Self>, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Stream> {
        Stream::of_model(slf, py, options)
    }

    fn __repr__(&self) -> String {
        let statistics = self.model.statistics();
        let (samples, labels) = (statistics.boundary_samples, statistics.labels);
        format!("<Model of {samples} boundary samples, {labels} labels>")
    }
}
