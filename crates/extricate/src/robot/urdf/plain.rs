//! URDF text reduced to what collides and what moves, each value checked. What the values mean is `urdf`'s matter.
//!
//! `urdf_rs` reads the result. Of a whole file it would fail on an empty `<texture/>`, an entity of the file's own or a limit
//! without velocity, and its errors name no element; it takes "1 x 2 3" for three numbers, and a joint without limits for one
//! with limits 0 and 0.

use roxmltree::Node;

use super::super::xml::{
    NEEDS_XACRO, child, children, document, label, numbers, numbers_within, own_attribute, required,
    with_declared_prefixes,
};
use super::Shapes;
use crate::error::{Error, Result};
use crate::math::quaternion_matrix;

const JOINT_TYPES: [&str; 7] = ["fixed", "revolute", "continuous", "prismatic", "planar", "spherical", "floating"];

/// The robot in `text` as a document of links and joints that `urdf_rs` can read without an error. Every joint that may
/// have limits but needs none states them, infinite where the file has none.
pub(super) fn plain(file: &str, text: &str, shapes: Shapes, warnings: &mut Vec<String>) -> Result<String> {
    let text = with_declared_prefixes(text);
    let document = document(file, &text, "URDF")?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err(Error::input(file, "root", format!("got <{}>, expected <robot>", robot.tag_name().name())));
    }
    if let Some(macro_node) =
        robot.descendants().find(|n| n.tag_name().namespace().is_some_and(|n| n.contains("xacro")))
    {
        let line = document.text_pos_at(macro_node.range().start).row;
        return Err(Error::input(file, format!("line {line}"), NEEDS_XACRO));
    }
    let mut writer = Writer { file, element: String::new(), text: String::from("<robot") };
    writer.attribute("name", own_attribute(robot, "name").unwrap_or("robot"));
    // It decides what a limit that is not stated means.
    own_attribute(robot, "version").into_iter().for_each(|version| writer.attribute("version", version));
    writer.text += ">";
    for node in children(robot, "link") {
        writer.link(node, shapes, warnings)?;
    }
    let have = |tag: &'static str| children(robot, "link").filter(move |link| child(*link, tag).is_some());
    if shapes == Shapes::Collision && have("collision").next().is_none() {
        let seen: Vec<&str> = have("visual").filter_map(|link| own_attribute(link, "name")).collect();
        if !seen.is_empty() {
            warnings.push(format!(
                "{file}: no link has <collision> geometry, so the robot collides with nothing; <visual> geometry ({}) is \
                 taken with `geometry = \"visual\"`",
                seen.join(", ")
            ));
        }
    }
    for node in children(robot, "joint") {
        writer.joint(node)?;
    }
    writer.text += "</robot>";
    Ok(writer.text)
}

struct Writer<'a> {
    file: &'a str,
    /// The link or joint that is written, for messages.
    element: String,
    text: String,
}

