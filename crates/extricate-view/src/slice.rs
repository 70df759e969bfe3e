//! The plane through a query and two of its exits: its free and colliding parts, and how far the
//! proof reaches.
//!
//! A point of the plane is the query moved along a tangent vector, so the exits lie in the plane
//! exactly, with rotations too. Lengths in the plane are those of the joint metric at the query;
//! proved distances are in the scene's metric.

use std::f64::consts::TAU;

use extricate::{Anchor, CheckScratch, Checker, Config, ConfigSpace, Label, Manifold, Metric, MetricScratch, Solver};
// The functions of the standard library differ in their last bits in a browser.
use libm::{hypot, sincos};
use serde::Serialize;

/// Ratio of half the slice's side to the distance of the farther exit that it covers.
const MARGIN_RATIO: f64 = 1.25;
/// Largest ratio of the second exit's distance to the first's that widens the slice.
const MAX_EXIT_RATIO: f64 = 4.0;
/// Least share of a second direction's length that is perpendicular to the first.
const MIN_ACROSS_SHARE: f64 = 0.05;
/// Directions in which the distance from the query is measured.
const RAYS: usize = 72;
/// Halvings per ray: the last interval is half the slice's side over 2^23, far below a pixel.
const HALVINGS: usize = 24;
/// Largest distance that is measured, in halves of the slice's side.
const REACH_HALVES: f64 = 2.0;

/// A square around the query.
#[derive(Debug, Serialize)]
pub struct Slice {
    /// Distance from the query to the sides, in the joint metric.
    half: f64,
    /// Cells along each side.
    cells: usize,
    /// States of the cells' centres, row by row from the lower left: `f` free, `c` colliding, `o`
    /// outside the limits. A count follows a state that repeats.
    states: String,
    /// Tangent vectors of length 1, to the right and up.
    axes: [Vec<f64>; 2],
    /// Positions of the exits; those after the second are projected onto the plane.
    exits: Vec<[f64; 2]>,
    /// Number of exits that lie in the plane: 2, or 1 if the upward direction is that of a joint.
    in_plane: usize,
    /// The coordinate that points up, if no second exit spans the plane.
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<String>,
    /// Closed lines at which the distance from the query is the lower bound and the depth; empty if
    /// it is not reached.
    rings: [Vec<[f32; 2]>; 2],
}

/// Returns the slice through `q` and the first two of `witnesses`; `None` if there is no exit, or
/// if the space is a line.
pub fn slice(
    solver: &Solver,
    q: &Config,
    witnesses: &[&[f64]],
    radii: [f64; 2],
    cells: usize,
    scratch: &mut CheckScratch,
) -> Option<Slice> {
    let frame = PlaneFrame::new(solver.scene().space(), q, witnesses)?;
    let half = frame.half();
    let states = states(solver.checker(), &frame, half, cells, scratch);
    let rings = radii.map(|radius| ring(solver.metric(), &frame, half, radius));
    let PlaneFrame { axes, exits, up, .. } = frame;
    let in_plane = if up.is_none() { 2 } else { 1 };
    Some(Slice { half, cells, states, axes, exits, in_plane, up, rings })
}

/// A plane of tangent vectors at a configuration.
struct PlaneFrame<'a> {
    space: &'a ConfigSpace,
    q: &'a [f64],
    axes: [Vec<f64>; 2],
    exits: Vec<[f64; 2]>,
    up: Option<String>,
}

