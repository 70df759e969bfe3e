//! Boxes that are divided by walls of any shape, wound at random.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::math::Vec3;
use crate::robot::mesh::TriangleMesh;
use crate::robot::mesh::cavities::{volume_and_area, winding_number};
use crate::robot::mesh::openings::branches;
use crate::robot::{Geometry, formats};

/// Corners of a grid, and quadrilaterals between them.
#[derive(Default)]
struct Faces {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Faces {
    fn corner(&mut self, at: [f64; 3]) -> u32 {
        let at = Vec3::from(at);
        self.vertices.iter().position(|v| *v == at).unwrap_or_else(|| {
            self.vertices.push(at);
            self.vertices.len() - 1
        }) as u32
    }

    fn face(&mut self, corners: [[f64; 3]; 4]) {
        let [a, b, c, d] = corners.map(|at| self.corner(at));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Faces between two cells of a grid, or between one and the outside, for which `parts` says
    /// so.
    fn of_cells(size: [i32; 3], parts: impl Fn([i32; 3], [i32; 3]) -> bool) -> Self {
        let mut faces = Self::default();
        for axis in 0..3 {
            for at in cells(size.map(|n| n + 1)) {
                let mut before = at;
                before[axis] -= 1;
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                if at[u] < size[u] && at[v] < size[v] && parts(before, at) {
                    let corner = |du: i32, dv: i32| {
                        let mut corner = at.map(f64::from);
                        corner[u] += f64::from(du);
                        corner[v] += f64::from(dv);
                        corner
                    };
                    faces.face([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
                }
            }
        }
        faces
    }

    /// Turns each triangle by chance, mixes them, and moves all; how all are moved, too.
    fn spoiled(mut self, rng: &mut ChaCha8Rng) -> (Self, impl Fn(Vec3) -> Vec3) {
        for triangle in &mut self.triangles {
            if rng.random() {
                triangle.swap(1, 2);
            }
        }
        self.triangles.shuffle(rng);
        let axis = Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5);
        let turn = nalgebra::Rotation3::from_scaled_axis(axis * 6.0);
        let (scale, by) = (10f64.powf(rng.random_range(-3.0..3.0)), Vec3::from_fn(|_, _| rng.random::<f64>()));
        let moved = move |v: Vec3| (turn * v + by) * scale;
        self.vertices.iter_mut().for_each(|v| *v = moved(*v));
        (self, moved)
    }

    fn mesh(&self) -> TriangleMesh {
        TriangleMesh::new(self.vertices.clone(), self.triangles.clone())
    }
}

fn cells(size: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..size[0]).flat_map(move |i| (0..size[1]).flat_map(move |j| (0..size[2]).map(move |k| [i, j, k])))
}

fn is_in(size: [i32; 3], cell: [i32; 3]) -> bool {
    (0..3).all(|axis| (0..size[axis]).contains(&cell[axis]))
}

fn volume(mesh: &TriangleMesh) -> f64 {
    volume_and_area(&mesh.vertices, &mesh.triangles).0
}

/// The faces of a cube of side 2 about the origin.
fn cube() -> Faces {
    let at = |k: usize| [k & 4, (k & 2) * 2, (k & 1) * 4].map(|bit| if bit == 0 { -1.0 } else { 1.0 });
    let mut faces = Faces::default();
    for face in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]] {
        faces.face(face.map(at));
    }
    faces
}

fn with_walls(walls: &[[u32; 3]]) -> Faces {
    let mut faces = cube();
    faces.triangles.extend(walls);
    faces
}

/// Two triangles between opposite edges of the cube, whose ends are diagonals of its faces.
fn diagonal_wall() -> [[u32; 3]; 2] {
    let corners = cube().vertices;
    let at = |x, y, z| corners.iter().position(|v| *v == Vec3::new(x, y, z)).unwrap() as u32;
    let [a, b, c, d] = [at(-1., -1., -1.), at(1., -1., 1.), at(1., 1., 1.), at(-1., 1., -1.)];
    [[a, b, c], [a, c, d]]
}

#[test]
fn a_diagonal_wall_is_left_out() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..20 {
        let (faces, _) = with_walls(&diagonal_wall()).spoiled(&mut rng);
        let mesh = faces.mesh();
        assert!(mesh.is_closed() && mesh.triangles.len() == 12, "{:?}", mesh.components);
        let side = (faces.vertices[0] - faces.vertices[1]).norm();
        assert!((volume(&mesh) / side.powi(3) - 1.0).abs() < 1e-9);
    }
}

