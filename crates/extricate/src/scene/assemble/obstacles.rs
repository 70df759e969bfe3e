//! Converts `[[obstacle]]` and `[[attached]]` entries to bodies.

use std::collections::HashSet;
use std::sync::Arc;

use super::bodies::{hull, refuse_vast, replaced};
use crate::error::{Error, Result};
use crate::math::{FARTHEST, Pose};
use crate::robot::mesh::is_scale;
use crate::robot::{Geometry, LoadLimit, TriangleMesh};
use crate::scene::file::shape_entry::SCENERY;
use crate::scene::file::{AttachedEntry, CutMesh, GeometryKind, ObstacleEntry, ScaleEntry, SceneFile, ShapeEntry};
use crate::scene::names::check_name;
use crate::scene::{Body, Part};

/// Reads a mesh. The arguments are the element that names it, for messages, its path in the scene
/// file, and its scale.
pub type LoadMesh<'a> = &'a mut dyn FnMut(&str, &str, [f64; 3]) -> Result<Arc<TriangleMesh>>;

/// Bodies that are no links.
#[derive(Debug, Clone, Default)]
pub struct Others {
    /// Bodies that are fixed to the world.
    pub obstacles: Vec<Body>,
    /// Bodies that links hold, each in the coordinates of its link.
    pub attached: Vec<Body>,
}

/// Creates the bodies of obstacles and attached objects. Entries with a URDF already have its
/// parts; `scene` has the function that cuts meshes, and the limits.
///
/// # Errors
/// [`Error::Input`] for repeated or empty names, entries without exactly one shape, sizes that are
/// not positive, and scales that are 0; errors of `load_mesh`.
pub fn others(
    file: &str,
    (obstacles, attached): (&[ObstacleEntry], &[AttachedEntry]),
    load_mesh: LoadMesh,
    scene: &SceneFile,
    warnings: &mut Vec<String>,
) -> Result<Others> {
    let (cut, limits) = (scene.cut, &scene.limits);
    limits.check(LoadLimit::Obstacles, obstacles.len() + attached.len(), file, "obstacle")?;
    let mut part_count = 0;
    let mut seen = HashSet::new();
    let mut others = Others::default();
    let count = obstacles.len();
    let obstacles = obstacles.iter().map(|entry| ("obstacle", &entry.name, &entry.shape, &entry.pose));
    let attached = attached.iter().map(|entry| ("attached", &entry.name, &entry.shape, &entry.pose));
    for (index, (kind, name, form, pose)) in obstacles.chain(attached).enumerate() {
        let number = if kind == "obstacle" { index + 1 } else { index + 1 - count };
        check_name(name).map_err(|problem| Error::input(file, format!("{kind} {number}"), problem))?;
        limits.check(LoadLimit::NameBytes, name.len(), file, &format!("{kind} {number}"))?;
        let element = format!("{kind} \"{name}\"");
        if !seen.insert(name) {
            return Err(Error::input(file, element, "the name occurs twice, expected every obstacle to have its own"));
        }
        let pose = pose.pose(file, &element)?;
        if let ("attached", Some(shape)) = (kind, form.kinds().into_iter().find(|kind| SCENERY.contains(kind))) {
            let problem =
                format!("shape: got {shape}, expected a shape that a link can hold: {shape} belongs to obstacles");
            return Err(Error::input(file, element, problem));
        }
        let mut parts = shapes(file, &element, form, load_mesh, cut, warnings)?;
        if kind == "attached" && parts.iter().any(|part| part.geometry.is_scenery()) {
            return Err(Error::input(file, element, "shape: got a urdf with a <plane>, which no link can hold"));
        }
        part_count += parts.len();
        limits.check(LoadLimit::Obstacles, part_count, file, &element)?;
        parts.iter_mut().for_each(|part| part.pose_frame_part = pose.then(&part.pose_frame_part));
        warn_of_lost_points(name, form, &parts, warnings);
        let of_kind = if kind == "obstacle" { &mut others.obstacles } else { &mut others.attached };
        let body = Body { name: name.clone(), robot: None, frame: 0, parts };
        refuse_vast(file, &body)?;
        of_kind.push(body);
    }
    Ok(others)
}

