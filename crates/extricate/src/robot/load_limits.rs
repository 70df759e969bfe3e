//! Limits on what files may hold: more is refused before it takes memory or time. Reads nothing.

use crate::error::{Error, Result};

/// A quantity of files that [`LoadLimits`] bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoadLimit {
    /// Bytes of a mesh file or of a file of points.
    FileBytes,
    /// Bytes of the scene file, URDFs and SRDFs of a scene together, or of a world.
    TextBytes,
    /// Elements, texts and comments of an XML file.
    XmlNodes,
    /// Attributes of one element of an XML file.
    XmlAttributes,
    /// Nesting depth of elements in an XML file.
    XmlDepth,
    /// Values of a scene file (TOML) or of a world (JSON, YAML).
    Values,
    /// Nodes that a COLLADA or glTF file shows, repeated instances included.
    MeshNodes,
    /// Corners that nodes of a COLLADA or glTF file place beyond those that its bytes can hold:
    /// nodes may show a geometry any number of times.
    Placed,
    /// Corners of a mesh file before equal ones are welded, points of a file of points,
    /// or cells of an octree.
    Vertices,
    /// Triangles of the meshes of a scene, scaled copies included.
    Triangles,
    /// Links of the robots of a scene.
    Links,
    /// Shapes of the links of a robot.
    Shapes,
    /// Obstacles and attached objects.
    Obstacles,
    /// Pairs of bodies that are checked.
    Pairs,
    /// Bytes of a name: of a robot, link, joint or obstacle.
    NameBytes,
}

use LoadLimit::*;

impl LoadLimit {
    /// All limits, in the order of the variants.
    pub const ALL: [LoadLimit; 15] = [
        FileBytes,
        TextBytes,
        XmlNodes,
        XmlAttributes,
        XmlDepth,
        Values,
        MeshNodes,
        Placed,
        Vertices,
        Triangles,
        Links,
        Shapes,
        Obstacles,
        Pairs,
        NameBytes,
    ];

    /// Name of the limit in messages and on the command line.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Value that holds unless another one is set.
    ///
    /// The defaults are several times what robots and worlds in use have, and bound the memory that
    /// loading takes.
    pub fn default_value(self) -> usize {
        self.row().1
    }

    /// Name, default, and what is counted, in words.
    fn row(self) -> (&'static str, usize, &'static str) {
        match self {
            FileBytes => ("file-bytes", 1 << 30, "bytes"),
            TextBytes => ("text-bytes", 1 << 28, "bytes of text"),
            XmlNodes => ("xml-nodes", 2_000_000, "XML nodes"),
            XmlAttributes => ("xml-attributes", 256, "attributes"),
            XmlDepth => ("xml-depth", 1_000, "elements within each other"),
            Values => ("values", 5_000_000, "values"),
            MeshNodes => ("mesh-nodes", 1_000_000, "nodes (those shown again count)"),
            Placed => ("placed", 500_000, "corners placed by nodes"),
            Vertices => ("vertices", 16_000_000, "corners, points or cells"),
            Triangles => ("triangles", 16_000_000, "triangles"),
            Links => ("links", 10_000, "links"),
            Shapes => ("shapes", 100_000, "shapes of links"),
            Obstacles => ("obstacles", 250_000, "obstacles"),
            Pairs => ("pairs", 5_000_000, "checked pairs of bodies"),
            NameBytes => ("name-bytes", 1_000, "bytes in a name"),
        }
    }
}

/// Limits on what the files of a scene may hold. More is refused with an error that names the
/// limit.
///
/// ```
/// use extricate::{LoadLimit, LoadLimits, load_scene_within};
/// let limits = LoadLimits::default().with(LoadLimit::Triangles, 20_000_000);
/// assert!(load_scene_within("missing.toml", &limits).is_err());
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoadLimits {
    most: [usize; LoadLimit::ALL.len()],
}

impl Default for LoadLimits {
    fn default() -> Self {
        Self { most: LoadLimit::ALL.map(LoadLimit::default_value) }
    }
}

impl LoadLimits {
    /// Returns the largest value that is allowed.
    pub fn get(&self, limit: LoadLimit) -> usize {
        self.most[limit as usize]
    }

    /// Returns the same limits with one changed.
    #[must_use]
    pub fn with(mut self, limit: LoadLimit, most: usize) -> Self {
        self.most[limit as usize] = most;
        self
    }

    /// Refuses a count `found` in `element` of `file` if it exceeds the limit.
    ///
    /// # Errors
    /// [`Error::Input`] that names the limit.
    pub fn check(&self, limit: LoadLimit, found: usize, file: &str, element: &str) -> Result<()> {
        if found <= self.get(limit) {
            return Ok(());
        }
        Err(Error::input(file, element, self.exceeded(limit, found)))
    }

    /// Describes the problem with a count `found` that exceeds the limit.
    pub fn exceeded(&self, limit: LoadLimit, found: usize) -> String {
        let (name, _, what) = limit.row();
        let most = self.get(limit);
        format!(
            "got {found} {what} or more, expected at most {most}; more are taken with the load limit `{name}={found}`"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_limit_has_a_place_and_a_name_of_its_own() {
        for (place, limit) in LoadLimit::ALL.into_iter().enumerate() {
            assert_eq!(limit as usize, place);
            assert_eq!(LoadLimit::ALL.iter().filter(|other| other.name() == limit.name()).count(), 1);
            let limits = LoadLimits::default().with(limit, 3);
            assert!(limits.check(limit, 3, "f", "e").is_ok());
            let message = limits.check(limit, 4, "f", "e").unwrap_err().to_string();
            assert!(
                message.starts_with("f: e: got 4 ") && message.contains(&format!("`{}=4`", limit.name())),
                "{message}"
            );
            assert!(LoadLimits::default().check(limit, limit.default_value(), "f", "e").is_ok());
        }
    }
}
