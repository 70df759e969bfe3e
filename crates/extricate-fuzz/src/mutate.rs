//! Changes inputs a little by a random number generator: bits, numbers, rows and pieces.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use safetensors::tensor::Dtype;

use crate::container::{Array, Container};
use crate::spoil::{REALS, WHOLES};

/// Largest number of changes of one input.
const MAX_CHANGES: usize = 4;

/// Words that replace numbers in text.
const NUMBER_WORDS: [&str; 14] = [
    "0",
    "1",
    "-1",
    "2",
    "0.5",
    "-0.0",
    "1e9",
    "1e308",
    "1e-320",
    "4294967295",
    "1099511627776",
    "18446744073709551615",
    "null",
    "[]",
];

/// Changes the parts of a model file or roadmap and corrects its checksum. Other inputs are changed
/// as bytes.
pub fn sealed(rng: &mut ChaCha8Rng, input: &[u8], other: &[u8]) -> Vec<u8> {
    let Some(mut file) = Container::open(input).filter(|_| rng.random_range(0..64) > 0) else {
        return bytes(rng, input, other);
    };
    let other = Container::open(other).unwrap_or_else(|| file.clone());
    for _ in 0..rng.random_range(1..=MAX_CHANGES) {
        let count = file.arrays.len();
        match rng.random_range(0..16) {
            0..=2 => file.text = text(rng, &file.text),
            3 if count > 0 => {
                file.arrays.remove(rng.random_range(0..count));
            }
            4 if count > 0 => {
                let array = &mut file.arrays[rng.random_range(0..count)];
                if let Some(same) = other.arrays.iter().find(|other| other.name == array.name) {
                    *array = same.clone();
                }
            }
            _ if count > 0 => {
                // Arrays of few bytes are as likely as large ones, being as interesting.
                let array = &mut file.arrays[rng.random_range(0..count)];
                change(rng, array);
            }
            _ => {}
        }
    }
    file.sealed()
}

/// Changes text or a mesh: bytes, numbers, and words of other inputs.
pub fn plain(rng: &mut ChaCha8Rng, input: &[u8], other: &[u8]) -> Vec<u8> {
    let mut changed = input.to_vec();
    for _ in 0..rng.random_range(1..=MAX_CHANGES) {
        match (rng.random_range(0..3), std::str::from_utf8(&changed)) {
            (0, Ok(known)) => changed = text(rng, known).into(),
            (1, Ok(known)) => changed = words(rng, known, &String::from_utf8_lossy(other)).into(),
            _ => change_bytes(rng, &mut changed, other),
        }
    }
    changed
}

/// Removes a word of a text, repeats it, or replaces it by another.
fn words(rng: &mut ChaCha8Rng, input: &str, other: &str) -> String {
    let is_end = |c: char| c.is_whitespace() || "<>=\"',;:/[]{}".contains(c);
    let mut words: Vec<&str> = input.split_inclusive(is_end).collect();
    let others: Vec<&str> = other.split_inclusive(is_end).collect();
    if words.is_empty() || others.is_empty() {
        return other.to_string();
    }
    let at = rng.random_range(0..words.len());
    match rng.random_range(0..4) {
        0 => drop(words.remove(at)),
        1 => words.insert(at, words[rng.random_range(0..words.len())]),
        2 => words[at] = words[rng.random_range(0..words.len())],
        _ => words[at] = others[rng.random_range(0..others.len())],
    }
    words.concat()
}

/// Changes an input as bytes of no known format.
pub fn bytes(rng: &mut ChaCha8Rng, input: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..rng.random_range(1..=MAX_CHANGES) {
        change_bytes(rng, &mut bytes, other);
    }
    bytes
}

/// Replaces a number of a text.
pub fn text(rng: &mut ChaCha8Rng, input: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
    let mut places: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, c) in input.char_indices().filter(|(_, c)| is_number(*c)) {
        match places.last_mut().filter(|place| place.end == at) {
            Some(place) => place.end += c.len_utf8(),
            None => places.push(at..at + c.len_utf8()),
        }
    }
    places.retain(|place| input[place.clone()].contains(|c: char| c.is_ascii_digit()));
    if places.is_empty() {
        return input.to_string();
    }
    let place = places[rng.random_range(0..places.len())].clone();
    let word = if rng.random_range(0..4) == 0 {
        rng.random_range(0..10_000_u32).to_string()
    } else {
        NUMBER_WORDS[rng.random_range(0..NUMBER_WORDS.len())].to_string()
    };
    format!("{}{word}{}", &input[..place.start], &input[place.end..])
}

