//! Tests boxes that walls of any shape divide, wound at random.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::are_inside;
use crate::math::Vec3;
use crate::robot::mesh::TriangleMesh;
use crate::robot::mesh::cavities;
use crate::robot::mesh::cavities::{volume_and_area, winding_number};
use crate::robot::mesh::edges::edge_connected;
use crate::robot::mesh::openings::branches;
use crate::robot::mesh::part::{Part, sorted};
use crate::robot::mesh::partition::closed_patches;
use crate::robot::{Geometry, formats};

/// Corners of a grid, and quadrilaterals between them.
#[derive(Debug, Default)]
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

    /// Adds faces between two cells of a grid, or between one and the outside, if `parts` returns
    /// true.
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

    /// Reverses triangles at random, shuffles them, and moves all points; also returns the motion.
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

/// Every triangle has corners of its own, as in files in f32.
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
    // Two balls are off the wall, on which x is z, and one is beside the cube.
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
    // Triangles face out of the solid, so that what is between the walls is outside.
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

/// Random chambers of grid cells have one wall between neighbours; only the outer boundary stays.
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
        // A hole that the outside does not reach has walls all around, so it is solid.
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

/// Adds a block from `low` to `high`, rotated about z, which shares corners with what is there.
fn add_block(faces: &mut Faces, low: [f64; 3], high: [f64; 3], turn: f64) {
    let at = |k: usize| {
        let v = Vec3::from_fn(|axis, _| if k >> (2 - axis) & 1 == 0 { low[axis] } else { high[axis] });
        let (sin, cos) = turn.sin_cos();
        [cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z]
    };
    for face in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]] {
        faces.face(face.map(at));
    }
}

fn add_flap(faces: &mut Faces, corners: [[f64; 3]; 3]) {
    let flap = corners.map(|at| faces.corner(at));
    faces.triangles.push(flap);
}

/// Counts the triangles in open components, and checks that no block has them.
fn open_triangles(faces: &Faces, blocks: usize) -> usize {
    let mesh = faces.mesh();
    let closed = mesh.components.iter().filter(|part| part.closed);
    let solid: usize = closed.map(|part| part.triangles.len()).sum();
    assert_eq!(solid, 12 * blocks, "{:?}", mesh.components);
    mesh.triangles.len() - solid
}

#[test]
fn solids_that_touch_along_edges_stay_solid_beside_a_flap() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut stacked = Faces::default();
    add_block(&mut stacked, [0., 0., 0.], [1., 1., 1.], 0.0);
    add_block(&mut stacked, [0., 0.5, 1.], [1., 1., 2.], 0.0);
    add_block(&mut stacked, [-1., -1., 0.], [0., 0., 1.], 0.0);
    add_flap(&mut stacked, [[1., 0., 0.], [1., 0., 1.], [2., -1., 0.5]]);
    let mut turned = Faces::default();
    add_block(&mut turned, [0., 0., 0.], [1., 1., 1.], 0.0);
    add_block(&mut turned, [0., 0., 0.], [1., 1., 1.], 30f64.to_radians());
    add_flap(&mut turned, [[1., 0., 0.], [1., 0., 1.], [2., -1., 0.5]]);
    for (mut faces, blocks) in [(stacked, 3), (turned, 2)] {
        for round in 0..20 {
            let mesh = faces.mesh();
            let deep = winding_number(&mesh.vertices, &mesh.triangles, &Vec3::new(0.31, 0.62, 0.5));
            assert!(deep > 0.6, "{blocks} blocks, order {round}: {deep}");
            assert_eq!(open_triangles(&faces, blocks), 1);
            if round == 0 { faces.triangles.reverse() } else { faces.triangles.shuffle(&mut rng) }
        }
    }
}

