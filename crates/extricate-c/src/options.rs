//! Options of a query, as C fills them in, checked.

#![allow(unsafe_code)]

use extricate::internals::query::options::{MAX_EXITS, MAX_STARTS};
use extricate::{Effort, QueryOptions, Scene, Stop, Termination, Toward};

use crate::abi::types::{
    EXTRICATE_EXHAUSTIVE, EXTRICATE_NEAREST, EXTRICATE_PROVED, EXTRICATE_QUICK, EXTRICATE_REFINED, ExtricateOptions,
};
use crate::raw::{self, Callback};
use crate::status::{Fault, Result};

/// Options, and what becomes of configurations beyond the limits.
#[derive(Clone, Default)]
pub struct Wanted {
    /// Of every query.
    pub options: QueryOptions,
    /// Whether configurations beyond the limits are refused.
    pub refuse_outside: bool,
}

/// What a program begins with.
pub fn defaults() -> ExtricateOptions {
    ExtricateOptions {
        effort: EXTRICATE_REFINED,
        refuse_outside: 0,
        free_radius: 0,
        segment: 0,
        contacts: 0,
        exits: 1,
        starts: 0,
        gap: f64::NAN,
        clearance: f64::NAN,
        max_checks: usize::MAX,
        max_seconds: f64::INFINITY,
        locked: std::ptr::null(),
        locked_count: 0,
        toward: std::ptr::null(),
        toward_count: 0,
        toward_share: 0.25,
        stop: None,
        stop_data: std::ptr::null_mut(),
    }
}

impl Wanted {
    /// Reads options for queries of `scene`; null stands for the defaults.
    ///
    /// # Safety
    /// That of [`crate::raw`].
    ///
    /// # Errors
    /// Names the member, its value and what was expected.
    pub unsafe fn read(at: *const ExtricateOptions, scene: &Scene) -> Result<Self> {
        if at.is_null() {
            return Ok(Self::default());
        }
        // SAFETY: the contract of this function.
        let given = unsafe { raw::shared(at, "options") }?;
        // SAFETY: the same.
        let locked = unsafe { raw::texts(given.locked, given.locked_count, "options.locked") }?;
        let locked = scene.joints_named("locked", locked)?;
        // SAFETY: the same.
        let goal = unsafe { raw::slice(given.toward, given.toward_count, "options.toward") }?;
        let toward = match goal {
            [] => None,
            goal => Some(Toward { goal: scene.config(goal)?.to_vec(), share: given.toward_share }),
        };
        // SAFETY: the header says so of `stop`.
        let callback = given.stop.map(|stop| unsafe { Callback::new(stop, given.stop_data) });
        let stop = callback.map(|callback| Stop::when(move || callback.ask()));
        Self::checked(given, locked, toward, stop)
    }

    fn checked(
        given: &ExtricateOptions,
        locked: Vec<usize>,
        toward: Option<Toward>,
        stop: Option<Stop>,
    ) -> Result<Self> {
        let fault = |member: &str, value: &dyn ToString, expected: &str| {
            Err(Fault::argument(format!("options.{member}: got {}, expected {expected}", value.to_string())))
        };
        let effort = match given.effort {
            EXTRICATE_NEAREST => Effort::Nearest,
            EXTRICATE_QUICK => Effort::Quick,
            EXTRICATE_REFINED => Effort::Refined,
            EXTRICATE_EXHAUSTIVE => Effort::Exhaustive,
            EXTRICATE_PROVED => Effort::Proved,
            other => return fault("effort", &other, "EXTRICATE_NEAREST, _QUICK, _REFINED, _EXHAUSTIVE or _PROVED"),
        };
        let gap = (!given.gap.is_nan()).then_some(given.gap);
        let proves = gap.is_some() || effort == Effort::Proved;
        let is_nearest = effort == Effort::Nearest;
        if !(1..=MAX_EXITS).contains(&given.exits) {
            return fault("exits", &given.exits, &format!("1 to {MAX_EXITS}"));
        }
        if given.exits > 1 && (is_nearest || proves) {
            return fault("exits", &given.exits, "1 with EXTRICATE_NEAREST or a gap to prove");
        }
        if given.starts > MAX_STARTS {
            return fault("starts", &given.starts, &format!("0 to {MAX_STARTS}"));
        }
        if given.starts > 0 && is_nearest {
            return fault("starts", &given.starts, "0 with EXTRICATE_NEAREST, which refines nothing");
        }
        if let Some(bad) = gap.filter(|gap| !(0.0..1.0).contains(gap) || is_nearest) {
            return fault("gap", &bad, "0 or more and less than 1, or nan; nan with EXTRICATE_NEAREST");
        }
        let clearance = (!given.clearance.is_nan()).then_some(given.clearance);
        if let Some(bad) = clearance.filter(|length| !(0.0..=1e9).contains(length)) {
            return fault("clearance", &bad, "0 to 1e9 [m], or nan");
        }
        if given.max_seconds.is_nan() || given.max_seconds <= 0.0 {
            return fault("max_seconds", &given.max_seconds, "more than 0");
        }
        if toward.is_some() && proves {
            return fault("toward", &"a goal with a gap to prove", "null: the search stops at the nearest");
        }
        if toward.is_some() && !(0.0..=1e9).contains(&given.toward_share) {
            return fault("toward_share", &given.toward_share, "0 or more");
        }
        let termination = Termination {
            max_checks: (given.max_checks != usize::MAX).then_some(given.max_checks),
            max_seconds: given.max_seconds.is_finite().then_some(given.max_seconds),
            stop,
        };
        let options = QueryOptions {
            effort,
            exits: given.exits,
            starts: (given.starts > 0).then_some(given.starts),
            gap,
            clearance,
            locked,
            toward,
            termination,
            free_radius: given.free_radius != 0,
            segment: given.segment != 0,
            contacts: given.contacts != 0,
        };
        Ok(Self { options, refuse_outside: given.refuse_outside != 0 })
    }
}

