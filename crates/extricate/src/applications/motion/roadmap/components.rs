//! Connected components of nodes, by union-find.

/// Disjoint sets of nodes, numbered from 0.
#[derive(Debug, Clone, Default)]
pub struct Components {
    parents: Vec<u32>,
}

impl Components {
    /// Makes the sets of nodes joined by edges.
    pub fn new(nodes: usize, edges: &[[u32; 2]]) -> Self {
        let mut components = Self::default();
        (0..nodes).for_each(|_| components.push());
        edges.iter().for_each(|[a, b]| {
            components.join(*a as usize, *b as usize);
        });
        components
    }

    /// Adds one node, in a set of its own.
    pub fn push(&mut self) {
        self.parents.push(self.parents.len() as u32);
    }

    /// Returns the node that represents the set of a node.
    pub fn root(&self, mut node: usize) -> usize {
        while self.parents[node] as usize != node {
            node = self.parents[node] as usize;
        }
        node
    }

    /// Joins the sets of two nodes; returns whether they were apart.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.halved(a), self.halved(b));
        // The older root represents both, whatever the order.
        let (low, high) = (a.min(b), a.max(b));
        self.parents[high] = low as u32;
        low != high
    }

    /// Returns the root, and halves the path to it.
    fn halved(&mut self, mut node: usize) -> usize {
        while self.parents[node] as usize != node {
            self.parents[node] = self.parents[self.parents[node] as usize];
            node = self.parents[node] as usize;
        }
        node
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_has_one_root() {
        let mut components = Components::new(6, &[[0, 1], [2, 3], [3, 4]]);
        assert!(components.root(1) == components.root(0) && components.root(4) == components.root(2));
        assert_ne!(components.root(0), components.root(2));
        assert!(components.join(1, 4) && !components.join(0, 3));
        assert_eq!((components.root(4), components.root(5)), (0, 5));
    }
}
