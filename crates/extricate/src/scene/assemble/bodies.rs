//! Creates the bodies of links, replaces meshes by hulls, and warns of open meshes and cavities.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use super::frames::FramePlacement;
use crate::error::{self, Error};
use crate::math::Vec3;
use crate::robot::mesh::convex_hull::convex_hull;
use crate::robot::mesh::openings::{branches, widest_gap};
use crate::robot::{Geometry, LinkGeometry, Robot, TriangleMesh};
use crate::scene::file::{CutMesh, GeometryKind};
use crate::scene::{Body, Part};

/// Creates a body for each link that has geometry, in document order; `seats` and `names` are by
/// link.
pub fn link_bodies(robot_index: usize, robot: &Robot, seats: &[FramePlacement], names: &[String]) -> Vec<Body> {
    let with_geometry = (0..robot.links.len()).filter(|&link| !robot.links[link].collision.is_empty());
    with_geometry
        .map(|link| {
            let part = |shape: &LinkGeometry| Part {
                pose_frame_part: seats[link].pose_frame_link.then(&shape.pose_link_geometry),
                geometry: shape.geometry.clone(),
            };
            let parts = robot.links[link].collision.iter().map(part).collect();
            Body { name: names[link].clone(), robot: Some(robot_index), frame: seats[link].frame, parts }
        })
        .collect()
}

/// Replaces the meshes of `robot` as `kind` returns for their link. Meshes that links share are
/// hulled or cut once.
pub fn replace_meshes(
    robot: &mut Robot,
    kind: impl Fn(&str) -> GeometryKind,
    cut: Option<CutMesh>,
    warnings: &mut Vec<String>,
) -> Result<(), String> {
    let mut done: HashMap<(*const TriangleMesh, GeometryKind), Vec<Geometry>> = HashMap::new();
    for link in &mut robot.links {
        let kind = kind(&link.name);
        let owner = format!("link `{}`", link.name);
        let mut parts = Vec::with_capacity(link.collision.len());
        for shape in std::mem::take(&mut link.collision) {
            let Geometry::Mesh(mesh) = &shape.geometry else {
                parts.push(shape);
                continue;
            };
            let key = (Arc::as_ptr(mesh), kind);
            if let Entry::Vacant(place) = done.entry(key) {
                place.insert(replaced(mesh, kind, cut, &owner, warnings)?);
            }
            parts.extend(done[&key].iter().map(|geometry| LinkGeometry { geometry: geometry.clone(), ..shape }));
        }
        link.collision = parts;
    }
    Ok(())
}

/// Largest overhang of convex parts beyond their mesh, as a share of its extent, that gets no
/// warning that they fill hollows.
const MAX_OVERHANG_SHARE: f64 = 0.01;

/// Returns the diagonal of the box around a mesh \[m\].
fn extent(mesh: &TriangleMesh) -> f64 {
    let low = mesh.vertices.iter().fold(Vec3::repeat(f64::INFINITY), |low, p| low.inf(p));
    let high = mesh.vertices.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
    (high - low).norm()
}