/// As files in f32 have them: every triangle with corners of its own.
#[test]
fn walls_are_left_out_behind_seams_too_and_that_is_told() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (faces, _) = with_walls(&diagonal_wall()).spoiled(&mut rng);
    let mut stl = vec![b' '; 80];
    stl.extend((faces.triangles.len() as u32).to_le_bytes());
    for triangle in &faces.triangles {
        stl.extend([0; 12]);
        for x in triangle.iter().flat_map(|&v| faces.vertices[v as usize].iter()) {
            let x = *x as f32;
            stl.extend(f32::from_bits(x.to_bits() + rng.random_range(0..2)).to_le_bytes());
        }
        stl.extend([0; 2]);
    }
    let mut warnings = Vec::new();
    let mesh = formats::parse_and_warn("a.stl", &stl, &mut warnings).unwrap();
    assert!(mesh.is_closed() && mesh.triangles.len() == 12, "{:?}", mesh.components);
    assert!(warnings.iter().any(|told| told.contains("a.stl: 2 triangles hang inside a solid")), "{warnings:?}");
}

#[test]
fn cavities_and_other_shells_beside_walls_stay_what_they_are() {
    let shell = |faces: &mut Faces, at: Vec3, radius: f64, outward: bool| {
        let ball = Geometry::Sphere { radius }.tessellate(8);
        let first = faces.vertices.len() as u32;
        faces.vertices.extend(ball.vertices.iter().map(|v| v + at));
        let turned = |[a, b, c]: [u32; 3]| if outward { [a, b, c] } else { [a, c, b] };
        faces.triangles.extend(ball.triangles.iter().map(|t| turned(t.map(|v| v + first))));
    };
    let mut faces = with_walls(&diagonal_wall());
    // Not on the wall, where x is z; then beside the cube.
    shell(&mut faces, Vec3::new(-0.5, 0.0, 0.5), 0.2, false);
    shell(&mut faces, Vec3::new(0.5, 0.0, -0.5), 0.2, true);
    shell(&mut faces, Vec3::new(4.0, 0.0, 0.0), 0.2, true);
    let mesh = faces.mesh();
    let cavities = (0..mesh.components.len()).filter(|&k| mesh.is_cavity(k)).count();
    assert!(mesh.is_closed() && mesh.components.len() == 4 && cavities == 1, "{:?}", mesh.components);
    let around = |x, y, z| winding_number(&mesh.vertices, &mesh.triangles, &Vec3::new(x, y, z)).round();
    assert_eq!([around(-0.5, 0., 0.5), around(0.9, 0., 0.9), around(4., 0., 0.), around(2., 0., 0.)], [0., 1., 1., 0.]);
}

#[test]
fn what_stands_out_of_a_solid_stays_as_a_surface() {
    // A flange all around the cube's lower edge, and a pane across the hole of a frame.
    let mut flange = cube();
    let ring = [[-1., -1., -1.], [1., -1., -1.], [1., 1., -1.], [-1., 1., -1.]];
    let wide = ring.map(|[x, y, z]| [2.0 * x, 2.0 * y, z]);
    (0..4).for_each(|k| flange.face([ring[k], ring[(k + 1) % 4], wide[(k + 1) % 4], wide[k]]));
    let frame: Vec<[i32; 3]> = cells([3, 3, 1]).filter(|cell| *cell != [1, 1, 0]).collect();
    let mut pane = Faces::of_cells([3, 3, 1], |a, b| frame.contains(&a) != frame.contains(&b));
    pane.face([[1., 1., 0.], [2., 1., 0.], [2., 2., 0.], [1., 2., 0.]]);
    for (faces, solid, sheet) in [(flange, 8.0, 8), (pane, 8.0, 2)] {
        let mesh = faces.mesh();
        let [body, rest] = &mesh.components[..] else { panic!("{:?}", mesh.components) };
        assert!(body.closed && !rest.closed && rest.triangles.len() == sheet, "{:?}", mesh.components);
        let enclosed = volume_and_area(&mesh.vertices, &mesh.triangles[body.triangles.clone()]).0;
        assert!((enclosed - solid).abs() < 1e-9, "{enclosed}");
        assert_eq!(branches(&mesh), 0);
    }
}

