//! Points and voxels of obstacles, which the page draws as copies of one small shape.

use extricate::geometry::{Body, Geometry, Pose};
use serde::Serialize;

use crate::scene_data::numbers;
use crate::triangles::{bounding_box, in_box};

/// Points or voxels of one shape as the page reads them.
#[derive(Debug, Serialize)]
pub struct Cloud {
    /// Pose in the body's frame: columns of the rotation, then the translation \[m\].
    pose: [f64; 12],
    /// Least corner of the box around the centres \[m\].
    low: [f64; 3],
    /// Sides of that box \[m\]; a coordinate is `low + side * number / 65535`.
    side: [f64; 3],
    /// Three numbers of two bytes per centre, little endian, in base64.
    centres: String,
    /// Side of a voxel, or diameter of a point's ball \[m\].
    size: f64,
    cubes: bool,
}

/// Number of points and voxels of a body.
pub fn count(body: &Body) -> usize {
    let of_part = |geometry: &Geometry| match geometry {
        Geometry::Points(cloud) => cloud.points().len(),
        Geometry::Voxels(voxels) => voxels.cells().len(),
        _ => 0,
    };
    body.parts.iter().map(|part| of_part(&part.geometry)).sum()
}

/// Returns the points and voxels of a body; only every `step`-th of them.
pub fn clouds(body: &Body, step: usize) -> Vec<Cloud> {
    let cloud = |pose: &Pose, all: &mut dyn Iterator<Item = [f64; 3]>, size: f64, cubes: bool| {
        let centres: Vec<[f64; 3]> = all.step_by(step).collect();
        let (low, side) = bounding_box(&centres)?;
        Some(Cloud { pose: numbers(pose), low, side, centres: in_box(&centres, low, side), size, cubes })
    };
    let of_part = |part: &extricate::parts::Part| {
        let pose = &part.pose_frame_part;
        match &part.geometry {
            Geometry::Points(found) => {
                cloud(pose, &mut found.points().iter().map(|point| (*point).into()), 2.0 * found.radius(), false)
            }
            Geometry::Voxels(found) => {
                let centre = |cell: &[i32; 3]| cell.map(|at| (f64::from(at) + 0.5) * found.size());
                cloud(pose, &mut found.cells().iter().map(centre), found.size(), true)
            }
            _ => None,
        }
    };
    body.parts.iter().filter_map(of_part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::geometry::{PointCloud, Voxels};
    use extricate::parts::Part;
    use std::sync::Arc;

    #[test]
    fn clouds_hold_every_centre_or_every_nth() {
        let cells = (0..10).map(|i| [i, 0, 0]).collect();
        let voxels = Arc::new(Voxels::new("f", "e", 0.1, cells).unwrap());
        let points = Arc::new(PointCloud::new("f", "e", 0.02, &[[1.0, 2.0, 3.0]; 4]).unwrap());
        let part = |geometry| Part { pose_frame_part: Pose::identity(), geometry };
        let parts = vec![part(Geometry::Voxels(voxels)), part(Geometry::Points(points))];
        let body = Body { name: "b".into(), robot: None, frame: 0, parts };
        assert_eq!(count(&body), 14);
        let all = clouds(&body, 1);
        assert!((all[0].low[0] - 0.05).abs() < 1e-12 && (all[0].side[0] - 0.9).abs() < 1e-12);
        assert_eq!((all[0].size, all[0].cubes, all[1].size, all[1].cubes), (0.1, true, 0.04, false));
        // Eight letters of base64 hold one centre of six bytes.
        assert_eq!((all[0].centres.len(), all[1].low), (80, [1.0, 2.0, 3.0]));
        assert_eq!(clouds(&body, 2)[0].centres.len(), 40);
    }
}
