//! Data that the page plays back without a query: paths from elsewhere, and released grasps.

use extricate::geometry::Body;
use extricate::{CheckScratch, Config, SegmentOptions, SegmentOutcome};
use serde::{Deserialize, Serialize};

use crate::answer_data::{AnswerData, Inspector};
use crate::scene_data::object_data;

#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Played {
    Path(PathData),
    Grasp(GraspData),
}

/// The exact checker's verdict on a path.
#[derive(Debug, Serialize)]
pub(crate) struct PathData {
    waypoints: usize,
    /// Length from waypoint to waypoint, in the scene's metric.
    length: f64,
    /// Number of segments that are proved free.
    free_segments: usize,
    /// Number of segments with a collision; the others are undecided.
    colliding_segments: usize,
    /// Share of the way at the first collision; `None` if none is known.
    first_collision: Option<f64>,
    /// A letter for every segment: `f` proved free, `c` with a collision, `u` undecided.
    segments: String,
}

/// A grasp, under the names of `extricate grasp --json`.
#[derive(Debug, Clone, Deserialize, Serialize)]
pub struct GraspData {
    /// The configuration of the released hand.
    pub config: Vec<f64>,
    /// Distance from the query, in the scene's metric.
    pub moved: f64,
    /// Whether the exact checker called it free.
    pub verified: bool,
    /// Links that touched at the query.
    pub touched: Vec<String>,
    /// Links that touched and still do.
    pub kept: Vec<String>,
    /// Numbers of fingers that touched, and that still do.
    pub fingers: [usize; 2],
    /// Whether every contact is on its side of the object.
    pub kept_sides: bool,
    /// Greatest depth of a link in the object at the query \[m\].
    pub depth_before: f64,
    /// Quality of the grasp; `None` if it was not evaluated.
    pub quality: Option<Quality>,
    /// Contacts of the hand with the object.
    #[serde(skip_serializing)]
    pub contacts: Vec<Touch>,
    /// Number of exact checks and contact evaluations.
    pub checks: usize,
}

/// Resistance of a grasp to wrenches.
#[derive(Debug, Clone, Deserialize, Serialize)]
pub struct Quality {
    /// Radius of the largest ball of wrenches that the contacts resist.
    pub epsilon: f64,
    /// Whether the contacts resist every wrench.
    pub force_closure: bool,
}

/// A contact of a grasp, as far as the page needs it.
#[derive(Debug, Clone, Deserialize)]
pub struct Touch {
    /// Signed distance of the two bodies \[m\].
    pub distance: f64,
}

/// A waypoint after the first.
#[derive(Debug, Serialize)]
pub(crate) struct Waypoint {
    /// Share of the way at the waypoint.
    pub(crate) at: f64,
    pub(crate) q: Vec<f64>,
}

