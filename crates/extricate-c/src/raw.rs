//! Turns pointers of the caller into references and slices. No other module dereferences them.
//!
//! All functions have one safety contract, that of `include/extricate.h`. A pointer is null, or
//! points to as many live values of its type as the caller says. During the call nobody else writes
//! to these values, nor uses those that the call writes. Null pointers, wrong alignment and
//! impossible lengths are detected and refused.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_void};
use std::mem::MaybeUninit;

use crate::abi::types::ExtricateProgress;
use crate::status::{Fault, Result};

/// Memory of the caller for one value; it may be uninitialised and is never read.
pub struct OutValue<'a, T>(&'a mut MaybeUninit<T>);

impl<T> OutValue<'_, T> {
    pub fn put(self, value: T) {
        self.0.write(value);
    }
}

impl<T> OutValue<'_, *mut T> {
    /// Hands a new handle to the caller.
    pub fn hand_over(self, value: T) {
        self.put(Box::into_raw(Box::new(value)));
    }
}

/// Memory of the caller for consecutive values.
pub struct OutValues<'a, T>(&'a mut [MaybeUninit<T>]);

impl<'a, T: Copy> OutValues<'a, T> {
    /// Writes one value after another, never beyond the end.
    pub fn fill(&mut self, values: impl IntoIterator<Item = T>) {
        self.0.iter_mut().zip(values).for_each(|(place, value)| {
            place.write(value);
        });
    }

    /// Splits the memory into parts of `size` values.
    pub fn parts(self, size: usize) -> impl Iterator<Item = OutValues<'a, T>> {
        self.0.chunks_mut(size.max(1)).map(OutValues)
    }
}

/// Returns a handle that the call only reads.
///
/// # Safety
/// The contract of this module.
pub unsafe fn shared<'a, T>(at: *const T, name: &str) -> Result<&'a T> {
    check(at, 1, name)?;
    // SAFETY: not null and aligned, and live by the contract.
    Ok(unsafe { &*at })
}

/// Returns a handle that nobody else uses during the call.
///
/// # Safety
/// The contract of this module.
pub unsafe fn exclusive<'a, T>(at: *mut T, name: &str) -> Result<&'a mut T> {
    check(at, 1, name)?;
    // SAFETY: not null and aligned, live and unshared by the contract.
    Ok(unsafe { &mut *at })
}

/// Returns consecutive values; the pointer may be null if there are none.
///
/// # Safety
/// The contract of this module.
pub unsafe fn slice<'a, T>(at: *const T, count: usize, name: &str) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    check(at, count, name)?;
    // SAFETY: not null, aligned, of a length that memory can have, and live by the contract.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// Returns the memory that one value is written to.
///
/// # Safety
/// The contract of this module.
pub unsafe fn place<'a, T>(at: *mut T, name: &str) -> Result<OutValue<'a, T>> {
    check(at, 1, name)?;
    // SAFETY: as in `exclusive`; `MaybeUninit` allows uninitialised memory.
    Ok(OutValue(unsafe { &mut *at.cast::<MaybeUninit<T>>() }))
}

/// Returns the memory that consecutive values are written to.
///
/// # Safety
/// The contract of this module.
pub unsafe fn places<'a, T>(at: *mut T, count: usize, name: &str) -> Result<OutValues<'a, T>> {
    if count == 0 {
        return Ok(OutValues(&mut []));
    }
    check(at, count, name)?;
    // SAFETY: as in `slice`; unshared by the contract. `MaybeUninit` allows uninitialised memory.
    Ok(OutValues(unsafe { std::slice::from_raw_parts_mut(at.cast::<MaybeUninit<T>>(), count) }))
}

/// Reads a text in UTF-8.
///
/// # Safety
/// The contract of this module; a zero ends the text.
pub unsafe fn text<'a>(at: *const c_char, name: &str) -> Result<&'a str> {
    check(at, 1, name)?;
    // SAFETY: not null, and ended by a zero by the contract.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|error| {
        let at = error.valid_up_to();
        Fault::argument(format!("{name}: byte {at}: got bytes that are not UTF-8, expected text in UTF-8"))
    })
}

/// Reads a text in UTF-8; null stands for none.
///
/// # Safety
/// The contract of [`text`].
pub unsafe fn optional_text<'a>(at: *const c_char, name: &str) -> Result<Option<&'a str>> {
    // SAFETY: the same contract.
    if at.is_null() { Ok(None) } else { unsafe { text(at, name) }.map(Some) }
}

/// Reads consecutive texts.
///
/// # Safety
/// The contract of [`slice`], and of [`text`] for each.
pub unsafe fn texts<'a>(at: *const *const c_char, count: usize, name: &str) -> Result<Vec<&'a str>> {
    // SAFETY: the same contracts.
    let all = unsafe { slice(at, count, name) }?;
    // SAFETY: the same contracts.
    all.iter().enumerate().map(|(k, at)| unsafe { text(*at, &format!("{name}[{k}]")) }).collect()
}

