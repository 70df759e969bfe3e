//! The pairs that collided last, which checks try first.

/// The times at which pairs collided, which order checks. No answer depends on them.
#[derive(Debug, Default)]
pub struct RecentPairs {
    /// Pairs that collided last, latest first; labels try them before the broad phase.
    pub recent: [u32; RECENT_COUNT],
    /// Time of the last collision of each pair, 0 for never.
    pub collided: Vec<u64>,
    now: u64,
}

/// Pairs that are tried before the broad phase.
const RECENT_COUNT: usize = 4;
/// Fills `recent` before as many pairs have collided.
pub const NO_PAIR: u32 = u32::MAX;

impl RecentPairs {
    pub fn new(pairs: usize) -> Self {
        Self { recent: [NO_PAIR; RECENT_COUNT], collided: vec![0; pairs], now: 0 }
    }

    pub fn note(&mut self, pair: u32) {
        self.now += 1;
        self.collided[pair as usize] = self.now;
        let last = self.recent.iter().position(|other| *other == pair).unwrap_or(RECENT_COUNT - 1);
        self.recent[last] = pair;
        self.recent[..=last].rotate_right(1);
    }
}