/// Most threads that may be asked for: starting more takes longer than they could save anywhere.
const MOST_THREADS: usize = 1024;

/// A number of threads, 0 for one a core.
pub fn threads(count: usize) -> Result<usize> {
    match count <= MOST_THREADS {
        true => Ok(count),
        false => Err(Fault::argument(format!("threads: got {count}, expected 0 (one a core) to {MOST_THREADS}"))),
    }
}

#[cfg(test)]
mod tests {
    use extricate::builtin;

    use super::*;

    fn read(change: impl FnOnce(&mut ExtricateOptions)) -> Result<Wanted> {
        let scene = builtin::scene("planar-arm").unwrap();
        let mut given = defaults();
        change(&mut given);
        // SAFETY: what the tests point to lives until they end.
        unsafe { Wanted::read(&given, &scene) }
    }

    #[test]
    fn defaults_are_those_of_the_library() {
        let of_null = unsafe { Wanted::read(std::ptr::null(), &builtin::scene("planar-arm").unwrap()) }.unwrap();
        let expected = QueryOptions { exits: 1, ..QueryOptions::default() };
        assert_eq!(read(|_| {}).unwrap().options, expected);
        assert_eq!(of_null.options, QueryOptions::default());
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        let name = [c"elbow".as_ptr()];
        let goal = [0.0; 3];
        let refused = |change: &dyn Fn(&mut ExtricateOptions)| read(change).map(drop).unwrap_err().message;
        assert!(refused(&|o| o.effort = 9).contains("options.effort: got 9, expected EXTRICATE_NEAREST"));
        assert!(
            refused(&|o| o.starts = 1_000_000_000_000).contains("options.starts: got 1000000000000, expected 0 to")
        );
        assert!(refused(&|o| o.exits = 0).contains("options.exits: got 0, expected 1 to"));
        assert!(refused(&|o| (o.exits, o.effort) = (2, EXTRICATE_PROVED)).contains("a gap to prove"));
        assert!(refused(&|o| o.gap = 1.0).contains("options.gap: got 1"));
        assert!(refused(&|o| o.clearance = -1.0).contains("options.clearance: got -1"));
        assert!(refused(&|o| o.max_seconds = 0.0).contains("options.max_seconds: got 0"));
        assert!(refused(&|o| (o.locked, o.locked_count) = (name.as_ptr(), 1)).contains("elbow"));
        assert!(refused(&|o| (o.toward, o.toward_count, o.gap) = (goal.as_ptr(), 3, 0.1)).contains("options.toward"));
        assert!(refused(&|o| (o.toward, o.toward_count) = (goal.as_ptr(), 2)).contains("expected 3 coordinates"));
        let goal = read(|o| (o.toward, o.toward_count) = (goal.as_ptr(), 3)).unwrap().options.toward;
        assert!(goal.is_some());
        assert!(threads(2000).unwrap_err().message.contains("got 2000"));
    }

    #[test]
    fn the_stop_of_c_is_asked() {
        unsafe extern "C" fn says(data: *mut std::ffi::c_void) -> bool {
            // SAFETY: the test passes a bool that lives.
            unsafe { *data.cast::<bool>() }
        }
        let mut answer = true;
        let data = (&raw mut answer).cast();
        let wanted = read(|o| {
            o.stop = Some(says);
            o.stop_data = data;
        });
        let wanted = wanted.unwrap();
        assert!(wanted.options.termination.stop.unwrap().is_asked());
    }
}
