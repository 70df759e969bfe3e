//! One answer as rows of text or a line of JSON.

use extricate::geometry::Vec3;
use extricate::{Answer, Contact, Effort, Scene, StraightSegment, Unproved};
use serde::Serialize;

use crate::report::{duration, fixed, pair_names, pairs_in_words};

/// An answer with names in place of indices: the JSON output of `query`.
#[derive(Debug, Serialize)]
pub struct QueryRow<'a> {
    /// Distance from the query to the witness, in the scene's metric; 0 where the query is free.
    pub depth: f64,
    /// Proved: no free configuration is nearer.
    pub lower_bound: f64,
    /// Share of the depth that is not proved.
    pub gap: f64,
    /// Why nothing is proved, where that is so.
    pub unproved: Option<Unproved>,
    /// The free configuration.
    pub witness: &'a [f64],
    /// Time of the library call alone \[s\].
    pub seconds: f64,
    /// Collision checks and distance evaluations spent.
    pub checks: usize,
    /// Largest displacement of any point of the robot \[m\].
    pub max_displacement: f64,
    /// Pairs that collide at the query.
    pub colliding: Vec<[&'a str; 2]>,
    /// Joints of the query that are beyond their limits.
    pub outside: Vec<&'a str>,
    /// Pairs that touch at the witness.
    pub touching: Vec<[&'a str; 2]>,
    /// Estimated share of starts that would lead to an exit which the query has not met.
    pub unseen: Option<f64>,
    /// With --continuous, depth of the nearest exit that was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest: Option<f64>,
    /// That the witness keeps \[m\].
    pub clearance: f64,
    /// Whether the witness was checked during this query.
    pub verified: bool,
    /// How hard the query tried.
    pub effort: Effort,
    /// Where pairs touch at the witness.
    pub contacts: Vec<ContactRow<'a>>,
    /// Of the depth, in tangent coordinates.
    pub gradient: &'a [f64],
    /// Whether no other exit was met that is about as near.
    pub unique: bool,
    /// Whether a limit ended the search before it was done.
    pub cut_short: bool,
    /// Whether that leaves much open.
    #[serde(skip)]
    pub is_doubtful: bool,
    /// The nearest distinct exits, where more than one was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exits: Vec<ExitRow<'a>>,
    /// Within which, around the witness, nothing touches; where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_radius: Option<f64>,
    /// The straight segment to the witness, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segment: Option<StraightSegment>,
}

/// A contact with names.
#[derive(Debug, Serialize)]
pub struct ContactRow<'a> {
    pair: [&'a str; 2],
    distance: f64,
    point_first: [f64; 3],
    point_second: [f64; 3],
    normal: [f64; 3],
}

/// An exit with names.
#[derive(Debug, Serialize)]
pub struct ExitRow<'a> {
    depth: f64,
    witness: &'a [f64],
    touching: Vec<[&'a str; 2]>,
}

impl<'a> ContactRow<'a> {
    fn new(contact: &Contact, scene: &'a Scene) -> Self {
        let Contact { pair, distance, point_first, point_second, normal } = *contact;
        let [point_first, point_second, normal] = [point_first, point_second, normal].map(|v: Vec3| v.into());
        Self { pair: scene.pair_names(pair), distance, point_first, point_second, normal }
    }
}

impl<'a> QueryRow<'a> {
    /// Names the pairs of `answer`.
    pub fn new(answer: &'a Answer, seconds: f64, scene: &'a Scene) -> Self {
        let exit = |exit: &'a extricate::Exit| ExitRow {
            depth: exit.depth,
            witness: &exit.witness,
            touching: pair_names(scene, &exit.touching),
        };
        Self {
            depth: answer.depth,
            lower_bound: answer.lower_bound,
            gap: answer.gap,
            unproved: answer.unproved,
            witness: &answer.witness,
            seconds,
            checks: answer.checks,
            max_displacement: answer.max_displacement,
            colliding: pair_names(scene, &answer.colliding),
            outside: scene.joints_of(&answer.outside),
            touching: pair_names(scene, &answer.touching),
            unseen: answer.unseen,
            nearest: answer.nearest,
            clearance: answer.clearance,
            verified: answer.verified,
            effort: answer.effort,
            contacts: answer.contacts.iter().map(|contact| ContactRow::new(contact, scene)).collect(),
            gradient: &answer.gradient,
            unique: answer.unique,
            cut_short: answer.cut_short,
            is_doubtful: answer.is_doubtful(),
            exits: answer.exits.iter().map(exit).collect(),
            free_radius: answer.free_radius,
            segment: answer.segment,
        }
    }

    /// The witness, every number with as many digits as tell it from all others: what is printed is
    /// the configuration that was checked.
    pub fn witness_text(&self) -> String {
        format!("{:>6}  [{}]", "at", self.witness.iter().map(|x| (x + 0.0).to_string()).collect::<Vec<_>>().join(", "))
    }

    /// The row for the query of input line `line`, and one for each exit beside the witness.
    pub fn text(&self, line: usize) -> String {
        let verified = if self.verified { "yes" } else { "no" };
        let pairs = if self.colliding.is_empty() { "none".into() } else { pairs_in_words(&self.colliding, 2) };
        let segment =
            self.segment.map_or(String::new(), |w| format!("; collides until {:.3} of the segment", w.colliding_until));
        let outside = match &self.outside[..] {
            [] => String::new(),
            joints => format!("; beyond limits: {}", joints.join(", ")),
        };
        let radius = self.free_radius.map_or(String::new(), |radius| format!("; nothing touches within {radius:.2e}"));
        let unproved = match self.unproved {
            None => "",
            Some(Unproved::Surfaces) => "; nothing is proved: what collides are surfaces without an inside",
            Some(Unproved::Shallow) => "; nothing is proved: the overlap is too shallow",
        };
        let doubt =
            if self.is_doubtful { "; a limit ended the search, and a nearer exit is not ruled out" } else { "" };
        let mut text = format!(
            "{line:>6}  {:>9}  {:>9}  {:>9}  {:>9}  {:>6}  {verified:<8}  {pairs}{outside}{segment}{radius}{unproved}{doubt}",
            fixed(self.depth, 5),
            fixed(self.lower_bound, 5),
            fixed(100.0 * self.max_displacement, 2),
            duration(self.seconds),
            self.checks,
        );
        for exit in self.exits.iter().skip(1) {
            let touching = pairs_in_words(&exit.touching, 2);
            text += &format!("\n{:>6}  {:>9.5}  another exit, touching {touching}", "or", exit.depth);
        }
        text
    }
}

