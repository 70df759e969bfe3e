//! The inner loops of sequential minimal optimisation: they choose two coefficients, move them, and
//! find points that may rest for a while. They see kernel rows, not points.

use super::kernel::{LANES, vectorized};

/// Least curvature `K_ii + K_jj - 2 K_ij` that `f32` rows resolve; nearer points get this one.
const LEAST_CURVATURE: f32 = 1e-6;

/// Signed coefficients `beta` and errors `y - K beta` of the points that take part, padded to whole
/// blocks.
pub struct ActiveSet {
    /// Index in the whole set of the point at each position.
    pub points: Vec<u32>,
    beta: Vec<[f64; LANES]>,
    errors: Vec<[f64; LANES]>,
    /// Lower and upper bounds of `beta`.
    least: Vec<[f64; LANES]>,
    greatest: Vec<[f64; LANES]>,
    /// 0 if `beta` may grow, else minus infinity: adding it masks a point without a branch.
    growable: Vec<[f32; LANES]>,
    /// 0 if `beta` may shrink, else minus infinity.
    shrinkable: Vec<[f32; LANES]>,
}

/// Coefficient of one point, with its error and bounds.
#[derive(Clone, Copy)]
pub struct Coefficient {
    /// Signed coefficient of the point.
    pub beta: f64,
    /// Error `y - (K beta)` of the point.
    pub error: f64,
    /// Lower bound of `beta`.
    pub least: f64,
    /// Upper bound of `beta`.
    pub greatest: f64,
}

impl Coefficient {
    /// Whether `beta` may grow.
    pub fn grows(&self) -> bool {
        self.beta < self.greatest
    }

    /// Whether `beta` may shrink.
    pub fn shrinks(&self) -> bool {
        self.beta > self.least
    }
}

/// Returns the largest error of a coefficient that may grow, and the least error of one that may
/// shrink. The coefficients are optimal if the first is not above the second.
pub fn error_range(coefficients: impl Iterator<Item = Coefficient>) -> (f64, f64) {
    coefficients.fold((f64::NEG_INFINITY, f64::INFINITY), |(largest, least), c| {
        let largest = if c.grows() { f64::max(largest, c.error) } else { largest };
        (largest, if c.shrinks() { f64::min(least, c.error) } else { least })
    })
}

/// Whether a point may rest: its coefficient is at a bound and pushed against it harder than any
/// pair that breaks the optimality conditions could undo (T. Joachims, "Making large-scale SVM
/// learning practical", 1998).
pub fn may_rest(c: &Coefficient, (largest, least): (f64, f64)) -> bool {
    (!c.shrinks() && c.error < least) || (!c.grows() && c.error > largest)
}

/// A point chosen for the next step.
pub struct ChosenPoint {
    /// Position among the active points.
    pub position: usize,
    /// Largest error (first choice) or largest `error_i - error_j` (second choice) seen.
    pub value: f64,
}

/// Blocks searched for their maximum before it is compared with the best so far: a plain maximum is
/// one instruction a register, one with its position is not.
const BLOCKS_PER_CHUNK: usize = 16;

#[inline(always)]
fn keep_larger<T: Copy + PartialOrd>(largest: &mut [T; LANES], values: [T; LANES]) {
    for lane in 0..LANES {
        largest[lane] = if values[lane] > largest[lane] { values[lane] } else { largest[lane] };
    }
}

#[inline(always)]
fn largest_lane<T: Copy + PartialOrd>(values: [T; LANES]) -> T {
    let mut largest = values[0];
    for value in values {
        largest = if value > largest { value } else { largest };
    }
    largest
}

/// Errors of a block; minus infinity where `mask` removes them.
#[inline(always)]
fn masked(errors: &[f64; LANES], mask: &[f32; LANES]) -> [f64; LANES] {
    let mut values = *errors;
    for lane in 0..LANES {
        values[lane] += f64::from(mask[lane]);
    }
    values
}

