//! The answer to a query.

use serde::{Deserialize, Serialize};

use super::keep::KeptError;
use super::options::Effort;
use crate::collision::Contact;
use crate::cspace::Config;
use crate::interface::words;
use crate::scene::PairId;

/// The nearest free configuration found, and what is known about it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Answer {
    /// Distance from the query to the witness, in the scene's metric; 0 if the query is free.
    pub depth: f64,
    /// Proved: no free configuration is nearer than this.
    pub lower_bound: f64,
    /// Share of the depth that is not proved, `1 - lower_bound / depth`: no free configuration is
    /// nearer by more than it. 0 if the query is free.
    pub gap: f64,
    /// Why nothing is proved; set if `lower_bound` is 0 and the query is not free.
    pub unproved: Option<Unproved>,
    /// A free configuration at distance `depth`.
    pub witness: Config,
    /// The effort that was requested.
    pub effort: Effort,
    /// Collision checks and distance evaluations spent.
    pub checks: usize,
    /// Largest displacement \[m\] of any point of the moving geometry between the query and the
    /// witness.
    pub max_displacement: f64,
    /// Pairs of the scene that collide at the query; only one of them with [`Effort::Nearest`],
    /// unless contacts were requested.
    pub colliding: Vec<PairId>,
    /// Coordinates of the query that lie beyond their limits. The query then is not free, whether
    /// or not anything collides. The witness is within all limits; `depth` is from the query as it
    /// is.
    pub outside: Vec<usize>,
    /// Kept links that are beyond their tolerances at the query, as indices into
    /// [`super::QueryOptions::keep`]. Pairs of [`super::QueryOptions::touch`] that do not touch
    /// follow these. The query then is not free, whether or not anything collides.
    pub off: Vec<usize>,
    /// How far each kept link is off at the witness; empty if the query is free. Pairs that have to
    /// touch follow: how far beyond the clearance they are, as a position.
    pub kept: Vec<KeptError>,
    /// Pairs of the scene that touch (within [`TOUCHING`] beyond the clearance) at the witness;
    /// none with [`Effort::Nearest`], unless contacts were requested.
    pub touching: Vec<PairId>,
    /// Estimated share in `[0, 1]` of starts that would lead to an exit which this query has not
    /// met. It is near 0 if one descent after another led to the same few ends, near 1 if each led
    /// to another. `None` if the query is free, or with [`Effort::Nearest`]. (Boender and Rinnooy
    /// Kan's estimate for multistart; starts are not uniform, so it is no probability of a miss.)
    pub unseen: Option<f64>,
    /// Depth of the nearest exit found, if the witness is the proxy of a continuous stream, which
    /// may be farther; 0 if the query is free.
    pub nearest: Option<f64>,
    /// Whether the witness is the proxy of a continuous stream that goes back to the nearest exit
    /// along a path that was proved free.
    pub detour: bool,
    /// Clearance \[m\] that the witness keeps, for pairs without one of their own: the clearance
    /// that the query aims at, or less, but at least the scene's
    /// ([`super::QueryOptions::clearance`]). Depth, bound and exits are those of a scene with this
    /// clearance. In a continuous stream, it is what the proxy keeps, at most what it aims at.
    pub clearance: f64,
    /// Whether the exact checker called the witness free during this query. Otherwise it did so
    /// when the model was learned.
    pub verified: bool,
    /// Points and normals at which the pairs of `touching` touch at the witness; meshes may have
    /// several for a pair.
    pub contacts: Vec<Contact>,
    /// How the distance to the witness changes with the query: a small tangent step `t` at the
    /// query (length `nv`) changes it by `gradient . t`. If the witness is the nearest exit, this
    /// is the gradient of the penetration depth, unless joints or links keep places that
    /// the query gives them. Zero if the query is free. For the largest
    /// displacement, which has kinks where several points move equally far, it is a mean over 1e-5
    /// to both sides.
    pub gradient: Vec<f64>,
    /// Whether no distinct exit (see [`SEPARATION`]) was met that is at most [`RIVAL`] times as
    /// far. Near a query with such an exit the nearest exit changes, and the gradient jumps. A set
    /// flag does not prove that there is none.
    pub unique: bool,
    /// Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    pub cut_short: bool,
    /// The nearest distinct exits by depth, the witness first, if more than one was requested. Each
    /// was verified and is the end of a descent, a local minimum of the distance to its accuracy;
    /// two of them are distinct by [`SEPARATION`]. There are fewer if fewer were found.
    pub exits: Vec<Exit>,
    /// Proved distance from the witness, in the scene's metric, within which no two bodies of a
    /// checked pair touch. Set if it was requested and the query is not free. Joint limits do not
    /// matter.
    pub free_radius: Option<f64>,
    /// The straight segment to the witness, if it was requested and the query is not free.
    pub segment: Option<StraightSegment>,
}

