//! Promises of effort `proved`: depths in closed form, bounds that no other search is below, gaps
//! that close, and answers that only get nearer.

use extricate::internals::cspace::sampling::Halton;
use extricate::{Config, Effort, MetricKind, QueryOptions, Scene, Solver, Termination, Unproved, builtin};

use crate::analytic::CLEARANCE;
use crate::baselines::{PROVED_BOUND_KEPT_SHARE, PROVED_GAPS_CLOSED_SHARE};
use crate::memory::{chain, collision, scene};
use crate::query::ask;

fn proved(gap: f64, checks: usize) -> QueryOptions {
    let termination = Termination::after_checks(checks);
    QueryOptions::default().effort(Effort::Proved).gap(gap).termination(termination)
}

fn colliding(world: &Solver, count: usize) -> Vec<Config> {
    let space = world.scene().space();
    let halton = Halton::new(space.nv(), 5);
    let mut q = vec![0.0; space.nq()];
    let mut all = (0..).map(|k| {
        halton.config(space, k, &mut q);
        space.config(&q).unwrap()
    });
    let asked = world.clone().options(QueryOptions::default().termination(Termination::after_checks(1))).unwrap();
    let collides = |q: &Config| asked.query(q).is_some_and(|answer| !answer.is_free());
    all.by_ref().take(20_000).filter(|q| collides(q)).take(count).collect()
}

/// Queries a scene of known depth with a gap of 1e-3.
fn closes(scene: Scene, count: usize, exact: impl Fn(&[f64]) -> f64) {
    let world = Solver::new(scene);
    for q in colliding(&world, count) {
        let answer = ask(&world, &q, &proved(1e-3, 20_000));
        let depth = exact(&q);
        assert!((answer.depth - depth).abs() < 1.1e-3 * depth, "{q:?}: {} {depth}", answer.depth);
        assert!(answer.lower_bound <= depth * (1.0 + 1e-9) && answer.gap <= 1.1e-3, "{q:?}: {answer:?} {depth}");
    }
}

#[test]
fn box_in_a_box() {
    let shape = collision([0.0; 3], [0.0; 3], "<box size=\"0.2 0.3 0.4\"/>");
    let slide = |axis, shape| ("prismatic", [0.0; 3], axis, -1.0, 1.0, shape);
    let urdf = chain(&[slide([1.0, 0.0, 0.0], ""), slide([0.0, 1.0, 0.0], ""), slide([0.0, 0.0, 1.0], &shape)]);
    let toml = "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"block\"\nshape = { box = [0.6, 0.5, 0.4] }\n";
    let reach = [0.4, 0.4, 0.4];
    closes(scene(toml, &[("r.urdf", urdf)]), 60, |q| {
        (0..3).map(|k| reach[k] + CLEARANCE - q[k].abs()).fold(f64::INFINITY, f64::min)
    });
}

/// A disc overlaps another disc, so that the depth is radial.
#[test]
fn disc_among_discs() {
    let disc = collision([0.0; 3], [0.0; 3], "<cylinder radius=\"0.1\" length=\"0.2\"/>");
    let slide = |axis, shape| ("prismatic", [0.0; 3], axis, -2.0, 2.0, shape);
    let urdf = chain(&[slide([1.0, 0.0, 0.0], ""), slide([0.0, 1.0, 0.0], &disc)]);
    let toml = "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"core\"\nshape = { cylinder = [0.3, 0.4] }\n";
    closes(scene(toml, &[("r.urdf", urdf)]), 60, |q| 0.4 + CLEARANCE - q[0].hypot(q[1]));
}

/// Each cart is on a rail of its own, in its own wall, so that the squared depths add.
#[test]
fn carts_part_by_themselves() {
    let cart = collision([0.0; 3], [0.0; 3], "<box size=\"0.2 0.2 0.2\"/>");
    let links: String = (0..4).map(|k| format!("<link name=\"cart{k}\">{cart}</link>")).collect();
    let joint = |k: usize| {
        format!(
            "<joint name=\"j{k}\" type=\"prismatic\"><parent link=\"base\"/><child link=\"cart{k}\"/>\
             <origin xyz=\"0 {k} 0\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
        )
    };
    let urdf =
        format!("<robot name=\"r\"><link name=\"base\"/>{links}{}</robot>", (0..4).map(joint).collect::<String>());
    let wall = |k: usize| {
        format!(
            "[[obstacle]]\nname = \"wall{k}\"\nshape = {{ box = [0.4, 0.4, 0.4] }}\npose = {{ xyz = [0.1, {k}, 0] }}\n"
        )
    };
    let toml = format!("[[robot]]\nurdf = \"r.urdf\"\n{}", (0..4).map(wall).collect::<String>());
    closes(scene(&toml, &[("r.urdf", urdf)]), 60, |q| {
        let depth = |x: f64| (0.3 + CLEARANCE - (x - 0.1).abs()).max(0.0);
        q.iter().map(|x| depth(*x).powi(2)).sum::<f64>().sqrt()
    });
}

