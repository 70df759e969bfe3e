//! Scenes whose size is a parameter: a chain of links among boxes, for the growth curves.

use std::fmt::Write as _;
use std::io::{Error as IoError, ErrorKind};
use std::path::Path;

use anyhow::Result;
use extricate::internals::scene::assemble::assemble;
use extricate::{Error, Scene};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::exact::drawn_poses::direction;
use crate::exact::meshes;
use crate::files;

const CHAIN_LENGTH_M: f64 = 1.5;

/// A chain of `links` meshes of 512 triangles with a revolute joint each, surrounded by `obstacles`
/// boxes.
///
/// The length of the chain and the total surface of the boxes are constant, so the share of
/// colliding configurations changes little with either number.
pub fn chain(links: usize, obstacles: usize) -> Result<Scene> {
    let length = CHAIN_LENGTH_M / links as f64;
    let link = files::stl(&meshes::bumpy(3, 0.0).scaled([0.2 * length, 0.2 * length, 0.5 * length]));
    let (urdf, toml) = (urdf(links, length), toml(obstacles));
    let scene = assemble(Path::new("scene.toml"), &toml, &mut |path| match path.file_name().and_then(|n| n.to_str()) {
        Some("chain.urdf") => Ok(urdf.clone().into_bytes()),
        Some("link.stl") => Ok(link.clone()),
        _ => Err(Error::Read { path: path.into(), source: IoError::from(ErrorKind::NotFound) }),
    });
    Ok(scene?)
}

fn urdf(links: usize, length: f64) -> String {
    // Limits shrink with the root of the number of links: the chain, a random walk of angles, then
    // bends alike.
    let most = (2.5 * (7.0 / links as f64).sqrt()).min(2.8);
    let mut text = String::from("<robot name=\"chain\"><link name=\"l0\"/>");
    for k in 1..=links {
        let axis = ["0 0 1", "0 1 0", "1 0 0"][k % 3];
        let (parent, start) = (k - 1, if k == 1 { 0.0 } else { length });
        let _ = write!(
            text,
            "<link name=\"l{k}\"><collision><origin xyz=\"0 0 {}\"/><geometry><mesh filename=\"link.stl\"/></geometry>\
             </collision></link><joint name=\"j{k}\" type=\"revolute\"><parent link=\"l{parent}\"/><child link=\"l{k}\"/>\
             <origin xyz=\"0 0 {start}\"/><axis xyz=\"{axis}\"/><limit lower=\"-{most}\" upper=\"{most}\" effort=\"1\" \
             velocity=\"1\"/></joint>",
            length / 2.0
        );
    }
    text + "</robot>"
}

fn toml(obstacles: usize) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut text = String::from("clearance = 1e-4\n[[robot]]\nurdf = \"chain.urdf\"\n");
    let side = 0.8 / (obstacles as f64).sqrt();
    for k in 0..obstacles {
        let at = direction(&mut rng) * (0.6 + 0.9 * rng.random::<f64>());
        let _ = write!(
            text,
            "[[obstacle]]\nname = \"box{k}\"\nshape = {{ box = [{side}, {side}, {side}] }}\npose = {{ xyz = [{}, {}, {}] }}\n",
            at.x, at.y, at.z
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_have_the_parts_that_were_asked_for() {
        let scene = chain(9, 30).unwrap();
        assert_eq!((scene.space().nq(), scene.bodies().len()), (9, 39));
    }
}
