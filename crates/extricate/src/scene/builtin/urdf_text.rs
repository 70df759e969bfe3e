//! Writes URDF: links with collision shapes and the joints between them.

use std::fmt::Write;

pub struct UrdfText {
    text: String,
}

/// A collision shape \[m\]: a mesh, a box by full sides, or a cylinder by radius and length.
pub enum Shape<'a> {
    /// Path of a mesh file, below the package `robot`.
    Mesh(&'a str),
    Box([f64; 3]),
    Cylinder([f64; 2]),
}

/// Elements of a URDF joint; `xyz` \[m\] and `rpy` \[rad\] place it in the parent's frame.
pub struct JointText<'a> {
    pub name: &'a str,
    /// Type of the joint as URDF spells it.
    pub kind: &'a str,
    /// Names of the two links.
    pub parent_child: [&'a str; 2],
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
    pub axis: [f64; 3],
    /// Lower and upper limit \[rad or m\].
    pub limits: Option<[f64; 2]>,
    /// Name of the joint that it follows, factor and offset.
    pub mimic: Option<(&'a str, f64, f64)>,
}

impl Default for JointText<'_> {
    fn default() -> Self {
        Self {
            name: "",
            kind: "fixed",
            parent_child: ["", ""],
            xyz: [0.0; 3],
            rpy: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            limits: None,
            mimic: None,
        }
    }
}

impl UrdfText {
    pub fn new(name: &str) -> Self {
        Self { text: format!("<?xml version=\"1.0\"?>\n<robot name=\"{name}\">\n") }
    }

    /// Adds a link with shapes at the given positions \[m\] in its frame.
    pub fn link(&mut self, name: &str, shapes: &[(Shape, [f64; 3])]) {
        self.line(&format!("  <link name=\"{name}\">"));
        for (shape, at) in shapes {
            let shape = match shape {
                Shape::Mesh(path) => format!("<mesh filename=\"package://robot/{path}\"/>"),
                Shape::Box(size) => format!("<box size=\"{}\"/>", numbers(size)),
                Shape::Cylinder([radius, length]) => format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"),
            };
            let origin = format!("<origin xyz=\"{}\"/>", numbers(at));
            self.line(&format!("    <collision>{origin}<geometry>{shape}</geometry></collision>"));
        }
        self.line("  </link>");
    }

    pub fn joint(&mut self, joint: &JointText) {
        let JointText { name, kind, parent_child: [parent, child], .. } = joint;
        self.line(&format!("  <joint name=\"{name}\" type=\"{kind}\">"));
        self.line(&format!("    <parent link=\"{parent}\"/><child link=\"{child}\"/>"));
        self.line(&format!("    <origin xyz=\"{}\" rpy=\"{}\"/>", numbers(&joint.xyz), numbers(&joint.rpy)));
        if *kind != "fixed" {
            self.line(&format!("    <axis xyz=\"{}\"/>", numbers(&joint.axis)));
        }
        if let Some([lower, upper]) = joint.limits {
            self.line(&format!("    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"100\" velocity=\"1\"/>"));
        }
        if let Some((leader, multiplier, offset)) = joint.mimic {
            self.line(&format!("    <mimic joint=\"{leader}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>"));
        }
        self.line("  </joint>");
    }

    pub fn finish(mut self) -> Vec<u8> {
        self.line("</robot>");
        self.text.into_bytes()
    }

    fn line(&mut self, line: &str) {
        // Writing to a `String` cannot fail.
        let _ = writeln!(self.text, "{line}");
    }
}

fn numbers(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(f64::to_string).collect();
    values.join(" ")
}