/// For convex rigid bodies under the largest displacement, the depth is that of translations
/// (Zhang, Kim, Varadhan and Manocha, "Generalized penetration depth computation", Computer-Aided
/// Design 39, 2007).
#[test]
fn rigid_bodies_under_the_largest_displacement() {
    let block = collision([0.0; 3], [0.0; 3], "<box size=\"0.2 0.3 0.4\"/>");
    let urdf = format!("<robot name=\"block\"><link name=\"block\">{block}</link></robot>");
    let toml = "metric = { kind = \"max-displacement\" }\n[[robot]]\nurdf = \"r.urdf\"\nbase = \"floating\"\n\
                bounds = { min = [-1, -1, -1], max = [1, 1, 1] }\n\
                [[obstacle]]\nname = \"wall\"\nshape = { box = [0.6, 0.5, 0.4] }\n";
    let world = Solver::new(scene(toml, &[("r.urdf", urdf)]));
    let mut seen = 0;
    for x in [0.1, 0.2, 0.3, 0.35] {
        // The block is upright, so the nearest exit is beyond a face of the wall.
        let q = [x, 0.05, 0.02, 0.0, 0.0, 0.0, 1.0];
        let exact = [0.4 - x, 0.4 - 0.05, 0.4 - 0.02].into_iter().fold(f64::INFINITY, f64::min) + CLEARANCE;
        let answer = ask(&world, &world.scene().space().config(&q).unwrap(), &proved(1e-3, 5000));
        assert!(
            (answer.depth - exact).abs() < 1.1e-3 * exact && answer.lower_bound <= exact * (1.0 + 1e-9),
            "{q:?}: {answer:?} {exact}"
        );
        assert!(answer.gap < 1.1e-3, "{q:?}: {answer:?} {exact}");
        seen += 1;
    }
    assert_eq!(seen, 4);
}

/// No bound is above what any search finds, whatever the clearance and metric. A gap that an answer
/// reports is real. More checks never raise the depth, and hardly lower the bound.
#[test]
fn bounds_hold_and_only_get_better() {
    let mut closed = [0; 2];
    // Scenes of more joints would take too long.
    for name in ["planar-arm", "shelf-arm", "free-box"] {
        for kind in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
            let clearances = if kind == MetricKind::Joint { &[0.0, 0.02][..] } else { &[1e-4] };
            for &clearance in clearances {
                let scene = builtin::scene(name).unwrap().with_metric(kind).with_clearance(clearance).unwrap();
                let world = Solver::new(scene);
                for q in colliding(&world, 2) {
                    let exhaustive = QueryOptions::default().effort(Effort::Exhaustive).starts(12);
                    let best = ask(&world, &q, &exhaustive);
                    let short = ask(&world, &q, &proved(0.05, 40));
                    let long = ask(&world, &q, &proved(0.05, 80));
                    let what = format!("{name} {kind:?} {clearance} {q:?}");
                    for answer in [&short, &long] {
                        assert!(answer.lower_bound <= best.depth * (1.0 + 1e-9), "{what}: {answer:?} {}", best.depth);
                        assert!(
                            answer.verified && (answer.gap - (1.0 - answer.lower_bound / answer.depth)).abs() < 1e-12
                        );
                    }
                    assert!(long.depth <= short.depth, "{what}");
                    // The bound on curvature depends on the depth, which differs here.
                    let [before, after] = [&short, &long].map(|answer| answer.lower_bound);
                    let is_kept = after >= PROVED_BOUND_KEPT_SHARE * before;
                    assert!(is_kept, "{what}: {before} {after} at {} {}", short.depth, long.depth);
                    if long.gap <= 0.05 + 1e-9 {
                        assert!(
                            long.depth * 0.95 <= best.depth * (1.0 + 1e-9),
                            "{what}: {} {}",
                            long.depth,
                            best.depth
                        );
                        closed[0] += 1;
                    }
                    closed[1] += 1;
                }
            }
        }
    }
    println!("closed {closed:?}");
    assert!(f64::from(closed[0]) > PROVED_GAPS_CLOSED_SHARE * f64::from(closed[1]), "{closed:?}");
}

/// Surfaces enclose nothing: the answer gives this as the reason why nothing is proved, and gives
/// it in no other case.
#[test]
fn what_is_not_proved_is_told_why() {
    let block = collision([0.0; 3], [0.0; 3], "<box size=\"0.2 0.2 0.2\"/>");
    let sheet = collision([0.0; 3], [0.0; 3], "<mesh filename=\"sheet.obj\"/>");
    let obj = "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0.1 0.1 0\nv -0.1 0.1 0\nf 1 2 3 4\n";
    let wall = "v 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nf 1 2 3 4\n";
    let toml = "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"wall\"\nshape = { mesh = \"wall.obj\" }\n";
    let solid = toml.replace("{ mesh = \"wall.obj\" }", "{ box = [0.1, 1, 1] }");
    for (shape, toml, expected) in
        [(&sheet, toml, Some(Unproved::Surfaces)), (&block, toml, None), (&block, &solid, None)]
    {
        let urdf = chain(&[("prismatic", [0.0; 3], [1.0, 0.0, 0.0], -1.0, 1.0, shape)]);
        let files = [("r.urdf", urdf), ("sheet.obj", obj.into()), ("wall.obj", wall.into())];
        let world = Solver::new(scene(toml, &files));
        let q = world.scene().space().config(&[0.02]).unwrap();
        let answer = world.query(&q).unwrap();
        assert!(answer.depth > 0.05 && answer.unproved == expected, "{answer:?}");
        assert_eq!(answer.unproved.is_some(), answer.lower_bound == 0.0);
    }
}
