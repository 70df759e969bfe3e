//! Makes names in a scene unique, finds what users name, and suggests names for unknown ones.

use std::collections::{HashMap, HashSet};

use super::file::RobotEntry;
use crate::error::{Error, MOST_LISTED, listed, quoted};

/// A link, joint or obstacle as a user may name it: `name`, or `robot/name`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Named<'a> {
    /// Name of the robot; `None` for an obstacle.
    pub robot: Option<&'a str>,
    /// Name as in its own file.
    pub name: &'a str,
}

impl Named<'_> {
    /// Returns `robot/name`, or `name` for an obstacle.
    pub fn qualified(&self) -> String {
        match self.robot {
            Some(robot) => format!("{robot}/{}", self.name),
            None => self.name.to_string(),
        }
    }
}

/// Returns the plain name of each entry if it occurs once, else the qualified one.
pub fn unique(all: &[Named]) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for named in all {
        *counts.entry(named.name).or_default() += 1;
    }
    all.iter().map(|named| if counts[named.name] == 1 { named.name.to_string() } else { named.qualified() }).collect()
}

/// An ordered list of names with a hash map for repeated searches.
pub struct NameIndex<'a> {
    all: Vec<Named<'a>>,
    places: HashMap<String, Vec<usize>>,
}

impl<'a> NameIndex<'a> {
    pub fn new(all: Vec<Named<'a>>) -> Self {
        let mut places: HashMap<String, Vec<usize>> = HashMap::with_capacity(all.len());
        for (place, named) in all.iter().enumerate() {
            let qualified = named.robot.map(|_| named.qualified());
            for name in std::iter::once(named.name.to_string()).chain(qualified) {
                places.entry(name).or_default().push(place);
            }
        }
        Self { all, places }
    }

    /// Returns the index of the one entry that `wanted` names, plain or qualified. The error lists
    /// candidates for an unknown or ambiguous name.
    pub fn find(&self, wanted: &str) -> Result<usize, String> {
        match self.places.get(wanted).map_or(&[][..], Vec::as_slice) {
            [one] => Ok(*one),
            [] => Err(unknown(wanted, &unique(&self.all))),
            hits => {
                let candidates = hits.iter().map(|&place| format!("`{}`", self.all[place].qualified()));
                Err(format!("`{}` is ambiguous, expected one of {}", quoted(wanted), listed(candidates)))
            }
        }
    }

    /// Returns whether an entry has this plain name.
    pub fn has_plain(&self, wanted: &str) -> bool {
        let places = self.places.get(wanted).map_or(&[][..], Vec::as_slice);
        places.iter().any(|&place| self.all[place].name == wanted)
    }
}

/// Refuses names that are empty or would break a line of a message or report.
pub fn check_name(name: &str) -> Result<(), String> {
    if name.trim().is_empty() || name.chars().any(char::is_control) {
        return Err(format!("got the name {:?}, expected one of printed characters", quoted(name)));
    }
    Ok(())
}

/// Returns the names of robots from their entries or else from their URDFs; a URDF's name that is
/// taken gets `-2` and so on.
///
/// # Errors
/// [`Error::Input`] if an entry's name is empty, not printable, or the name of another entry.
pub fn robot_names<'a>(
    file: &str,
    entries: &[RobotEntry],
    urdf_names: impl Iterator<Item = &'a str>,
) -> crate::error::Result<Vec<String>> {
    let mut taken: HashSet<String> = HashSet::new();
    for (index, name) in entries.iter().enumerate().filter_map(|(index, entry)| Some((index, entry.name.as_ref()?))) {
        let fault = |problem: String| Error::input(file, format!("robot {}", index + 1), format!("name: {problem}"));
        check_name(name).map_err(fault)?;
        if !taken.insert(name.clone()) {
            return Err(fault(format!("got `{name}`, expected a name that is no other robot's")));
        }
    }
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let name = |(entry, urdf): (&RobotEntry, &'a str)| {
        if let Some(name) = &entry.name {
            return name.clone();
        }
        let next = numbers.entry(urdf).or_insert(1);
        let name = loop {
            let name = if *next == 1 { urdf.to_string() } else { format!("{urdf}-{next}") };
            *next += 1;
            if !taken.contains(&name) {
                break name;
            }
        };
        taken.insert(name.clone());
        name
    };
    Ok(entries.iter().zip(urdf_names).map(name).collect())
}