#[test]
fn a_lens_between_two_walls_is_as_the_file_winds_it() {
    let belt = [[0., -1., -1.], [0., 1., -1.], [0., 1., 1.], [0., -1., 1.]];
    let half = |faces: &mut Faces, x: f64| {
        let far = belt.map(|[_, y, z]| [x, y, z]);
        (0..4).for_each(|k| faces.face([belt[k], far[k], far[(k + 1) % 4], belt[(k + 1) % 4]]));
        faces.face(far);
    };
    let mut faces = Faces::default();
    [1.0, -1.0].into_iter().for_each(|x| half(&mut faces, x));
    for tip in [0.5, -0.5] {
        let tip = faces.corner([tip, 0., 0.]);
        for k in 0..4 {
            let [a, b] = [belt[k], belt[(k + 1) % 4]].map(|at| faces.corner(at));
            faces.triangles.push([a, b, tip]);
        }
    }
    let inside = |triangles: Vec<[u32; 3]>| {
        let mesh = TriangleMesh::new(faces.vertices.clone(), triangles);
        assert!(mesh.is_closed());
        (mesh.triangles.len(), winding_number(&mesh.vertices, &mesh.triangles, &Vec3::zeros()).round())
    };
    // Outward seen from the solid, so that what is between the walls is outside.
    let mut outward = faces.triangles.clone();
    for t in &mut outward {
        let [a, b, c] = t.map(|v| faces.vertices[v as usize]);
        let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(&(c - a)));
        let is_wall = t[2] as usize >= faces.vertices.len() - 2;
        if (normal.dot(&middle) > 0.0) == is_wall {
            t.swap(1, 2);
        }
    }
    let mut inward = outward.clone();
    inward.iter_mut().for_each(|t| t.swap(1, 2));
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut random = outward.clone();
    random.iter_mut().filter(|_| rng.random()).for_each(|t| t.swap(1, 2));
    let all = faces.triangles.len();
    assert_eq!([inside(outward), inside(inward), inside(random)], [(all, 0.0), (all, 0.0), (all - 8, 1.0)]);
}

/// Chambers of cells of a grid, at random, with one wall between two of them: what stays bounds all
/// of them together.
#[test]
fn random_walls_between_cells_leave_one_solid() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut left_out = 0;
    for _ in 0..50 {
        let size = [0; 3].map(|_| rng.random_range(1..4));
        let full: Vec<[i32; 3]> = cells(size).filter(|_| rng.random_range(0..8) > 0).collect();
        // Cells of one chamber have no walls between them.
        let chamber: Vec<u32> = full.iter().map(|_| rng.random_range(0..4)).collect();
        let of = |cell: [i32; 3]| full.iter().position(|other| *other == cell).map(|k| chamber[k]);
        let faces = Faces::of_cells(size, |a, b| of(a) != of(b));
        let bare = Faces::of_cells(size, |a, b| of(a).is_some() != of(b).is_some());
        // A hole that nothing leads to is glued to walls: it is solid.
        let reached = outside_cells(size, &full);
        let solid = cells(size).filter(|cell| !reached.contains(cell)).count();
        let holes = solid - full.len();
        if holes > 0 || full.is_empty() {
            continue;
        }
        let (spoiled, moved) = faces.spoiled(&mut rng);
        let mesh = spoiled.mesh();
        assert!(mesh.is_closed(), "{size:?} {full:?} {chamber:?}: {:?}", mesh.components);
        left_out += spoiled.triangles.len() - mesh.triangles.len();
        assert_eq!(mesh.triangles.len(), bare.triangles.len(), "{size:?} {full:?} {chamber:?}");
        for cell in cells(size) {
            let middle = cell.map(|x| f64::from(x) + 0.5);
            let expected = if full.contains(&cell) { 1.0 } else { 0.0 };
            let found = winding_number(&mesh.vertices, &mesh.triangles, &moved(Vec3::from(middle)));
            assert!((found - expected).abs() < 1e-6, "{cell:?}: {found}");
        }
    }
    assert!(left_out > 400, "{left_out}");
}

fn outside_cells(size: [i32; 3], full: &[[i32; 3]]) -> Vec<[i32; 3]> {
    let beyond = |cell: &[i32; 3]| (0..3).all(|axis| (-1..=size[axis]).contains(&cell[axis]));
    let (mut reached, mut next) = (vec![[-1; 3]], 0);
    while next < reached.len() {
        for axis in 0..3 {
            for step in [-1, 1] {
                let mut cell = reached[next];
                cell[axis] += step;
                let is_free = beyond(&cell) && !(is_in(size, cell) && full.contains(&cell));
                if is_free && !reached.contains(&cell) {
                    reached.push(cell);
                }
            }
        }
        next += 1;
    }
    reached
}
