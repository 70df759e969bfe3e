//! Groups of joints that colliding pairs connect. The search finds an exit of each group alone and
//! combines the nearest ones.

use std::ops::Range;

use crate::query::context::Context;
use crate::scene::{Motion, PairId, Scene};

/// A union-find forest of tangent coordinates. Coordinates in no group are *idle*.
#[derive(Debug, Default)]
pub struct Groups {
    parent: Vec<usize>,
    is_idle: Vec<bool>,
    /// Whether the group of each root was searched since it last changed.
    is_searched: Vec<bool>,
    /// Memory for [`Groups::are_one`]: whether a coordinate is on the chain of a group.
    is_on_chain: Vec<bool>,
}

impl Groups {
    /// Groups the coordinates that may move by the pairs that have to part.
    pub fn split(&mut self, context: &Context, pairs: impl IntoIterator<Item = PairId>) {
        let nv = context.checker.scene().space.nv();
        self.parent.clear();
        self.parent.extend(0..nv);
        for (list, value) in [(&mut self.is_idle, true), (&mut self.is_searched, false)] {
            list.clear();
            list.resize(nv, value);
        }
        for pair in pairs {
            self.join(context, pair);
        }
    }

    /// Adds to each group the joints that it carries, since they move with it in any case.
    pub fn join_carried(&mut self, context: &Context) {
        let scene = context.checker.scene();
        let is_world = |frame: usize| matches!(scene.frames[frame].motion, Motion::World);
        for frame in 0..scene.frames.len() {
            let mut above = scene.frames[frame].parent;
            while !is_world(above) && own(scene, above).all(|v| self.is_idle[v]) {
                above = scene.frames[above].parent;
            }
            let root = own(scene, above).find(|v| !self.is_idle[*v]);
            if let Some(root) = root {
                own(scene, frame).filter(|v| !context.is_locked(*v)).for_each(|v| {
                    self.unite(root, v);
                });
            }
        }
    }

    /// Unites the coordinates that move a pair; returns whether that changed any group.
    pub fn join(&mut self, context: &Context, pair: PairId) -> bool {
        let (mut first, mut is_new) = (None, false);
        coordinates(context.checker.scene(), pair, &mut |v| {
            if !context.is_locked(v) {
                is_new |= self.unite(*first.get_or_insert(v), v);
            }
        });
        is_new
    }

    /// Unites all coordinates that may move; returns whether that changed any group.
    pub fn join_all(&mut self, context: &Context) -> bool {
        let free = (0..self.parent.len()).filter(|v| !context.is_locked(*v));
        let Some(first) = free.clone().next() else { return false };
        free.fold(false, |is_new, v| self.unite(first, v) | is_new)
    }

    /// Unites two coordinates; returns whether that changed any group.
    fn unite(&mut self, a: usize, b: usize) -> bool {
        let was_idle = [a, b].map(|v| std::mem::replace(&mut self.is_idle[v], false)).contains(&true);
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
        if a != b || was_idle {
            self.is_searched[a.min(b)] = false;
        }
        a != b || was_idle
    }

    /// Returns the least coordinate of the group of `v`.
    pub fn root(&self, mut v: usize) -> usize {
        while self.parent[v] != v {
            v = self.parent[v];
        }
        v
    }

    pub fn roots(&self) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.parent.len()).filter(|v| self.parent[*v] == *v && !self.is_idle[*v])
    }

    /// Whether the group of `root` contains coordinate `v`.
    pub fn holds(&self, root: usize, v: usize) -> bool {
        !self.is_idle[v] && self.root(v) == root
    }

    /// Returns the root of the group that moves a pair, if one does.
    pub fn root_of(&self, scene: &Scene, pair: PairId) -> Option<usize> {
        let mut root = None;
        coordinates(scene, pair, &mut |v| {
            if !self.is_idle[v] {
                root = Some(self.root(v));
            }
        });
        root
    }

    /// Returns the next group that was not searched since it last changed, and marks it as
    /// searched.
    pub fn next_unsearched(&mut self) -> Option<usize> {
        let next = self.roots().find(|root| !self.is_searched[*root])?;
        self.is_searched[next] = true;
        Some(next)
    }

    /// Whether there is at most one group, and all idle joints that may move carry it. No joint
    /// then has to be held still.
    pub fn are_one(&mut self, context: &Context) -> bool {
        let (scene, mut is_on_chain) = (context.checker.scene(), std::mem::take(&mut self.is_on_chain));
        is_on_chain.clear();
        is_on_chain.extend((0..self.parent.len()).map(|v| context.is_locked(v)));
        for frame in (0..scene.frames.len()).filter(|frame| own(scene, *frame).any(|v| !self.is_idle[v])) {
            let mut below = frame;
            while !matches!(scene.frames[below].motion, Motion::World) {
                own(scene, below).for_each(|v| is_on_chain[v] = true);
                below = scene.frames[below].parent;
            }
        }
        self.is_on_chain = is_on_chain;
        self.roots().count() <= 1 && self.is_on_chain.iter().all(|is_on_chain| *is_on_chain)
    }
}

/// Returns the tangent coordinates of a frame's own joint.
pub fn own(scene: &Scene, frame: usize) -> Range<usize> {
    match &scene.frames[frame].motion {
        Motion::World => 0..0,
        Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } => coordinate.v..coordinate.v + 1,
        Motion::Ball { v, .. } => *v..v + 3,
    }
}

/// Calls `each` with the tangent coordinates that move the bodies of a pair relative to each other.
pub fn coordinates(scene: &Scene, pair: PairId, each: &mut dyn FnMut(usize)) {
    let pair = &scene.pairs[pair.index()];
    let (mut first, mut second) = (scene.bodies[pair.first].frame, scene.bodies[pair.second].frame);
    // Joints that carry both bodies do not part them. Frames come after those that carry them.
    while first != second {
        let frame = if first > second { &mut first } else { &mut second };
        own(scene, *frame).for_each(&mut *each);
        *frame = scene.frames[*frame].parent;
    }
}

/// Whether all coordinates that could part a pair are locked.
pub fn is_held(context: &Context, pair: PairId) -> bool {
    let mut all = true;
    coordinates(context.checker.scene(), pair, &mut |v| all &= context.is_locked(v));
    all
}