impl Writer<'_> {
    fn link(&mut self, node: Node, shapes: Shapes, warnings: &mut Vec<String>) -> Result<()> {
        self.element = label(node);
        self.text += "<link";
        self.copy(node, "name")?;
        self.text += ">";
        let tag = match shapes {
            Shapes::Collision => "collision",
            Shapes::Visual => "visual",
        };
        for part in children(node, tag) {
            let Some(shape) = child(part, "geometry").and_then(|g| g.children().find(Node::is_element)) else {
                warnings.push(format!("{}: {}: a <{tag}> without geometry is ignored", self.file, self.element));
                continue;
            };
            self.text += "<collision>";
            self.origin(part)?;
            self.text += "<geometry>";
            self.shape(shape)?;
            self.text += "</geometry></collision>";
        }
        self.text += "</link>";
        Ok(())
    }

    fn shape(&mut self, node: Node) -> Result<()> {
        let tag = node.tag_name().name();
        if !matches!(tag, "box" | "sphere" | "cylinder" | "capsule" | "mesh") {
            return self.error(format!("got geometry <{tag}>, expected box, sphere, cylinder, capsule or mesh"));
        }
        self.text.extend(["<", tag]);
        match tag {
            "box" => self.copy_numbers::<3>(node, "size")?,
            "mesh" => {
                self.copy(node, "filename")?;
                self.copy_numbers_if_any::<3>(node, "scale")?;
            }
            _ => self.copy_numbers::<1>(node, "radius")?,
        }
        if matches!(tag, "cylinder" | "capsule") {
            self.copy_numbers::<1>(node, "length")?;
        }
        self.text += "/>";
        Ok(())
    }

    fn origin(&mut self, parent: Node) -> Result<()> {
        let Some(node) = child(parent, "origin") else { return Ok(()) };
        self.text += "<origin";
        self.copy_numbers_if_any::<3>(node, "xyz")?;
        match own_attribute(node, "quat_xyzw") {
            None => self.copy_numbers_if_any::<3>(node, "rpy")?,
            Some(value) => {
                let quaternion = nalgebra::Vector4::from(numbers::<4>(self.file, &self.element, "quat_xyzw", value)?);
                let Some(unit) = quaternion.try_normalize(1e-9) else {
                    return self.error(format!("got quat_xyzw=\"{value}\", expected a quaternion that is not zero"));
                };
                let [roll, pitch, yaw] = roll_pitch_yaw(unit.as_slice());
                self.attribute("rpy", &format!("{roll} {pitch} {yaw}"));
            }
        }
        self.text += "/>";
        Ok(())
    }

    fn joint(&mut self, node: Node) -> Result<()> {
        self.element = label(node);
        self.text += "<joint";
        self.copy(node, "name")?;
        self.copy(node, "type")?;
        let kind = own_attribute(node, "type").unwrap_or_default();
        if !JOINT_TYPES.contains(&kind) {
            let kinds = "fixed, revolute, continuous, prismatic, planar, spherical or floating";
            return self.error(format!("got type=\"{kind}\", expected {kinds}"));
        }
        self.text += ">";
        for tag in ["parent", "child"] {
            let Some(end) = child(node, tag) else {
                return self.error(format!("got no <{tag}>, expected one with a link"));
            };
            self.text.extend(["<", tag]);
            self.copy(end, "link")?;
            self.text += "/>";
        }
        self.origin(node)?;
        if let Some(axis) = child(node, "axis").filter(|axis| own_attribute(*axis, "xyz").is_some()) {
            self.text += "<axis";
            self.copy_numbers::<3>(axis, "xyz")?;
            self.text += "/>";
        }
        let mimic = child(node, "mimic");
        // Fixed joints stay fixed, whatever they are said to follow.
        if let Some(mimic) = mimic.filter(|_| kind != "fixed") {
            self.text += "<mimic";
            self.copy(mimic, "joint")?;
            self.copy_numbers_if_any::<1>(mimic, "multiplier")?;
            self.copy_numbers_if_any::<1>(mimic, "offset")?;
            self.text += "/>";
        }
        if mimic.is_none() {
            self.limit(kind, child(node, "limit"))?;
        }
        self.text += "</joint>";
        Ok(())
    }

    fn limit(&mut self, kind: &str, limit: Option<Node>) -> Result<()> {
        let limit = match kind {
            "revolute" | "prismatic" => limit,
            "planar" | "floating" => {
                limit.filter(|l| own_attribute(*l, "lower").is_some() && own_attribute(*l, "upper").is_some())
            }
            _ => return Ok(()),
        };
        // `urdf_rs` insists on a velocity.
        self.text += "<limit velocity='0'";
        match limit {
            Some(limit) => {
                for name in ["lower", "upper"] {
                    if let Some(value) = own_attribute(limit, name) {
                        // Some say "no limit" with 1e16.
                        numbers_within::<1>(f64::MAX, self.file, &self.element, name, value)?;
                        self.attribute(name, value);
                    }
                }
            }
            None => self.text += " lower='-inf' upper='inf'",
        }
        self.text += "/>";
        Ok(())
    }

    fn copy(&mut self, node: Node, name: &str) -> Result<()> {
        let value = required(self.file, &self.element, node, name)?;
        self.attribute(name, value);
        Ok(())
    }

    /// An attribute that must be there and hold `N` finite numbers.
    fn copy_numbers<const N: usize>(&mut self, node: Node, name: &str) -> Result<()> {
        let value = required(self.file, &self.element, node, name)?;
        numbers::<N>(self.file, &self.element, name, value)?;
        self.attribute(name, value);
        Ok(())
    }

    fn copy_numbers_if_any<const N: usize>(&mut self, node: Node, name: &str) -> Result<()> {
        if own_attribute(node, name).is_some() { self.copy_numbers::<N>(node, name) } else { Ok(()) }
    }

    fn attribute(&mut self, name: &str, value: &str) {
        self.text.extend([" ", name, "=\""]);
        for c in value.chars() {
            match c {
                '<' => self.text += "&lt;",
                '&' => self.text += "&amp;",
                '"' => self.text += "&quot;",
                c => self.text.push(c),
            }
        }
        self.text += "\"";
    }

    fn error(&self, problem: String) -> Result<()> {
        Err(Error::input(self.file, &self.element, problem))
    }
}

