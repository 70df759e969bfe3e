//! Names in a scene: made unique by their robot's name, looked up as users write them, listed where
//! unknown.

use std::collections::{HashMap, HashSet};

use super::file::RobotEntry;
use crate::error::Error;

/// A link, joint or obstacle as a user may name it: `name`, or `robot/name`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Named<'a> {
    /// The robot's name; `None` for an obstacle.
    pub robot: Option<&'a str>,
    /// As in its own file.
    pub name: &'a str,
}

impl Named<'_> {
    /// `robot/name`, or `name` for an obstacle.
    pub fn qualified(&self) -> String {
        match self.robot {
            Some(robot) => format!("{robot}/{}", self.name),
            None => self.name.to_string(),
        }
    }
}

/// The plain name where it occurs once, else the qualified one.
pub fn unique(all: &[Named]) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for named in all {
        *counts.entry(named.name).or_default() += 1;
    }
    all.iter().map(|named| if counts[named.name] == 1 { named.name.to_string() } else { named.qualified() }).collect()
}

/// Index of the one entry that `wanted` names, plain or qualified; else what is wrong with it, with
/// the candidates.
pub fn find(all: &[Named], wanted: &str) -> Result<usize, String> {
    let hits: Vec<usize> = (0..all.len()).filter(|&i| all[i].name == wanted || all[i].qualified() == wanted).collect();
    match hits[..] {
        [one] => Ok(one),
        [] => Err(unknown(wanted, &unique(all))),
        _ => {
            let candidates: Vec<String> = hits.iter().map(|&i| format!("`{}`", all[i].qualified())).collect();
            Err(format!("`{wanted}` is ambiguous, expected one of {}", candidates.join(", ")))
        }
    }
}

/// Refuses names that are empty or would break a line of a message or of a report.
pub fn check_name(name: &str) -> Result<(), String> {
    if name.trim().is_empty() || name.chars().any(char::is_control) {
        return Err(format!("got the name {name:?}, expected one of printed characters"));
    }
    Ok(())
}

/// The names of robots: as their entries say, else as their URDFs do, with `-2` and so on where
/// that is taken.
///
/// # Errors
/// [`Error::Input`] where an entry's name is no name or another entry's.
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
    let name = |(entry, urdf): (&RobotEntry, &str)| {
        if let Some(name) = &entry.name {
            return name.clone();
        }
        let numbered = (2..).map(|number| format!("{urdf}-{number}"));
        let name = std::iter::once(urdf.to_string()).chain(numbered).find(|name| !taken.contains(name));
        let name = name.unwrap_or_default();
        taken.insert(name.clone());
        name
    };
    Ok(entries.iter().zip(urdf_names).map(name).collect())
}

/// Candidates that a message lists.
const LISTED: usize = 12;

/// `got x, expected one of ..`: the most similar candidates first where there are many.
pub fn unknown<S: AsRef<str>>(wanted: &str, candidates: &[S]) -> String {
    let mut candidates: Vec<&str> = candidates.iter().map(AsRef::as_ref).collect();
    if candidates.is_empty() {
        return format!("got `{wanted}`, but there is nothing that it could name");
    }
    let more = candidates.len().saturating_sub(LISTED);
    if more > 0 {
        candidates.sort_by_key(|candidate| edits(wanted, candidate));
        candidates.truncate(LISTED);
    }
    let listed: Vec<String> = candidates.iter().map(|candidate| format!("`{candidate}`")).collect();
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
        assert_eq!(find(&ALL, "arm"), Ok(2));
        assert_eq!(find(&ALL, "right/arm"), Ok(2));
        assert_eq!(find(&ALL, "table"), Ok(3));
        assert_eq!(find(&ALL, "right/hand"), Ok(1));
        assert_eq!(find(&ALL, "hand").unwrap_err(), "`hand` is ambiguous, expected one of `left/hand`, `right/hand`");
        assert_eq!(
            find(&ALL, "tabel").unwrap_err(),
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
