//! Reads the options of a query from the structure that C callers fill in.

#![allow(unsafe_code)]

use std::ffi::c_void;

use extricate::{Error, PairId, QueryOptions, Scene, Solver, Stop, Termination, Toward};

use crate::abi::handles::ExtricateSolver;
use crate::abi::types::{EXTRICATE_REFINED, ExtricateOptions, ExtricateWeight};
use crate::enum_constants::{EFFORTS, choice};
use crate::motion_options::kept_links;
use crate::raw::{self, Callback};
use crate::status::{Fault, Result};

/// Efforts as messages list them. A test checks that the header lists the same.
const EFFORTS_EXPECTED: &str = "EXTRICATE_NEAREST, _QUICK, _REFINED, _EXHAUSTIVE or _PROVED";

/// Options that were read from C.
#[derive(Debug, Default)]
pub struct Wanted {
    /// The options, not yet checked.
    pub options: QueryOptions,
    /// Whether configurations beyond the limits are refused.
    pub refuse_outside: bool,
    /// Weights in place of those of the scene.
    pub weights: Weights,
}

/// Weights of joints, for translations and for the rotation, in place of those of a scene.
#[derive(Debug, Clone, Default)]
pub struct Weights(Vec<(String, [f64; 2])>);

impl Weights {
    /// Returns `solver` with these weights.
    ///
    /// # Errors
    /// If a joint is unknown, or a weight makes no sense.
    pub fn solver(&self, solver: &Solver) -> Result<Solver> {
        match self.0.is_empty() {
            true => Ok(solver.clone()),
            false => Ok(solver.weighted(self.0.iter().map(|(name, both)| (name.as_str(), *both)))?),
        }
    }
}

/// Returns what `extricate_options_init()` writes.
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
        free: std::ptr::null(),
        free_count: 0,
        keep: std::ptr::null(),
        touch: std::ptr::null(),
        touch_count: 0,
        weights: std::ptr::null(),
        weight_count: 0,
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
    /// The contract of [`crate::raw`].
    ///
    /// # Errors
    /// If a member is not an effort, a text, the name of a joint, or a configuration of `scene`.
    pub unsafe fn read(at: *const ExtricateOptions, scene: &Scene) -> Result<Self> {
        if at.is_null() {
            return Ok(Self::default());
        }
        // SAFETY: the contract of this function.
        let given = unsafe { raw::shared(at, "options") }?;
        // SAFETY: the same.
        let locked = unsafe { raw::texts(given.locked, given.locked_count, "options.locked") }?;
        // SAFETY: the same.
        let free = unsafe { raw::texts(given.free, given.free_count, "options.free") }?;
        // SAFETY: the same.
        let keep = unsafe { kept_links(given.keep, scene) }?;
        // SAFETY: the same.
        let touch = unsafe { raw::texts(given.touch, given.touch_count, "options.touch") }?;
        // SAFETY: the same.
        let weights = unsafe { raw::slice(given.weights, given.weight_count, "options.weights") }?;
        let weight = |(at, weight): (usize, &ExtricateWeight)| {
            // SAFETY: the same.
            let joint = unsafe { raw::text(weight.joint, &format!("options.weights[{at}].joint")) }?;
            Ok((joint.to_string(), [weight.translation, weight.rotation]))
        };
        let weights = Weights(weights.iter().enumerate().map(weight).collect::<Result<_>>()?);
        // SAFETY: the same.
        let goal = unsafe { raw::slice(given.toward, given.toward_count, "options.toward") }?;
        let limits = Limits { max_checks: given.max_checks, max_seconds: given.max_seconds };
        // SAFETY: the header states the contract for `stop`.
        let termination = unsafe { limits.termination(given.stop, given.stop_data) }?;
        let Some(effort) = choice(EFFORTS, given.effort) else {
            return Err(fault("effort", given.effort, EFFORTS_EXPECTED));
        };
        let mut options = QueryOptions::default()
            .effort(effort)
            .exits(given.exits)
            .locked(held_joints(scene, locked, free)?)
            .keep(keep)
            .touch(touching_pairs(scene, &touch)?)
            .free_radius(given.free_radius != 0)
            .segment(given.segment != 0)
            .contacts(given.contacts != 0)
            .termination(termination);
        options.starts = (given.starts > 0).then_some(given.starts);
        options.gap = (!given.gap.is_nan()).then_some(given.gap);
        options.clearance = (!given.clearance.is_nan()).then_some(given.clearance);
        if !goal.is_empty() {
            options.toward = Some(Toward::new(scene.config(goal)?, given.toward_share));
        }
        Ok(Self { options, refuse_outside: given.refuse_outside != 0, weights })
    }

    /// Makes a solver with these options, which shares all else with `solver`.
    ///
    /// # Errors
    /// If an option makes no sense. The message names the member, its value and what was expected.
    pub fn of(self, solver: &Solver) -> Result<ExtricateSolver> {
        let own = self.weights.solver(solver)?.options(self.options).map_err(of_call)?;
        let (base, weights) = (solver.clone(), self.weights);
        Ok(ExtricateSolver { base, solver: own, refuse_outside: self.refuse_outside, weights })
    }
}

