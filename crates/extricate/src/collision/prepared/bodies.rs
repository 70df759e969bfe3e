//! Bodies of a scene with their prepared shapes, and their poses at a configuration. No pairs.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::iter::repeat;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::placed::Placed;
use super::shape::PreparedShape;
use crate::collision::shapes::bounds::{Aabb, bounding_ball};
use crate::collision::shapes::bvh::TreeLayout;
use crate::collision::shapes::convex::ConvexCore;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::kinematics::{self, PoseBlock};
use crate::math::{Pose, Vec3};
use crate::robot::{Geometry, TriangleMesh};
use crate::scene::correspondence::by_name;
use crate::scene::{Body, Scene};

/// Prepared bodies of a scene.
pub struct Bodies {
    /// Bodies in the order of the scene.
    pub bodies: Vec<PreparedBody>,
    /// Parts of all bodies, body after body.
    pub parts: Vec<PreparedPart>,
    /// Indices of the bodies on moving frames.
    moving: Vec<usize>,
    /// Whether all shapes are convex or scenery made of convex shapes, so that there is no mesh.
    pub all_convex: bool,
    pub has_scenery: bool,
}

/// Body with a bounding volume.
pub struct PreparedBody {
    /// Range of its parts; empty for a body of empty meshes.
    pub parts: Range<usize>,
    /// Bounding ball: centre in frame coordinates and radius \[m\]. The radius is below 0 for a
    /// body without parts.
    pub ball: (Vec3, f64),
    /// Index of the frame that carries the body.
    pub frame: usize,
    /// World-aligned bounding box of a fixed body with parts.
    pub world_box: Option<Aabb>,
}

/// Shape on a frame.
pub struct PreparedPart {
    /// Shape, which several parts and scenes may share.
    pub prepared: Arc<PreparedShape>,
    /// Maps shape coordinates to frame coordinates.
    pub pose_frame_part: Pose,
    frame: usize,
}

impl PreparedPart {
    pub fn shape(&self) -> &Shape {
        &self.prepared.shape
    }
}

/// Poses of frames, bodies and parts at one configuration.
#[derive(Debug, Default)]
pub struct Placement {
    /// World poses of the frames.
    pub poses: Vec<Pose>,
    /// Centres of the bodies' balls in the world \[m\].
    pub centers: Vec<Vec3>,
    /// World poses of parts. They are valid if the entry of `part_epochs` is the current epoch or
    /// [`FIXED_EPOCH`].
    part_poses: Vec<Pose>,
    part_epochs: Vec<u32>,
    epoch: u32,
}

/// Epoch of a part that does not move. Its pose is always valid.
const FIXED_EPOCH: u32 = u32::MAX;

impl Bodies {
    /// Prepares every shape, and reuses those of `before`, a scene with its prepared bodies.
    pub fn new(scene: &Scene, before: Option<(&Scene, &Self)>) -> Self {
        Self::prepare(scene, before, repeat(None)).expect("no tree is given that might not fit")
    }

    /// Prepares every shape. `layouts` belong to the meshes and convex hulls, body after body.
    /// Returns `None` if one does not fit or their number differs.
    pub fn with_layouts(scene: &Scene, layouts: Vec<Option<TreeLayout>>) -> Option<Self> {
        let fits = meshes(scene.bodies.iter()).count() == layouts.len();
        fits.then(|| Self::prepare(scene, None, layouts.into_iter())).flatten()
    }

    fn prepare(
        scene: &Scene,
        before: Option<(&Scene, &Self)>,
        layouts: impl Iterator<Item = Option<TreeLayout>>,
    ) -> Option<Self> {
        let known = before.map(|(old, prepared)| (old, prepared, by_name(old, scene)));
        let mut all =
            Self { bodies: Vec::new(), parts: Vec::new(), moving: Vec::new(), all_convex: true, has_scenery: false };
        let twin = |(index, body): (usize, &Body)| {
            let (old, prepared, names) = known.as_ref()?;
            let at = names[index]?;
            Some(Twin::of(body, &old.bodies[at], prepared, &prepared.bodies[at]))
        };
        let twins: Vec<Option<Twin>> = scene.bodies.iter().enumerate().map(twin).collect();
        let is_new = |(_, twin): &(&Body, &Option<Twin>)| !twin.as_ref().is_some_and(|twin| twin.has_equal_shapes);
        let new = scene.bodies.iter().zip(&twins).filter(is_new).map(|(body, _)| body);
        let mut shapes = prepared_meshes(meshes(new).zip(layouts))?;
        for (body, twin) in scene.bodies.iter().zip(twins) {
            all.push(body, twin, &mut shapes);
        }
        let kinds = || all.parts.iter().map(|part| &part.shape().kind);
        let all_convex = !kinds().any(|kind| matches!(kind, ShapeKind::Mesh(_)));
        let has_scenery = kinds().any(|kind| matches!(kind, ShapeKind::Scenery(_)));
        (all.all_convex, all.has_scenery) = (all_convex, has_scenery);
        Some(all)
    }