/// Titles of the columns of [`QueryRow::text`].
pub fn header(unit: &str) -> String {
    let title = format!(
        "{:>6}  {:>9}  {:>9}  {:>9}  {:>9}  {:>6}  {:<8}  colliding pairs",
        "line", "depth", "at least", "moved", "time", "checks", "verified"
    );
    format!("{title}\n{:>6}  {:>9}  {:>9}  {:>9}", "", format!("[{unit}]"), format!("[{unit}]"), "[cm]")
}

#[cfg(test)]
pub mod tests {
    use super::*;

    pub fn answer(depth: f64, verified: bool) -> Answer {
        Answer {
            depth,
            lower_bound: depth / 4.0,
            gap: 0.75,
            unproved: None,
            witness: vec![0.5],
            effort: Effort::Refined,
            checks: 40,
            max_displacement: depth * 0.5,
            colliding: vec![],
            outside: vec![],
            touching: vec![],
            unseen: Some(0.1),
            nearest: None,
            clearance: 1e-4,
            verified,
            contacts: vec![],
            gradient: vec![-1.0],
            unique: true,
            cut_short: false,
            exits: vec![],
            free_radius: None,
            segment: None,
        }
    }

    #[test]
    fn json_has_the_documented_keys() {
        let answer = answer(0.2, true);
        let row = QueryRow {
            depth: answer.depth,
            lower_bound: answer.lower_bound,
            gap: answer.gap,
            unproved: answer.unproved,
            witness: &answer.witness,
            seconds: 1e-4,
            checks: 40,
            max_displacement: 0.1,
            colliding: vec![["arm", "shelf"]],
            outside: vec![],
            touching: vec![["arm", "shelf"]],
            unseen: answer.unseen,
            nearest: answer.nearest,
            clearance: 1e-4,
            verified: true,
            effort: answer.effort,
            contacts: vec![ContactRow {
                pair: ["arm", "shelf"],
                distance: 1e-4,
                point_first: [0.0; 3],
                point_second: [0.0; 3],
                normal: [0.0, 0.0, 1.0],
            }],
            gradient: &answer.gradient,
            unique: true,
            cut_short: false,
            is_doubtful: false,
            exits: vec![ExitRow { depth: 0.2, witness: &[0.5], touching: vec![] }],
            free_radius: None,
            segment: None,
        };
        assert_eq!(
            serde_json::to_string(&row).unwrap(),
            "{\"depth\":0.2,\"lower_bound\":0.05,\"gap\":0.75,\"unproved\":null,\"witness\":[0.5],\"seconds\":0.0001,\"checks\":40,\
             \"max_displacement\":0.1,\"colliding\":[[\"arm\",\"shelf\"]],\"outside\":[],\"touching\":[[\"arm\",\"shelf\"]],\"unseen\":0.1,\
             \"clearance\":0.0001,\"verified\":true,\"effort\":\"refined\",\
             \"contacts\":[{\"pair\":[\"arm\",\"shelf\"],\"distance\":0.0001,\"point_first\":[0.0,0.0,0.0],\
             \"point_second\":[0.0,0.0,0.0],\"normal\":[0.0,0.0,1.0]}],\"gradient\":[-1.0],\"unique\":true,\"cut_short\":false,\
             \"exits\":[{\"depth\":0.2,\"witness\":[0.5],\"touching\":[]}]}"
        );
        assert!(row.text(3).ends_with("yes       arm - shelf"), "{}", row.text(3));
        let widths: Vec<_> = header("rad").lines().map(|l| l.find("depth").or(l.find("[rad]"))).collect();
        assert!(widths.iter().all(Option::is_some));
    }
}