impl Inspector<'_> {
    /// Returns the page's data of a path: straight segments from waypoint to waypoint.
    pub fn path_data(&mut self, first: &Config, rest: &[Config]) -> AnswerData {
        let all: Vec<&Config> = std::iter::once(first).chain(rest).collect();
        let metric = self.solver().metric();
        let lengths: Vec<f64> = all.windows(2).map(|ends| metric.distance(ends[0], ends[1])).collect();
        let shares = shares(&lengths);
        let mut way: Vec<Waypoint> = rest.iter().zip(&shares).map(|(q, &at)| Waypoint { at, q: q.to_vec() }).collect();
        let path = self.judged(&all, &lengths, &shares);
        // The last waypoint is the witness.
        let last = way.pop().map_or_else(|| first.to_vec(), |last| last.q);
        // The end of a path need not touch anything, so it has no contacts; overlaps there are
        // coloured.
        let exit = self.exit_by_way(first, way, last, path.length, None);
        self.played_data(first, exit, Played::Path(path))
    }

    /// Returns the page's data of a grasp of an object that is no obstacle of the scene, as
    /// [`Inspector::grasp_data`] does.
    ///
    /// # Errors
    /// Fails if the object cannot be an obstacle of the scene, or as [`Inspector::grasp_data`].
    pub fn grasp_of_object_data(&mut self, q: &Config, grasp: GraspData, object: Body) -> Result<AnswerData, String> {
        let in_words = |error: extricate::Error| error.to_string();
        let scene = self.solver().scene().with_obstacles([object]).map_err(in_words)?;
        let solver = self.solver().with_scene(scene).map_err(in_words)?;
        let mut data = Inspector::new(&solver, self.detail()).grasp_data(q, grasp)?;
        data.object = object_data(solver.scene());
        Ok(data)
    }

    /// Returns the page's data of a grasp that was released from the query `q`.
    ///
    /// # Errors
    /// Fails if the grasp belongs to another hand.
    pub fn grasp_data(&mut self, q: &Config, grasp: GraspData) -> Result<AnswerData, String> {
        let found = self.solver().scene().space().config_anywhere(&grasp.config);
        let found = found.map_err(|error| format!("config: {error}"))?;
        // Contacts of a grasp lie within its own reach, which is usually above the clearance.
        let reach = grasp.contacts.iter().map(|contact| contact.distance).fold(0.0, f64::max);
        let exit = self.exit_by_way(q, Vec::new(), found.to_vec(), grasp.moved, Some(reach));
        Ok(self.played_data(q, exit, Played::Grasp(grasp)))
    }

    fn judged(&self, waypoints: &[&Config], lengths: &[f64], shares: &[f64]) -> PathData {
        let (checker, mut scratch) = (self.solver().checker(), CheckScratch::default());
        let mut path = PathData {
            waypoints: waypoints.len(),
            length: lengths.iter().sum(),
            free_segments: 0,
            colliding_segments: 0,
            first_collision: None,
            segments: String::new(),
        };
        for (at, ends) in waypoints.windows(2).enumerate() {
            let begins = if at == 0 { 0.0 } else { shares[at - 1] };
            match checker.segment(ends[0], ends[1], &SegmentOptions::default(), &mut scratch) {
                SegmentOutcome::Free => {
                    path.free_segments += 1;
                    path.segments.push('f');
                }
                SegmentOutcome::Contact { colliding_at, .. } => {
                    path.colliding_segments += 1;
                    path.segments.push('c');
                    path.first_collision.get_or_insert(begins + colliding_at * (shares[at] - begins));
                }
                _ => path.segments.push('u'),
            }
        }
        path
    }
}

/// Ends of successive lengths as shares of their sum; equal shares if the sum is 0.
fn shares(lengths: &[f64]) -> Vec<f64> {
    let (sum, count) = (lengths.iter().sum::<f64>(), lengths.len() as f64);
    let mut until = 0.0;
    let mut shares: Vec<f64> = lengths
        .iter()
        .map(|length| {
            until += if sum > 0.0 { length / sum } else { 1.0 / count };
            until.min(1.0)
        })
        .collect();
    // Without this, rounding could keep the last share below 1.
    shares.last_mut().into_iter().for_each(|last| *last = 1.0);
    shares
}

