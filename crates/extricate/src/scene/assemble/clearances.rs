//! Converts the clearances of a scene file to clearances by names of bodies.

use crate::error::Result;
use crate::scene::clearances::Clearances;
use crate::scene::file::SceneFile;

/// Returns the exceptions from the clearance that a scene file gives. `body` takes the element for
/// messages and a name of the file; it returns the body's name in the scene, or `None` if the link
/// has no geometry.
pub fn clearances_of(entry: &SceneFile, body: &dyn Fn(String, &str) -> Result<Option<String>>) -> Result<Clearances> {
    let mut all = Clearances { own: entry.clearance.unwrap_or_default().lengths().1, ..Clearances::default() };
    for (a, b, length) in &entry.pairs.clearance {
        let find = |name| body(format!("pairs: clearance [{a:?}, {b:?}]"), name);
        if let (Some(a), Some(b)) = (find(a)?, find(b)?) {
            all.pairs.push(([a, b], *length));
        }
    }
    for (name, added) in &entry.padding {
        all.padding.extend(body("padding".into(), name)?.map(|name| (name, *added)));
    }
    Ok(all)
}
