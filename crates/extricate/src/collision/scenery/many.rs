//! One convex shape at many places: a ball at every point of a cloud, or a cube in every occupied
//! cell.

use super::layers::layers;
use super::nodes::{Approach, At, Element};
use super::places::PlaceTree;
use crate::collision::convex_distance::nearer_than;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::bvh::{Cuboid, View};
use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::collision::shapes::{ConvexSolid, Shape};
use crate::math::{Pose, Vec3};
use crate::robot::{PointCloud, Voxels};

/// A box of places is not opened if its half diagonal is at most this share of the radius of the
/// other shape's ball. Lab L122 has the sweep.
const SMALL_BOX_SHARE: f64 = 0.5;

/// Equal convex shapes without rotation.
#[derive(Debug, Clone)]
pub struct Many {
    solid: ConvexSolid,
    /// Box around the solid, in its own frame.
    bounds: Aabb,
    /// Places in the order of the tree.
    places: Vec<Vec3>,
    /// Lower bound \[m\] on what the neighbours add to the depth of a point in the shape at each
    /// place; empty if unknown.
    deeper: Vec<f64>,
    tree: PlaceTree,
}

impl Many {
    /// Puts a ball at every point; `None` without points.
    pub fn of_points(cloud: &PointCloud) -> Option<Self> {
        let radius = cloud.radius();
        let shape = ConvexShape { core: ConvexCore::Point, radius };
        Self::new(shape, Vec3::repeat(radius), cloud.points(), &[])
    }

    /// Puts a cube in every cell; `None` without cells.
    pub fn of_voxels(voxels: &Voxels) -> Option<Self> {
        let half_extents = Vec3::repeat(0.5 * voxels.size());
        let shape = ConvexShape { core: ConvexCore::Box { half_extents }, radius: 0.0 };
        let places: Vec<Vec3> = voxels.cells().iter().map(|cell| voxels.center(cell)).collect();
        let layers = layers(voxels.cells()).into_iter().map(|k| f64::from(k - 1) * voxels.size());
        Self::new(shape, half_extents, &places, &layers.collect::<Vec<f64>>())
    }

    fn new(shape: ConvexShape, half: Vec3, places: &[Vec3], deeper: &[f64]) -> Option<Self> {
        if places.is_empty() {
            return None;
        }
        let boxes: Vec<Aabb> = places.iter().map(|place| Aabb::between(&(place - half), &(place + half))).collect();
        let (tree, order) = PlaceTree::new(&boxes);
        Some(Self {
            solid: ConvexSolid::without_planes(shape),
            bounds: Aabb::between(&-half, &half),
            places: order.iter().map(|&i| places[i as usize]).collect(),
            deeper: order.iter().filter_map(|&i| deeper.get(i as usize).copied()).collect(),
            tree,
        })
    }

    pub fn bounds(&self) -> &Aabb {
        self.tree.bounds()
    }

    pub fn cuboid(&self) -> &Cuboid {
        self.tree.cuboid()
    }

    pub fn root(&self) -> At {
        self.tree.root()
    }

    /// See [`super::Scenery::open`].
    #[inline]
    pub fn open(&self, at: At, approach: &Approach, limit: f64, each: impl FnMut(f64, At)) {
        self.tree.open(at, approach, limit, each);
    }

    #[inline]
    pub fn element(&self, number: u32) -> Option<Element<'_>> {
        self.places.get(number as usize).map(|place| Element {
            solid: &self.solid,
            bounds: &self.bounds,
            place: *place,
        })
    }

    /// Returns a support point, for a unit direction, of the shapes with their places anywhere in
    /// `boxes`.
    pub fn support(&self, boxes: &[Aabb], along: &Vec3) -> Vec3 {
        let across = along.abs();
        let heights = boxes.iter().map(|all| (along.dot(&all.center) + across.dot(&all.half), all));
        let farthest = heights.reduce(|a, b| if b.0 > a.0 { b } else { a });
        let place = farthest.map_or_else(Vec3::zeros, |(_, all)| all.center + all.half.zip_map(along, f64::copysign));
        place + self.solid.shape.core.support(along) + along * self.solid.shape.radius
    }

    /// Adds boxes that contain every place with its shape nearer than `limit` \[m\] to a convex
    /// shape. These are single places, and boxes of several that are small compared with that
    /// shape.
    pub fn places_near(
        &self,
        (other, shape): (&Shape, &ConvexShape),
        relative: &Relative,
        limit: f64,
        found: &mut Vec<Aabb>,
    ) {
        let approach = self.approach(relative, &other.bounds);
        let small = SMALL_BOX_SHARE * other.ball.1;
        // The stack never exceeds the depth of the tree times the children of a node, which is less
        // than this.
        let mut stack: arrayvec::ArrayVec<At, 256> = arrayvec::ArrayVec::new();
        stack.push(self.root());
        while let Some(at) = stack.pop() {
            let places = match at.as_element() {
                Some(number) => Aabb { center: self.places[number as usize], half: Vec3::zeros() },
                None => self.places_in(at),
            };
            if at.as_element().is_some() || places.half.norm() <= small {
                let pose = Pose::translation(places.center);
                if nearer_than(&self.shape_at(&places.half), &pose, shape, &relative.pose_a_b, limit) {
                    found.push(places);
                }
            } else {
                self.tree.open(at, &approach, limit, |_, child| stack.push(child));
            }
        }
    }

    /// Returns a box around the shapes of a node.
    pub fn bounds_of(&self, at: At) -> Aabb {
        self.tree.bounds_of(at)
    }

    /// Returns a box around the places of a node.
    fn places_in(&self, at: At) -> Aabb {
        let all = self.tree.bounds_of(at);
        Aabb { center: all.center, half: (all.half - self.bounds.half).sup(&Vec3::zeros()) }
    }

    /// Returns the Minkowski sum of the shape and a box around the origin.
    fn shape_at(&self, half: &Vec3) -> ConvexShape {
        let ConvexShape { core, radius } = &self.solid.shape;
        let own = if let ConvexCore::Box { half_extents } = core { *half_extents } else { Vec3::zeros() };
        ConvexShape { core: ConvexCore::Box { half_extents: half + own }, radius: *radius }
    }

    /// Prepares tests of nodes against a shape with box `bounds`.
    pub fn approach<'a>(&self, relative: &'a Relative, bounds: &'a Aabb) -> Approach<'a> {
        let cuboid = Cuboid::around(bounds);
        let view = View::new(&relative.pose_a_b, self.cuboid(), &cuboid);
        let seen = view.see(&cuboid, 0.0);
        Approach { relative, bounds, seen: Some((view, seen)), low: 0.0 }
    }

    /// See [`super::Scenery::depth_above`].
    pub fn depth_above(&self, point: &Vec3, mut least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        let mut best = None;
        let reach_squared = |least: f64| if least < 0.0 { least * least } else { 0.0 };
        stack.clear();
        stack.push((0.0, self.root().0));
        while let Some((bound, at)) = stack.pop() {
            let at = At(at);
            if bound > reach_squared(least) {
                continue;
            }
            let Some(number) = at.as_element() else {
                let start = stack.len();
                self.tree.open_at(at, point, reach_squared(least), |bound, child| {
                    crate::collision::shapes::bvh::push_sorted(stack, start, (bound, child.0), |entry| entry.0);
                });
                continue;
            };
            let mut depth = self.solid.depth(&(point - self.places[number as usize]));
            if depth > 0.0 {
                depth += self.deeper.get(number as usize).unwrap_or(&0.0);
            }
            if depth > least {
                (best, least) = (Some(depth), depth);
            }
        }
        best
    }
}
