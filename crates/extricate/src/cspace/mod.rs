//! The configuration space: a product of intervals, circles and SO(3), without robots or metrics of
//! bodies.

mod rows;
pub mod sampling;
mod sound;

pub use rows::Rows;
pub use sound::WEIGHTS;

use std::f64::consts::PI;
use std::ops::{Deref, Range};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::math::{FARTHEST, quaternion_exp, quaternion_log, quaternion_product, wrap_angle};

/// Distance outside its limits \[rad or m\] at which a coordinate is still moved onto them in
/// silence.
pub const LIMIT_TOLERANCE: f64 = 1e-9;

/// A checked point of a [`ConfigSpace`]: right length, within limits, angles wrapped, quaternions
/// unit.
///
/// [`ConfigSpace::config`] makes one. [`ConfigSpace::config_anywhere`] makes one for queries, which
/// may lie beyond limits.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Config(Box<[f64]>);

impl Config {
    /// Wraps values that a search or an exact check has visited, and that therefore need no check.
    pub(crate) fn trusted(values: &[f64]) -> Self {
        Self(values.into())
    }

    /// Copies values that a search has visited, and that therefore need no check.
    pub(crate) fn set(&mut self, values: &[f64]) {
        self.0.copy_from_slice(values);
    }
}

impl From<Config> for Vec<f64> {
    fn from(config: Config) -> Self {
        config.0.into_vec()
    }
}

impl Deref for Config {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

/// Side of the collision boundary that a configuration is on, by an exact check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// Every checked pair keeps the clearance.
    Free,
    /// Some checked pair does not keep the clearance.
    Colliding,
}

/// One factor of the product manifold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Manifold {
    /// A closed interval \[rad or m\]; one coordinate.
    Interval {
        /// Least value of the coordinate.
        lower: f64,
        /// Greatest value of the coordinate.
        upper: f64,
    },
    /// An angle in `[-pi, pi)` \[rad\]; one coordinate.
    Circle,
    /// SO(3): unit quaternion x, y, z, w; four coordinates, three tangent dimensions.
    Rotation,
}

/// A factor, and its place in configurations and tangent vectors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    /// Name in messages: the joint, with `.x` and so on if it has several factors.
    pub name: String,
    /// Values that the factor takes.
    pub manifold: Manifold,
    /// Weight of its squared displacement in the joint metric.
    pub weight: f64,
    /// Index of its first coordinate.
    pub q: usize,
    /// Index of its first tangent coordinate.
    pub v: usize,
}

impl Manifold {
    /// Number of coordinates of a point.
    pub fn coordinates(&self) -> usize {
        if *self == Self::Rotation { 4 } else { 1 }
    }

    /// Number of dimensions of the tangent space.
    pub fn dimensions(&self) -> usize {
        if *self == Self::Rotation { 3 } else { 1 }
    }
}

impl Factor {
    /// Range of its coordinates in a configuration.
    pub fn coordinates(&self) -> Range<usize> {
        self.q..self.q + self.manifold.coordinates()
    }

    /// Range of its coordinates in a tangent vector.
    pub fn tangents(&self) -> Range<usize> {
        self.v..self.v + self.manifold.dimensions()
    }

    /// Weighted square of the distance between two configurations in this factor alone.
    pub fn distance_squared(&self, a: &[f64], b: &[f64]) -> f64 {
        let q = self.q;
        let squared = match self.manifold {
            Manifold::Interval { .. } => (b[q] - a[q]).powi(2),
            Manifold::Circle => wrap_angle(b[q] - a[q]).powi(2),
            Manifold::Rotation => {
                let conjugate = [-a[q], -a[q + 1], -a[q + 2], a[q + 3]];
                let log = quaternion_log(&quaternion_product(&conjugate, &b[q..q + 4]));
                log.iter().map(|x| x * x).sum()
            }
        };
        self.weight * squared
    }

    fn fault(&self, value: String, expected: String) -> Error {
        Error::Config { element: format!("`{}` (coordinate {})", self.name, self.q), value, expected }
    }
}

