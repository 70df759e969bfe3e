//! Finds every number of a structure and replaces it by one that makes no sense.
//!
//! The integration tests of the library use this file too.

use serde_json::Value;

/// Replacement of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spoil {
    /// A count or an index, which JSON can express.
    Whole(u64),
    /// Any number of double precision.
    Real(f64),
}

/// Replacements of counts and indices.
pub const WHOLES: [u64; 7] = [0, 1, 2, 1_000, u32::MAX as u64, 1 << 40, u64::MAX];
/// Replacements of other numbers.
pub const REALS: [f64; 11] =
    [0.0, -0.0, -1.0, 0.7, 1e9, 5e-324, 1e-30, 1e308, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// Replaces a number that JSON cannot express, until bytes are made of the rest.
const STAND_IN: f64 = 1.234_567_890_123e-201;

/// Returns JSON pointers of the numbers of `value`; of long lists only those of the first two
/// entries and the last one.
pub fn numbers(value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    collect(value, &mut String::new(), &mut found);
    found
}

fn collect(value: &Value, at: &mut String, found: &mut Vec<String>) {
    let length = at.len();
    let mut below = |key: &str, value: &Value, found: &mut Vec<String>| {
        at.push('/');
        at.push_str(&key.replace('~', "~0").replace('/', "~1"));
        collect(value, at, found);
        at.truncate(length);
    };
    match value {
        Value::Object(entries) => entries.iter().for_each(|(key, value)| below(key, value, found)),
        Value::Array(entries) => {
            let is_shown =
                |k: &usize| *k < 2 || *k + 1 == entries.len() || entries.len() <= 16 && entries[*k].is_object();
            (0..entries.len()).filter(is_shown).for_each(|k| below(&k.to_string(), &entries[k], found));
        }
        Value::Number(_) => found.push(at.clone()),
        _ => {}
    }
}

/// Returns the replacements to try for a number.
pub fn spoils_of(number: &Value) -> Vec<Spoil> {
    if number.is_f64() { REALS.map(Spoil::Real).to_vec() } else { WHOLES.map(Spoil::Whole).to_vec() }
}

/// Puts `spoil` at `pointer` of `value` and makes bytes of it; returns `None` if the structure has
/// no place for such a number.
pub fn spoiled(
    value: &Value,
    pointer: &str,
    spoil: Spoil,
    bytes: impl Fn(Value) -> Option<Vec<u8>>,
) -> Option<Vec<u8>> {
    let mut value = value.clone();
    let place = value.pointer_mut(pointer)?;
    match spoil {
        Spoil::Whole(number) => *place = number.into(),
        Spoil::Real(_) => *place = STAND_IN.into(),
    }
    let mut bytes = bytes(value)?;
    if let Spoil::Real(number) = spoil {
        let stand_in = STAND_IN.to_le_bytes();
        let at = bytes.windows(stand_in.len()).position(|window| window == stand_in)?;
        bytes[at..at + stand_in.len()].copy_from_slice(&number.to_le_bytes());
    }
    Some(bytes)
}
