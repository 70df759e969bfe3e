//! Deserialises arrays of exact length: `toml` silently drops the rest of one that is too long.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// Deserialises an array of exactly `N` elements.
pub fn exactly<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(of: D) -> Result<[T; N], D::Error> {
    sized(Vec::deserialize(of)?)
}

/// As [`exactly`], for a key that may be absent.
pub fn exactly_if_any<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    of: D,
) -> Result<Option<[T; N]>, D::Error> {
    exactly(of).map(Some)
}

/// Deserialises a list of arrays of two names.
pub fn pairs_of_names<'de, D: Deserializer<'de>>(of: D) -> Result<Vec<[String; 2]>, D::Error> {
    Vec::<Vec<String>>::deserialize(of)?.into_iter().map(sized).collect()
}

fn sized<T, const N: usize, E: Error>(elements: Vec<T>) -> Result<[T; N], E> {
    let found = elements.len();
    elements.try_into().map_err(|_| E::custom(format_args!("got an array of {found}, expected one of {N}")))
}

#[cfg(test)]
mod tests {
    use crate::scene::file::parse;

    #[test]
    fn arrays_that_are_too_long_or_too_short_are_named() {
        let robot = "[[robot]]\nurdf = 'a'\n";
        let obstacle = "[[obstacle]]\nname = 'a'\n";
        for (text, found) in [
            (format!("{robot}pose = {{ xyz = [0, 0, 0, 1] }}"), "got an array of 4, expected one of 3"),
            (format!("{robot}pose = {{ rpy = [0, 0] }}"), "got an array of 2, expected one of 3"),
            (format!("{robot}limits = {{ a = [0, 1, 2] }}"), "expected [lower, upper]"),
            (format!("{obstacle}shape = {{ box = [1, 1, 1, 1] }}"), "got an array of 4"),
            (format!("{obstacle}shape = {{ cylinder = [1, 1, 1] }}"), "got an array of 3, expected one of 2"),
            (format!("{obstacle}shape = {{ capsule = [1] }}"), "got an array of 1"),
            (format!("{obstacle}shape = {{ mesh = 'a', scale = [1, 1, 1, 1] }}"), "expected a number or [x, y, z]"),
            ("[pairs]\ndisable = [['a', 'b'], ['a', 'b', 'c']]".into(), "got an array of 3, expected one of 2"),
            ("metric = { weights = { a = [1, 2, 3] } }".into(), "[translation, rotation]"),
        ] {
            let message = parse("s.toml", &text).unwrap_err().to_string();
            assert!(message.contains(found), "{text}: {message}");
        }
    }
}
