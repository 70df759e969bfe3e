//! Writers that meet a full disk or little memory report an error that names the file. Old files
//! stay whole, and nothing unfinished is left.
//!
//! A limit on the size of files stands in for a full disk, because everybody can set one on every
//! system; `scripts/check-full-disk.sh` fills a real one.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::process::{Finished, Workspace};

const WORLD: &str = r#"{"world": {"collision_objects": [{"header": {"frame_id": "w"}, "id": "tray", "meshes": [{"vertices":
    [{"x": 0, "y": 0, "z": 0}, {"x": 1, "y": 0, "z": 0}, {"x": 0, "y": 1, "z": 0}, {"x": 0, "y": 0, "z": SIZE}],
    "triangles": [{"vertex_indices": [0, 2, 1]}, {"vertex_indices": [0, 1, 3]}, {"vertex_indices": [1, 2, 3]}, {"vertex_indices": [2, 0, 3]}]}],
    "mesh_poses": [{"position": {"x": 1, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}]}]}}"#;

/// Runs a line under `limit`, a command of the shell. Files that grow beyond a limit send a signal,
/// which is ignored, so that writing fails as on a full disk.
fn limited(workspace: &Workspace, limit: &str, line: &str) -> Command {
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("trap '' XFSZ; {limit} || exit 99; exec \"$0\" \"$@\""));
    command.arg(env!("CARGO_BIN_EXE_extricate")).args(line.split_whitespace());
    command.current_dir(workspace.path(".")).stdin(Stdio::null());
    command
}

/// A workspace in which every writer has an old file to replace.
fn with_old_files() -> Workspace {
    let workspace = Workspace::new();
    workspace.write("tray.json", WORLD.replace("SIZE", "1"));
    workspace.run("import tray.json -o tray.toml").expect_code(0);
    workspace.write("tray.json", WORLD.replace("SIZE", "2"));
    workspace.run("learn scene.toml -o a.model --labels 3000 --seed 1").expect_code(0);
    workspace.run("demo --scene planar-arm --queries 1 --seconds 0.05 --out demo.html").expect_code(0);
    crate::grasps::add_files(&workspace);
    workspace.write("g.jsonl", crate::grasps::grasps_of_a_mesh(4));
    for line in [
        "plan scene.toml --from 2.5,0 --to -2.5,0 --roadmap kept",
        "view scene.toml --q 0.1,0 -o view.html",
        "report a.model -n 2 -o report.html",
        "grasp hand.toml --input g.jsonl --objects meshes -o grasps.jsonl",
        "man pages",
    ] {
        workspace.run(line).expect_code(0);
    }
    workspace
}

/// Lines that write, and the first file that each writes.
const WRITERS: [(&str, &str); 10] = [
    ("learn scene.toml -o a.model --labels 5000", "a.model"),
    ("learn scene.toml -o new.model --labels 5000", "new.model"),
    ("import tray.json -o tray.toml", "tray-meshes/tray.obj"),
    ("demo --scene planar-arm --queries 1 --seconds 0.05 --out demo.html", "demo.html"),
    ("plan scene.toml --from 2.5,0 --to -2.5,0.1 --roadmap kept", "kept"),
    ("view scene.toml --q 0.1,0 -o view.html", "view.html"),
    ("report a.model -n 2 -o report.html", "report.html"),
    ("grasp hand.toml --input g.jsonl --objects meshes -o grasps.jsonl", "grasps.jsonl.part"),
    ("man pages", "pages/extricate"),
    ("demo --scene planar-arm --export there", "there/"),
];

#[test]
fn a_full_disk_leaves_old_files_and_is_told() {
    let workspace = with_old_files();
    let before = workspace.files();
    // Nothing fits, or half a kilobyte does: every writer has a larger file.
    for blocks in [0, 1] {
        // Both files of the import would fit, and so would the first of the grasps.
        let fits = |file: &str| blocks > 0 && (file.ends_with(".obj") || file.ends_with(".part"));
        for (line, file) in WRITERS.into_iter().filter(|(_, file)| !fits(file)) {
            let failed = Finished::new(limited(&workspace, &format!("ulimit -f {blocks}"), line).output().unwrap());
            let told = failed.stderr.clone();
            let last = told.lines().last().unwrap_or_default();
            let parts = ["extricate: error: cannot write", file, "File too large"];
            assert!(failed.code == Some(1) && parts.iter().all(|part| last.contains(part)), "{line}: {told}");
            let after = workspace.files();
            let changed = |path: &&PathBuf| before.get(*path) != after.get(*path);
            let changed: Vec<_> = before.keys().chain(after.keys()).filter(changed).collect();
            assert!(changed.is_empty(), "{line}: {changed:?}");
        }
    }
}