/// Returns the shorter turn from one angle to another \[rad\]. Of the two half turns it chooses the
/// same arc in both directions, so that a reversed edge is the same edge.
fn turn(from: f64, to: f64) -> f64 {
    let turn = wrap_angle(to - from);
    if turn == -PI && to > from { PI } else { turn }
}

/// A product of manifolds with limits.
///
/// ```
/// use extricate::{ConfigSpace, Manifold};
/// let mut space = ConfigSpace::default();
/// space.push("lift", Manifold::Interval { lower: 0.0, upper: 0.5 }, 1.0);
/// space.push("turn", Manifold::Circle, 1.0);
/// let q = space.config(&[0.2, 7.0]).unwrap();
/// assert!((q[1] - (7.0 - std::f64::consts::TAU)).abs() < 1e-15);
/// assert!(space.config(&[0.7, 0.0]).is_err());
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ConfigSpace {
    factors: Vec<Factor>,
    nq: usize,
    nv: usize,
}

impl ConfigSpace {
    /// Appends a factor; returns its first coordinate and first tangent coordinate.
    pub fn push(&mut self, name: impl Into<String>, manifold: Manifold, weight: f64) -> (usize, usize) {
        let (q, v) = (self.nq, self.nv);
        let (dq, dv) = (manifold.coordinates(), manifold.dimensions());
        self.factors.push(Factor { name: name.into(), manifold, weight, q, v });
        self.nq += dq;
        self.nv += dv;
        (q, v)
    }

    /// Number of coordinates of a configuration.
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Number of tangent dimensions (degrees of freedom).
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// All factors, in the order of their coordinates.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Checks length, finiteness and limits; wraps angles and normalises quaternions.
    ///
    /// # Errors
    /// [`Error::Config`], naming the coordinate. Values up to [`LIMIT_TOLERANCE`] outside a limit
    /// are moved onto it; quaternions may be off unit length by 1e-3.
    pub fn config(&self, values: &[f64]) -> Result<Config> {
        let mut q = self.config_anywhere(values)?;
        for (factor, lower, upper) in self.intervals() {
            let x = &mut q.0[factor.q];
            if *x < lower - LIMIT_TOLERANCE || *x > upper + LIMIT_TOLERANCE {
                return Err(factor.fault(x.to_string(), format!("a value within [{lower}, {upper}]")));
            }
            *x = x.clamp(lower, upper);
        }
        Ok(q)
    }

    /// Does the same without the check of limits: sensors read values beyond them and drives
    /// overshoot. Such a configuration is not free, but the nearest free one to it can be found.
    ///
    /// # Errors
    /// [`Error::Config`], naming the coordinate.
    pub fn config_anywhere(&self, values: &[f64]) -> Result<Config> {
        if values.len() != self.nq {
            return Err(Error::Config {
                element: "length".into(),
                value: values.len().to_string(),
                expected: format!("{} coordinates", self.nq),
            });
        }
        let mut q: Box<[f64]> = values.into();
        for factor in &self.factors {
            let x = &mut q[factor.coordinates()];
            // Sums and products of larger numbers mean nothing, and angles lose their last digits.
            if let Some(bad) = x.iter().find(|c| !(-FARTHEST..=FARTHEST).contains(*c)) {
                return Err(factor.fault(bad.to_string(), "a finite number within 1e9".into()));
            }
            match factor.manifold {
                Manifold::Interval { .. } => {}
                Manifold::Circle => x[0] = wrap_angle(x[0]),
                Manifold::Rotation => {
                    let norm = x.iter().map(|c| c * c).sum::<f64>().sqrt();
                    if (norm - 1.0).abs() > 1e-3 {
                        let expected = "a unit quaternion x, y, z, w".into();
                        return Err(factor.fault(format!("{x:?} of length {norm}"), expected));
                    }
                    // A quaternion that is unit up to rounding stays as it is, so that reading a
                    // configuration again returns the same one.
                    if (norm - 1.0).abs() > 4.0 * f64::EPSILON {
                        normalize(x);
                    }
                }
            }
        }
        Ok(Config(q))
    }

    /// Returns the factors that have limits, with these limits.
    fn intervals(&self) -> impl Iterator<Item = (&Factor, f64, f64)> {
        self.factors.iter().filter_map(|factor| match factor.manifold {
            Manifold::Interval { lower, upper } => Some((factor, lower, upper)),
            Manifold::Circle | Manifold::Rotation => None,
        })
    }

