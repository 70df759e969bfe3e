//! Decompresses LZF, the compression of PCD files.
//!
//! A control byte below 32 precedes literal bytes, one more than its value. Any other one repeats
//! earlier output. Its upper three bits are the length, to which another byte is added if they are
//! 7. Its lower five bits and one more byte are the distance back.

/// Bytes to add to the stored length of a repeat.
const REPEAT_OFFSET_BYTES: usize = 2;

/// Decompresses `packed` to `size` bytes.
///
/// # Errors
/// A description of the problem if `packed` is damaged or of another size.
pub(super) fn unpacked(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let short = || "got compressed data that is cut short, expected all of it".to_owned();
    // It grows as it is filled, since the size may be wrong.
    let mut out: Vec<u8> = Vec::new();
    let mut rest = packed;
    while let Some((&control, after)) = rest.split_first() {
        let control = usize::from(control);
        if control < 32 {
            let (literal, after) = after.split_at_checked(control + 1).ok_or_else(short)?;
            out.extend_from_slice(literal);
            rest = after;
        } else {
            let (more, after) = if control >> 5 == 7 { after.split_first().ok_or_else(short)? } else { (&0, after) };
            let (low, after) = after.split_first().ok_or_else(short)?;
            let length = (control >> 5) + usize::from(*more) + REPEAT_OFFSET_BYTES;
            let back = (control & 31) << 8 | usize::from(*low);
            let from = out.len().checked_sub(back + 1);
            let from =
                from.ok_or_else(|| format!("got a repeat of {} bytes before the first, expected data", back + 1))?;
            // A repeat may overlap its own output, so bytes are copied one by one.
            (from..from + length).for_each(|at| out.push(out[at]));
            rest = after;
        }
        if out.len() > size {
            break;
        }
    }
    if out.len() == size {
        return Ok(out);
    }
    let found = if out.len() > size { "more".to_owned() } else { format!("{} bytes", out.len()) };
    Err(format!("got compressed data of {found}, expected {size} bytes when decompressed"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_repeats_are_taken() {
        assert_eq!(unpacked(&[2, 1, 2, 3], 3).unwrap(), [1, 2, 3]);
        assert_eq!(unpacked(&[1, 5, 6, 1 << 5, 1], 5).unwrap(), [5, 6, 5, 6, 5]);
        assert_eq!(unpacked(&[0, 4, 7 << 5, 10, 0], 20).unwrap(), [4; 20]);
        assert_eq!(unpacked(&[], 0).unwrap(), [0; 0]);
    }

    #[test]
    fn what_is_spoiled_is_an_error() {
        let fault = |packed: &[u8], size| unpacked(packed, size).unwrap_err();
        assert!(fault(&[2, 1], 3).contains("cut short"));
        assert!(fault(&[0, 4, 7 << 5, 10], 20).contains("cut short"));
        assert!(fault(&[0, 4, 7 << 5], 20).contains("cut short"));
        assert!(fault(&[0, 4, 1 << 5, 1], 4).contains("a repeat of 2 bytes before the first"));
        assert!(fault(&[2, 1, 2, 3], 2).contains("got compressed data of more, expected 2 bytes"));
        assert!(fault(&[2, 1, 2, 3], 4).contains("got compressed data of 3 bytes, expected 4"));
    }
}