    /// Adds a body. `shapes` holds prepared shapes by the geometry that they were made from.
    fn push(&mut self, body: &Body, twin: Option<Twin>, shapes: &mut HashMap<Key, Arc<PreparedShape>>) {
        let start = self.parts.len();
        match twin.as_ref().filter(|twin| twin.has_equal_shapes) {
            Some(Twin { prepared, known, .. }) => {
                let prepared = &prepared.parts[known.parts.clone()];
                self.parts.extend(body.parts.iter().zip(prepared).map(|(part, known)| PreparedPart {
                    prepared: Arc::clone(&known.prepared),
                    pose_frame_part: part.pose_frame_part,
                    frame: body.frame,
                }));
            }
            None => self.parts.extend(prepared_parts(body, shapes)),
        }
        let parts = start..self.parts.len();
        let own = &self.parts[parts.clone()];
        let (ball, world_box) = match twin.filter(|twin| twin.body == body) {
            Some(Twin { known, .. }) => (known.ball, known.world_box),
            None => (ball_around(own), (body.frame == 0 && !own.is_empty()).then(|| box_around(own))),
        };
        if body.frame != 0 {
            self.moving.push(self.bodies.len());
        }
        self.bodies.push(PreparedBody { parts, ball, frame: body.frame, world_box });
    }

    /// Returns a placement with the fixed parts at their poses.
    pub fn placement(&self) -> Placement {
        let part_epochs = self.parts.iter().map(|part| if part.frame == 0 { FIXED_EPOCH } else { 0 }).collect();
        Placement {
            part_poses: self.parts.iter().map(|part| part.pose_frame_part).collect(),
            part_epochs,
            centers: self.bodies.iter().map(|body| body.ball.0).collect(),
            ..Placement::default()
        }
    }

    pub fn place(&self, scene: &Scene, q: &[f64], placement: &mut Placement) {
        kinematics::forward(scene, q, &mut placement.poses);
        self.begin(placement);
        for &body in &self.moving {
            let PreparedBody { ball, frame, .. } = &self.bodies[body];
            placement.centers[body] = placement.poses[*frame].point(&ball.0);
        }
    }

    /// Moves the frames to one configuration of a block. The centres of the bodies stay as they
    /// are.
    pub fn place_lane(&self, block: &PoseBlock, lane: usize, placement: &mut Placement) {
        placement.poses.clear();
        placement.poses.extend((0..block.frames()).map(|frame| block.pose(frame, lane)));
        self.begin(placement);
    }

    /// Invalidates the poses of moving parts.
    fn begin(&self, placement: &mut Placement) {
        placement.epoch = (placement.epoch + 1) % FIXED_EPOCH;
        if placement.epoch == 0 {
            placement.part_epochs.iter_mut().filter(|epoch| **epoch != FIXED_EPOCH).for_each(|epoch| *epoch = 0);
            placement.epoch = 1;
        }
    }

    /// Returns two parts at the placed configuration. Poses of parts are computed on first use.
    pub fn placed<'a>(&'a self, placement: &'a mut Placement, first: usize, second: usize) -> (Placed<'a>, Placed<'a>) {
        for part in [first, second] {
            let epoch = placement.part_epochs[part];
            if epoch != placement.epoch && epoch != FIXED_EPOCH {
                let prepared = &self.parts[part];
                placement.part_poses[part] = placement.poses[prepared.frame].then(&prepared.pose_frame_part);
                placement.part_epochs[part] = placement.epoch;
            }
        }
        let at = |part: usize| Placed { prepared: &self.parts[part].prepared, pose: &placement.part_poses[part] };
        (at(first), at(second))
    }
}

/// Body of the same name in another scene, with its prepared shapes.
struct Twin<'a> {
    body: &'a Body,
    prepared: &'a Bodies,
    known: &'a PreparedBody,
    /// Whether both bodies have the same shapes in the same order; their poses may differ.
    has_equal_shapes: bool,
}

impl<'a> Twin<'a> {
    fn of(body: &Body, twin: &'a Body, prepared: &'a Bodies, known: &'a PreparedBody) -> Self {
        let (ours, theirs) = (&body.parts, &twin.parts);
        let are_equal = ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(a, b)| a.geometry == b.geometry);
        // Geometry without a shape has no prepared part.
        let has_equal_shapes = known.parts.len() == theirs.len() && are_equal;
        Self { body: twin, prepared, known, has_equal_shapes }
    }
}

/// Key of geometry that many bodies may share, such as the boxes of a wall: its kind, and its sizes
/// or the address of its mesh.
type Key = (u8, [u64; 3]);

/// Address of a mesh, cloud or grid, which bodies share by pointer and which may take long to
/// prepare. `None` for other geometry.
pub fn shared_shape(geometry: &Geometry) -> Option<usize> {
    match geometry {
        Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => Some(Arc::as_ptr(mesh) as usize),
        Geometry::Voxels(voxels) => Some(Arc::as_ptr(voxels) as usize),
        Geometry::Points(points) => Some(Arc::as_ptr(points) as usize),
        Geometry::HeightField(field) => Some(Arc::as_ptr(field) as usize),
        _ => None,
    }
}