/// Returns, for each point of a block, the gain `(error_i - error_j)^2 / (K_ii + K_jj - 2 K_ij)` of
/// a step with the first choice, whose error is `error`. Also returns `error_i - error_j`, minus
/// infinity where masked.
///
/// The gain only ranks, so `f32` suffices; the gap decides when to stop and is `f64`.
#[inline(always)]
fn gains(
    error: f64,
    errors: &[f64; LANES],
    mask: &[f32; LANES],
    kernel: &[f32; LANES],
) -> ([f32; LANES], [f64; LANES]) {
    let (mut gains, mut gaps) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        gaps[lane] = error - errors[lane] + f64::from(mask[lane]);
        let (slope, curvature) = (gaps[lane] as f32, 2.0 - 2.0 * kernel[lane]);
        let curvature = if curvature > LEAST_CURVATURE { curvature } else { LEAST_CURVATURE };
        gains[lane] = if slope > 0.0 { slope * slope / curvature } else { f32::NEG_INFINITY };
    }
    (gains, gaps)
}

impl ActiveSet {
    /// Copies the given points from the whole set `all`.
    pub fn gather(all: &[Coefficient], points: Vec<u32>) -> Self {
        let blocks = points.len().div_ceil(LANES);
        let zeros = vec![[0.0; LANES]; blocks];
        let mut set = Self {
            beta: zeros.clone(),
            errors: zeros.clone(),
            least: zeros.clone(),
            greatest: zeros,
            growable: vec![[f32::NEG_INFINITY; LANES]; blocks],
            shrinkable: vec![[f32::NEG_INFINITY; LANES]; blocks],
            points,
        };
        for position in 0..set.points.len() {
            let (b, l) = (position / LANES, position % LANES);
            let c = all[set.points[position] as usize];
            (set.beta[b][l], set.errors[b][l]) = (c.beta, c.error);
            (set.least[b][l], set.greatest[b][l]) = (c.least, c.greatest);
            set.mark(position);
        }
        set
    }

    /// Writes coefficients and errors back to the whole set.
    pub fn scatter(&self, all: &mut [Coefficient]) {
        for (position, point) in self.points.iter().enumerate() {
            all[*point as usize] = self.coefficient(position);
        }
    }

    /// Positions of the points that must not rest.
    pub fn restless(&self) -> Vec<u32> {
        let range = error_range((0..self.points.len()).map(|p| self.coefficient(p)));
        (0..self.points.len() as u32).filter(|p| !may_rest(&self.coefficient(*p as usize), range)).collect()
    }

    fn coefficient(&self, position: usize) -> Coefficient {
        let (b, l) = (position / LANES, position % LANES);
        Coefficient {
            beta: self.beta[b][l],
            error: self.errors[b][l],
            least: self.least[b][l],
            greatest: self.greatest[b][l],
        }
    }

    /// Updates the masks at `position`.
    fn mark(&mut self, position: usize) {
        let (b, l, c) = (position / LANES, position % LANES, self.coefficient(position));
        let mask = |open: bool| if open { 0.0 } else { f32::NEG_INFINITY };
        self.growable[b][l] = mask(c.grows());
        self.shrinkable[b][l] = mask(c.shrinks());
    }

    /// Chooses the first of the pair: the point of largest error whose coefficient may grow, if
    /// any.
    pub fn first(&self) -> Option<ChosenPoint> {
        let (errors, growable) = (&self.errors[..], &self.growable[..]);
        let best = vectorized(
            #[inline(always)]
            move || {
                let mut best = (f64::NEG_INFINITY, 0);
                let chunks = errors.chunks(BLOCKS_PER_CHUNK).zip(growable.chunks(BLOCKS_PER_CHUNK));
                for (chunk, (errors, mask)) in chunks.enumerate() {
                    let mut largest = [f64::NEG_INFINITY; LANES];
                    for (errors, mask) in errors.iter().zip(mask) {
                        keep_larger(&mut largest, masked(errors, mask));
                    }
                    let value = largest_lane(largest);
                    best = if value > best.0 { (value, chunk) } else { best };
                }
                best
            },
        );
        self.locate_first(best)
    }

    /// Finds the position of the largest error, which is `best.0` and lies in chunk `best.1`.
    fn locate_first(&self, best: (f64, usize)) -> Option<ChosenPoint> {
        let blocks = best.1 * BLOCKS_PER_CHUNK..((best.1 + 1) * BLOCKS_PER_CHUNK).min(self.errors.len());
        let mut values = blocks.flat_map(|b| masked(&self.errors[b], &self.growable[b]));
        let offset = values.position(|value| value == best.0 && value > f64::NEG_INFINITY)?;
        Some(ChosenPoint { position: best.1 * BLOCKS_PER_CHUNK * LANES + offset, value: best.0 })
    }