impl<'a> PlaneFrame<'a> {
    fn new(space: &'a ConfigSpace, q: &'a [f64], witnesses: &[&[f64]]) -> Option<Self> {
        let nv = space.nv();
        let mut weights = vec![1.0; nv];
        for factor in space.factors() {
            weights[factor.tangents()].fill(factor.weight);
        }
        let dot = |a: &[f64], b: &[f64]| -> f64 { (0..nv).map(|k| weights[k] * a[k] * b[k]).sum() };
        let toward = |witness: &&[f64]| {
            let mut tangent = vec![0.0; nv];
            space.difference(q, witness, &mut tangent);
            tangent
        };
        let tangents: Vec<Vec<f64>> = witnesses.iter().map(toward).collect();
        let first = tangents.first()?;
        let length = dot(first, first).sqrt();
        if !(length > 0.0 && length.is_finite()) || nv < 2 {
            return None;
        }
        let right: Vec<f64> = first.iter().map(|x| x / length).collect();
        // Part of a direction that is perpendicular to the first, as a unit vector, if it is large
        // enough.
        let across = |tangent: &[f64]| {
            let along = dot(tangent, &right);
            let rest: Vec<f64> = (0..nv).map(|k| tangent[k] - along * right[k]).collect();
            let length = dot(&rest, &rest).sqrt();
            let is_enough = length > MIN_ACROSS_SHARE * dot(tangent, tangent).sqrt();
            is_enough.then(|| rest.iter().map(|x| x / length).collect::<Vec<f64>>())
        };
        let of_exit = tangents.get(1).and_then(|second| across(second));
        let (above, up) = match of_exit {
            Some(above) => (above, None),
            None => {
                let mut order: Vec<usize> = (0..nv).collect();
                order.sort_by(|&a, &b| right[b].abs().total_cmp(&right[a].abs()));
                let unit = |v: usize| (0..nv).map(|k| f64::from(k == v)).collect::<Vec<f64>>();
                let (v, above) = order.into_iter().find_map(|v| Some((v, across(&unit(v))?)))?;
                let factor = space.factors().iter().find(|factor| factor.tangents().contains(&v))?;
                (above, Some(factor.name.clone()))
            }
        };
        let exits = tangents.iter().map(|tangent| [dot(tangent, &right), dot(tangent, &above)]).collect();
        Some(Self { space, q, axes: [right, above], exits, up })
    }

    /// Distance from the query to the sides.
    fn half(&self) -> f64 {
        let length = |exit: &[f64; 2]| hypot(exit[0], exit[1]);
        let nearest = self.exits.first().map_or(1.0, length);
        let second = self.exits.get(1).filter(|_| self.up.is_none()).map_or(0.0, length);
        MARGIN_RATIO * nearest.max(second.min(MAX_EXIT_RATIO * nearest))
    }

    /// Writes the configuration at a point of the plane, within limits or not.
    fn config(&self, x: f64, y: f64, out: &mut [f64]) {
        let [right, above] = &self.axes;
        let tangent: Vec<f64> = right.iter().zip(above).map(|(a, b)| x * a + y * b).collect();
        self.space.integrate(self.q, &tangent, out);
        let intervals = self.space.factors().iter().filter(|f| matches!(f.manifold, Manifold::Interval { .. }));
        intervals.for_each(|f| out[f.q] = self.q[f.q] + tangent[f.v]);
    }
}

fn states(checker: &Checker, frame: &PlaneFrame, half: f64, cells: usize, scratch: &mut CheckScratch) -> String {
    let mut runs: Vec<(char, usize)> = Vec::new();
    let middle = |at: usize| half * ((2 * at + 1) as f64 / cells as f64 - 1.0);
    let mut q = vec![0.0; frame.q.len()];
    let (mut inside, mut row, mut labels) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..cells {
        inside.clear();
        row.clear();
        for x in 0..cells {
            frame.config(middle(x), middle(y), &mut q);
            inside.push(frame.space.outside(&q).next().is_none());
            if inside[x] {
                row.extend_from_slice(&q);
            }
        }
        labels.clear();
        labels.resize(row.len() / q.len(), Label::Free);
        checker.label_batch_serial(&row, &mut labels, scratch);
        let mut found = labels.iter();
        for is_inside in &inside {
            let state = match is_inside.then(|| found.next()).flatten() {
                Some(Label::Free) => 'f',
                Some(Label::Colliding) => 'c',
                None => 'o',
            };
            match runs.last_mut() {
                Some((last, count)) if *last == state => *count += 1,
                _ => runs.push((state, 1)),
            }
        }
    }
    runs.iter().map(|(state, count)| if *count > 1 { format!("{state}{count}") } else { state.to_string() }).collect()
}