/// Grasps that fit stay beside the old file, so that a run with more space resumes from them.
#[test]
fn grasps_on_a_disk_that_fills_up_are_gone_on_with() {
    let workspace = with_old_files();
    let output = || std::fs::read_to_string(workspace.path("grasps.jsonl")).unwrap();
    let old = output();
    workspace.write("g.jsonl", crate::grasps::grasps_of_a_mesh(40));
    let line = "grasp hand.toml --input g.jsonl --objects meshes -o grasps.jsonl";
    let failed = Finished::new(limited(&workspace, "ulimit -f 8", line).output().unwrap());
    failed.expect_failure(&["cannot write grasps.jsonl.part", "File too large"]);
    assert_eq!(output(), old);
    let part = std::fs::read_to_string(workspace.path("grasps.jsonl.part")).unwrap();
    assert!(part.ends_with('\n') && part.lines().count() > 4, "{part}");
    workspace.run(&format!("{line} --resume")).expect_code(0);
    assert!(output().starts_with(&part) && output().lines().count() == 40);
    assert!(!workspace.path("grasps.jsonl.part").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_on_a_full_disk_is_told() {
    let workspace = Workspace::new();
    for line in [
        "query scene.toml --q 0.1,0 --json",
        "check scene.toml --q 0.1,0",
        "sample scene.toml -n 5",
        "info scene.toml",
        "learn scene.toml -o a.model --labels 500",
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = workspace.command(line).stdout(full).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {told}");
        assert!(told.contains("error: cannot write to standard output"), "{line}: {told}");
    }
}

/// With little memory every command is done, refuses, or is aborted by a failed allocation, and
/// files stay whole. With less than the smallest of these limits the system cannot load the
/// program.
#[cfg(target_os = "linux")]
#[test]
fn little_memory_ends_in_an_error_or_an_abort_and_leaves_files_whole() {
    let workspace = with_old_files();
    let kept = |files: BTreeMap<PathBuf, Vec<u8>>| -> BTreeMap<PathBuf, Vec<u8>> {
        let is_kept = |path: &PathBuf| {
            let name = path.file_name().unwrap().to_string_lossy();
            // The next run replaces a part, and an abort leaves hidden files. The demo writes its
            // page before it learns: the page may be new, and is whole.
            let is_shown = name == "demo.html";
            let is_whole = || std::fs::read_to_string(path).is_ok_and(|text| text.ends_with("</html>\n"));
            assert!(!is_shown || is_whole(), "{name}");
            !is_shown && !name.ends_with(".part") && !name.starts_with(".extricate-")
        };
        files.into_iter().filter(|(path, _)| is_kept(path)).collect()
    };
    let (mut done, mut refused, mut aborted) = (0, 0, 0);
    for (line, _) in WRITERS {
        for kibibytes in [24_000, 32_000, 48_000, 4_000_000] {
            let _ = std::fs::remove_dir_all(workspace.path("there"));
            let before = kept(workspace.files());
            let output = limited(&workspace, &format!("ulimit -c 0; ulimit -v {kibibytes}"), line).output().unwrap();
            let told = String::from_utf8_lossy(&output.stderr);
            match output.status.code() {
                Some(0) => done += 1,
                Some(1) if told.contains("extricate: error: ") => refused += 1,
                // The second is the C library's, when it has no room for the data of a thread.
                None if output.status.signal() == Some(6)
                    && (told.contains("memory allocation of") || told.contains("out of memory")) =>
                {
                    aborted += 1;
                }
                _ => panic!("{line} within {kibibytes} KiB: {:?}\n{told}", output.status),
            }
            assert!(output.status.success() || kept(workspace.files()) == before, "{line} within {kibibytes} KiB");
        }
    }
    assert!(done > 0 && refused + aborted > 0, "{done} done, {refused} refused, {aborted} aborted");
    for line in ["info a.model", "info there/planar-arm.toml", "query scene.toml --world tray.toml --q 0.1,0"] {
        workspace.run(line).expect_code(0);
    }
}
