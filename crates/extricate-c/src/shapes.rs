//! Reads obstacles from the structures of C callers, with the library's own checks.

#![allow(unsafe_code)]

use std::sync::Arc;

use extricate::entries::{ObstacleEntry, PoseEntry, SceneFile, ShapeEntry, read_obstacles};
use extricate::geometry::{Body, Geometry, HeightField, PointCloud, Pose, Voxels};
use extricate::parts::from_arrays;

use crate::abi::types::{
    EXTRICATE_BOX, EXTRICATE_CAPSULE, EXTRICATE_CYLINDER, EXTRICATE_HALF_SPACE, EXTRICATE_HEIGHT_FIELD, EXTRICATE_MESH,
    EXTRICATE_POINTS, EXTRICATE_SPHERE, EXTRICATE_VOXELS, ExtricateObstacle, ExtricatePose, ExtricateShape,
};
use crate::raw;
use crate::status::{Fault, Result};

/// Name in messages of obstacles that came from no file.
const NAME: &str = "scene";

/// Reads a pose; messages name it `element`.
pub fn pose(element: &str, given: &ExtricatePose) -> Result<Pose> {
    Ok(entry(given).pose(NAME, element)?)
}

fn entry(given: &ExtricatePose) -> PoseEntry {
    PoseEntry { xyz: given.position, quat_xyzw: Some(given.quaternion), ..PoseEntry::default() }
}

/// Returns the bodies of obstacles, and warnings about them.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// The message names the obstacle, what is wrong and what was expected.
pub unsafe fn bodies(given: &[ExtricateObstacle]) -> Result<(Vec<Body>, Vec<String>)> {
    let read = |(at, given): (usize, &ExtricateObstacle)| -> Result<ObstacleEntry> {
        // SAFETY: the contract of this function.
        let name = unsafe { raw::text(given.name, &format!("obstacle {at}: name")) }?;
        // SAFETY: the same.
        let shape = unsafe { shape(&format!("obstacle \"{name}\""), &given.shape) }?;
        Ok(ObstacleEntry { name: name.to_string(), shape, pose: entry(&given.pose) })
    };
    let obstacle = given.iter().enumerate().map(read).collect::<Result<_>>()?;
    Ok(read_obstacles(NAME, &SceneFile { obstacle, ..SceneFile::default() })?)
}

/// # Safety
/// The contract of [`crate::raw`].
unsafe fn shape(element: &str, given: &ExtricateShape) -> Result<ShapeEntry> {
    let [x, y, z] = given.size;
    let none = ShapeEntry::default();
    // SAFETY: the contract of this function: three numbers per point.
    let points = || unsafe { rows(given.points, given.point_count, &format!("{element}: points")) };
    Ok(match given.kind {
        EXTRICATE_BOX => ShapeEntry { cuboid: Some([x, y, z]), ..none },
        EXTRICATE_SPHERE => ShapeEntry { sphere: Some(x), ..none },
        EXTRICATE_CYLINDER => ShapeEntry { cylinder: Some([x, y]), ..none },
        EXTRICATE_CAPSULE => ShapeEntry { capsule: Some([x, y]), ..none },
        EXTRICATE_MESH => {
            // SAFETY: the same: three indices per triangle.
            let triangles = unsafe { rows(given.triangles, given.triangle_count, &format!("{element}: triangles")) }?;
            let mesh = from_arrays(element, &points()?, triangles)?;
            ShapeEntry { triangles: Some(Arc::new(mesh)), convex: given.convex != 0, ..none }
        }
        EXTRICATE_POINTS => scenery(Geometry::Points(Arc::new(PointCloud::new(NAME, element, x, &points()?)?))),
        EXTRICATE_VOXELS => {
            // SAFETY: the same: three indices per cell.
            let cells = unsafe { rows(given.cells, given.cell_count, &format!("{element}: cells")) }?;
            scenery(Geometry::Voxels(Arc::new(Voxels::new(NAME, element, x, cells)?)))
        }
        EXTRICATE_HEIGHT_FIELD => {
            let name = format!("{element}: heights");
            // SAFETY: the same: one number per height.
            let heights = unsafe { raw::slice(given.heights, given.height_count, &name) }?.to_vec();
            scenery(Geometry::HeightField(Arc::new(HeightField::new(NAME, element, x, given.columns, heights)?)))
        }
        EXTRICATE_HALF_SPACE => scenery(Geometry::half_space(NAME, element, given.size, given.offset)?),
        other => {
            let expected = "EXTRICATE_BOX or another of the kinds in extricate.h";
            return Err(Fault::argument(format!("{element}: kind: got {other}, expected {expected}")));
        }
    })
}

fn scenery(geometry: Geometry) -> ShapeEntry {
    ShapeEntry { scenery: Some(geometry), ..ShapeEntry::default() }
}

/// # Safety
/// The contract of [`crate::raw`], for three values per row.
unsafe fn rows<T: Copy>(at: *const T, count: usize, name: &str) -> Result<Vec<[T; 3]>> {
    // SAFETY: the contract of this function; an array is laid out as its values.
    Ok(unsafe { raw::slice(at.cast::<[T; 3]>(), count, name) }?.to_vec())
}
