//! The Python module `extricate._extricate`, a thin shell around the library. Users import its
//! classes and functions from `python/extricate/__init__.py`.

// Every argument of a Python function, keywords included, is a parameter here.
#![allow(clippy::too_many_arguments)]

mod entries;
mod error;
mod long_call;
mod model;
mod motion;
mod queries;
mod rows;
mod scene;
mod solver;

/// The native half of `extricate`.
#[pyo3::pymodule]
mod _extricate {
    #[pymodule_export]
    use super::entries::pose::_pose_matrix;
    #[pymodule_export]
    use super::entries::scenery::_octree_cells;
    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::model::learning::learn;
    #[pymodule_export]
    use super::model::progress::Progress;
    #[pymodule_export]
    use super::motion::roadmap::Roadmap;
    #[pymodule_export]
    use super::queries::options::_query_options;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::scene::import::_find_package;
    #[pymodule_export]
    use super::scene::import::import_world;
    #[pymodule_export]
    use super::scene::joint::Joint;
    #[pymodule_export]
    use super::solver::Solver;
    #[pymodule_export]
    use super::solver::stream::Stream;

    /// Version of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
