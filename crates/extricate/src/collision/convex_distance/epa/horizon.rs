//! The border of the patch of triangles that is seen from a new point: the directed edges around
//! it.

/// A point that sees a patch with a longer border is refused; borders of 4 to 10 edges are usual.
const MAX_EDGES: usize = 96;

/// Edges `[from, to]` of the patch's triangles that no other triangle of the patch has reversed.
pub(crate) struct Horizon {
    edges: [[u8; 2]; MAX_EDGES],
    count: usize,
}

impl Horizon {
    pub fn empty() -> Self {
        Self { edges: [[0; 2]; MAX_EDGES], count: 0 }
    }

    pub fn edges(&self) -> &[[u8; 2]] {
        &self.edges[..self.count]
    }

    /// Adds a triangle to the patch; returns `false` if its border would be longer than
    /// [`MAX_EDGES`].
    #[inline(always)]
    pub fn add(&mut self, [a, b, c]: [u8; 3]) -> bool {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if let Some(inner) = self.position([to, from]) {
                self.count -= 1;
                self.edges[inner] = self.edges[self.count];
            } else if self.count == MAX_EDGES {
                return false;
            } else {
                self.edges[self.count] = [from, to];
                self.count += 1;
            }
        }
        true
    }

    /// Returns whether the edges form one loop that meets no vertex twice, as around a patch of a
    /// convex surface.
    pub fn is_one_loop(&self) -> bool {
        let Some([start, mut at]) = self.edges().first().copied() else { return false };
        let mut met = 1_u128 << start;
        for _ in 1..self.count {
            if met >> at & 1 == 1 {
                return false;
            }
            met |= 1 << at;
            let Some(edge) = self.edges().iter().find(|edge| edge[0] == at) else { return false };
            at = edge[1];
        }
        at == start
    }

    /// Returns whether the border stays one loop with this triangle: it shares an edge, and its
    /// other corner is new or is closed in.
    pub fn can_grow(&self, [a, b, c]: [u8; 3]) -> bool {
        let shared = [[b, a], [c, b], [a, c]].map(|edge| self.position(edge).is_some());
        let is_on_loop = |corner: u8| self.edges().iter().any(|edge| edge[0] == corner);
        match shared {
            [true, false, false] => !is_on_loop(c),
            [false, true, false] => !is_on_loop(a),
            [false, false, true] => !is_on_loop(b),
            [false, false, false] | [true, true, true] => false,
            _ => true,
        }
    }

    fn position(&self, edge: [u8; 2]) -> Option<usize> {
        self.edges().iter().position(|other| *other == edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn horizon_of(triangles: &[[u8; 3]]) -> Horizon {
        let mut horizon = Horizon::empty();
        triangles.iter().for_each(|triangle| assert!(horizon.add(*triangle)));
        horizon
    }

    #[test]
    fn patches_of_one_piece_have_one_loop() {
        assert!(horizon_of(&[[0, 1, 2]]).is_one_loop());
        assert!(horizon_of(&[[0, 1, 2], [1, 0, 3], [2, 1, 4]]).is_one_loop());
        // Two pieces, two that share a vertex, a ring, the whole surface, nothing.
        assert!(!horizon_of(&[[0, 1, 2], [3, 4, 5]]).is_one_loop());
        assert!(!horizon_of(&[[0, 1, 2], [0, 4, 5]]).is_one_loop());
        assert!(!horizon_of(&[[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]]).is_one_loop());
        assert!(!Horizon::empty().is_one_loop());
    }

    #[test]
    fn growth_keeps_one_loop() {
        let horizon = horizon_of(&[[0, 1, 2], [1, 0, 3]]);
        assert!(horizon.can_grow([2, 1, 4]));
        assert!(!horizon.can_grow([4, 5, 6]));
        // Closes vertex 1 in, or pinches the loop at vertex 3.
        assert!(horizon.can_grow([2, 1, 3]));
        assert!(!horizon_of(&[[0, 1, 2], [1, 0, 3], [3, 0, 4]]).can_grow([2, 1, 4]));
    }
}
