//! Shared by tests of motions: labelled configurations, samples along a path, and a scene.

use std::path::Path;

use crate::collision::{CheckScratch, Checker};
use crate::cspace::sampling::Halton;
use crate::cspace::{Config, Label};
use crate::scene::assemble::assemble;
use crate::solver::Solver;

/// Returns the first `count` configurations of a low-discrepancy sequence with this label.
pub fn labelled(checker: &Checker, label: Label, count: usize, seed: u64) -> Vec<Config> {
    let space = &checker.scene().space;
    let (halton, mut scratch) = (Halton::new(space.nv(), seed), CheckScratch::default());
    let mut q = vec![0.0; space.nq()];
    let mut found = Vec::new();
    for index in 0..100_000 {
        halton.config(space, index, &mut q);
        if checker.label(&q, &mut scratch) == label {
            found.push(space.config(&q).unwrap());
        }
        if found.len() == count {
            break;
        }
    }
    found
}

/// Calls `each` with configurations along a path, at most a hundredth of a unit apart.
pub fn along(checker: &Checker, points: &[Vec<f64>], mut each: impl FnMut(&[f64])) {
    let space = &checker.scene().space;
    let mut p = vec![0.0; space.nq()];
    for (a, b) in points.iter().zip(points.iter().skip(1)) {
        let samples = 20 + (100.0 * space.distance(a, b)) as usize;
        for sample in 0..=samples {
            space.interpolate(a, b, sample as f64 / samples as f64, &mut p);
            each(&p);
        }
    }
}

/// A floating peg of 1 x 1 x 4.5 m, with ends above and below a plate 3 m thick that fills its
/// bounds. The plate has a square hole of the width `hole` \[m\].
pub fn peg(hole: f64) -> (Solver, [Config; 2]) {
    let urdf = r#"<robot name="peg"><link name="peg"><collision><geometry><box size="1 1 4.5"/></geometry></collision></link></robot>"#;
    let side = (10.0 - hole) / 2.0;
    let off = (hole + side) / 2.0;
    let walls = [[side, 10.0, -off, 0.0], [side, 10.0, off, 0.0], [hole, side, 0.0, -off], [hole, side, 0.0, off]];
    let mut text = String::from(
        "metric = { kind = \"object-norm\" }\n[[robot]]\nurdf = \"peg.urdf\"\nbase = \"floating\"\nbounds = { min = [-4, -4, -6], max = [4, 4, 6] }\n",
    );
    for (k, [w, d, x, y]) in walls.into_iter().enumerate() {
        let shape = format!("shape = {{ box = [{w:?}, {d:?}, 3.0] }}\npose = {{ xyz = [{x:?}, {y:?}, 0.0] }}");
        text += &format!("[[obstacle]]\nname = \"wall{k}\"\n{shape}\n");
    }
    let scene = assemble(Path::new("peg.toml"), &text, &mut |_| Ok(urdf.as_bytes().to_vec())).unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let ends = [[2.0, 2.0, 4.8, 0.0, 0.0, 0.0, 1.0], [-2.0, -2.0, -4.8, half, 0.0, 0.0, half]];
    let ends = ends.map(|end| scene.space.config(&end).unwrap());
    (Solver::new(scene), ends)
}