fn change(rng: &mut ChaCha8Rng, array: &mut Array) {
    let (size, row) = (array.size(), array.shape.get(1).copied().unwrap_or(1).max(1) * array.size());
    let numbers = array.bytes.len() / size;
    if numbers == 0 || array.dtype == Dtype::U8 && rng.random_range(0..8) > 0 {
        let other = array.bytes.clone();
        return change_structure(rng, &mut array.bytes, &other);
    }
    let at = rng.random_range(0..numbers) * size;
    match rng.random_range(0..8) {
        0 => array.bytes[at] ^= 1 << rng.random_range(0..8),
        1 => {
            let first = at / row * row;
            let last = (first + row * rng.random_range(1..4_usize)).min(array.bytes.len());
            array.bytes.drain(first..last);
        }
        2 => {
            let first = at / row * row;
            let copy = array.bytes[first..(first + row).min(array.bytes.len())].to_vec();
            array.bytes.extend(copy);
        }
        3 => {
            let from = rng.random_range(0..numbers) * size;
            array.bytes.copy_within(from..from + size, at);
        }
        4 => {
            // An attacker would change all of them.
            let number = number(rng, array.dtype);
            array.bytes.chunks_exact_mut(size).for_each(|bytes| bytes.copy_from_slice(&number[..size]));
        }
        _ => {
            let number = number(rng, array.dtype);
            array.bytes[at..at + size].copy_from_slice(&number[..size]);
        }
    }
}

/// Returns the bytes of a random number of this type.
fn number(rng: &mut ChaCha8Rng, dtype: Dtype) -> [u8; 8] {
    let real = match rng.random_range(0..3) {
        0 => rng.random_range(-4.0..4.0),
        _ => REALS[rng.random_range(0..REALS.len())],
    };
    match dtype {
        Dtype::F64 => real.to_le_bytes(),
        Dtype::F32 => u64::from((real as f32).to_bits()).to_le_bytes(),
        _ if rng.random() => WHOLES[rng.random_range(0..WHOLES.len())].to_le_bytes(),
        _ => rng.random_range(0..300_u64).to_le_bytes(),
    }
}

/// Changes the bytes of a structure that holds double-precision numbers among others: the last byte
/// of these is nearly always one of a few.
fn change_structure(rng: &mut ChaCha8Rng, bytes: &mut Vec<u8>, other: &[u8]) {
    let ends: Vec<usize> = (7..bytes.len()).filter(|at| matches!(bytes[*at], 0x3e..=0x40 | 0xbe..=0xc0)).collect();
    if ends.is_empty() || rng.random_range(0..3) == 0 {
        return change_bytes(rng, bytes, other);
    }
    let end = ends[rng.random_range(0..ends.len())];
    let number = number(rng, Dtype::F64);
    bytes[end - 7..=end].copy_from_slice(&number);
}

fn change_bytes(rng: &mut ChaCha8Rng, bytes: &mut Vec<u8>, other: &[u8]) {
    if bytes.is_empty() {
        bytes.push(rng.random());
        return;
    }
    let at = rng.random_range(0..bytes.len());
    let some = rng.random_range(1..16_usize).min(bytes.len() - at);
    match rng.random_range(0..9) {
        0..=1 => bytes[at] ^= 1 << rng.random_range(0..8),
        2 => bytes[at] = rng.random(),
        3 => bytes[at..at + some].fill(0xff),
        4 => {
            bytes.drain(at..at + some);
        }
        5 => {
            let copy = bytes[at..at + some].to_vec();
            bytes.splice(at..at, copy);
        }
        6 if !other.is_empty() => {
            let from = rng.random_range(0..other.len());
            let piece = &other[from..other.len().min(from + rng.random_range(1..64_usize))];
            bytes.splice(at..at + some, piece.iter().copied());
        }
        7 => bytes.truncate(at),
        _ => bytes[at] = bytes[at].wrapping_add(if rng.random() { 1 } else { 0xff }),
    }
}