fn key(geometry: &Geometry) -> Option<Key> {
    let sizes = |sizes: [f64; 3]| sizes.map(f64::to_bits);
    let shared = |mesh: &Arc<TriangleMesh>| [Arc::as_ptr(mesh) as u64, 0, 0];
    Some(match geometry {
        Geometry::Sphere { radius } => (0, sizes([*radius, 0.0, 0.0])),
        Geometry::Box { half_extents } => (1, sizes(*half_extents)),
        Geometry::Cylinder { radius, half_length } => (2, sizes([*radius, *half_length, 0.0])),
        Geometry::Capsule { radius, half_length } => (3, sizes([*radius, *half_length, 0.0])),
        Geometry::Mesh(mesh) => (4, shared(mesh)),
        Geometry::ConvexHull(mesh) => (5, shared(mesh)),
        Geometry::Voxels(voxels) => (6, [Arc::as_ptr(voxels) as u64, 0, 0]),
        Geometry::Points(points) => (7, [Arc::as_ptr(points) as u64, 0, 0]),
        Geometry::HeightField(field) => (8, [Arc::as_ptr(field) as u64, 0, 0]),
        Geometry::HalfSpace { .. } => return None,
    })
}

/// Geometries made of triangles.
fn meshes<'a>(bodies: impl Iterator<Item = &'a Body>) -> impl Iterator<Item = &'a Geometry> {
    bodies.flat_map(|body| body.parts.iter().map(|part| &part.geometry)).filter(|geometry| match geometry {
        Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => !mesh.triangles.is_empty(),
        _ => false,
    })
}

/// Prepares each of `meshes` once, on all threads of the current pool, since this takes long. Uses
/// the known layouts of trees; returns `None` if one does not fit.
fn prepared_meshes<'a>(
    meshes: impl Iterator<Item = (&'a Geometry, Option<TreeLayout>)>,
) -> Option<HashMap<Key, Arc<PreparedShape>>> {
    let keyed = meshes.filter_map(|(geometry, layout)| Some((key(geometry)?, (geometry, layout))));
    let unique: HashMap<Key, (&Geometry, Option<TreeLayout>)> = keyed.collect();
    let prepared = |(key, (geometry, layout))| {
        let shape = match layout {
            Some(layout) => PreparedShape::of(Shape::with_layout(geometry, layout)?),
            None => PreparedShape::new(geometry)?,
        };
        Some((key, Arc::new(shape)))
    };
    // Avoid threads if a change brings no mesh.
    if unique.is_empty() { Some(HashMap::new()) } else { unique.into_par_iter().map(prepared).collect() }
}

fn prepared_parts(body: &Body, shapes: &mut HashMap<Key, Arc<PreparedShape>>) -> impl Iterator<Item = PreparedPart> {
    body.parts.iter().filter_map(|part| {
        let new = || Some(Arc::new(PreparedShape::new(&part.geometry)?));
        let prepared = match key(&part.geometry).map(|key| shapes.entry(key)) {
            Some(Entry::Occupied(known)) => Arc::clone(known.get()),
            Some(Entry::Vacant(place)) => Arc::clone(place.insert(new()?)),
            None => new()?,
        };
        Some(PreparedPart { prepared, pose_frame_part: part.pose_frame_part, frame: body.frame })
    })
}

fn box_around(parts: &[PreparedPart]) -> Aabb {
    let points: Vec<Vec3> = parts.iter().flat_map(points_around).collect();
    Aabb::around(points.iter())
}

fn ball_around(parts: &[PreparedPart]) -> (Vec3, f64) {
    match parts {
        [] => (Vec3::zeros(), f64::NEG_INFINITY),
        [part] => (part.pose_frame_part.point(&part.shape().ball.0), part.shape().ball.1 * (1.0 + 1e-12)),
        _ => {
            let points: Vec<Vec3> = parts.iter().flat_map(points_around).collect();
            bounding_ball(&points)
        }
    }
}

/// Points in frame coordinates whose convex hull holds the part.
fn points_around(part: &PreparedPart) -> impl Iterator<Item = Vec3> {
    outline(part.shape()).into_iter().map(|p| part.pose_frame_part.point(&p))
}

/// Points whose convex hull holds the shape.
fn outline(shape: &Shape) -> Vec<Vec3> {
    match &shape.kind {
        ShapeKind::Mesh(mesh) => mesh.vertices.clone(),
        ShapeKind::Scenery(_) => shape.bounds.corners().to_vec(),
        ShapeKind::Convex(solid) => match &solid.shape.core {
            ConvexCore::Hull(hull) => hull.points().to_vec(),
            _ => shape.bounds.corners().to_vec(),
        },
    }
}
