//! Reads how files are loaded from the structure that C callers fill in.

#![allow(unsafe_code)]

use extricate::{LoadLimit, LoadLimits, LoadOptions};

use crate::abi::types::ExtricateLoadOptions;
use crate::raw;
use crate::status::{Fault, Result};

/// Reads how files are loaded; null stands for the defaults.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// If a name is not that of a limit.
pub unsafe fn read(at: *const ExtricateLoadOptions) -> Result<LoadOptions> {
    if at.is_null() {
        return Ok(LoadOptions::default());
    }
    // SAFETY: the contract of this function.
    let given = unsafe { raw::shared(at, "options") }?;
    // SAFETY: the same.
    let packages = unsafe { raw::texts(given.packages, given.package_count, "options.packages") }?;
    // SAFETY: the same.
    let limits = unsafe { raw::slice(given.limits, given.limit_count, "options.limits") }?;
    let mut own = LoadLimits::default();
    for (at, limit) in limits.iter().enumerate() {
        // SAFETY: the same.
        let name = unsafe { raw::text(limit.name, &format!("options.limits[{at}].name")) }?;
        let Some(known) = LoadLimit::ALL.into_iter().find(|known| known.name() == name) else {
            let names: Vec<&str> = LoadLimit::ALL.into_iter().map(LoadLimit::name).collect();
            let expected = format!("expected one of {}", names.join(", "));
            return Err(Fault::argument(format!("options.limits[{at}].name: got \"{name}\", {expected}")));
        };
        own = own.with(known, limit.most);
    }
    Ok(LoadOptions::default().limits(own).packages(packages.iter().map(Into::into).collect()))
}
