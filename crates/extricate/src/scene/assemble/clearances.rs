//! From the lengths in a scene file to clearances of bodies by name.

use crate::error::Result;
use crate::scene::clearances::Clearances;
use crate::scene::file::SceneFile;

/// The clearances that a scene file asks for; `body` finds the name of a body as the scene has it
/// by an element of a message and a name as the file has it, `None` for what has no geometry.
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