/// Warns of the points that a cloud lacks because they are NaN.
fn warn_of_lost_points(name: &str, entry: &ShapeEntry, parts: &[Part], warnings: &mut Vec<String>) {
    let [Part { geometry: Geometry::Points(cloud), .. }] = parts else { return };
    let (lost, all) = (entry.left_out, entry.left_out + cloud.points().len());
    let words = match lost {
        0 => return,
        1 => "points is left out: it has a coordinate that is NaN",
        _ => "points are left out: they have coordinates that are NaN",
    };
    warnings.push(format!("obstacle `{name}`: {lost} of {all} {words}"));
}

/// Returns the parts of an entry, relative to its pose.
fn shapes(
    file: &str,
    element: &str,
    entry: &ShapeEntry,
    load_mesh: LoadMesh,
    cut: Option<CutMesh>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Part>> {
    let whole = |geometry| Part { pose_frame_part: Pose::identity(), geometry };
    let geometry = shape(file, element, entry, load_mesh, warnings)?;
    match (&geometry, entry.convex_parts, &entry.parts) {
        (Some(Geometry::Mesh(mesh)), true, _) => {
            let parts = replaced(mesh, GeometryKind::ConvexParts, cut, element, warnings);
            Ok(parts.map_err(|problem| Error::input(file, element, problem))?.into_iter().map(whole).collect())
        }
        (None, _, Some(parts)) => Ok(parts.clone()),
        (None, ..) => Err(Error::input(file, element, "shape: got a urdf that was not read, expected one from a file")),
        _ => Ok(geometry.into_iter().map(whole).collect()),
    }
}

/// Returns the one shape of an entry; `None` for a URDF.
fn shape(
    file: &str,
    element: &str,
    entry: &ShapeEntry,
    load_mesh: LoadMesh,
    warnings: &mut Vec<String>,
) -> Result<Option<Geometry>> {
    let fault = |problem: String| Error::input(file, element, problem);
    let given = entry.kinds();
    let [kind] = given[..] else {
        let found = if given.is_empty() { "none".to_string() } else { given.join(" and ") };
        let kinds = "box, sphere, cylinder, capsule, mesh, urdf, voxels, points, half-space, height-field";
        return Err(fault(format!("shape: got {found}, expected exactly one of {kinds}")));
    };
    entry.check_numbers(file, element, kind)?;
    if kind != "mesh" && (entry.scale.is_some() || entry.convex || entry.convex_parts) {
        let problem = format!("shape: `scale`, `convex` and `convex-parts` belong to a mesh, got them with a {kind}");
        return Err(fault(problem));
    }
    if entry.convex && entry.convex_parts {
        return Err(fault("shape: got `convex` and `convex-parts`, expected one of them".into()));
    }
    if kind == "urdf" {
        return Ok(None);
    }
    if let Some(scenery) = &entry.scenery {
        return Ok(Some(scenery.clone()));
    }
    let sizes = |sizes: &[f64], what: &str| match sizes.iter().find(|x| !(**x > 0.0 && **x <= FARTHEST)) {
        Some(bad) => Err(fault(format!("{kind}: got {bad:?}, expected {what} > 0 and within 1e9 [m]"))),
        None => Ok(()),
    };
    if let Some(sides) = entry.cuboid {
        sizes(&sides, "full sides [x, y, z], each")?;
        return Ok(Some(Geometry::Box { half_extents: sides.map(|side| side / 2.0) }));
    }
    if let Some(radius) = entry.sphere {
        sizes(&[radius], "a radius")?;
        return Ok(Some(Geometry::Sphere { radius }));
    }
    if let Some([radius, length]) = entry.cylinder {
        sizes(&[radius, length], "[radius, length], each")?;
        return Ok(Some(Geometry::Cylinder { radius, half_length: length / 2.0 }));
    }
    if let Some([radius, length]) = entry.capsule {
        sizes(&[radius, length], "[radius, length], each")?;
        return Ok(Some(Geometry::Capsule { radius, half_length: length / 2.0 }));
    }
    let scale = match entry.scale {
        None => [1.0; 3],
        Some(ScaleEntry::Uniform(scale)) => [scale; 3],
        Some(ScaleEntry::Axes(scale)) => scale,
    };
    if !is_scale(&scale) {
        return Err(fault(format!("scale: got {scale:?}, expected factors of size 1e-9 to 1e9, not zero")));
    }
    let mesh = match &entry.triangles {
        Some(mesh) if scale == [1.0; 3] => Arc::clone(mesh),
        Some(mesh) => Arc::new(mesh.scaled(scale)),
        None => load_mesh(&format!("{element}: mesh"), entry.mesh.as_deref().unwrap_or_default(), scale)?,
    };
    if !entry.convex {
        return Ok(Some(Geometry::Mesh(mesh)));
    }
    Ok(Some(hull(&mesh, element, warnings)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::scene::file;

    fn assembled(text: &str) -> Result<Vec<Body>> {
        let scene = file::parse("s.toml", text)?;
        Ok(others(
            "s.toml",
            (&scene.obstacle, &scene.attached),
            &mut |_, _, scale| Ok(tetrahedron(scale)),
            &scene,
            &mut Vec::new(),
        )?
        .obstacles)
    }

    fn tetrahedron(scale: [f64; 3]) -> Arc<TriangleMesh> {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        Arc::new(TriangleMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).scaled(scale))
    }

    fn one(shape: &str) -> Result<Geometry> {
        let bodies = assembled(&format!("[[obstacle]]\nname = 'a'\nshape = {shape}"))?;
        Ok(bodies[0].parts[0].geometry.clone())
    }

    #[test]
    fn sizes_are_halved_where_geometry_wants_halves() {
        assert!(
            matches!(one("{ box = [2, 4, 6] }"), Ok(Geometry::Box { half_extents }) if half_extents == [1.0, 2.0, 3.0])
        );
        assert!(matches!(one("{ sphere = 2 }"), Ok(Geometry::Sphere { radius: 2.0 })));
        assert!(matches!(one("{ cylinder = [1, 4] }"), Ok(Geometry::Cylinder { radius: 1.0, half_length: 2.0 })));
        assert!(matches!(one("{ capsule = [1, 4] }"), Ok(Geometry::Capsule { radius: 1.0, half_length: 2.0 })));
    }

    #[test]
    fn meshes_are_scaled_and_hulled() {
        let Ok(Geometry::Mesh(mesh)) = one("{ mesh = 'a.stl', scale = [1, 2, -3] }") else { panic!() };
        assert!(
            mesh.vertices.contains(&Vec3::new(0.0, 0.0, -3.0)) && mesh.vertices.contains(&Vec3::new(0.0, 2.0, 0.0))
        );
        assert!(matches!(one("{ mesh = 'a.stl', convex = true }"), Ok(Geometry::ConvexHull(_))));
    }

    #[test]
    fn faults_name_obstacle_value_and_expectation() {
        let message = |shape: &str| one(shape).unwrap_err().to_string();
        assert!(
            message("{ sphere = 0 }")
                .contains("obstacle \"a\": sphere: got 0.0, expected a radius > 0 and within 1e9 [m]")
        );
        assert!(message("{ box = [1, -2, 3] }").contains("got -2"));
        assert!(message("{ cylinder = [1, nan] }").contains("NaN"));
        assert!(message("{ sphere = 1e300 }").contains("got 1e300"));
        assert!(message("{ }").contains("got none, expected exactly one of box"));
        assert!(message("{ sphere = 1, box = [1, 1, 1] }").contains("got box and sphere"));
        assert!(message("{ sphere = 1, scale = 2 }").contains("belong to a mesh"));
        assert!(message("{ mesh = 'a.stl', scale = 0 }").contains("scale: got [0.0, 0.0, 0.0]"));
        assert!(message("{ mesh = 'a.stl', scale = 1e-200 }").contains("expected factors of size 1e-9 to 1e9"));
        let twice = "[[obstacle]]\nname = 'a'\nshape = { sphere = 1 }\n".repeat(2);
        assert!(assembled(&twice).unwrap_err().to_string().contains("occurs twice"));
        assert!(
            assembled("[[obstacle]]\nname = ''\nshape = { sphere = 1 }")
                .unwrap_err()
                .to_string()
                .contains("obstacle 1")
        );
        let pose = assembled("[[obstacle]]\nname = 'a'\nshape = { sphere = 1 }\npose = { xyz = [inf, 0, 0] }");
        assert!(pose.unwrap_err().to_string().contains("pose: got inf"));
    }
}