/// Returns the shapes that replace a mesh, with a warning if convex parts fill its hollows.
pub fn replaced(
    mesh: &Arc<TriangleMesh>,
    kind: GeometryKind,
    cut: Option<CutMesh>,
    owner: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<Geometry>, String> {
    match kind {
        GeometryKind::Mesh | GeometryKind::Visual => Ok(vec![Geometry::Mesh(Arc::clone(mesh))]),
        GeometryKind::ConvexHull => Ok(vec![hull(mesh, owner, warnings)]),
        GeometryKind::ConvexParts => {
            let cut = cut.ok_or("got convex-parts where nothing cuts meshes, expected a scene that `store` loads")?;
            let (parts, beyond) = cut(mesh);
            if beyond > MAX_OVERHANG_SHARE * extent(mesh) {
                let count = parts.len();
                warnings.push(format!(
                    "{owner}: {count} convex parts stand out of the mesh by up to {beyond:.2e} m: what is in a hollow of it collides there; `mesh` keeps hollows open"
                ));
            }
            Ok(parts.into_iter().map(|hull| Geometry::ConvexHull(Arc::new(hull))).collect())
        }
    }
}

/// Returns the convex hull of a mesh. A flat mesh has none and stays, with a warning that names
/// `owner`.
pub fn hull(mesh: &Arc<TriangleMesh>, owner: &str, warnings: &mut Vec<String>) -> Geometry {
    match convex_hull(&mesh.vertices) {
        Some(hull) => Geometry::ConvexHull(Arc::new(hull)),
        None => {
            warnings.push(format!("{owner}: a mesh is flat and has no convex hull: it is kept as a surface"));
            Geometry::Mesh(Arc::clone(mesh))
        }
    }
}

/// Caches a slow result by mesh, because many bodies may share one.
#[derive(Debug)]
pub struct OncePerMesh<T>(HashMap<*const TriangleMesh, (Arc<TriangleMesh>, T)>);

impl<T> Default for OncePerMesh<T> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<T: Copy> OncePerMesh<T> {
    /// Returns `find(geometry)`; for a mesh or hull the result is computed once.
    pub fn of(&mut self, geometry: &Geometry, find: impl Fn(&Geometry) -> T) -> T {
        match geometry {
            Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => {
                // The clone keeps the mesh alive, so that no other one reuses its address.
                self.0.entry(Arc::as_ptr(mesh)).or_insert_with(|| (Arc::clone(mesh), find(geometry))).1
            }
            other => find(other),
        }
    }
}

/// Numbers of open components, cavities and all components of a mesh, for warnings.
#[derive(Debug, Clone, Copy, Default)]
pub struct Surfaces {
    open: usize,
    cavities: usize,
    all: usize,
    /// Largest distance between facing open edges \[m\].
    gap: Option<f64>,
    /// Number of edges of open components that have three triangles or more.
    branches: usize,
}

impl Surfaces {
    fn of(geometry: &Geometry) -> Self {
        let Geometry::Mesh(mesh) = geometry else { return Self::default() };
        Self {
            open: mesh.components.iter().filter(|component| !component.closed).count(),
            cavities: (0..mesh.components.len()).filter(|&component| mesh.is_cavity(component)).count(),
            all: mesh.components.len(),
            gap: widest_gap(mesh),
            branches: branches(mesh),
        }
    }
}

/// Warns once if the meshes of a body have open components, and once if they have cavities; `known`
/// caches the counts.
pub fn warn_of_surfaces(body: &Body, known: &mut OncePerMesh<Surfaces>, warnings: &mut Vec<String>) {
    let Surfaces { open, cavities, all, gap, branches } = body.parts.iter().fold(Surfaces::default(), |sum, part| {
        let own = known.of(&part.geometry, Surfaces::of);
        let gap = [sum.gap, own.gap].into_iter().flatten().reduce(f64::max);
        let (open, cavities, all) = (sum.open + own.open, sum.cavities + own.cavities, sum.all + own.all);
        Surfaces { open, cavities, all, gap, branches: sum.branches + own.branches }
    });
    let kind = match (body.robot, body.frame) {
        (Some(_), _) => "link",
        (None, 0) => "obstacle",
        (None, _) => "attached",
    };
    if open > 0 {
        let counted = match (open, all) {
            (1, 1) => "its mesh is open: it is a surface, not a solid".to_string(),
            (1, _) => format!("1 of {all} mesh components is open: it is a surface, not a solid"),
            _ => format!("{open} of {all} mesh components are open: they are surfaces, not solids"),
        };
        let gap = gap.map(|gap| format!("open edges are up to {gap:.1e} m from each other"));
        let walls = match branches {
            0 => None,
            1 => Some("1 edge has 3 triangles or more: a wall inside, or sheets that meet".to_owned()),
            _ => Some(format!("{branches} edges have 3 triangles or more: walls inside, or sheets that meet")),
        };
        let why: Vec<String> = gap.into_iter().chain(walls).collect();
        let why = if why.is_empty() { String::new() } else { format!(" ({})", why.join("; ")) };
        warnings.push(format!("{kind} `{}`: {counted}{why}", body.name));
    }
    if cavities > 0 {
        let counted = match cavities {
            1 => format!("1 of {all} closed mesh components lies within another one and faces inward: it is a cavity"),
            _ => format!("{cavities} of {all} mesh components lie within others and face inward: they are cavities"),
        };
        warnings.push(format!("{kind} `{}`: {counted}, and what is in it collides only with its walls", body.name));
    }
}

/// Largest radius of a shape \[m\]. Double precision is too coarse for distances to larger ones:
/// with a cylinder of 1e9 m, a configuration was called free that overlapped by 0.3 m.
pub const LARGEST: f64 = 1e5;

/// Refuses bodies that are too large for exact distances.
///
/// # Errors
/// [`Error::Input`] if the radius of a shape exceeds [`LARGEST`]; scenery may be larger.
pub fn refuse_vast(file: &str, body: &Body) -> error::Result<()> {
    let radii = body.parts.iter().filter(|part| !part.geometry.is_scenery()).map(|part| radius(&part.geometry));
    let Some(vast) = radii.into_iter().find(|radius| *radius > LARGEST) else { return Ok(()) };
    let problem =
        format!("got a shape with a radius of {vast:e} m, expected at most {LARGEST:e} m; a half-space has no end");
    Err(Error::input(file, format!("body \"{}\"", body.name), problem))
}

/// Returns the greatest distance \[m\] of a point of a shape from its own origin.
pub fn radius(geometry: &Geometry) -> f64 {
    match geometry {
        Geometry::Sphere { radius } => *radius,
        Geometry::Box { half_extents } => Vec3::from(*half_extents).norm(),
        Geometry::Cylinder { radius, half_length } => radius.hypot(*half_length),
        Geometry::Capsule { radius, half_length } => radius + half_length,
        Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => mesh.vertices.iter().map(|v| v.norm()).fold(0.0, f64::max),
        scenery => scenery.scenery_radius(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Vec3};

    fn body(triangles: Vec<[u32; 3]>) -> Body {
        let near = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let far = near.map(|v| v + Vec3::new(5.0, 0.0, 0.0));
        let mesh = TriangleMesh::new(near.into_iter().chain(far).collect(), triangles);
        let part = Part { pose_frame_part: Pose::identity(), geometry: Geometry::Mesh(Arc::new(mesh)) };
        Body { name: "a".into(), robot: Some(0), frame: 0, parts: vec![part] }
    }

    #[test]
    fn open_components_are_told_once_a_body() {
        let solid = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut warnings = Vec::new();
        let mut known = OncePerMesh::default();
        let mut warn_of_surfaces =
            |body: &Body, warnings: &mut Vec<String>| warn_of_surfaces(body, &mut known, warnings);
        warn_of_surfaces(&body(solid.clone()), &mut warnings);
        assert!(warnings.is_empty());
        let mixed: Vec<[u32; 3]> = solid.iter().copied().chain([[4, 5, 6], [4, 6, 7]]).collect();
        warn_of_surfaces(&body(mixed), &mut warnings);
        warn_of_surfaces(&body(vec![[0, 1, 2]]), &mut warnings);
        assert_eq!(warnings.len(), 2);
        assert!(warnings[0].contains("link `a`: 1 of 2 mesh components"), "{}", warnings[0]);
    }

    #[test]
    fn flat_meshes_stay_surfaces() {
        let mut warnings = Vec::new();
        let flat = TriangleMesh::new(vec![Vec3::zeros(), Vec3::x(), Vec3::y()], vec![[0, 1, 2]]);
        assert!(matches!(hull(&Arc::new(flat), "link `a`", &mut warnings), Geometry::Mesh(_)));
        assert!(warnings[0].contains("link `a`") && warnings[0].contains("flat"));
    }
}