impl Answer {
    /// Returns whether a nearer exit may well have been missed: the search was cut short, and over
    /// half of the depth is not proved.
    pub fn is_doubtful(&self) -> bool {
        self.cut_short && self.gap > 0.5
    }

    /// Adds how far \[m\] beyond the clearance a pair is that has to touch.
    pub(crate) fn push_gap(&mut self, position: f64) {
        self.kept.push(KeptError { position, rotation: 0.0 });
    }

    /// Returns whether the query itself is free.
    pub fn is_free(&self) -> bool {
        self.colliding.is_empty() && self.outside.is_empty() && self.off.is_empty()
    }
}

/// Why no lower bound above 0 is proved for a query that is not free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Unproved {
    /// Only surfaces collide: they enclose nothing, and might pass through each other.
    Surfaces,
    /// The bodies overlap by less than the rounding, or by less than the convex sets inside them
    /// show.
    Shallow,
    /// Nothing collides: only a kept link is off, or a pair that has to touch is apart.
    Off,
}

words! { Unproved as "unproved" { Surfaces = "surfaces", Shallow = "shallow", Off = "off" } }

/// One of several exits.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Exit {
    /// Distance from the query, in the scene's metric.
    pub depth: f64,
    /// A verified free configuration at that distance.
    pub witness: Config,
    /// Pairs of the scene that touch there.
    pub touching: Vec<PairId>,
}

/// The geodesic from the query to the witness; fractions are those of
/// [`crate::ConfigSpace::interpolate`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StraightSegment {
    /// The last fraction at which a collision (or a pair that nearly collides) was found; before it
    /// the segment may be free in parts.
    pub colliding_until: f64,
    /// From this fraction on, every configuration is free: proved.
    pub free_from: f64,
}

/// A pair touches if it is nearer than the clearance plus this \[m\].
pub const TOUCHING: f64 = 1e-4;

/// Two exits are distinct if they are farther apart than this share of the smaller depth, in the
/// metric's tensor at the query.
pub const SEPARATION: f64 = 0.25;

/// The nearest exit is ambiguous if another one is at most this many times as far as the witness.
pub const RIVAL: f64 = 1.01;

/// Returns the answer to a free query, from which other answers start.
pub fn free_answer(q: &Config, nv: usize, effort: Effort, clearance: f64) -> Answer {
    Answer {
        depth: 0.0,
        lower_bound: 0.0,
        gap: 0.0,
        unproved: None,
        witness: q.clone(),
        effort,
        checks: 1,
        nearest: None,
        detour: false,
        max_displacement: 0.0,
        colliding: Vec::new(),
        outside: Vec::new(),
        off: Vec::new(),
        kept: Vec::new(),
        touching: Vec::new(),
        unseen: None,
        clearance,
        verified: true,
        contacts: Vec::new(),
        gradient: vec![0.0; nv],
        unique: true,
        cut_short: false,
        exits: Vec::new(),
        free_radius: None,
        segment: None,
    }
}
