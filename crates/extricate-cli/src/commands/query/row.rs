//! Formats one answer as rows of text or as a line of JSON.

use extricate::{Answer, AnswerRecord, KeptError, Scene, Unproved};
use serde::Serialize;

use crate::report::{duration, fixed, pairs_in_words};

/// An answer with names in place of indices: the JSON output of `query`.
#[derive(Debug, Serialize)]
pub struct QueryRow<'a> {
    #[serde(flatten)]
    record: AnswerRecord<'a>,
    /// Time of the library call alone \[s\].
    seconds: f64,
    #[serde(skip)]
    is_doubtful: bool,
}

impl<'a> QueryRow<'a> {
    pub fn new(answer: &'a Answer, seconds: f64, scene: &'a Scene) -> Self {
        Self { record: answer.record(scene), seconds, is_doubtful: answer.is_doubtful() }
    }

    /// Prints the witness with enough digits to distinguish each number from all others, so that
    /// the printed configuration is the one that was checked.
    pub fn witness_text(&self) -> String {
        let numbers: Vec<String> = self.record.witness.iter().map(|x| (x + 0.0).to_string()).collect();
        format!("{:>6}  [{}]", "at", numbers.join(", "))
    }

    /// Returns the row for the query of input line `line`, and one for each further exit.
    pub fn text(&self, line: usize) -> String {
        let Self { record, seconds, is_doubtful } = self;
        let verified = if record.verified { "yes" } else { "no" };
        let pairs = if record.colliding.is_empty() { "none".into() } else { pairs_in_words(&record.colliding, 2) };
        let segment = record
            .segment
            .map_or(String::new(), |way| format!("; collides until {:.3} of the segment", way.colliding_until));
        let outside = match &record.outside[..] {
            [] => String::new(),
            joints => format!("; beyond limits: {}", joints.join(", ")),
        };
        let radius =
            record.free_radius.map_or(String::new(), |radius| format!("; nothing touches within {radius:.2e}"));
        let kept = |kept: &KeptError| format!("; kept to {:.1e} m, {:.1e} rad", kept.position, kept.rotation);
        let kept: String = record.kept.iter().map(kept).collect();
        let unproved = match record.unproved {
            None => "",
            Some(Unproved::Surfaces) => "; nothing is proved: what collides are surfaces without an inside",
            Some(Unproved::Off) => "; nothing is proved: only a kept link is off",
            Some(_) => "; nothing is proved: the overlap is too shallow",
        };
        let doubt = if *is_doubtful { "; a limit ended the search, and a nearer exit is not ruled out" } else { "" };
        let mut text = format!(
            "{line:>6}  {:>9}  {:>9}  {:>9}  {:>9}  {:>6}  {verified:<8}  {pairs}{outside}{kept}{segment}{radius}{unproved}{doubt}",
            fixed(record.depth, 5),
            fixed(record.lower_bound, 5),
            fixed(100.0 * record.max_displacement, 2),
            duration(*seconds),
            record.checks,
        );
        for exit in record.exits.iter().skip(1) {
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
    use extricate::{Solver, builtin};

    /// An answer for an arm in collision, with the given depth.
    pub fn answer(depth: f64, verified: bool) -> Answer {
        let solver = Solver::new(builtin::scene("planar-arm").unwrap());
        let mut answer = solver.query(&solver.scene().config(&[0.4, 0.0, 0.0]).unwrap()).unwrap();
        (answer.depth, answer.lower_bound, answer.verified) = (depth, depth / 4.0, verified);
        answer
    }

    #[test]
    fn a_row_is_the_record_and_its_time() {
        let (scene, answer) = (builtin::scene("planar-arm").unwrap(), answer(0.2, true));
        let row = QueryRow::new(&answer, 1e-4, &scene);
        let mut expected = serde_json::to_value(answer.record(&scene)).unwrap();
        expected["seconds"] = 1e-4.into();
        assert_eq!(serde_json::to_value(&row).unwrap(), expected);
        let [first, second] = scene.pair_names(answer.colliding[0]);
        let text = row.text(3);
        assert!(text.starts_with("     3    0.20000    0.05000") && text.contains("  yes       "), "{text}");
        assert!(text.contains(&format!("{first} - {second}")), "{text}");
        let widths: Vec<_> = header("rad").lines().map(|l| l.find("depth").or(l.find("[rad]"))).collect();
        assert!(widths.iter().all(Option::is_some));
    }
}
