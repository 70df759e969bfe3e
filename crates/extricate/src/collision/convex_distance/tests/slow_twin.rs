//! Signed distance of two polytopes by trying every pair of features: no search, nothing shared
//! with the fast path.

use crate::collision::convex_distance::tests::*;

fn corners(core: &ConvexCore, pose: &Pose) -> Vec<Vec3> {
    let local = match core {
        ConvexCore::Point => vec![Vec3::zeros()],
        ConvexCore::Segment { half_length } => vec![Vec3::z() * *half_length, Vec3::z() * -half_length],
        ConvexCore::Box { half_extents } => (0..8)
            .map(|k| half_extents.component_mul(&Vec3::from_fn(|i, _| if k >> i & 1 == 0 { -1.0 } else { 1.0 })))
            .collect(),
        ConvexCore::Cylinder { .. } => panic!("not a polytope"),
        ConvexCore::Triangle(corners) => corners.to_vec(),
        ConvexCore::Hull(hull) => hull.points().to_vec(),
        ConvexCore::Prism { top, bottom } => top.iter().flat_map(|p| [*p, Vec3::new(p.x, p.y, *bottom)]).collect(),
    };
    let mut distinct: Vec<Vec3> = Vec::new();
    for point in local.iter().map(|p| pose.point(p)) {
        if !distinct.contains(&point) {
            distinct.push(point);
        }
    }
    distinct
}

fn pairs(points: &[Vec3]) -> Vec<[Vec3; 2]> {
    (0..points.len()).flat_map(|i| (0..i).map(move |j| [points[i], points[j]])).collect()
}

fn triples(points: &[Vec3]) -> Vec<[Vec3; 3]> {
    let three = |i, j| (0..j).map(move |k| [points[i], points[j], points[k]]);
    (0..points.len()).flat_map(|i| (0..i).flat_map(move |j| three(i, j))).collect()
}