    /// Returns the coordinates that lie beyond their limits.
    pub fn outside<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = usize> + 'a {
        let is_outside = |(factor, lower, upper): &(&Factor, f64, f64)| q[factor.q] < *lower || q[factor.q] > *upper;
        self.intervals().filter(is_outside).map(|(factor, ..)| factor.q)
    }

    /// Moves coordinates beyond a limit onto it.
    pub fn clamp(&self, q: &mut [f64]) {
        self.intervals().for_each(|(factor, lower, upper)| q[factor.q] = q[factor.q].clamp(lower, upper));
    }

    /// Writes the tangent vector from `a` to `b` along the geodesic: differences, wrapped on
    /// circles, body-frame rotation vectors.
    pub fn difference(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) {
        for factor in &self.factors {
            let (q, v) = (factor.q, factor.v);
            match factor.manifold {
                Manifold::Interval { .. } => tangent[v] = b[q] - a[q],
                Manifold::Circle => tangent[v] = turn(a[q], b[q]),
                Manifold::Rotation => {
                    let conjugate = [-a[q], -a[q + 1], -a[q + 2], a[q + 3]];
                    let log = quaternion_log(&quaternion_product(&conjugate, &b[q..q + 4]));
                    tangent[v..v + 3].copy_from_slice(&log);
                }
            }
        }
    }

    /// `out = q + tangent` on the manifold; intervals are clamped to their limits, angles wrapped,
    /// quaternions unit.
    pub fn integrate(&self, q: &[f64], tangent: &[f64], out: &mut [f64]) {
        for factor in &self.factors {
            let (i, v) = (factor.q, factor.v);
            match factor.manifold {
                Manifold::Interval { lower, upper } => out[i] = (q[i] + tangent[v]).clamp(lower, upper),
                Manifold::Circle => out[i] = wrap_angle(q[i] + tangent[v]),
                Manifold::Rotation => {
                    let product = quaternion_product(&q[i..i + 4], &quaternion_exp(&tangent[v..v + 3]));
                    out[i..i + 4].copy_from_slice(&product);
                    normalize(&mut out[i..i + 4]);
                }
            }
        }
    }

    /// Writes the point at fraction `t` of the geodesic from `a` (0) to `b` (1).
    pub fn interpolate(&self, a: &[f64], b: &[f64], t: f64, out: &mut [f64]) {
        for factor in &self.factors {
            let q = factor.q;
            match factor.manifold {
                Manifold::Interval { lower, upper } => out[q] = (a[q] + t * (b[q] - a[q])).clamp(lower, upper),
                Manifold::Circle => out[q] = wrap_angle(a[q] + t * turn(a[q], b[q])),
                Manifold::Rotation => {
                    let conjugate = [-a[q], -a[q + 1], -a[q + 2], a[q + 3]];
                    let log = quaternion_log(&quaternion_product(&conjugate, &b[q..q + 4])).map(|x| x * t);
                    let product = quaternion_product(&a[q..q + 4], &quaternion_exp(&log));
                    out[q..q + 4].copy_from_slice(&product);
                    normalize(&mut out[q..q + 4]);
                }
            }
        }
    }

    /// Weighted distance `sqrt(sum w delta^2)`: the joint metric [sqrt(weight) times rad or m].
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.distance_squared(a, b).sqrt()
    }

    /// Returns the square of [`ConfigSpace::distance`].
    pub fn distance_squared(&self, a: &[f64], b: &[f64]) -> f64 {
        self.factors.iter().map(|factor| factor.distance_squared(a, b)).sum()
    }

    /// Largest distance between any two points in the joint metric.
    pub fn diameter(&self) -> f64 {
        let squared = |factor: &Factor| match factor.manifold {
            Manifold::Interval { lower, upper } => (upper - lower).powi(2),
            Manifold::Circle | Manifold::Rotation => PI * PI,
        };
        self.factors.iter().map(|f| f.weight * squared(f)).sum::<f64>().sqrt()
    }
}

