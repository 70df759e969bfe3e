//! The Python module `extricate._extricate`: a thin shell around the library. What users see is put together in
//! `python/extricate/__init__.py`.

// Arguments of a function of Python, keyword ones too, are parameters here.
#![allow(clippy::too_many_arguments)]

mod answer;
mod arrays;
mod asking;
mod batch;
mod changed;
mod clearance;
mod contacts;
mod error;
mod geometry;
mod import;
mod joint;
mod layout;
mod learning;
mod long_call;
mod meshes;
mod model;
mod parts;
mod pose;
mod positions;
mod progress;
mod rows;
mod sampling;
mod scene;
mod scene_check;
mod scene_edit;
mod scene_query;
mod scenery;
mod segments;
mod source;
mod statistics;
mod stream;

/// The native half of `extricate`.
#[pyo3::pymodule]
mod _extricate {
    #[pymodule_export]
    use crate::changed::ChangedScene;
    #[pymodule_export]
    use crate::import::import_world;
    #[pymodule_export]
    use crate::joint::Joint;
    #[pymodule_export]
    use crate::learning::learn;
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::progress::Progress;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::stream::Stream;

    /// Version of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