/// Roll, pitch and yaw \[rad\] of a unit quaternion x, y, z, w. `urdf_rs` reads `quat_xyzw` from URDF version 1.1 on only, and
/// takes a pitch within 4.5 mrad of 90 degrees for 90 degrees.
///
/// Roll is read off after yaw is undone: where pitch is near 90 degrees, and both turn about nearly the same axis, what is
/// uncertain in one is then made up for by the other.
fn roll_pitch_yaw(quaternion: &[f64]) -> [f64; 3] {
    let r = quaternion_matrix(quaternion);
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let (sin, cos) = yaw.sin_cos();
    let pitch = (-r[(2, 0)]).atan2(cos * r[(0, 0)] + sin * r[(1, 0)]);
    let roll = (sin * r[(0, 2)] - cos * r[(1, 2)]).atan2(cos * r[(1, 1)] - sin * r[(0, 1)]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::math::Pose;

    #[test]
    fn angles_give_back_the_rotation_even_at_the_poles() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for k in 0..3000 {
            // A third of them pitched by nearly 90 degrees, from 1 to 1e-16 rad off.
            let mut rpy = [0; 3].map(|_| rng.random_range(-3.0..3.0));
            if k % 3 == 0 {
                rpy[1] = std::f64::consts::FRAC_PI_2 - 10f64.powf(rng.random_range(-16.0..0.0));
            }
            let expected = Pose::from_xyz_rpy([0.0; 3], rpy).rotation;
            let quaternion = nalgebra::UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
            let found = Pose::from_xyz_rpy([0.0; 3], roll_pitch_yaw(quaternion.coords.as_slice())).rotation;
            assert!((found - expected).norm() < 1e-14, "{rpy:?}: {}", (found - expected).norm());
        }
    }

    #[test]
    fn only_what_is_needed_stays() {
        let text = "<!DOCTYPE robot [<!ENTITY one '1 '>]><robot name='&lt;a&quot;' xmlns='u' xmlns:x='v'>\
            <gazebo><link name='none'/></gazebo><material><texture/></material><joint type='planar' name='j'>\
            <limit lower='1'/><dynamics damping='x'/><parent link='a'/><child link='b'/></joint>\
            <link name='a'><inertial/><visual/><x:collision name='c'><origin xyz='&one;&one; 2'/><geometry><sphere \
            radius='1'/></geometry></x:collision></link></robot>";
        let expected = "<robot name=\"&lt;a&quot;\"><link name=\"a\"><collision><origin xyz=\"1 1  2\"/><geometry>\
            <sphere radius=\"1\"/></geometry></collision></link><joint name=\"j\" type=\"planar\"><parent link=\"a\"/>\
            <child link=\"b\"/><limit velocity='0' lower='-inf' upper='inf'/></joint></robot>";
        assert_eq!(plain("r.urdf", text, Shapes::Collision, &mut vec![]).unwrap(), expected);
    }
}
