//! Reads MoveIt's `.scene` text: words between blanks that give a name, then objects of shapes with
//! poses, then a dot. In the newer form an object also has a pose and subframes.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use super::imported::Imported;
use super::message_pose::MessagePose;
use super::objects::{Object, Objects, Shape};
use super::value::unit;
use crate::error::{Error, Result};
use crate::robot::{LoadLimits, formats};

/// Largest number of shapes, subframes, vertices or triangles that a text may claim.
const MAX_COUNT: f64 = 1e8;

/// Reads the text of a file.
///
/// # Errors
/// [`Error::Input`] with the line and the word that is wrong, and what was expected there.
pub fn read(file: &str, text: &str, limits: &LoadLimits) -> Result<Imported> {
    let text = text.trim_start_matches('\u{feff}');
    let mut words = Words { file, lines: text.lines().enumerate(), line: 0, rest: "".split_whitespace() };
    // The first line is the name of the scene, which is not used.
    words.next_line();
    let is_newer = is_newer(text);
    let (mut objects, mut found) = (Objects::new(limits), Vec::<Object>::new());
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut colours = false;
    loop {
        match words.word("* before an object, or . at the end")? {
            "." => break,
            "*" => {
                let object = object(&mut words, is_newer, &mut objects, &mut colours)?;
                match places.entry(object.name.clone()) {
                    Entry::Occupied(place) => found[*place.get()].shapes.extend(object.shapes),
                    Entry::Vacant(place) => {
                        place.insert(found.len());
                        found.push(object);
                    }
                }
            }
            other => return Err(words.fault(other, "* before an object, or . at the end")),
        }
    }
    if colours {
        objects.note("colours are not taken: a scene has none");
    }
    for object in found {
        objects.stand(file, object)?;
    }
    let (entries, notes) = objects.finish();
    Ok(Imported { entries, notes })
}

/// Returns whether objects have poses. The line below the first object's name then holds several
/// numbers; in the older form it holds one, the number of shapes.
fn is_newer(text: &str) -> bool {
    let mut lines = text.lines().skip(1).skip_while(|line| !line.starts_with('*')).skip(1);
    lines.next().is_some_and(|line| line.split_whitespace().count() > 1)
}

fn object(words: &mut Words, is_newer: bool, objects: &mut Objects, colours: &mut bool) -> Result<Object> {
    let name = words.rest_of_line();
    if name.is_empty() {
        return Err(words.fault("", "the name of an object behind *"));
    }
    let pose = if is_newer { words.pose()? } else { MessagePose::IDENTITY };
    let count = words.count("the number of shapes")?;
    let mut shapes = Vec::new();
    for _ in 0..count {
        let shape = shape(words, &name)?;
        shapes.push((shape, pose.then(&words.pose()?)));
        let colour = words.numbers::<4>("a colour: r, g, b, a")?;
        *colours |= colour.iter().any(|x| *x != 0.0);
    }
    if is_newer {
        let subframes = words.count("the number of subframes")?;
        for _ in 0..subframes {
            words.word("the name of a subframe")?;
            words.pose()?;
        }
        if subframes > 0 {
            objects.note(format!("object \"{name}\": its {subframes} subframes are not taken: a scene has none"));
        }
    }
    Ok(Object { name, shapes })
}