fn normalize(quaternion: &mut [f64]) {
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    quaternion.iter_mut().for_each(|x| *x /= norm);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge that is proved in one direction is returned in the other.
    #[test]
    fn half_turns_are_the_same_arc_in_both_directions() {
        let mut space = ConfigSpace::default();
        space.push("turn", Manifold::Circle, 1.0);
        for [a, b] in [[0.0, -PI], [0.5 * PI, -0.5 * PI], [-0.25 * PI, 0.75 * PI], [1.0, 1.0]] {
            let ([mut there, mut back], mut step) = ([[0.0], [0.0]], [0.0]);
            space.interpolate(&[a], &[b], 0.3, &mut there);
            space.interpolate(&[b], &[a], 0.7, &mut back);
            assert!((there[0] - back[0]).abs() < 1e-12, "{a} {b}: {there:?} {back:?}");
            space.difference(&[a], &[b], &mut step);
            space.integrate(&[a], &[0.3 * step[0]], &mut back);
            assert!((there[0] - back[0]).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_configuration_is_itself_when_it_is_read_again() {
        let (space, mut q) = (space(), [0.0; 6]);
        let halton = sampling::Halton::new(space.nv(), 5);
        for index in 0..500 {
            halton.config(&space, index, &mut q);
            let once = space.config(&q).unwrap();
            assert_eq!(space.config(&once).unwrap(), once);
        }
    }

    /// Makes a space with a factor of every kind.
    pub fn space() -> ConfigSpace {
        let mut space = ConfigSpace::default();
        space.push("a", Manifold::Interval { lower: -1.0, upper: 2.0 }, 1.0);
        space.push("b", Manifold::Circle, 2.0);
        space.push("c", Manifold::Rotation, 0.5);
        space
    }

    #[test]
    fn integrate_inverts_difference() {
        let space = space();
        let halton = sampling::Halton::new(space.nv(), 3);
        let (mut a, mut b, mut c) = (vec![0.0; 6], vec![0.0; 6], vec![0.0; 6]);
        let mut tangent = vec![0.0; 5];
        for i in 0..200 {
            halton.config(&space, 2 * i, &mut a);
            halton.config(&space, 2 * i + 1, &mut b);
            space.difference(&a, &b, &mut tangent);
            space.integrate(&a, &tangent, &mut c);
            assert!(space.distance(&b, &c) < 1e-7, "{a:?} {b:?} {c:?}");
            space.interpolate(&a, &b, 0.25, &mut c);
            assert!((space.distance(&a, &c) - 0.25 * space.distance(&a, &b)).abs() < 1e-7);
        }
    }

    #[test]
    fn configurations_beyond_limits_are_told_and_moved_onto_them() {
        let space = space();
        let q = space.config_anywhere(&[2.5, 7.0, 0.0, 0.0, 0.0, 1.0]).unwrap();
        assert_eq!((q[0], space.outside(&q).collect::<Vec<_>>()), (2.5, vec![0]));
        let mut inside = q.to_vec();
        space.clamp(&mut inside);
        assert_eq!((inside[0], &inside[1..], space.outside(&inside).count()), (2.0, &q[1..], 0));
        assert!(space.config_anywhere(&[f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 1.0]).is_err());
        assert!(space.config(&q).unwrap_err().to_string().contains("[-1, 2]"));
    }

    #[test]
    fn bad_configurations_are_named() {
        let space = space();
        let message = |q: &[f64]| space.config(q).unwrap_err().to_string();
        assert!(message(&[0.0; 3]).contains("6 coordinates"));
        assert!(message(&[3.0, 0.0, 0.0, 0.0, 0.0, 1.0]).contains("`a`"));
        assert!(message(&[f64::NAN, 0.0, 0.0, 0.0, 0.0, 1.0]).contains("finite"));
        // The wrapped angle of so large a number would be chance.
        assert!(message(&[0.0, 1e308, 0.0, 0.0, 0.0, 1.0]).contains("`b` (coordinate 1)"));
        assert!(space.config_anywhere(&[1e308, 0.0, 0.0, 0.0, 0.0, 1.0]).is_err());
        assert!(message(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.5]).contains("unit quaternion"));
    }
}