fn point_segment(p: &Vec3, [a, b]: [Vec3; 2]) -> f64 {
    let edge = b - a;
    let share = ((p - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
    (p - (a + edge * share)).norm()
}

/// Normal of a triangle, at a right angle to its longest edge up to rounding even if the triangle
/// is thin.
fn normal_of([a, b, c]: [Vec3; 3]) -> Vec3 {
    let mut edges = [b - a, c - b, a - c];
    edges.sort_by(|e, f| e.norm_squared().total_cmp(&f.norm_squared()));
    let normal = edges[0].cross(&edges[1]);
    normal - edges[2] * (normal.dot(&edges[2]) / edges[2].norm_squared())
}

/// Returns the distance to the plane if the projection lies in the triangle, else infinity.
fn point_face(p: &Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let mut normal = normal_of([a, b, c]);
    normal *= (b - a).cross(&(c - a)).dot(&normal).signum();
    if normal.norm() < 1e-11 {
        return f64::INFINITY;
    }
    let inside = [[a, b], [b, c], [c, a]].iter().all(|[from, to]| (to - from).cross(&(p - from)).dot(&normal) >= 0.0);
    if inside { ((p - a).dot(&normal) / normal.norm()).abs() } else { f64::INFINITY }
}

/// Returns the distance of the lines if their nearest points lie in the segments, else infinity.
fn segment_segment([a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> f64 {
    let (u, v, between) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let area = uu * vv - uv * uv;
    if area < 1e-12 * uu * vv {
        return f64::INFINITY; // Parallel: the ends decide.
    }
    let (ru, rv) = (u.dot(&between), v.dot(&between));
    let (s, t) = ((uv * rv - vv * ru) / area, (uu * rv - uv * ru) / area);
    let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if inside { (between.dot(&u.cross(&v)) / u.cross(&v).norm()).abs() } else { f64::INFINITY }
}

/// Every point pair is taken as an edge and every triple as a face: those inside the polytope never
/// decide.
pub(crate) fn signed_distance(first: &ConvexCore, pose_first: &Pose, second: &ConvexCore, pose_second: &Pose) -> f64 {
    let (a, b) = (corners(first, pose_first), corners(second, pose_second));
    let (edges_a, edges_b, faces_a, faces_b) = (pairs(&a), pairs(&b), triples(&a), triples(&b));
    let mut normals: Vec<Vec3> = vec![Vec3::x(), Vec3::y(), Vec3::z()];
    normals.extend(faces_a.iter().chain(&faces_b).map(|face| normal_of(*face)));
    for [p, q] in &edges_a {
        normals.extend(edges_b.iter().map(|[r, s]| (q - p).cross(&(s - r))));
    }
    // Flat or thinner differences also need normals across their edges and faces.
    if a.len() <= 3 && b.len() <= 3 {
        for [p, q] in edges_a.iter().chain(&edges_b) {
            normals.extend([Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| (q - p).cross(&axis)));
            normals.extend(faces_a.iter().chain(&faces_b).map(|[r, s, t]| (q - p).cross(&(s - r).cross(&(t - r)))));
            normals.push(q - p);
        }
        normals.extend(a.iter().flat_map(|p| b.iter().map(move |q| p - q)));
    }
    let mut depth = f64::INFINITY;
    for normal in normals.iter().filter(|normal| normal.norm() > 1e-15).map(|normal| normal.normalize()) {
        let range = |points: &[Vec3]| {
            points
                .iter()
                .map(|p| p.dot(&normal))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let ((low_a, high_a), (low_b, high_b)) = (range(&a), range(&b));
        depth = depth.min(high_a - low_b).min(high_b - low_a);
    }
    let mut distance = f64::INFINITY;
    for (points, others, edges, faces) in [(&a, &b, &edges_b, &faces_b), (&b, &a, &edges_a, &faces_a)] {
        for p in points {
            others.iter().for_each(|other| distance = distance.min((p - other).norm()));
            edges.iter().for_each(|edge| distance = distance.min(point_segment(p, *edge)));
            faces.iter().for_each(|face| distance = distance.min(point_face(p, *face)));
        }
    }
    for edge_a in &edges_a {
        edges_b.iter().for_each(|edge_b| distance = distance.min(segment_segment(*edge_a, *edge_b)));
    }
    // One of the normals parts shapes that are apart (separating axes); the features then give the
    // distance.
    if depth <= 1e-14 { distance } else { -depth }
}

#[test]
fn separation_agrees_with_all_features() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut overlapping, mut apart) = (0, 0);
    for _ in 0..2_500 {
        let (first, second) = (random_polytope(&mut rng), random_polytope(&mut rng));
        let (mut pose_first, pose_second) = (random_pose(&mut rng, 0.4), random_pose(&mut rng, 0.4));
        let shapes = [rounded(first, 0.0), rounded(second, 0.0)];
        // At the random pose, then moved along the normal to where contact is near.
        for step in 0..4 {
            let found = separation(&shapes[0], &pose_first, &shapes[1], &pose_second, f64::INFINITY).unwrap();
            let slow = signed_distance(&shapes[0].core, &pose_first, &shapes[1].core, &pose_second);
            assert!(
                (found.distance - slow).abs() <= 1e-9,
                "{found:?} {slow} {shapes:#?} {pose_first:?} {pose_second:?}"
            );
            assert!(found.depth_lower <= -slow + 1e-11 && found.depth_lower > -slow - 1e-9, "{found:?} {slow}");
            if slow < 0.0 {
                overlapping += 1
            } else {
                apart += 1
            }
            let size = 10.0_f64.powf(-3.0 - 9.0 * rng.random::<f64>());
            let target = [0.0, size, -size][step % 3];
            pose_first.translation += found.normal * (target - found.distance);
        }
    }
    assert!(overlapping > 1000 && apart > 1000, "{overlapping} {apart}");
}
