//! Which pairs collided last.

/// When pairs collided, to try first those that did last. No answer depends on it.
#[derive(Debug, Default)]
pub struct RecentPairs {
    /// Those that did last, latest first: tried before the broad phase.
    pub recent: [u32; RECENT],
    /// The time of each, 0 for never.
    pub collided: Vec<u64>,
    now: u64,
}

/// How many pairs are tried before the broad phase.
const RECENT: usize = 4;
/// No pair.
pub const NO_PAIR: u32 = u32::MAX;

impl RecentPairs {
    /// Of pairs that never collided.
    pub fn new(pairs: usize) -> Self {
        Self { recent: [NO_PAIR; RECENT], collided: vec![0; pairs], now: 0 }
    }

    /// Notes that a pair collides now.
    pub fn note(&mut self, pair: u32) {
        self.now += 1;
        self.collided[pair as usize] = self.now;
        let last = self.recent.iter().position(|other| *other == pair).unwrap_or(RECENT - 1);
        self.recent[last] = pair;
        self.recent[..=last].rotate_right(1);
    }
}