/// Blocks share edges at any angle, with flaps on them.
#[test]
fn no_triangle_of_a_closed_block_becomes_a_surface() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    for _ in 0..200 {
        let mut faces = Faces::default();
        let blocks = rng.random_range(1..6);
        for k in 0..blocks {
            let wide = [0.5, 1.0, 1.5].map(|side| side * rng.random_range(1..3) as f64);
            let turn = [k as f64, 0.0][rng.random_range(0..2)] * rng.random_range(0.2..1.0);
            add_block(&mut faces, [0.0; 3], [wide[0] + 0.01 * k as f64, wide[1] + 0.01 * k as f64, 1.0], turn);
        }
        for _ in 0..rng.random_range(1..4) {
            // At least the tip is outside of all blocks.
            let far = [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0), 3.0];
            add_flap(&mut faces, [[0., 0., 0.], [0., 0., 1.], far]);
        }
        let flaps = faces.triangles.len() - 12 * blocks;
        let (spoiled, _) = faces.spoiled(&mut rng);
        assert_eq!(open_triangles(&spoiled, blocks), flaps);
    }
}

/// A box with a wall is below a smaller one, whose floor lies in the lid of the first.
#[test]
fn the_order_of_triangles_in_one_plane_does_not_decide() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let mut faces = with_walls(&diagonal_wall());
    add_block(&mut faces, [-1., 0.2, 1.], [1., 1., 2.], 0.0);
    for _ in 0..40 {
        faces.triangles.shuffle(&mut rng);
        assert_eq!(open_triangles(&faces, 2), 0);
    }
}

/// Most of the fan is inside, but it reaches out of the box whose edge it shares.
#[test]
fn a_closed_box_that_reaches_out_is_no_wall() {
    let mut faces = cube();
    let [a, b] = [[-1., -1., -1.], [-1., -1., 1.]].map(|at| faces.corner(at));
    // The fan has slices, with all but one tip inside.
    let count = 600;
    let tips: Vec<u32> = (0..=count)
        .map(|k| {
            let turn = (5.0 + 80.0 * k as f64 / count as f64).to_radians();
            let long = if k == 301 { 4.0 } else { 1.5 };
            faces.corner([long * turn.cos() - 1.0, long * turn.sin() - 1.0, 0.0])
        })
        .collect();
    for pair in tips.windows(2) {
        faces.triangles.extend([[a, pair[1], pair[0]], [b, pair[0], pair[1]]]);
    }
    faces.triangles.extend([[a, b, tips[count]], [b, a, tips[0]]]);
    add_flap(&mut faces, [[1., 1., 1.], [1., 1., -1.], [3., 3., 0.]]);
    let mesh = faces.mesh();
    let out = 3.5 * (5.0 + 80.0 * 301.0 / count as f64).to_radians().cos() - 1.0;
    let around = winding_number(&mesh.vertices, &mesh.triangles, &Vec3::new(out, out, 0.0));
    assert!(around > 0.5, "{around}: {:?}", mesh.components);
}

#[test]
fn one_triangle_or_one_corner_outside_is_seen() {
    let mut faces = cube();
    let solid = Part::new(&faces.vertices, faces.triangles.clone());
    let mut walls = Vec::new();
    for k in 0..1000 {
        let x = f64::from(k) / 1000.0 - 0.5;
        add_flap(&mut faces, [[-1., -1., -1.], [x, 0., 0.5], [x, 0.5, -0.5]]);
        walls.push(faces.triangles[faces.triangles.len() - 1]);
    }
    assert!(are_inside(&faces.vertices, &[&solid], &walls));
    let at = walls[501][1] as usize;
    for (x, middle_is_out) in [(1.4, false), (8.0, true)] {
        faces.vertices[at].x = x;
        let middle = walls[501].map(|v| faces.vertices[v as usize]).iter().sum::<Vec3>() / 3.0;
        assert_eq!(middle.x > 1.0, middle_is_out);
        assert!(!are_inside(&faces.vertices, &[&solid], &walls));
    }
}