    /// Chooses the partner of largest gain among points of less error whose coefficient may shrink.
    pub fn second(&self, error: f64, row: &[[f32; LANES]]) -> Option<ChosenPoint> {
        let (errors, shrinkable) = (&self.errors[..], &self.shrinkable[..]);
        let (best, gap) = vectorized(
            #[inline(always)]
            move || {
                let (mut best, mut widest) = ((f32::NEG_INFINITY, 0), [f64::NEG_INFINITY; LANES]);
                let chunks = errors
                    .chunks(BLOCKS_PER_CHUNK)
                    .zip(shrinkable.chunks(BLOCKS_PER_CHUNK))
                    .zip(row.chunks(BLOCKS_PER_CHUNK));
                for (chunk, ((errors, mask), kernel)) in chunks.enumerate() {
                    let mut largest = [f32::NEG_INFINITY; LANES];
                    for ((errors, mask), kernel) in errors.iter().zip(mask).zip(kernel) {
                        let (gains, gaps) = gains(error, errors, mask, kernel);
                        keep_larger(&mut largest, gains);
                        keep_larger(&mut widest, gaps);
                    }
                    let value = largest_lane(largest);
                    best = if value > best.0 { (value, chunk) } else { best };
                }
                (best, largest_lane(widest))
            },
        );
        let blocks = best.1 * BLOCKS_PER_CHUNK..((best.1 + 1) * BLOCKS_PER_CHUNK).min(self.errors.len());
        let mut values = blocks.flat_map(|b| gains(error, &self.errors[b], &self.shrinkable[b], &row[b]).0);
        let offset = values.position(|value| value == best.0 && value > f32::NEG_INFINITY)?;
        Some(ChosenPoint { position: best.1 * BLOCKS_PER_CHUNK * LANES + offset, value: gap })
    }

    /// Moves the coefficient of `i` up and that of `j` down by the best common step, and updates
    /// the errors. The same pass makes the next first choice.
    pub fn step(&mut self, i: usize, j: usize, row_i: &[[f32; LANES]], row_j: &[[f32; LANES]]) -> Option<ChosenPoint> {
        let ((bi, li), (bj, lj)) = ((i / LANES, i % LANES), (j / LANES, j % LANES));
        let curvature = f64::from((2.0 - 2.0 * row_i[bj][lj]).max(LEAST_CURVATURE));
        let (room_i, room_j) = (self.greatest[bi][li] - self.beta[bi][li], self.beta[bj][lj] - self.least[bj][lj]);
        let step = ((self.errors[bi][li] - self.errors[bj][lj]) / curvature).min(room_i).min(room_j);
        // Coefficients that reach a bound are set to it exactly, whatever the rounding.
        self.beta[bi][li] = if step == room_i { self.greatest[bi][li] } else { self.beta[bi][li] + step };
        self.beta[bj][lj] = if step == room_j { self.least[bj][lj] } else { self.beta[bj][lj] - step };
        self.mark(i);
        self.mark(j);
        let (errors, growable) = (&mut self.errors[..], &self.growable[..]);
        // Moved, since the compiler cannot prove that a borrowed `step` stays the same as errors
        // change.
        let best = vectorized(
            #[inline(always)]
            move || {
                let mut best = (f64::NEG_INFINITY, 0);
                let rows = row_i.chunks(BLOCKS_PER_CHUNK).zip(row_j.chunks(BLOCKS_PER_CHUNK));
                let chunks = errors.chunks_mut(BLOCKS_PER_CHUNK).zip(growable.chunks(BLOCKS_PER_CHUNK)).zip(rows);
                for (chunk, ((errors, mask), (row_i, row_j))) in chunks.enumerate() {
                    let mut largest = [f64::NEG_INFINITY; LANES];
                    for ((errors, mask), (row_i, row_j)) in errors.iter_mut().zip(mask).zip(row_i.iter().zip(row_j)) {
                        let mut renewed = *errors;
                        for lane in 0..LANES {
                            renewed[lane] -= step * f64::from(row_i[lane] - row_j[lane]);
                        }
                        *errors = renewed;
                        keep_larger(&mut largest, masked(errors, mask));
                    }
                    let value = largest_lane(largest);
                    best = if value > best.0 { (value, chunk) } else { best };
                }
                best
            },
        );
        self.locate_first(best)
    }
}
