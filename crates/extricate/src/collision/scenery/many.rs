//! One convex shape at many places: a ball about every point of a cloud, a cube in every occupied
//! cell.

use super::layers::layers;
use super::places::PlaceTree;
use super::tree::{Approach, At, Element};
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::bvh::Cuboid;
use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::math::Vec3;
use crate::robot::{PointCloud, Voxels};

/// Equal convex shapes, not turned.
#[derive(Debug, Clone)]
pub struct Many {
    solid: ConvexSolid,
    /// Around the solid, in its own frame.
    bounds: Aabb,
    /// In the order of the tree.
    places: Vec<Vec3>,
    /// How much deeper \[m\] a point of the shape at each place lies in all of them than in that
    /// one, at least; none where nothing is known.
    deeper: Vec<f64>,
    tree: PlaceTree,
}

impl Many {
    /// A ball about every point; `None` without points.
    pub fn of_points(cloud: &PointCloud) -> Option<Self> {
        let radius = cloud.radius();
        let shape = ConvexShape { core: ConvexCore::Point, radius };
        Self::new(shape, Vec3::repeat(radius), cloud.points(), &[])
    }

    /// A cube in every cell; `None` without cells.
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

    /// Around all.
    pub fn bounds(&self) -> &Aabb {
        self.tree.bounds()
    }

    /// The same.
    pub fn cuboid(&self) -> &Cuboid {
        self.tree.cuboid()
    }

    /// The node that holds all.
    pub fn root(&self) -> At {
        self.tree.root()
    }

    /// See [`super::Scenery::open`].
    #[inline]
    pub fn open(&self, at: At, approach: &Approach, limit: f64, each: impl FnMut(f64, At)) {
        self.tree.open(at, approach, limit, each);
    }

    /// The shape at one place.
    #[inline]
    pub fn element(&self, number: u32) -> Option<Element<'_>> {
        self.places.get(number as usize).map(|place| Element {
            solid: &self.solid,
            bounds: &self.bounds,
            place: *place,
        })
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