/// Points at which the distance from the query first reaches `radius`.
fn ring(metric: &Metric, frame: &PlaneFrame, half: f64, radius: f64) -> Vec<[f32; 2]> {
    let (mut anchor, mut scratch) = (Anchor::default(), MetricScratch::default());
    metric.anchor(frame.q, &mut anchor);
    let mut q = vec![0.0; frame.q.len()];
    let mut ring = Vec::with_capacity(RAYS);
    for ray in 0..RAYS {
        let (sine, cosine) = sincos(TAU * ray as f64 / RAYS as f64);
        let mut is_beyond = |length: f64| {
            frame.config(length * cosine, length * sine, &mut q);
            metric.distance_from(&anchor, &q, &mut scratch) >= radius
        };
        let (mut low, mut high) = (0.0, REACH_HALVES * half);
        if radius <= 0.0 || !is_beyond(high) {
            return Vec::new();
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_beyond(middle) { high = middle } else { low = middle }
        }
        ring.push([(low * cosine) as f32, (low * sine) as f32]);
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::{MetricKind, QueryOptions, Sampler, builtin};
    use std::ops::ControlFlow;

    fn of(name: &str, metric: MetricKind, exits: usize) -> (Slice, [f64; 2], Solver, Config) {
        let scene = builtin::scene(name).unwrap().with_metric(metric);
        let solver = Solver::new(scene).options(QueryOptions::default().exits(exits)).unwrap();
        let mut sampler = Sampler::new(&solver, Some(Label::Colliding), 0);
        // Exits on opposite sides span no plane, and no inner ring is drawn for a bound of 0.
        loop {
            let drawn = sampler.draw(1, &mut |_, _| ControlFlow::Continue(())).unwrap();
            let q = solver.scene().config(&drawn[0]).unwrap();
            let answer = solver.query(&q).unwrap();
            let mut witnesses: Vec<&[f64]> = answer.exits.iter().map(|exit| &*exit.witness).collect();
            if exits == 1 {
                witnesses.push(&answer.witness);
            }
            let radii = [answer.lower_bound, answer.depth];
            let found = slice(&solver, &q, &witnesses, radii, 32, &mut CheckScratch::default()).unwrap();
            if answer.lower_bound > 0.0 && found.in_plane == exits.min(2) {
                return (found, radii, solver, q);
            }
        }
    }

    fn decoded(states: &str) -> Vec<char> {
        let (mut cells, mut rest) = (Vec::new(), states);
        while let Some(state) = rest.chars().next() {
            let digits = rest[1..].chars().take_while(char::is_ascii_digit).count();
            cells.extend(std::iter::repeat_n(state, rest[1..1 + digits].parse().unwrap_or(1)));
            rest = &rest[1 + digits..];
        }
        cells
    }

    #[test]
    fn exits_lie_where_the_plane_says_and_cells_are_what_the_checker_says() {
        for name in ["planar-arm", "free-box"] {
            let (slice, _, solver, q) = of(name, MetricKind::Joint, 3);
            assert_eq!(slice.in_plane, 2);
            let frame = PlaneFrame { space: solver.scene().space(), q: &q, axes: slice.axes, exits: vec![], up: None };
            let (cells, mut at) = (decoded(&slice.states), vec![0.0; q.len()]);
            assert_eq!(cells.len(), 32 * 32);
            for (number, state) in cells.iter().enumerate() {
                let middle = |at: usize| slice.half * ((2 * at + 1) as f64 / 32.0 - 1.0);
                frame.config(middle(number % 32), middle(number / 32), &mut at);
                let expected = match frame.space.outside(&at).next() {
                    Some(_) => 'o',
                    None if solver.check(&at) => 'f',
                    None => 'c',
                };
                assert_eq!(*state, expected, "{name} {number}");
            }
            for exit in &slice.exits[..2] {
                frame.config(exit[0], exit[1], &mut at);
                assert!(solver.check(&at), "{name}: {exit:?}");
            }
        }
    }

    #[test]
    fn nothing_free_lies_within_the_proved_ring() {
        for metric in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
            let (slice, [lower, depth], ..) = of("planar-arm", metric, 2);
            assert!(lower > 0.0 && lower <= depth);
            let cells = decoded(&slice.states);
            for (number, _) in cells.iter().enumerate().filter(|(_, state)| **state == 'f') {
                let middle = |at: usize| slice.half * ((2 * at + 1) as f64 / 32.0 - 1.0);
                let (x, y) = (middle(number % 32), middle(number / 32));
                let ray = (y.atan2(x).rem_euclid(TAU) / TAU * RAYS as f64).round() as usize % RAYS;
                let proved = slice.rings[0].get(ray).map_or(0.0, |p| f64::from(p[0].hypot(p[1])));
                assert!(x.hypot(y) > 0.97 * proved, "{metric:?}: free at {x} {y}, proved to {proved}");
            }
        }
    }

    #[test]
    fn without_a_second_exit_a_joint_points_up() {
        let (slice, ..) = of("planar-arm", MetricKind::Joint, 1);
        assert!(slice.up.is_some() && slice.in_plane == 1);
        assert!(slice.exits[0][1].abs() < 1e-12);
    }
}