/// Returns the pairs of bodies with these names.
fn touching_pairs(scene: &Scene, names: &[&str]) -> Result<Vec<PairId>> {
    if !names.len().is_multiple_of(2) {
        return Err(Fault::argument(format!("options.touch_count: got {}, expected an even number", names.len())));
    }
    Ok(names
        .chunks_exact(2)
        .map(|two| scene.pair_named("touch", [two[0], two[1]]))
        .collect::<extricate::Result<_>>()?)
}

/// Returns the joints that a query holds: the locked ones, or all but the free ones.
fn held_joints(scene: &Scene, locked: Vec<&str>, free: Vec<&str>) -> Result<Vec<usize>> {
    if free.is_empty() {
        return Ok(scene.joints_named("locked", locked)?);
    }
    if !locked.is_empty() {
        return Err(Fault::argument("options.locked, options.free: got both, expected one of them"));
    }
    let free = scene.joints_named("free", free)?;
    Ok((0..scene.joints().len()).filter(|joint| !free.contains(joint)).collect())
}

/// The limits of a call, as its options have them.
pub struct Limits {
    /// Most checks; `usize::MAX` stands for no limit.
    pub max_checks: usize,
    /// Most seconds; infinity stands for no limit.
    pub max_seconds: f64,
}

impl Limits {
    pub fn of(termination: &Termination) -> Self {
        Self {
            max_checks: termination.max_checks.unwrap_or(usize::MAX),
            max_seconds: termination.max_seconds.unwrap_or(f64::INFINITY),
        }
    }

    /// Returns the limits together with the function that ends the call.
    ///
    /// # Safety
    /// The contract of [`Callback::new`].
    ///
    /// # Errors
    /// If a limit makes no sense.
    pub unsafe fn termination(
        self,
        stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
        data: *mut c_void,
    ) -> Result<Termination> {
        // SAFETY: the contract of this function.
        let callback = stop.map(|stop| unsafe { Callback::new(stop, data) });
        let mut termination = Termination::default();
        termination.max_checks = (self.max_checks != usize::MAX).then_some(self.max_checks);
        termination.max_seconds = (self.max_seconds != f64::INFINITY).then_some(self.max_seconds);
        termination.stop = callback.map(|callback| Stop::when(move || callback.ask()));
        QueryOptions::default().termination(termination.clone()).check().map_err(of_call)?;
        Ok(termination)
    }
}

/// Converts the error of a call: an option is a member of its structure.
pub fn of_call(error: Error) -> Fault {
    match error {
        Error::Option { name, value, expected } => fault(name, value, &expected),
        other => other.into(),
    }
}

/// Makes the fault of a member of the options that makes no sense.
pub fn fault(member: &str, value: impl std::fmt::Display, expected: &str) -> Fault {
    Fault::argument(format!("options.{member}: got {value}, expected {expected}"))
}

/// Most threads of a call: starting more takes longer than they could save on any machine.
const MAX_THREADS: usize = 1024;

