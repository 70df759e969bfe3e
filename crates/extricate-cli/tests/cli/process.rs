//! Runs the program on a small scene.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// Two links of half a metre that rotate about z in a plane, and a post that both can hit.
const ROBOT: &str = r#"<robot name="planar">
  <link name="base"/>
  <link name="upper">
    <collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision>
  </link>
  <link name="fore">
    <collision><origin xyz="0.25 0 0"/><geometry><box size="0.46 0.04 0.04"/></geometry></collision>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0.5 0 0"/>
    <parent link="upper"/><child link="fore"/><axis xyz="0 0 1"/>
    <limit lower="-2.5" upper="2.5" effort="1" velocity="1"/>
  </joint>
</robot>
"#;
const SCENE: &str = r#"clearance = 1e-4
metric = { kind = "joint" }

[[robot]]
urdf = "planar.urdf"

[[obstacle]]
name = "post"
shape = { cylinder = [0.1, 0.5] }
pose = { xyz = [0.6, 0.1, 0] }
"#;

/// The arm is stretched out, through the post.
pub const COLLIDING: &str = "[0.1, 0.0]";
/// The arm is turned away from the post.
pub const FREE: &str = "[-2.0, 0.0]";

/// A directory with the small scene in it.
pub struct Workspace {
    folder: TempDir,
}

impl Workspace {
    pub fn new() -> Self {
        let workspace = Self { folder: tempfile::tempdir().unwrap() };
        workspace.write("planar.urdf", ROBOT);
        workspace.write("scene.toml", SCENE);
        workspace
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Returns every file of the directory with its contents.
    pub fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let (mut files, mut folders) = (BTreeMap::new(), vec![self.folder.path().to_path_buf()]);
        while let Some(folder) = folders.pop() {
            for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if path.is_dir() {
                    folders.push(path);
                } else {
                    files.insert(path.clone(), std::fs::read(path).unwrap());
                }
            }
        }
        files
    }

    /// Runs `extricate` with the words of `line` in this directory.
    pub fn run(&self, line: &str) -> Finished {
        self.run_with_input(line, "")
    }

    pub fn run_with_input(&self, line: &str, input: &str) -> Finished {
        let mut child = self.command(line).stdin(Stdio::piped()).spawn().unwrap();
        // The program may end without reading its input.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        Finished::new(child.wait_with_output().unwrap())
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_extricate"));
        command.current_dir(self.folder.path()).args(line.split_whitespace());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Learns the small scene into `small.model`.
    pub fn learned() -> Self {
        let workspace = Self::new();
        workspace.run("learn scene.toml -o small.model --labels 4000 --seed 1").expect_code(0);
        workspace
    }
}

/// Exit code and output of a process that ended.
pub struct Finished {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Finished {
    pub fn new(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    #[track_caller]
    pub fn expect_code(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// Standard output as one JSON value a line.
    #[track_caller]
    pub fn json(&self) -> Vec<Value> {
        self.stdout.lines().map(|l| serde_json::from_str(l).unwrap_or_else(|e| panic!("{e}: {l}"))).collect()
    }

    /// Fails with exit code 1, nothing on standard output, and a message with all of `parts`.
    #[track_caller]
    pub fn expect_failure(self, parts: &[&str]) {
        let failed = self.expect_code(1);
        assert_eq!(failed.stdout, "");
        let last = failed.stderr.lines().last().unwrap_or_default();
        assert!(last.starts_with("extricate: error: "), "{}", failed.stderr);
        for part in parts {
            assert!(last.contains(part), "{part:?} is not in {last:?}");
        }
    }
}

#[track_caller]
pub fn assert_keys(value: &Value, keys: &[&str]) {
    let mut found: Vec<_> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    let mut expected = keys.to_vec();
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
}

pub fn exists(path: &Path) -> bool {
    path.try_exists().unwrap()
}

/// Ends a process immediately, as a power cut would.
pub fn kill(mut child: Child) {
    let _ = child.kill();
    child.wait().unwrap();
}
