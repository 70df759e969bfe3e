//! Formats numbers and tables for people.

use extricate::{PairId, Scene};
pub use extricate_view::{MIXED_UNIT, metric_unit};

/// Returns the `share` quantile of `values` (which it sorts), linear between neighbours; `NaN` if
/// empty.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    let at = share * (values.len() - 1) as f64;
    let (low, high) = (values[at.floor() as usize], values[at.ceil() as usize]);
    // Equal neighbours may be infinite, and their difference would be NaN.
    if low == high { low } else { low + (at - at.floor()) * (high - low) }
}

/// Formats a duration with three digits and a suitable unit.
pub fn duration(seconds: f64) -> String {
    for (limit, factor, unit) in [(1e-3, 1e6, "us"), (1.0, 1e3, "ms"), (120.0, 1.0, "s")] {
        if seconds < limit {
            return format!("{} {unit}", three_digits(seconds * factor));
        }
    }
    format!("{} min", three_digits(seconds / 60.0))
}

/// Formats a share as a percentage; never rounds up to `100 %`.
pub fn percent(share: f64) -> String {
    let tenths = (share * 1000.0 + 1e-9).floor() / 10.0;
    if tenths == tenths.round() { format!("{tenths:.0} %") } else { format!("{tenths:.1} %") }
}

/// Formats a whole number with separated thousands.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// Formats a whole number and what it counts: `1 query`, `1,200 queries`.
pub fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{} {}", count(n), if n == 1 { one } else { many })
}

/// Formats a number with so many decimals; a value that rounds to zero has no sign.
pub fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(plain) if plain.chars().all(|c| matches!(c, '0' | '.')) => plain.to_owned(),
        _ => text,
    }
}

/// Explains one unit of the metric, if the metric adds lengths to angles; `weights` names the
/// option that changes it.
pub fn what_a_unit_is(scene: &Scene, weights: &str) -> Option<String> {
    if metric_unit(scene) != MIXED_UNIT {
        return None;
    }
    let is_weighted = scene.space().factors().iter().any(|factor| factor.weight != 1.0);
    Some(match is_weighted {
        false => format!("1 m counts as 1 rad; {weights} changes that"),
        true => format!("metres and radians are added, each joint by its weight; {weights} changes that"),
    })
}

/// Returns the names of both bodies of each pair.
pub fn pair_names<'a>(scene: &'a Scene, pairs: &[PairId]) -> Vec<[&'a str; 2]> {
    pairs.iter().map(|&pair| scene.pair_names(pair)).collect()
}

/// Names the first `most` pairs: `arm - shelf, hand - shelf and 3 more`.
pub fn pairs_in_words(names: &[[&str; 2]], most: usize) -> String {
    let mut text = names.iter().take(most).map(|[a, b]| format!("{a} - {b}")).collect::<Vec<_>>().join(", ");
    if names.len() > most {
        text += &format!(" and {} more", names.len() - most);
    }
    text
}

/// Formats two columns, the first padded; every row is one line.
pub fn two_columns<L: AsRef<str>>(rows: &[(L, String)]) -> String {
    let width = rows.iter().map(|(label, _)| label.as_ref().chars().count()).max().unwrap_or(0);
    rows.iter().map(|(label, value)| format!("  {:<width$}  {value}", label.as_ref())).collect::<Vec<_>>().join("\n")
}

fn three_digits(value: f64) -> String {
    match value {
        v if v < 10.0 => format!("{v:.2}"),
        v if v < 100.0 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        assert_eq!(quantile(&mut [3.0, 1.0, 2.0], 0.5), 2.0);
        assert_eq!(quantile(&mut [1.0, 2.0], 0.5), 1.5);
        assert_eq!(quantile(&mut [1.0, f64::INFINITY, f64::INFINITY], 0.75), f64::INFINITY);
        assert!(quantile(&mut [], 0.5).is_nan());
    }

    #[test]
    fn durations_take_the_unit_that_fits() {
        assert_eq!(duration(12.34e-6), "12.3 us");
        assert_eq!(duration(0.00123), "1.23 ms");
        assert_eq!(duration(19.6), "19.6 s");
        assert_eq!(duration(600.0), "10.0 min");
    }

    #[test]
    fn a_share_below_one_is_never_shown_as_all() {
        assert_eq!(percent(1.0), "100 %");
        assert_eq!(percent(0.9999), "99.9 %");
        assert_eq!(percent(0.0), "0 %");
        assert_eq!(percent(0.935), "93.5 %");
    }

    #[test]
    fn counts_and_lists_read_well() {
        assert_eq!(count(1234567), "1,234,567");
        assert_eq!(count(12), "12");
        assert_eq!(counted(1, "query", "queries"), "1 query");
        assert_eq!(counted(1200, "query", "queries"), "1,200 queries");
        assert_eq!((&*fixed(-0.0, 1), &*fixed(-1e-9, 3), &*fixed(-0.25, 1)), ("0.0", "0.000", "-0.2"));
        assert_eq!((&*fixed(-0.0, 0), &*fixed(f64::NEG_INFINITY, 2)), ("0", "-inf"));
        let names = [["a", "b"], ["c", "d"], ["e", "f"]];
        assert_eq!(pairs_in_words(&names, 2), "a - b, c - d and 1 more");
        assert_eq!(two_columns(&[("x", "1".into()), ("long", "2".into())]), "  x     1\n  long  2");
    }
}
