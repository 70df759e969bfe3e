//! Limbs that no part has to do with: back to where the query has them.

use crate::cspace::Label;
use crate::query::search::Search;

/// Brings the joints that no part moves back to where the query has them, if that is free; `base`
/// is memory.
pub fn return_idle(whole: &mut Search, is_moved: &[bool], base: &mut Vec<f64>) {
    let context = whole.context;
    base.clone_from(&whole.known.incumbent.config);
    for factor in context.checker.scene().space.factors().iter().filter(|factor| !is_moved[factor.v]) {
        let coordinates = factor.coordinates();
        base[coordinates.clone()].copy_from_slice(&whole.known.anchor.q[coordinates]);
    }
    context.checker.scene().space.clamp(base);
    if *base != whole.known.incumbent.config
        && !whole.evaluator.is_spent()
        && whole.evaluator.label(context, base) == Label::Free
    {
        let depth = whole.evaluator.distance(context, &whole.known.anchor, base);
        whole.known.take(depth, base, true);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::query::plan::Plan;
    use crate::query::search::Incumbent;
    use crate::query::search::parts::search_parts;
    use crate::query::search::termination::Deadline;
    use crate::query::{Effort, QueryOptions, QueryScratch, World};
    use crate::scene::assemble::assemble;

    /// A cart in a wall, and one at whose place the nearest known exit has the first: that one
    /// stands behind a post, so that it cannot slide away, and the other behind one of its own.
    /// Once the first is out on this side of its post, the other goes back to where it was.
    #[test]
    fn an_idle_limb_returns_once_its_place_is_free() {
        let cart = |name: &str, axis: &str| {
            format!(
                "<link name='{name}'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>\
                 <joint name='of_{name}' type='prismatic'><parent link='base'/><child link='{name}'/>\
                 <axis xyz='{axis}'/><limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
            )
        };
        let urdf = format!("<robot name='r'><link name='base'/>{}{}</robot>", cart("a", "1 0 0"), cart("b", "0 1 0"))
            .replace("<child link='b'/>", "<child link='b'/><origin xyz='1 0 0'/>");
        let walls =
            [("wall", [0.4, 0.1], [0.0, 0.0]), ("post", [0.05, 0.1], [0.7, 0.0]), ("other", [0.1, 0.05], [1.0, 0.4])];
        let mut toml = String::from("[[robot]]\nurdf = 'r.urdf'\n");
        for (name, [wide, deep], [x, y]) in walls {
            toml += &format!(
                "[[obstacle]]\nname = '{name}'\nshape = {{ box = [{wide}, {deep}, 0.2] }}\npose = {{ xyz = [{x}, {y}, 0] }}\n"
            );
        }
        let scene = assemble(Path::new("scene.toml"), &toml, &mut |_: &Path| Ok(urdf.clone().into_bytes())).unwrap();
        let world = World::new(scene);
        let (context, options, q) = (world.context(), QueryOptions::default(), [0.05, 0.0]);
        let QueryScratch { evaluator, descent, boundary, known, parts, .. } = &mut QueryScratch::default();
        evaluator.begin(Deadline::default());
        let mut colliding = Vec::new();
        context.checker.colliding_pairs(&q, &mut evaluator.check, &mut colliding);
        context.metric.anchor(&q, &mut known.anchor);
        known.begin(&context, 1);
        known.proof.begin(Effort::Refined, &colliding, None);
        let behind = [1.0, 0.8];
        assert_eq!(evaluator.label(&context, &behind), Label::Free);
        known.take(context.metric.distance(&q, &behind), &behind, true);
        parts.split(context.checker.scene(), &colliding);
        let plan = Plan::of(&options, &context);
        let context = &context;
        let mut search =
            Search { context, plan, known, evaluator, descent, boundary, believes: false, turn: None, part: None };
        search_parts(&mut search, parts);
        let Incumbent { depth, config, .. } = &search.known.incumbent;
        assert!(config[1] == 0.0 && (depth - 0.25).abs() < 1e-3, "{config:?} {depth}");
    }
}
