//! Layouts of triangle trees as plain arrays, stored beside their meshes. No file format.

use super::bodies::PreparedPart;
use crate::collision::shapes::ShapeKind;
use crate::collision::shapes::bvh::TreeLayout;
use crate::collision::shapes::convex::ConvexCore;
use crate::math::LANES;

/// Tree layouts of the meshes of a scene.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TreeArrays {
    /// Number of tree elements of every mesh and convex hull, body after body; 0 for a convex one,
    /// which needs no tree.
    pub counts: Vec<u32>,
    /// Nodes and blocks of every tree, each node before its children. A block stores its number of
    /// triangles, a node 8 plus its number of children.
    pub elements: Vec<u8>,
    /// Triangles in the blocks of every tree, in order.
    pub order: Vec<u32>,
}

impl TreeArrays {
    /// Collects the layouts of the prepared shapes of a scene.
    pub fn of(parts: &[PreparedPart]) -> Self {
        let mut kept = Self::default();
        for part in parts {
            match &part.shape().kind {
                ShapeKind::Mesh(mesh) => {
                    let TreeLayout { elements, order } = &mesh.tree.layout;
                    kept.counts.push(elements.len() as u32);
                    kept.elements.extend(elements);
                    kept.order.extend(order);
                }
                ShapeKind::Convex(solid) if matches!(solid.shape.core, ConvexCore::Hull(_)) => kept.counts.push(0),
                ShapeKind::Convex(_) | ShapeKind::Scenery(_) => {}
            }
        }
        kept
    }

    /// Layout of every mesh and convex hull that has one; `None` if counts and arrays disagree. It
    /// is not yet checked whether the layouts fit the meshes.
    pub fn layouts(&self) -> Option<Vec<Option<TreeLayout>>> {
        let (mut elements, mut order) = (&self.elements[..], &self.order[..]);
        let mut layouts = Vec::with_capacity(self.counts.len());
        for count in &self.counts {
            let (own, others) = elements.split_at_checked(*count as usize)?;
            let triangles = own.iter().map(|element| usize::from(*element)).filter(|element| *element <= LANES);
            let (numbers, rest) = order.split_at_checked(triangles.sum())?;
            layouts.push((*count > 0).then(|| TreeLayout { elements: own.to_vec(), order: numbers.to_vec() }));
            (elements, order) = (others, rest);
        }
        (elements.is_empty() && order.is_empty()).then_some(layouts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Checker;
    use crate::collision::shapes::test_mesh::{cuboid, joined};
    use crate::math::Vec3;
    use crate::robot::Geometry;
    use crate::scene::{Scene, builtin};
    use std::sync::Arc;

    /// A built-in scene with two brackets of `plates` plates and one convex mesh.
    fn scene(plates: usize) -> Arc<Scene> {
        let mut scene = builtin::scene("planar-arm").unwrap();
        let plate = |k: usize| cuboid(Vec3::new(0.03 * k as f64, 0.0, 0.0), Vec3::new(0.01, 0.1, 0.1));
        let bracket = || joined(&(0..plates).map(plate).collect::<Vec<_>>());
        for (body, mesh) in scene.bodies.iter_mut().zip([bracket(), plate(0), bracket()]) {
            body.parts[0].geometry = Geometry::Mesh(Arc::new(mesh));
        }
        Arc::new(scene)
    }

    #[test]
    fn trees_are_the_same_once_more() {
        let made = Checker::new(scene(9));
        let kept = made.kept_trees();
        assert_eq!(kept.counts.len(), 3);
        assert!(kept.counts[0] > 9 && kept.counts[1] == 0, "{:?}", kept.counts);
        assert_eq!(kept.order.len(), 2 * 9 * 12);
        assert_eq!(Checker::with_trees(scene(9), &kept).unwrap().kept_trees(), kept);
    }

    #[test]
    fn trees_of_other_meshes_are_refused() {
        let kept = Checker::new(scene(9)).kept_trees();
        for plates in [8, 10] {
            assert!(Checker::with_trees(scene(plates), &kept).is_none(), "{plates} plates");
        }
        let refused = |spoil: fn(&mut TreeArrays)| {
            let mut spoiled = kept.clone();
            spoil(&mut spoiled);
            Checker::with_trees(scene(9), &spoiled).is_none()
        };
        assert!(!refused(|_| ()));
        assert!(refused(|kept| kept.counts.truncate(2)));
        assert!(refused(|kept| kept.counts.push(0)));
        assert!(refused(|kept| kept.counts.swap(0, 1)));
        assert!(refused(|kept| kept.counts[2] += 1));
        assert!(refused(|kept| kept.counts[0] = u32::MAX));
        assert!(refused(|kept| kept.elements[3] = 0));
        assert!(refused(|kept| kept.elements.push(1)));
        assert!(refused(|kept| kept.order[5] = u32::MAX));
        assert!(refused(|kept| kept.order.push(0)));
        assert!(refused(|kept| kept.order.truncate(100)));
    }
}
