//! Limbs that collide independently.

use std::path::Path;

use super::*;
use crate::learning::LearnOptions;
use crate::model::Model;
use crate::query::plan::Plan;
use crate::query::search::termination::Deadline;
use crate::query::{Effort, QueryOptions, QueryScratch, World};
use crate::scene::assemble::assemble;
use crate::scene::{MetricKind, builtin};

/// Carts on rails of their own, each before a wall: of `n` that collide, one is free where it
/// is 0.6 and the clearance from its wall's middle.
fn carts(n: usize, metric: MetricKind) -> Model {
    let (mut urdf, mut toml) = (String::from("<robot name='carts'><link name='base'/>"), String::new());
    for k in 0..n {
        urdf += &format!(
            "<link name='c{k}'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>\
             <joint name='j{k}' type='prismatic'><parent link='base'/><child link='c{k}'/><origin xyz='0 {k} 0'/>\
             <axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        );
        toml += &format!(
            "[[obstacle]]\nname = 'w{k}'\nshape = {{ box = [1, 0.2, 0.2] }}\npose = {{ xyz = [0, {k}, 0] }}\n"
        );
    }
    urdf += "</robot>";
    let toml = format!("[[robot]]\nurdf = 'carts.urdf'\n{toml}");
    let mut scene = assemble(Path::new("scene.toml"), &toml, &mut |_: &Path| Ok(urdf.clone().into_bytes())).unwrap();
    scene.metric = metric;
    let options = LearnOptions { labels: 30_000, seconds: None, ..LearnOptions::default() };
    Model::learn(scene, &options).unwrap()
}

#[test]
fn the_nearest_exit_of_many_limbs_combines_those_of_each() {
    for (n, metric) in
        [(4, MetricKind::Joint), (8, MetricKind::Joint), (16, MetricKind::Joint), (6, MetricKind::ObjectNorm)]
    {
        let model = carts(n, metric);
        let (mut scratch, clear) = (QueryScratch::default(), 0.6 + model.scene().clearance);
        let (mut found, mut checks, all) = (0, 0, 60);
        for at in 0..all {
            let x = |k: usize| 2.0 * (0.618_034 * (at * n + k + 1) as f64).fract() - 1.0;
            let q = model.scene().space.config(&(0..n).map(x).collect::<Vec<_>>()).unwrap();
            let mut to = q.to_vec();
            to.iter_mut().filter(|x| x.abs() < clear).for_each(|x| *x = clear.copysign(*x));
            let exact = model.metric().distance(&q, &to);
            let answer = model.view().query_with(&q, &QueryOptions::default(), &mut scratch).unwrap();
            let unlearned = model.world().view().query_with(&q, &QueryOptions::default(), &mut scratch).unwrap();
            assert!(unlearned.verified && unlearned.depth > exact - 1e-6 && unlearned.depth <= 1.05 * exact + 1e-6);
            assert!(answer.verified && answer.depth > exact - 1e-6 && answer.lower_bound <= answer.depth);
            found += usize::from(answer.depth <= 1.05 * exact + 1e-6);
            checks += answer.checks;
            let exhaustive = QueryOptions { effort: Effort::Exhaustive, ..QueryOptions::default() };
            assert!(at > 3 || model.view().query_with(&q, &exhaustive, &mut scratch).unwrap().depth <= answer.depth);
        }
        println!("{n} carts, {metric:?}: {found} of {all}, {checks} checks");
        assert!(found * 100 >= 95 * all, "{n} {metric:?}: {found} of {all}");
        assert!(checks <= 8 * n * all, "{n} {metric:?}: {checks}");
    }
}

#[test]
fn pairs_that_share_a_joint_are_of_one_part() {
    let scene = builtin::scene("dual-arm").unwrap();
    let joints = |pair: PairId| {
        let mut found = Vec::new();
        coordinates(&scene, pair, &mut |v| found.push(v));
        found
    };
    let of_arm = |arm: usize| {
        let is_of_arm = |pair: &PairId| {
            let joints = joints(*pair);
            !joints.is_empty() && joints.iter().all(|v| v / 7 == arm)
        };
        (0..scene.pairs.len()).map(PairId::new).filter(is_of_arm).collect::<Vec<_>>()
    };
    let (left, right) = (of_arm(0), of_arm(1));
    let both = (0..scene.pairs.len())
        .map(PairId::new)
        .find(|pair| joints(*pair).iter().any(|v| *v < 7) && joints(*pair).iter().any(|v| *v > 6));
    let mut parts = IndependentParts::default();
    parts.split(&scene, &[left[0], right[0]]);
    assert_eq!(parts.count(), 2);
    parts.split(&scene, &[left[0], right[0], both.unwrap()]);
    assert_eq!(parts.count(), 1);
    parts.split(&scene, &[]);
    assert_eq!(parts.count(), 0);
}

/// A cart in a wall, and one at whose place the nearest known exit has the first: that one stands
/// behind a post, so that it cannot slide away, and the other behind one of its own. Once the first
/// is out on this side of its post, the other goes back to where it was.
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
