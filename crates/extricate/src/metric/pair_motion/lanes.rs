//! Evaluates a pair's motion for up to eight pairs of points at once, in vector lanes.

use super::{Chain, Joint, PairMotion};
use crate::math::{LANES, Vec3};

/// One number for each lane.
pub type Lanes = [f64; LANES];

/// Results of [`PairMotion::place_all`] for up to eight pairs of points.
#[doc(hidden)]
#[derive(Debug, Clone, Default)]
pub struct PairMotions {
    /// Velocity of `a - b`, by coordinate and axis of the world.
    pub columns: Vec<[Lanes; 3]>,
    /// Bounds on second derivatives, see [`PairMotion::derivatives`].
    pub second: Lanes,
    /// Bounds on third derivatives, see [`PairMotion::derivatives`].
    pub third: Lanes,
    levers: Vec<Lanes>,
    sums: Vec<Lanes>,
}

/// Evaluates `of` for each lane. It compiles to vector instructions if `of` is one operation.
#[inline(always)]
pub fn lanes(of: impl FnMut(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl PairMotion {
    /// Evaluates pairs of points under the joint metric, with derivatives along geodesics of length
    /// `distance`. Unused lanes repeat the first pair.
    #[inline(always)]
    pub fn place_all(&self, points: &[[Vec3; 2]], distance: f64, out: &mut PairMotions) {
        out.columns.clear();
        out.columns.resize(self.coordinates.len(), [[0.0; LANES]; 3]);
        let point = |lane: usize| points.get(lane).unwrap_or(&points[0]);
        let side = |side: usize| [0, 1, 2].map(|axis| lanes(|lane| point(lane)[side][axis]));
        let first = self.chains[0].place_all(&side(0), 1.0, distance, out);
        let second = self.chains[1].place_all(&side(1), -1.0, distance, out);
        let both = |order: usize| {
            let (x, y) = (&first[order], &second[order]);
            lanes(|k| if self.is_shared { x[k] + y[k] } else { larger(x[k], y[k]) })
        };
        out.second = both(0);
        let (here, there) = (both(1), both(2));
        out.third = lanes(|k| 0.75 * here[k] + 0.25 * there[k]);
    }
}

impl Chain {
    /// Adds the velocities of points to the columns. Returns bounds on their second and third
    /// derivatives at the start, and on the third at `distance`.
    #[inline(always)]
    fn place_all(&self, points: &[Lanes; 3], sign: f64, distance: f64, out: &mut PairMotions) -> [Lanes; 3] {
        out.levers.clear();
        for joint in &self.joints {
            out.levers.push(joint.place_all(points, sign, &mut out.columns));
        }
        out.sums.clear();
        out.sums.resize(out.columns.len(), [0.0; LANES]);
        let [mut second, mut third, mut third_there] = [[0.0; LANES]; 3];
        let [mut squared, mut farthest, mut farthest_there]: [Lanes; 3] = [[0.0; LANES]; 3];
        // The same as `derivatives` and `measure_reaches`, but each step takes all lanes at once,
        // so that it compiles to vector instructions.
        for (k, joint) in self.joints.iter().enumerate().rev() {
            let (turned, rate, lever, before) = (self.turned[k], joint.rate, out.levers[k], out.sums[joint.at]);
            let moved = lanes(|k| distance * squared[k].sqrt());
            let reach = if joint.is_slide { lever } else { lanes(|k| lever[k] + moved[k]) };
            let sum = lanes(|k| before[k] + rate * reach[k]);
            squared = lanes(|k| squared[k] + (sum[k] * sum[k] - before[k] * before[k]));
            out.sums[joint.at] = sum;
            if joint.is_slide {
                let (by_slide, next) = (rate * 2.0 * turned, rate * 3.0 * turned * turned);
                second = second.map(|x| x + by_slide);
                third = third.map(|x| x + next);
                third_there = third_there.map(|x| x + next);
                continue;
            }
            let (by_turn, next) = (turned * turned, turned.powi(3));
            let more = lanes(|k| larger(lever[k] - farthest[k], 0.0));
            let more_there = lanes(|k| larger(reach[k] - farthest_there[k], 0.0));
            second = lanes(|k| second[k] + more[k] * by_turn);
            third = lanes(|k| third[k] + more[k] * next);
            third_there = lanes(|k| third_there[k] + more_there[k] * next);
            farthest = lanes(|k| larger(lever[k], farthest[k]));
            farthest_there = lanes(|k| larger(reach[k], farthest_there[k]));
        }
        [second, third, third_there]
    }
}

impl Joint {
    /// Adds the velocities of points to `columns`, and returns the levers of the joint.
    #[inline(always)]
    fn place_all(&self, points: &[Lanes; 3], sign: f64, columns: &mut [[Lanes; 3]]) -> Lanes {
        if self.is_slide {
            for (axis, along) in columns[self.at].iter_mut().enumerate() {
                along.iter_mut().for_each(|x| *x += sign * self.axes[0][axis]);
            }
            return [1.0; LANES];
        }
        let [x, y, z] = [0, 1, 2].map(|axis| lanes(|k| points[axis][k] - self.origin[axis]));
        let mut across = [0.0; LANES];
        for (axis, column) in self.axes.iter().zip(&mut columns[self.at..]).take(self.dimensions) {
            let u = lanes(|k| axis.y * z[k] - axis.z * y[k]);
            let v = lanes(|k| axis.z * x[k] - axis.x * z[k]);
            let w = lanes(|k| axis.x * y[k] - axis.y * x[k]);
            across = lanes(|k| u[k] * u[k] + v[k] * v[k] + w[k] * w[k]);
            for (of_axis, velocity) in column.iter_mut().zip([u, v, w]) {
                *of_axis = lanes(|k| of_axis[k] + sign * velocity[k]);
            }
        }
        if self.rate == 0.0 {
            [0.0; LANES]
        } else if self.dimensions == 1 {
            lanes(|k| across[k].sqrt() / self.rate)
        } else {
            lanes(|k| (x[k] * x[k] + y[k] * y[k] + z[k] * z[k]).sqrt())
        }
    }
}