/// The leg at fraction `t` of the way from `from` by `way` to `to`: its ends, and the share of the
/// leg.
pub(crate) fn leg<'a>(from: &'a [f64], way: &'a [Waypoint], to: &'a [f64], t: f64) -> (&'a [f64], &'a [f64], f64) {
    let (mut low, mut start) = (0.0, from);
    for point in way {
        if t <= point.at {
            let share = if point.at > low { (t - low) / (point.at - low) } else { 1.0 };
            return (start, &point.q, share);
        }
        (low, start) = (point.at, &point.q);
    }
    (start, to, if low < 1.0 { (t - low) / (1.0 - low) } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer_data::Detail;
    use extricate::{Label, Sampler, Solver, builtin};
    use std::ops::ControlFlow;

    fn solver() -> Solver {
        Solver::new(builtin::scene("planar-arm").unwrap())
    }

    /// A free and a colliding configuration of the planar arm.
    fn ends(solver: &Solver) -> [Config; 2] {
        [Label::Free, Label::Colliding].map(|label| {
            let drawn = Sampler::new(solver, Some(label), 0).draw(1, &mut |_, _| ControlFlow::Continue(()));
            solver.scene().config(&drawn.unwrap()[0]).unwrap()
        })
    }

    fn value(data: &AnswerData) -> serde_json::Value {
        serde_json::to_value(data).unwrap()
    }

    #[test]
    fn a_path_through_a_collision_is_judged_and_shown_by_its_waypoints() {
        let solver = solver();
        let [free, hit] = ends(&solver);
        let mut inspector = Inspector::new(&solver, Detail::default());
        let data = value(&inspector.path_data(&free, &[hit.clone(), free.clone()]));
        let path = &data["played"]["path"];
        assert_eq!((&path["waypoints"], &path["colliding_segments"]), (&3.into(), &2.into()), "{path}");
        assert_eq!(path["segments"], "cc");
        assert!(path["first_collision"].as_f64().unwrap() <= 0.5);
        let exit = &data["exits"][0];
        let length = 2.0 * solver.metric().distance(&free, &hit);
        assert!((exit["depth"].as_f64().unwrap() - length).abs() < 1e-12);
        assert_eq!(exit["way"][0], serde_json::json!({ "at": 0.5, "q": hit.to_vec() }));
        assert_eq!(exit["witness"], serde_json::json!(free.to_vec()));
        // The path is free at both ends and collides in the middle.
        let stretches = exit["stretches"].as_array().unwrap();
        let is_free = |at: usize| stretches[at]["pairs"].as_array().unwrap().is_empty();
        assert!(stretches.len() >= 3 && is_free(0) && is_free(stretches.len() - 1) && !is_free(1), "{stretches:?}");
        // A path that does not move at all.
        let still = value(&inspector.path_data(&free, &[free.clone(), free.clone()]));
        assert_eq!(still["played"]["path"]["free_segments"], 2);
        assert_eq!(still["exits"][0]["way"][0]["at"], 0.5);
    }

    #[test]
    fn a_way_is_walked_leg_by_leg() {
        let way = [Waypoint { at: 0.25, q: vec![1.0] }, Waypoint { at: 0.25, q: vec![2.0] }];
        for (t, from, to, share) in
            [(0.0, 0.0, 1.0, 0.0), (0.125, 0.0, 1.0, 0.5), (0.25, 0.0, 1.0, 1.0), (1.0, 2.0, 3.0, 1.0)]
        {
            assert_eq!(leg(&[0.0], &way, &[3.0], t), (&[from][..], &[to][..], share), "{t}");
        }
        assert_eq!(shares(&[0.0, 0.0]), [0.5, 1.0]);
        assert_eq!(shares(&[1.0, 3.0]), [0.25, 1.0]);
    }

    #[test]
    fn a_grasp_of_another_hand_is_refused() {
        let solver = solver();
        let [free, hit] = ends(&solver);
        let grasp = GraspData {
            config: free.to_vec(),
            moved: 0.3,
            verified: true,
            touched: vec!["tip".into()],
            kept: Vec::new(),
            fingers: [1, 0],
            kept_sides: true,
            depth_before: 0.01,
            quality: None,
            contacts: Vec::new(),
            checks: 7,
        };
        let mut inspector = Inspector::new(&solver, Detail::default());
        let data = value(&inspector.grasp_data(&hit, grasp.clone()).unwrap());
        assert_eq!((&data["played"]["grasp"]["moved"], &data["exits"][0]["depth"]), (&0.3.into(), &0.3.into()));
        assert!(!data["exits"][0]["stretches"][0]["pairs"].as_array().unwrap().is_empty());
        // An object that is no obstacle of the scene is the body after those of the scene.
        let object = solver.scene().bodies().iter().find(|body| body.is_obstacle()).unwrap().clone();
        let bare = Solver::new(solver.scene().without_obstacles());
        let mut inspector = Inspector::new(&bare, Detail::default());
        let last = bare.scene().bodies().len() as u64;
        let data = value(&inspector.grasp_of_object_data(&hit, grasp.clone(), object.clone()).unwrap());
        assert_eq!(data["object"]["name"], object.name);
        let bodies: Vec<u64> =
            data["pairs"].as_object().unwrap().values().map(|pair| pair[1].as_u64().unwrap()).collect();
        assert!(bodies.iter().all(|body| *body <= last), "{bodies:?}");
        let taken = bare.scene().bodies()[0].clone();
        assert!(inspector.grasp_of_object_data(&hit, grasp.clone(), taken).unwrap_err().contains("taken"));
        let short = GraspData { config: vec![0.0], ..grasp };
        assert!(inspector.grasp_data(&hit, short).unwrap_err().contains("config"));
    }
}
