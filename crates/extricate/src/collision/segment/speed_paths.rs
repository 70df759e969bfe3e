//! Indices of the bounds on the relative speeds of pairs of bodies in the list of all speed bounds.

use crate::scene::Scene;

/// Indices of speed bounds of checked pairs, each relative to the nearest common frame of its
/// bodies.
pub struct SpeedPaths {
    /// Two indices for each checked pair.
    pub pairs: Vec<[usize; 2]>,
}

impl SpeedPaths {
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
            let shared = shared_end(a, b);
            [bodies[pair.first] + a.len() - shared, bodies[pair.second] + b.len() - shared]
        };
        let pairs = scene.pairs.iter().map(place).collect();
        Self { pairs }
    }
}

/// Number of last frames that two paths to the world share, at least the world itself. Found by
/// bisection, because chains may have thousands of frames and scenes millions of pairs.
fn shared_end(a: &[usize], b: &[usize]) -> usize {
    let (mut shared, mut most) = (1, a.len().min(b.len()));
    while shared < most {
        let middle = (shared + most).div_ceil(2);
        if a[a.len() - middle] == b[b.len() - middle] {
            shared = middle;
        } else {
            most = middle - 1;
        }
    }
    shared
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_share_what_is_behind_the_frame_where_they_meet() {
        // A random tree: the parent of every frame comes earlier.
        let parents: Vec<usize> = (0..200).map(|frame: usize| frame.saturating_sub(1 + frame * frame % 7)).collect();
        let path = |frame: usize| {
            let mut path = vec![frame];
            while path[path.len() - 1] != 0 {
                path.push(parents[path[path.len() - 1]]);
            }
            path
        };
        for (first, second) in (0..200).flat_map(|a| (0..200).step_by(3).map(move |b| (a, b))) {
            let (a, b) = (path(first), path(second));
            let shared = a.iter().rev().zip(b.iter().rev()).take_while(|(x, y)| x == y).count();
            assert_eq!(shared_end(&a, &b), shared, "{first} {second}");
        }
    }
}
