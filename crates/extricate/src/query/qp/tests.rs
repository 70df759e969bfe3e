//! Tests of the quadratic program against closed forms, itself and a slow twin.

use crate::math::quadratic_form::{Factor, QuadraticForm};
use crate::query::qp::*;
use rand::{RngExt, SeedableRng};

#[test]
fn projects_onto_a_corner() {
    let mut qp = Qp::default();
    qp.reset(2);
    qp.push(1.0).copy_from_slice(&[1.0, 0.0]);
    qp.push(2.0).copy_from_slice(&[0.0, 1.0]);
    assert_eq!(qp.solve(&QuadraticForm::identity(2), &[0.0, 0.0], f64::INFINITY), QpOutcome::Solved);
    assert!((qp.step[0] - 1.0).abs() < 1e-12 && (qp.step[1] - 2.0).abs() < 1e-12);
    assert!((qp.multiplier_sum(2) - 3.0).abs() < 1e-12);
}

/// A diagonal Hessian starts in the box and is not factored; the result must not differ.
#[test]
fn a_diagonal_hessian_gives_what_a_dense_one_does() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    for _ in 0..200 {
        let n = 1 + (rng.random::<f64>() * 7.0) as usize;
        let mut number = || rng.random::<f64>() * 2.0 - 1.0;
        let mut hessian = QuadraticForm::identity(n);
        hessian.entries_mut().iter_mut().for_each(|h| *h = 0.3 + number().abs());
        let gradient: Vec<f64> = (0..n).map(|_| number()).collect();
        let mut qp = Qp::default();
        qp.reset(n);
        qp.set_box(&vec![-1.0; n], &vec![1.0; n]);
        for _ in 0..3 {
            qp.push(-0.2).iter_mut().for_each(|a| *a = number());
        }
        let outcome = qp.solve(&hessian, &gradient, f64::INFINITY);
        let (step, objective) = (qp.step.clone(), qp.objective);
        let entry = |at: usize| if at.is_multiple_of(n + 1) { hessian.diagonal(at / (n + 1)) } else { 0.0 };
        let hessian = QuadraticForm::dense(n, (0..n * n).map(entry).collect());
        assert_eq!(qp.solve(&hessian, &gradient, f64::INFINITY), outcome);
        if outcome == QpOutcome::Solved {
            assert!((qp.objective - objective).abs() < 1e-9, "{objective} {}", qp.objective);
            assert_eq!(qp.solve(&hessian, &gradient, objective - 1e-6), QpOutcome::Above);
            assert_eq!(qp.solve(&hessian, &gradient, objective + 1e-6), QpOutcome::Solved);
        }
        assert!(step.iter().zip(&qp.step).all(|(a, b)| (a - b).abs() < 1e-9), "{step:?} {:?}", qp.step);
    }
}

#[test]
fn contradiction_is_told() {
    let mut qp = Qp::default();
    qp.reset(1);
    qp.push(1.0).copy_from_slice(&[1.0]);
    qp.push(1.0).copy_from_slice(&[-1.0]);
    assert_eq!(qp.solve(&QuadraticForm::identity(1), &[0.0], f64::INFINITY), QpOutcome::Infeasible);
}

/// The slow twin is projected gradient ascent on the dual.
#[test]
fn agrees_with_dual_ascent() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    for _ in 0..200 {
        let (n, m) = (1 + (rng.random::<f64>() * 7.0) as usize, (rng.random::<f64>() * 12.0) as usize);
        let mut number = || rng.random::<f64>() * 2.0 - 1.0;
        let root: Vec<f64> = (0..n * n).map(|_| number()).collect();
        let mut hessian = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                hessian[i * n + j] = (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum::<f64>();
            }
            hessian[i * n + i] += 0.5;
        }
        let form = QuadraticForm::dense(n, hessian.clone());
        let gradient: Vec<f64> = (0..n).map(|_| number()).collect();
        let inside: Vec<f64> = (0..n).map(|_| number()).collect();
        let mut qp = Qp::default();
        qp.reset(n);
        let mut boxed = Qp::default();
        boxed.reset(n);
        let (low, high): (Vec<f64>, Vec<f64>) =
            inside.iter().map(|x| (x - 0.4 * number().abs(), x + 0.4 * number().abs())).unzip();
        boxed.set_box(&low, &high);
        for _ in 0..m {
            let row: Vec<f64> = (0..n).map(|_| number()).collect();
            let bound = dot(&row, &inside) - 0.3 * number().abs();
            qp.push(bound).copy_from_slice(&row);
            boxed.push(bound).copy_from_slice(&row);
        }
        if number() > 0.0 {
            // Compare the box with the same box given as general rows.
            for k in 0..n {
                qp.push(low[k])[k] = 1.0;
                qp.push(-high[k])[k] = -1.0;
            }
            assert_eq!(boxed.solve(&form, &gradient, f64::INFINITY), QpOutcome::Solved);
        } else {
            boxed.step.clear();
        }
        let m = qp.bounds.len();
        assert_eq!(qp.solve(&form, &gradient, f64::INFINITY), QpOutcome::Solved);
        let mut factor = Factor::default();
        form.factor(&mut factor);
        let mut lambda = vec![0.0; m];
        let mut step = vec![0.0; n];
        for _ in 0..20_000 {
            for i in 0..m {
                let row = qp.row(i).to_vec();
                let mut lifted = row.clone();
                factor.solve(&mut lifted);
                step = gradient.iter().map(|g| -g).collect();
                for (k, multiplier) in lambda.iter().enumerate() {
                    step.iter_mut().zip(qp.row(k)).for_each(|(s, r)| *s += multiplier * r);
                }
                factor.solve(&mut step);
                lambda[i] = f64::max(0.0, lambda[i] + (qp.bounds[i] - dot(&row, &step)) / dot(&row, &lifted));
            }
            if (0..m).all(|i| qp.bounds[i] - dot(qp.row(i), &step) < 1e-12) {
                break;
            }
        }
        let value = |t: &[f64]| {
            let ht: Vec<f64> = (0..n).map(|i| dot(&hessian[i * n..(i + 1) * n], t)).collect();
            0.5 * dot(&ht, t) + dot(&gradient, t)
        };
        assert!((0..m).all(|i| dot(qp.row(i), &qp.step) >= qp.bounds[i] - 1e-9));
        assert!((qp.objective - value(&qp.step)).abs() < 1e-9, "{} {}", qp.objective, value(&qp.step));
        assert!(boxed.step.iter().zip(&qp.step).all(|(a, b)| (a - b).abs() < 1e-6), "{:?} {:?}", boxed.step, qp.step);
        if m > 0 {
            assert!(value(&qp.step) <= value(&step) + 1e-6, "{} {}", value(&qp.step), value(&step));
        }
    }
}