fn shape(words: &mut Words, object: &str) -> Result<Shape> {
    const KINDS: &str = "a shape: box, sphere, cylinder, cone, plane or mesh";
    Ok(match words.word(KINDS)? {
        "box" => Shape::Box(words.numbers("the sides x, y, z of a box [m]")?),
        "sphere" => Shape::Sphere(words.numbers::<1>("the radius of a sphere [m]")?[0]),
        "cylinder" => Shape::Cylinder(words.numbers("the radius and the length of a cylinder [m]")?),
        "cone" => Shape::Cone(words.numbers("the radius and the height of a cone [m]")?),
        "plane" => Shape::Plane(words.numbers("a, b, c, d of a plane")?),
        "mesh" => {
            let vertices = words.count("the number of vertices")?;
            let triangles = words.count("the number of triangles")?;
            let line = words.line;
            let vertex = |_| words.numbers("the coordinates of a vertex [m]");
            let vertices = (0..vertices).map(vertex).collect::<Result<Vec<_>>>()?;
            let corner = |_| Ok([words.index(&vertices)?, words.index(&vertices)?, words.index(&vertices)?]);
            let triangles = (0..triangles).map(corner).collect::<Result<Vec<_>>>()?;
            let name = format!("{}: line {line}: mesh of object \"{object}\"", words.file);
            Shape::Mesh(Arc::new(formats::from_arrays(&name, &vertices, triangles)?))
        }
        other => return Err(words.fault(other, KINDS)),
    })
}

/// Iterates over the words of a text and keeps the number of the line for messages.
struct Words<'a> {
    file: &'a str,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    /// Number of the current line, from 1; 0 before the first.
    line: usize,
    rest: std::str::SplitWhitespace<'a>,
}

impl<'a> Words<'a> {
    fn fault(&self, found: &str, expected: &str) -> Error {
        let found = if found.is_empty() { "nothing".into() } else { format!("`{}`", shorten(found)) };
        Error::input(self.file, format!("line {}", self.line), format!("got {found}, expected {expected}"))
    }

    fn next_line(&mut self) -> Option<&'a str> {
        let (index, line) = self.lines.next()?;
        (self.line, self.rest) = (index + 1, "".split_whitespace());
        Some(line)
    }

    /// Returns the remaining words of the line, joined by single blanks.
    fn rest_of_line(&mut self) -> String {
        let words: Vec<&str> = std::mem::replace(&mut self.rest, "".split_whitespace()).collect();
        words.join(" ")
    }

    fn word(&mut self, expected: &str) -> Result<&'a str> {
        loop {
            if let Some(word) = self.rest.next() {
                return Ok(word);
            }
            match self.next_line() {
                Some(line) => self.rest = line.split_whitespace(),
                None => return Err(self.fault("", expected)),
            }
        }
    }

    fn numbers<const N: usize>(&mut self, expected: &str) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = self.word(expected)?;
            let parsed = word.parse::<f64>().ok().filter(|x| x.is_finite());
            *number = parsed.ok_or_else(|| self.fault(word, expected))?;
        }
        Ok(numbers)
    }

    fn count(&mut self, expected: &str) -> Result<usize> {
        let word = self.word(expected)?;
        let parsed = word.parse::<u32>().ok().filter(|count| f64::from(*count) <= MAX_COUNT);
        parsed.map(|count| count as usize).ok_or_else(|| self.fault(word, expected))
    }

    fn index(&mut self, vertices: &[[f64; 3]]) -> Result<u32> {
        let expected = "the index of a vertex";
        let word = self.word(expected)?;
        let parsed = word.parse::<u32>().ok().filter(|index| (*index as usize) < vertices.len());
        parsed.ok_or_else(|| self.fault(word, &format!("{expected} below {}", vertices.len())))
    }

    /// Reads a position, then a quaternion x, y, z, w.
    fn pose(&mut self) -> Result<MessagePose> {
        let xyz = self.numbers("a position x, y, z [m]")?;
        let quaternion = self.numbers("a quaternion x, y, z, w")?;
        let unit = unit(quaternion)
            .ok_or_else(|| self.fault(&format!("{quaternion:?}"), "a quaternion x, y, z, w of length 1"))?;
        Ok(MessagePose { xyz, quaternion: unit })
    }
}

fn shorten(word: &str) -> String {
    const MAX_CHARS: usize = 40;
    let cut = if word.chars().nth(MAX_CHARS).is_some() { ".." } else { "" };
    word.chars().take(MAX_CHARS).chain(cut.chars()).collect()
}