/// Reads a number of threads; 0 stands for one per core.
pub fn threads(count: usize) -> Result<usize> {
    match count <= MAX_THREADS {
        true => Ok(count),
        false => Err(Fault::argument(format!("threads: got {count}, expected 0 (one a core) to {MAX_THREADS}"))),
    }
}

#[cfg(test)]
mod tests {
    use extricate::{QUERY_OPTIONS, builtin};

    use super::*;
    use crate::abi::types::{EXTRICATE_NEAREST, EXTRICATE_PROVED};

    /// Members that are no query options of the library: lengths of lists, the stop function, the
    /// weights of the scene, the inverse of `locked`, and whether configurations are refused.
    const OF_C_ALONE: &[&str] = &[
        "refuse_outside",
        "locked_count",
        "free",
        "free_count",
        "touch_count",
        "weights",
        "weight_count",
        "toward_count",
        "stop",
        "stop_data",
    ];
    /// Defaults that C spells differently from Python.
    const DEFAULTS_IN_C: &[(&str, &str)] = &[
        ("effort", "EXTRICATE_REFINED"),
        ("starts", "0"),
        ("gap", "nan"),
        ("clearance", "nan"),
        ("locked", "null"),
        ("keep", "null"),
        ("touch", "null"),
        ("toward", "null"),
        ("max_checks", "SIZE_MAX"),
        ("max_seconds", "infinity"),
        ("free_radius", "0"),
        ("segment", "0"),
        ("contacts", "0"),
    ];
    /// Values that C spells differently from Python.
    const VALUES_IN_C: &[(&str, &str)] =
        &[("effort", EFFORTS_EXPECTED), ("free_radius", "0 or 1"), ("segment", "0 or 1"), ("contacts", "0 or 1")];

    fn solver() -> Solver {
        Solver::new(builtin::scene("planar-arm").unwrap())
    }

    fn read(change: impl FnOnce(&mut ExtricateOptions)) -> Result<Wanted> {
        let mut given = defaults();
        change(&mut given);
        // SAFETY: what the tests point to lives until they end.
        unsafe { Wanted::read(&given, solver().scene()) }
    }

    #[test]
    fn defaults_are_those_of_the_library() {
        // SAFETY: null may be read.
        let of_null = unsafe { Wanted::read(std::ptr::null(), solver().scene()) }.unwrap();
        assert_eq!(read(|_| {}).unwrap().options, QueryOptions::default());
        assert_eq!(of_null.options, QueryOptions::default());
    }

    /// Reads the names of the members of `ExtricateOptions` in the header, and their comments.
    fn members() -> Vec<(String, String)> {
        let header = include_str!("../include/extricate.h");
        let (_, inside) = header.split_once("typedef struct ExtricateOptions {").unwrap();
        let (inside, _) = inside.split_once("} ExtricateOptions;").unwrap();
        let (mut members, mut comment) = (Vec::new(), String::new());
        for line in inside.lines().map(str::trim).filter(|line| !line.is_empty()) {
            if let Some(text) = line.strip_prefix("//") {
                comment += text;
                continue;
            }
            // A member is `type name;`, or `type (*name)(..);` if it is a function.
            let declared = line.split_once("(*").map_or(line, |(_, after)| after);
            let declared = declared.split([')', ';']).next().unwrap();
            let name = declared.rsplit([' ', '*']).next().unwrap();
            members.push((name.to_string(), std::mem::take(&mut comment)));
        }
        members
    }

    /// Spells a default as the header does.
    fn default_of(member: &str) -> String {
        let given = defaults();
        let count = |count: usize| if count == usize::MAX { "SIZE_MAX".into() } else { count.to_string() };
        let number = |number: f64| match number {
            f64::INFINITY => "infinity".into(),
            number if number.is_nan() => "nan".into(),
            number => number.to_string(),
        };
        let pointer = |is_null: bool| if is_null { "null".into() } else { "a pointer".into() };
        match member {
            "effort" if given.effort == EXTRICATE_REFINED => "EXTRICATE_REFINED".into(),
            "exits" => count(given.exits),
            "starts" => count(given.starts),
            "gap" => number(given.gap),
            "clearance" => number(given.clearance),
            "locked" => pointer(given.locked.is_null()),
            "keep" => pointer(given.keep.is_null()),
            "touch" => pointer(given.touch.is_null()),
            "toward" => pointer(given.toward.is_null()),
            "toward_share" => number(given.toward_share),
            "max_checks" => count(given.max_checks),
            "max_seconds" => number(given.max_seconds),
            "free_radius" => given.free_radius.to_string(),
            "segment" => given.segment.to_string(),
            "contacts" => given.contacts.to_string(),
            other => panic!("{other}: no such member, expected one for every option of the library"),
        }
    }