/// Largest number of candidates that [`unknown`] ranks by similarity.
const MAX_RANKED_NAMES: usize = 2000;

/// Writes `got x, expected one of ..`; of many candidates it lists the most similar ones.
pub fn unknown<S: AsRef<str>>(wanted: &str, candidates: &[S]) -> String {
    let mut told: Vec<&str> = candidates.iter().map(AsRef::as_ref).collect();
    let wanted = quoted(wanted);
    if told.is_empty() {
        return format!("got `{wanted}`, but there is nothing that it could name");
    }
    let more = told.len().saturating_sub(MOST_LISTED);
    if more > 0 {
        told.truncate(MAX_RANKED_NAMES);
        told.sort_by_cached_key(|candidate| edits(&wanted, &quoted(candidate)));
        told.truncate(MOST_LISTED);
    }
    let listed: Vec<String> = told.iter().map(|candidate| format!("`{}`", quoted(candidate))).collect();
    let rest = if more > 0 { format!(" or {more} others") } else { String::new() };
    format!("got `{wanted}`, expected one of {}{rest}", listed.join(", "))
}

/// Levenshtein distance, by characters.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Named; 4] = [
        Named { robot: Some("left"), name: "hand" },
        Named { robot: Some("right"), name: "hand" },
        Named { robot: Some("right"), name: "arm" },
        Named { robot: None, name: "table" },
    ];

    #[test]
    fn only_repeated_names_are_qualified() {
        assert_eq!(unique(&ALL), ["left/hand", "right/hand", "arm", "table"]);
    }

    #[test]
    fn lookup_takes_plain_and_qualified_names() {
        let index = NameIndex::new(ALL.to_vec());

        assert!(index.has_plain("hand") && !index.has_plain("left/hand"));
        assert_eq!(index.find("arm"), Ok(2));
        assert_eq!(index.find("right/arm"), Ok(2));
        assert_eq!(index.find("table"), Ok(3));
        assert_eq!(index.find("right/hand"), Ok(1));
        assert_eq!(index.find("hand").unwrap_err(), "`hand` is ambiguous, expected one of `left/hand`, `right/hand`");
        assert_eq!(
            index.find("tabel").unwrap_err(),
            "got `tabel`, expected one of `left/hand`, `right/hand`, `arm`, `table`"
        );
    }

    #[test]
    fn robots_get_names_of_their_own() {
        let names = |text: &str, urdf: &[&str]| {
            let scene = crate::scene::file::parse("s.toml", text).unwrap();
            robot_names("s.toml", &scene.robot, urdf.iter().copied()).map_err(|error| error.to_string())
        };
        let plain = "[[robot]]\nurdf = 'a'\n";
        let named = "[[robot]]\nurdf = 'a'\nname = 'arm-2'\n";
        assert_eq!(names(&plain.repeat(3), &["arm", "arm", "b"]).unwrap(), ["arm", "arm-2", "b"]);
        assert_eq!(names(&format!("{plain}{plain}{named}"), &["arm"; 3]).unwrap(), ["arm", "arm-3", "arm-2"]);
        assert!(names(&named.repeat(2), &["a", "a"]).unwrap_err().contains("robot 2: name: got `arm-2`"));
        assert!(
            names("[[robot]]\nurdf = 'a'\nname = ''", &["a"]).unwrap_err().contains("robot 1: name: got the name \"\"")
        );
        assert!(check_name("a\nb").is_err() && check_name("a b").is_ok());
    }

    #[test]
    fn long_lists_keep_the_most_similar() {
        let many: Vec<String> = (0..40).map(|i| format!("finger_joint_{i}")).chain(["wrist".to_string()]).collect();
        let message = unknown("wrst", &many);
        assert!(message.contains("`wrist`") && message.contains("or 29 others"), "{message}");
        assert_eq!(edits("kitten", "sitting"), 3);
    }
}