/// Points `at` to a list that a handle holds, and returns its length; 0 if one of the two is null.
///
/// # Safety
/// The contract of this module.
pub unsafe fn list<H, T>(handle: *const H, at: *mut *const T, of: impl FnOnce(&H) -> &[T]) -> usize {
    // SAFETY: the contract of this function.
    let (handle, at) = unsafe { (shared(handle, "handle"), place(at, "list")) };
    match (handle, at) {
        (Ok(handle), Ok(at)) => {
            let all = of(handle);
            at.put(all.as_ptr());
            all.len()
        }
        _ => 0,
    }
}

/// Takes a handle back and frees it; null is ignored.
///
/// # Safety
/// The handle came from [`OutValue::hand_over`], and is not used again.
pub unsafe fn take_back<T>(at: *mut T) {
    if !at.is_null() {
        // SAFETY: made by `Box::into_raw`, and given back once by the contract.
        drop(unsafe { Box::from_raw(at) });
    }
}

/// A function of the caller, with the data that it is called with.
#[derive(Clone, Copy)]
pub struct Callback {
    function: unsafe extern "C" fn(*mut c_void) -> bool,
    data: *mut c_void,
}

// SAFETY: the header says that the function is called on any thread, at the same time on several.
unsafe impl Send for Callback {}
// SAFETY: as above.
unsafe impl Sync for Callback {}

impl Callback {
    /// # Safety
    /// The function may be called with `data`, on any thread, for as long as this or a copy lives.
    pub unsafe fn new(function: unsafe extern "C" fn(*mut c_void) -> bool, data: *mut c_void) -> Self {
        Self { function, data }
    }

    pub fn ask(&self) -> bool {
        // SAFETY: by the contract of `new`.
        unsafe { (self.function)(self.data) }
    }
}

/// A function of the caller that hears of the progress of a run, with its data.
#[derive(Clone, Copy)]
pub struct Listener {
    function: unsafe extern "C" fn(*const ExtricateProgress, *mut c_void) -> bool,
    data: *mut c_void,
}

// SAFETY: the header says that the function is called on any thread.
unsafe impl Send for Listener {}
// SAFETY: `tell` is called by one thread at a time, that of the run.
unsafe impl Sync for Listener {}

impl Listener {
    /// # Safety
    /// The function may be called with `data`, on any thread, for as long as this or a copy lives.
    pub unsafe fn new(
        function: unsafe extern "C" fn(*const ExtricateProgress, *mut c_void) -> bool,
        data: *mut c_void,
    ) -> Self {
        Self { function, data }
    }

    /// Tells the state of the run; returns whether to go on.
    pub fn tell(&self, state: &ExtricateProgress) -> bool {
        // SAFETY: by the contract of `new`.
        unsafe { (self.function)(state, self.data) }
    }
}

fn check<T>(at: *const T, count: usize, name: &str) -> Result<()> {
    if at.is_null() {
        return Err(Fault::argument(format!("{name}: got a null pointer")));
    }
    if !at.is_aligned() {
        return Err(Fault::argument(format!("{name}: got a pointer that is not aligned")));
    }
    let bytes = count.checked_mul(size_of::<T>()).filter(|bytes| isize::try_from(*bytes).is_ok());
    bytes.map(drop).ok_or_else(|| Fault::argument(format!("{name}: got a count of {count}, more than memory has")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_seen_is_refused() {
        let numbers = [1.0, 2.0, 3.0];
        let at = numbers.as_ptr();
        // SAFETY: the array is live; pointers that are refused are not dereferenced.
        unsafe {
            assert_eq!(slice(at, 3, "q"), Ok(&numbers[..]));
            assert_eq!(slice::<f64>(std::ptr::null(), 0, "q"), Ok(&[][..]));
            let fault = |result: Result<&[f64]>| result.unwrap_err().message;
            assert_eq!(fault(slice(std::ptr::null(), 3, "q")), "q: got a null pointer");
            assert!(fault(slice(at.byte_add(1), 1, "q")).contains("not aligned"));
            assert!(fault(slice(at, usize::MAX, "q")).contains("more than memory has"));
            assert!(text(c"\xff".as_ptr(), "path").unwrap_err().message.contains("path: byte 0: got bytes"));
            assert_eq!(optional_text(std::ptr::null(), "folder"), Ok(None));
            let names = [c"a".as_ptr(), std::ptr::null()];
            assert_eq!(texts(names.as_ptr(), 2, "names").unwrap_err().message, "names[1]: got a null pointer");
        }
    }

    #[test]
    fn handles_are_given_and_taken_back() {
        let mut out = MaybeUninit::<*mut String>::uninit();
        // SAFETY: `out` is live; the handle is used as long as it is.
        unsafe {
            place(out.as_mut_ptr(), "out").unwrap().hand_over("a".to_string());
            let handle = out.assume_init();
            assert_eq!(shared(handle, "handle").unwrap(), "a");
            exclusive(handle, "handle").unwrap().push('b');
            assert_eq!(shared(handle, "handle").unwrap(), "ab");
            take_back(handle);
            take_back::<String>(std::ptr::null_mut());
            let mut row = [0.0; 4];
            places(row.as_mut_ptr(), 3, "row").unwrap().fill([1.0; 9]);
            assert_eq!(row, [1.0, 1.0, 1.0, 0.0]);
        }
    }
}