    #[test]
    fn the_header_has_every_option_of_the_library() {
        let members = members();
        let in_c = |table: &[(&str, &'static str)], name: &str, usual: &'static str| {
            table.iter().find(|(own, _)| *own == name).map_or(usual, |(_, text)| text)
        };
        for option in QUERY_OPTIONS {
            let (default, values) =
                (in_c(DEFAULTS_IN_C, option.name, option.default), in_c(VALUES_IN_C, option.name, option.expected));
            let comment = &members.iter().find(|(name, _)| name == option.name).expect(option.name).1;
            assert_eq!(default_of(option.name), default, "{}", option.name);
            assert!(comment.contains(values), "{}: `{comment}` does not say `{values}`", option.name);
            let default = format!("{default} by default");
            assert!(comment.contains(&default), "{}: `{comment}` does not say `{default}`", option.name);
        }
        let cpp = include_str!("../include/extricate.hpp");
        let passed = |name: &str| cpp.contains(&format!("raw_.{name} = "));
        assert!(QUERY_OPTIONS.iter().all(|option| passed(option.name)), "C++ does not pass every option on");
        let is_option = |name: &str| QUERY_OPTIONS.iter().any(|option| option.name == name);
        let others: Vec<&str> = members.iter().map(|(name, _)| name.as_str()).filter(|name| !is_option(name)).collect();
        assert_eq!(others, OF_C_ALONE);
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        let name = [c"elbow".as_ptr()];
        let goal = [0.0; 3];
        let refused = |change: &dyn Fn(&mut ExtricateOptions), said: &str| {
            let message = read(change).and_then(|wanted| wanted.of(&solver())).map(drop).unwrap_err().message;
            assert!(message.contains(said), "{message}");
        };
        refused(&|o| o.effort = 9, "options.effort: got 9, expected EXTRICATE_NEAREST");
        refused(&|o| o.starts = 1_000_000_000_000, "options.starts: got 1000000000000, expected 1 to");
        refused(&|o| o.exits = 0, "options.exits: got 0, expected 1 to");
        refused(&|o| (o.exits, o.effort) = (2, EXTRICATE_PROVED), "options.exits: got 2, expected 1 with a gap");
        refused(&|o| (o.gap, o.effort) = (0.1, EXTRICATE_NEAREST), "options.gap: got 0.1, expected none");
        refused(&|o| o.gap = 1.0, "options.gap: got 1");
        refused(&|o| o.clearance = -1.0, "options.clearance: got -1");
        for (seconds, said) in [(0.0, "0"), (f64::NAN, "NaN"), (f64::NEG_INFINITY, "-inf")] {
            refused(&|o| o.max_seconds = seconds, &format!("options.max_seconds: got {said}, expected more than 0"));
        }
        refused(&|o| (o.locked, o.locked_count) = (name.as_ptr(), 1), "elbow");
        refused(&|o| o.keep = name[0], "keep: got `elbow`");
        refused(&|o| o.keep = c"{\"link\": 1}".as_ptr(), "options.keep: got {\"link\": 1}");
        refused(&|o| (o.toward, o.toward_count, o.gap) = (goal.as_ptr(), 3, 0.1), "options.toward: got a goal");
        refused(&|o| (o.toward, o.toward_count) = (goal.as_ptr(), 2), "expected 3 coordinates");
        let share = |o: &mut ExtricateOptions| (o.toward, o.toward_count, o.toward_share) = (goal.as_ptr(), 3, -1.0);
        refused(&share, "options.toward_share: got -1, expected 0 to");
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
