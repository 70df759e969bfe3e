//! A tree of boxes over many places, with eight children a node and without pointers.

use pulp::{Arch, Simd, WithSimd};

use super::nodes::{Approach, At};
use crate::collision::broad_phase::static_tree::arrange;
use crate::collision::shapes::bounds::{Aabb, EMPTY};
use crate::collision::shapes::bvh::{Boxes, Cuboid, Lanes, below, lanes_of, rounded_up, rounding_at};
use crate::math::{LANES, Vec3};

/// Each box of a level is around eight consecutive boxes of the level below.
#[derive(Debug, Clone)]
pub struct PlaceTree {
    /// Levels from the leaves to the root.
    levels: Vec<Vec<Boxes>>,
    bounds: Aabb,
    cuboid: Cuboid,
}

impl PlaceTree {
    /// Builds the tree over at least one box; also returns the order of `boxes` in it.
    pub fn new(boxes: &[Aabb]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        arrange(boxes, &mut order);
        let mut level: Vec<Aabb> = order.iter().map(|&i| boxes[i as usize]).collect();
        let mut levels = Vec::new();
        loop {
            levels.push(level.chunks(LANES).map(Boxes::new).collect::<Vec<Boxes>>());
            level = level.chunks(LANES).map(around).collect();
            if level.len() == 1 {
                let cuboid = Cuboid::around(&level[0]);
                return (Self { levels, bounds: level[0], cuboid }, order);
            }
        }
    }

    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    pub fn cuboid(&self) -> &Cuboid {
        &self.cuboid
    }

    pub fn root(&self) -> At {
        At::new(self.levels.len() - 1, 0)
    }

    /// Box around the contents of a node, rounded up.
    pub fn bounds_of(&self, at: At) -> Aabb {
        let around = self.levels.get(at.level() + 1);
        let cuboid = around.map_or(self.cuboid, |boxes| boxes[at.number() / LANES].get(at.number() % LANES));
        let [center, half] = [cuboid.center, cuboid.half].map(|of| Vec3::from(of.map(f64::from)));
        Aabb { center, half }
    }

    fn child(at: At, lane: usize) -> At {
        let number = at.number() * LANES + lane;
        if at.level() == 0 { At::element(number) } else { At::new(at.level() - 1, number) }
    }

    fn boxes(&self, at: At) -> &Boxes {
        &self.levels[at.level()][at.number()]
    }

    /// See [`super::Scenery::open`].
    #[inline]
    pub fn open(&self, at: At, approach: &Approach, limit: f64, mut each: impl FnMut(f64, At)) {
        let Some((view, seen)) = &approach.seen else { return };
        let bounds = Arch::new().dispatch(Bounds { boxes: self.boxes(at), against: Against::Box { view, seen } });
        for lane in lanes_of(below(&bounds, rounded_up(limit))) {
            each(f64::from(bounds[lane]), Self::child(at, lane));
        }
    }

    /// Same as `open` for a point, with lower bounds [m^2] on squared distances.
    #[inline]
    pub fn open_at(&self, at: At, point: &Vec3, limit_squared: f64, mut each: impl FnMut(f64, At)) {
        let place = [point.x as f32, point.y as f32, point.z as f32];
        let against = Against::Point { place, rounding: rounding_at(point, &self.cuboid) };
        let bounds = Arch::new().dispatch(Bounds { boxes: self.boxes(at), against });
        for lane in lanes_of(below(&bounds, rounded_up(limit_squared))) {
            each(f64::from(bounds[lane]), Self::child(at, lane));
        }
    }
}

fn around(boxes: &[Aabb]) -> Aabb {
    let (lower, upper) =
        boxes.iter().fold(EMPTY, |(l, u), b| (l.inf(&(b.center - b.half)), u.sup(&(b.center + b.half))));
    Aabb::between(&lower, &upper)
}

enum Against<'a> {
    Box { view: &'a crate::collision::shapes::bvh::View, seen: &'a crate::collision::shapes::bvh::Seen },
    Point { place: [f32; 3], rounding: f32 },
}

struct Bounds<'a> {
    boxes: &'a Boxes,
    against: Against<'a>,
}

impl WithSimd for Bounds<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Lanes {
        match self.against {
            Against::Box { view, seen } => self.boxes.lower_bounds(simd, view, seen),
            Against::Point { place, rounding } => self.boxes.distances_squared(simd, &place, rounding),
        }
    }
}
