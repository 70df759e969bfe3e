//! Linearised rows of kept links, and what is left of other rows along them.

use super::{AIM_SHARE, LinkConstraint, perpendicular};
use crate::kinematics::{Twists, Wrench};
use crate::math::{Pose, Vec3};
use crate::query::qp::Qp;
use crate::scene::Scene;

/// Rows of all kept links at one configuration: a step `t` changes the offset of row `i` by
/// `rows[i] . t`.
#[derive(Debug, Default)]
pub struct KeptRows {
    /// Coefficients over the tangent coordinates, row major.
    pub rows: Vec<f64>,
    /// Offsets \[m or rad\].
    pub offsets: Vec<f64>,
    /// How large searches let them be.
    pub allowed: Vec<f64>,
    /// Lengths of the vectors that the offsets are components of.
    lengths: Vec<f64>,
}

impl KeptRows {
    /// Forgets all rows.
    pub fn clear(&mut self) {
        for list in [&mut self.rows, &mut self.offsets, &mut self.allowed, &mut self.lengths] {
            list.clear();
        }
    }

    /// Linearises the offsets at the configuration of `poses` and `twists`.
    pub fn set(&mut self, scene: &Scene, kept: &[LinkConstraint], poses: &[Pose], twists: &Twists) {
        self.clear();
        for link in kept {
            let offset = link.offset(poses);
            if let Some(tolerance) = link.position {
                for k in 0..3 {
                    let wrench = Wrench::at(&offset.origin, offset.base.vector(&Vec3::ith(k, 1.0)));
                    self.add(scene, link, twists, &wrench, (offset.position[k], tolerance));
                    self.lengths.push(offset.position.norm());
                }
            }
            let Some(tolerance) = link.rotation else { continue };
            let directions = match link.axis {
                None => (0..3).map(|k| Vec3::ith(k, 1.0)).collect::<Vec<_>>(),
                Some(axis) => {
                    let kept = link.target.rotation * axis;
                    let first = perpendicular(&kept);
                    vec![first, kept.cross(&first)]
                }
            };
            for direction in directions {
                let wrench = Wrench { force: Vec3::zeros(), moment: offset.base.vector(&direction) };
                self.add(scene, link, twists, &wrench, (offset.rotation.dot(&direction), tolerance));
                self.lengths.push(offset.rotation.norm());
            }
        }
    }

    /// Adds two rows to a program for each kept coordinate, over the first `nv` unknowns: it
    /// neither falls nor rises beyond what is allowed.
    pub fn push(&self, qp: &mut Qp, nv: usize) {
        for (row, (offset, allowed)) in self.rows.chunks_exact(nv).zip(self.offsets.iter().zip(&self.allowed)) {
            for sign in [1.0, -1.0] {
                let slots = &mut qp.push((-allowed - sign * offset).min(0.0))[..nv];
                slots.iter_mut().zip(row).for_each(|(slot, slope)| *slot = sign * slope);
            }
        }
    }

    /// Returns by how much each row has to change so that all links are kept.
    pub fn changes(&self) -> impl Iterator<Item = f64> {
        let each = self.offsets.iter().zip(self.allowed.iter().zip(&self.lengths));
        each.map(|(offset, (allowed, length))| if length > allowed { offset * (allowed / length - 1.0) } else { 0.0 })
    }

    fn add(
        &mut self,
        scene: &Scene,
        link: &LinkConstraint,
        twists: &Twists,
        wrench: &Wrench,
        (offset, tolerance): (f64, f64),
    ) {
        let (start, nv) = (self.rows.len(), scene.space.nv());
        self.rows.resize(start + nv, 0.0);
        let row = &mut self.rows[start..];
        let back = Wrench { force: -wrench.force, moment: -wrench.moment };
        twists.add_power(scene, link.link.0, wrench, row);
        twists.add_power(scene, link.base.0, &back, row);
        self.offsets.push(offset);
        self.allowed.push(AIM_SHARE * tolerance);
    }
}

/// The span of the rows of kept links: what they leave of the gradient of anything else.
#[derive(Debug, Default)]
pub struct Span {
    /// An orthonormal basis in the inner product of the inverse weights, row major.
    basis: Vec<f64>,
    rest: Vec<f64>,
}

impl Span {
    /// Sets the span of `rows` (row major) for inverse weights of the tangent coordinates.
    pub fn set(&mut self, rows: &[f64], inverse: &[f64]) {
        self.basis.clear();
        for row in rows.chunks_exact(inverse.len()) {
            let before = product(row, row, inverse);
            // Twice is enough (Kahan and Parlett): rounding leaves parts along the basis after
            // once.
            self.reduce(row, inverse);
            let once = std::mem::take(&mut self.rest);
            self.reduce(&once, inverse);
            let length = product(&self.rest, &self.rest, inverse);
            if length > 1e-12 * before {
                let scale = 1.0 / length.sqrt();
                self.basis.extend(self.rest.iter().map(|x| x * scale));
            }
        }
    }

    /// Returns the part of a row that is orthogonal to the span.
    pub fn reduce(&mut self, row: &[f64], inverse: &[f64]) -> &[f64] {
        self.rest.clear();
        self.rest.extend_from_slice(row);
        for unit in self.basis.chunks_exact(inverse.len()) {
            let along = product(&self.rest, unit, inverse);
            self.rest.iter_mut().zip(unit).for_each(|(x, u)| *x -= along * u);
        }
        &self.rest
    }
}

fn product(a: &[f64], b: &[f64], inverse: &[f64]) -> f64 {
    a.iter().zip(b).zip(inverse).map(|((a, b), w)| a * b * w).sum()
}
