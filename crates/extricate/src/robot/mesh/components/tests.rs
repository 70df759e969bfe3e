//! Tests cubes and tetrahedra as files have them.

use crate::robot::mesh::TriangleMesh;
use crate::robot::mesh::components::*;

fn volume(mesh: &TriangleMesh, component: &Component) -> f64 {
    component.triangles.clone().map(|t| mesh.corners(t)).map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum()
}

/// Unit cube with a corner at `corner`, as soup; `faces` lists those of -x, +x, -y, +y, -z, +z that
/// are there.
fn cube(corner: [f64; 3], faces: &[usize]) -> Vec<Vec3> {
    let mut soup = Vec::new();
    for &face in faces {
        let (axis, side) = (face / 2, (face % 2) as f64);
        let (u, v) = if face % 2 == 1 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        let at = |p: f64, q: f64| {
            let mut point = Vec3::from(corner);
            point[axis] += side;
            point[u] += p;
            point[v] += q;
            point
        };
        soup.extend([at(0., 0.), at(1., 0.), at(1., 1.), at(0., 0.), at(1., 1.), at(0., 1.)]);
    }
    soup
}

fn mesh(soup: Vec<Vec3>) -> TriangleMesh {
    let triangles = (0..soup.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriangleMesh::new(soup, triangles)
}

const ALL: &[usize] = &[0, 1, 2, 3, 4, 5];

#[test]
fn closed_components_face_outward_whatever_the_file_says() {
    let mut soup = cube([0.; 3], ALL);
    let first = soup.len();
    soup.extend(cube([3., 0., 0.], ALL));
    soup[first..].reverse();
    soup.swap(0, 1);
    soup.extend(cube([6., 0., 0.], &[0, 1, 2]));
    let mesh = mesh(soup);
    assert_eq!(mesh.components.iter().map(|c| c.closed).collect::<Vec<_>>(), [true, true, false]);
    assert!(!mesh.is_closed());
    assert!((volume(&mesh, &mesh.components[0]) - 1.0).abs() < 1e-12);
    assert!((volume(&mesh, &mesh.components[1]) - 1.0).abs() < 1e-12);
    assert_eq!(mesh.components[2].triangles, 24..30);
}

#[test]
fn solids_that_touch_at_an_edge_a_corner_or_a_wall_are_closed() {
    for (corner, faces) in [([1., 1., 0.], ALL), ([1., 1., 1.], ALL), ([1., 0., 0.], ALL)] {
        let mut soup = cube([0.; 3], ALL);
        let mut second = cube(corner, faces);
        second.reverse();
        soup.extend(second);
        let mesh = mesh(soup);
        // A shared wall makes them one component; an edge or a corner alone does not.
        let parts = if corner == [1., 0., 0.] { 1 } else { 2 };
        assert_eq!((mesh.components.len(), mesh.triangles.len()), (parts, 24));
        assert!(mesh.is_closed());
        let sum: f64 = mesh.components.iter().map(|component| volume(&mesh, component)).sum();
        assert!((sum - 2.0).abs() < 1e-12, "{corner:?}");
    }
}

/// A box from the origin to `high`, as soup, wound outward or inward.
fn block(high: Vec3, outward: bool) -> Vec<Vec3> {
    let mut soup: Vec<Vec3> = cube([0.; 3], ALL).iter().map(|corner| corner.component_mul(&high)).collect();
    if !outward {
        soup.reverse();
    }
    soup
}

/// Their walls at the shared edge lie in one plane, so no order around it tells them apart.
#[test]
fn solids_that_overlap_and_share_an_edge_are_both_solid() {
    for (first, second) in [(true, true), (true, false), (false, true), (false, false)] {
        let mut soup = block(Vec3::new(2., 0.4, 0.4), first);
        soup.extend(block(Vec3::new(0.4, 2., 0.4), second));
        let mesh = mesh(soup);
        assert!(mesh.is_closed());
        let volumes: Vec<f64> = mesh.components.iter().map(|component| volume(&mesh, component)).collect();
        assert!(volumes.len() == 2 && volumes.iter().all(|volume| (volume - 0.32).abs() < 1e-12), "{volumes:?}");
    }
}

#[test]
fn a_cavity_that_touches_an_edge_of_its_solid_is_one() {
    for wound in [true, false] {
        // A wedge shares an edge with the block, and is wound inward.
        let mut soup = block(Vec3::repeat(2.0), wound);
        let [a, b] = [Vec3::new(0., 0., 0.), Vec3::new(0., 0., 2.)];
        let [c, d] = [Vec3::new(1., 0.5, 0.5), Vec3::new(0.5, 1., 1.)];
        let mut wedge: Vec<Vec3> = [[a, b, c], [a, c, d], [a, d, b], [b, d, c]].concat();
        if !wound {
            wedge.reverse();
        }
        soup.extend(wedge);
        let mesh = mesh(soup);
        let cavities: Vec<bool> = (0..mesh.components.len()).map(|component| mesh.is_cavity(component)).collect();
        assert_eq!(cavities, [false, true], "{wound}");
    }
}

#[test]
fn a_sheet_at_a_corner_of_a_solid_leaves_it_closed() {
    let mut soup = cube([0.; 3], ALL);
    soup.extend([Vec3::repeat(1.0), Vec3::new(2., 1., 1.), Vec3::new(1., 2., 1.)]);
    let mesh = mesh(soup);
    assert_eq!(mesh.components.iter().map(|c| c.closed).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn double_sided_files_say_each_triangle_once() {
    let two_sided = |faces: &[usize]| {
        let mut soup = cube([0.; 3], faces);
        let mut back = soup.clone();
        back.reverse();
        soup.extend(back);
        mesh(soup)
    };
    let solid = two_sided(ALL);
    assert!(solid.is_closed());
    assert_eq!(solid.triangles.len(), 12);
    let open = two_sided(&[0, 2, 4]);
    assert!(!open.is_closed());
    assert_eq!(open.triangles.len(), 6);
}

#[test]
fn a_flat_triangle_bridges_a_t_junction() {
    let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0.5, 0., 0.]].map(Vec3::from).to_vec();
    let split = vec![[0, 2, 1], [0, 4, 3], [4, 1, 3], [0, 3, 2], [1, 2, 3]];
    assert!(!TriangleMesh::new(points.clone(), split.clone()).is_closed());
    let bridged = TriangleMesh::new(points, [split, vec![[0, 1, 4]]].concat());
    assert!(bridged.is_closed());
    assert_eq!(bridged.triangles.len(), 5);
    assert!((volume(&bridged, &bridged.components[0]) - 1.0 / 6.0).abs() < 1e-12);
}

#[test]
fn slivers_stay_and_a_moebius_strip_does_no_harm() {
    let sliver = [[0., 0., 0.], [1., 0., 0.], [0.5, 1e-8, 0.]].map(Vec3::from).to_vec();
    assert_eq!(TriangleMesh::new(sliver, vec![[0, 1, 2]]).triangles.len(), 1);
    // The projective plane is closed and cannot be oriented.
    let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1], [1, 2, 4], [2, 3, 5], [3, 4, 1], [4, 5, 2]];
    let points = (0..6).map(|k| Vec3::new((k as f64).cos(), (k as f64).sin(), (k * k) as f64)).collect();
    let plane = TriangleMesh::new(points, [faces.to_vec(), vec![[5, 1, 3]]].concat());
    assert!(plane.is_closed());
    assert!(plane.triangles[0] == [0, 1, 2] || plane.triangles[0] == [0, 2, 1]);
}