/// A cavity that touches an edge of its solid is hollow, so a sheet in it is no wall.
#[test]
fn a_sheet_in_a_cavity_is_no_wall() {
    let mut faces = cube();
    let first = Part::new(&faces.vertices, faces.triangles.clone());
    faces.triangles.clone_from(&first.triangles);
    let [a, b, c, d] = [[-1., -1., -1.], [-1., -1., 1.], [0.5, 0.0, -0.2], [0.0, 0.5, 0.2]].map(|at| faces.corner(at));
    let mut wedge = Part::new(&faces.vertices, vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]]).triangles;
    wedge.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    faces.triangles.extend(wedge);
    add_flap(&mut faces, [[-1., -1., -1.], [-1., -1., 1.], [-0.4, -0.4, 0.0]]);
    let flap = sorted(&faces.triangles[faces.triangles.len() - 1]).map(|v| faces.vertices[v as usize]);
    let mesh = faces.mesh();
    let cavities = (0..mesh.components.len()).filter(|&k| mesh.is_cavity(k)).count();
    let open: Vec<_> = mesh.components.iter().filter(|part| !part.closed).collect();
    assert!(cavities == 1 && open.len() == 1, "{:?}", mesh.components);
    let corners = mesh.corners(open[0].triangles.start);
    assert!(flap.iter().all(|corner| corners.contains(corner)));
}

/// Returns what is closed if walls are ignored: solids, cavities, and what is left of each group.
fn closed_by_edges_alone(mesh: &Faces) -> Vec<[u32; 3]> {
    let groups = edge_connected(mesh.triangles.clone(), |triangle| *triangle);
    let divided = groups.into_iter().flat_map(|group| {
        let (mut solids, rest) = closed_patches(group);
        solids.extend(Some(rest).filter(|rest| !rest.is_empty()));
        solids
    });
    let mut parts: Vec<Part> = divided.map(|patch| Part::new(&mesh.vertices, patch)).collect();
    cavities::turn(&mesh.vertices, &mut parts);
    parts.into_iter().filter(|part| part.closed).flat_map(|part| part.triangles).collect()
}

/// Blocks of a grid overlap, touch and share walls, each wound at random, with flaps.
#[test]
fn what_is_solid_by_edges_alone_stays_solid() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let (mut solid, mut more) = (0, 0);
    for round in 0..600 {
        let mut faces = Faces::default();
        for _ in 0..rng.random_range(2..6) {
            let low = [0; 3].map(|_| f64::from(rng.random_range(0..3)));
            let high = low.map(|x| x + f64::from(rng.random_range(1..3)));
            let first = faces.triangles.len();
            add_block(&mut faces, low, high, 0.0);
            let way = rng.random_range(0..3);
            for triangle in &mut faces.triangles[first..] {
                if way == 1 || way == 2 && rng.random() {
                    triangle.swap(1, 2);
                }
            }
        }
        // Glued parts have each wall once.
        if rng.random() {
            let mut seen = std::collections::HashSet::new();
            faces.triangles.retain(|triangle| seen.insert(sorted(triangle)));
        }
        for _ in 0..rng.random_range(0..4) {
            let corners = [0; 3].map(|_| rng.random_range(0..faces.vertices.len() as u32));
            if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                faces.triangles.push(corners);
            }
        }
        faces.triangles.shuffle(&mut rng);
        let before = closed_by_edges_alone(&faces);
        let mesh = faces.mesh();
        let closed = mesh.components.iter().filter(|part| part.closed);
        let after: Vec<[u32; 3]> = closed.flat_map(|part| mesh.triangles[part.triangles.clone()].to_vec()).collect();
        for _ in 0..20 {
            let point = Vec3::from_fn(|_, _| rng.random_range(0.0..5.0));
            let was = winding_number(&faces.vertices, &before, &point) > 0.5;
            let is = winding_number(&mesh.vertices, &after, &point) > 0.5;
            assert!(is || !was, "{round}: {point:?} {faces:?}");
            solid += usize::from(was);
            more += usize::from(is && !was);
        }
    }
    assert!(solid > 500 && more > 5, "{solid} {more}");
}
