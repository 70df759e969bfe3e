//! Where the bounds on the speeds of two bodies stand among those of all.

use crate::scene::Scene;

/// Where the bounds on the speeds of two bodies stand, seen from their nearest common frame.
pub struct SpeedPaths {
    /// Of each checked pair.
    pub pairs: Vec<[usize; 2]>,
}

impl SpeedPaths {
    /// For all bodies and checked pairs.
    pub fn new(scene: &Scene) -> Self {
        let path = |body: usize| {
            let mut frames = vec![scene.bodies[body].frame];
            while frames[frames.len() - 1] != 0 {
                frames.push(scene.frames[frames[frames.len() - 1]].parent);
            }
            frames
        };
        let paths: Vec<Vec<usize>> = (0..scene.bodies.len()).map(path).collect();
        let mut total = 0;
        let mut bodies = Vec::new();
        for path in &paths {
            bodies.push(total);
            total += path.len();
        }
        let place = |pair: &crate::scene::BodyPair| {
            let (a, b) = (&paths[pair.first], &paths[pair.second]);
            let (i, j) = (0..a.len())
                .find_map(|i| b.iter().position(|frame| *frame == a[i]).map(|j| (i, j)))
                .expect("all frames are in the world");
            [bodies[pair.first] + i, bodies[pair.second] + j]
        };
        let pairs = scene.pairs.iter().map(place).collect();
        Self { pairs }
    }
}
