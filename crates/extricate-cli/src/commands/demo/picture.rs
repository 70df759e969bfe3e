//! A picture of a page, drawn by a browser of this computer.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use extricate::files;

/// Programs that draw pages without a window, in the order in which they are tried.
const BROWSERS: [&str; 5] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "msedge"];
/// Names a browser in place of these.
const BROWSER_VARIABLE: &str = "EXTRICATE_CHROMIUM";
/// The size of pictures of links.
const WINDOW: &str = "--window-size=1280,720";

/// Returns a browser that draws pictures.
///
/// # Errors
/// Fails if there is none.
pub fn browser() -> anyhow::Result<PathBuf> {
    let named = std::env::var_os(BROWSER_VARIABLE).map(PathBuf::from);
    if let Some(path) = &named
        && !path.is_file()
    {
        bail!("{BROWSER_VARIABLE}: got {}, expected a browser", path.display());
    }
    let folders: Vec<PathBuf> = std::env::var_os("PATH").iter().flat_map(std::env::split_paths).collect();
    let places = BROWSERS.iter().flat_map(|name| {
        let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
        folders.iter().map(move |folder| folder.join(&file))
    });
    let found = named.or_else(|| places.into_iter().find(|path| path.is_file()));
    found.with_context(|| {
        format!("--png: found no browser, expected Chromium or Chrome on the PATH, or its file in {BROWSER_VARIABLE}")
    })
}

/// Draws a page at its first query into a PNG file.
///
/// # Errors
/// Fails if the browser draws nothing, or if the file cannot be written.
pub fn draw(browser: &Path, page: &Path, picture: &Path) -> anyhow::Result<()> {
    let page = page.canonicalize().with_context(|| format!("cannot read {}", page.display()))?;
    // Its own profile keeps the browser apart from one that is open.
    let folder = std::env::temp_dir().join(format!("extricate-picture-{}", std::process::id()));
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let drawn = folder.join("page.png");
    // Without a sandbox, which needs rights that containers lack: the page is this program's own.
    let done = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--hide-scrollbars", "--no-first-run", WINDOW])
        .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--virtual-time-budget=8000"])
        .arg(format!("--user-data-dir={}", folder.display()))
        .arg(format!("--screenshot={}", drawn.display()))
        // The link to a place is not played.
        .arg(format!("file://{}#t=0", page.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let bytes = fs::read(&drawn);
    // What the browser still holds open is left to the system.
    let _ = fs::remove_dir_all(&folder);
    done.with_context(|| format!("cannot start {}", browser.display()))?;
    let bytes = bytes.with_context(|| format!("{} drew no picture", browser.display()))?;
    Ok(files::write_atomically(picture, &bytes)?)
}

/// Whether a file that begins with `head` is a picture that may be replaced.
pub fn is_png(head: &[u8]) -> bool {
    head.starts_with(b"\x89PNG\r\n\x1a\n")
}
