//! What an XML text holds, counted before it is parsed: the parser compares every attribute of an
//! element with all others, copies namespaces from element to element, and expands entities as
//! often as they are named. No checks of syntax, which the parser does.

use std::collections::{HashMap, HashSet};

use crate::error::{Error, Result};
use crate::robot::{LoadLimit, LoadLimits};

/// Entities within entities are followed this deep; the parser follows no further than ten.
const DEEPEST_ENTITY: usize = 11;
/// Namespaces that the parser may copy: as many as are in scope at each element that declares one.
const MOST_COPIES: usize = 2_000_000;

/// One text, walked through once.
#[derive(Default)]
pub(crate) struct Scan<'a> {
    /// Where the name of the first element ends.
    pub end_of_root_name: Option<usize>,
    /// Prefixes of elements and attributes that the first element does not declare, in the order in
    /// which they are met.
    pub undeclared: Vec<&'a str>,
    used: HashSet<&'a str>,
    declared: HashSet<&'a str>,
    declared_at_root: HashSet<&'a str>,
    /// Elements that declare namespaces.
    declaring: usize,
    /// Most attributes of an element, and where it begins.
    attributes: (usize, usize),
    depth: usize,
    /// Most elements within each other, and where the innermost begins.
    deepest: (usize, usize),
    entities: HashMap<&'a str, &'a str>,
    /// Names of the entities that the text refers to, and how often.
    references: HashMap<&'a str, usize>,
}

impl<'a> Scan<'a> {
    pub fn of(text: &'a str) -> Self {
        let mut scan = Self::default();
        scan.walk(text);
        // What entities hold is parsed as often as they are named.
        let values: Vec<&str> = scan.entities.values().copied().collect();
        let at_root = scan.end_of_root_name.take().unwrap_or(text.len());
        scan.end_of_root_name = Some(at_root);
        let outside = std::mem::take(&mut scan.references);
        values.into_iter().for_each(|value| scan.walk(value));
        scan.references = outside;
        scan.end_of_root_name = (at_root < text.len()).then_some(at_root);
        let unknown = |prefix: &&&str| !scan.declared_at_root.contains(**prefix) && is_prefix(prefix);
        let mut undeclared: Vec<&str> = scan.used.iter().filter(unknown).copied().collect();
        undeclared.sort_unstable();
        scan.undeclared = undeclared;
        scan
    }

    /// Refuses what would take more time or memory to parse than files of robots do.
    ///
    /// # Errors
    /// [`Error::Input`] with the line and the limit.
    pub fn check(&self, file: &str, text: &str, limits: &LoadLimits) -> Result<()> {
        let line =
            |at: usize| format!("line {}", text.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count() + 1);
        for (limit, (found, at)) in [(LoadLimit::XmlAttributes, self.attributes), (LoadLimit::XmlDepth, self.deepest)] {
            if found > limits.get(limit) {
                // What is met within an entity has no line.
                return Err(Error::input(file, line(at.min(text.len())), limits.exceeded(limit, found)));
            }
        }
        let copies = self.declaring.saturating_mul(self.declared.len());
        if copies > MOST_COPIES {
            let problem = format!(
                "got {} elements that declare namespaces, {} in all, expected less than {MOST_COPIES} pairs of both",
                self.declaring,
                self.declared.len()
            );
            return Err(Error::input(file, "namespaces", problem));
        }
        limits.check(LoadLimit::EntityBytes, self.expanded(), file, "entities")
    }

    /// Bytes that entities add where they are named, as far as the parser follows them.
    fn expanded(&self) -> usize {
        let within: HashMap<&str, HashMap<&str, usize>> =
            self.entities.iter().map(|(name, value)| (*name, references(value))).collect();
        let mut sizes: HashMap<&str, usize> = self.entities.iter().map(|(name, value)| (*name, value.len())).collect();
        let sum = |sizes: &HashMap<&str, usize>, named: &HashMap<&str, usize>| {
            let size = |(name, count): (&&str, &usize)| sizes.get(*name).map_or(0, |size| size.saturating_mul(*count));
            named.iter().map(size).fold(0, usize::saturating_add)
        };
        if within.values().any(|inner| !inner.is_empty()) {
            for _ in 0..DEEPEST_ENTITY {
                sizes = within
                    .iter()
                    .map(|(name, inner)| (*name, self.entities[name].len().saturating_add(sum(&sizes, inner))))
                    .collect();
            }
        }
        sum(&sizes, &self.references)
    }

    fn walk(&mut self, text: &'a str) {
        let mut at = 0;
        let mut outside = 0;
        while let Some(found) = text[at..].find('<') {
            let start = at + found;
            let rest = &text[start..];
            let length = if rest.starts_with("<!--") {
                after(rest, "-->")
            } else if rest.starts_with("<![CDATA[") {
                after(rest, "]]>")
            } else if rest.starts_with("<?") {
                after(rest, "?>")
            } else if rest.starts_with("<!") {
                self.document_type(rest)
            } else if rest.starts_with("</") {
                self.depth = self.depth.saturating_sub(1);
                after(rest, ">")
            } else {
                self.element(rest, start)
            };
            // Texts between, and attributes.
            add_references(&text[outside..start], &mut self.references);
            if !rest.starts_with("<!") {
                add_references(&rest[..length], &mut self.references);
            }
            at = start + length;
            outside = at;
        }
        add_references(&text[outside..], &mut self.references);
    }

    /// Counts an opening tag that `rest` begins with; its length.
    fn element(&mut self, rest: &'a str, start: usize) -> usize {
        let bytes = rest.as_bytes();
        let name_end = (1..bytes.len()).find(|&k| ends_name(bytes[k])).unwrap_or(bytes.len());
        let is_root = self.end_of_root_name.is_none();
        if is_root {
            self.end_of_root_name = (name_end < bytes.len()).then_some(start + name_end);
        }
        self.use_prefix(&rest[1..name_end]);
        let (mut at, mut attributes, mut declares) = (name_end, 0, false);
        let mut name_start = None;
        let mut end = bytes.len();
        while at < bytes.len() {
            match bytes[at] {
                b'>' => {
                    end = at + 1;
                    break;
                }
                quote @ (b'"' | b'\'') => {
                    attributes += 1;
                    at +=
                        bytes[at + 1..].iter().position(|&byte| byte == quote).map_or(bytes.len(), |length| length + 1);
                    name_start = None;
                }
                b'=' => {
                    let name = name_start.take().map_or("", |start| rest[start..at].trim_ascii_end());
                    declares |= self.attribute(name, is_root);
                }
                byte if !byte.is_ascii_whitespace() && name_start.is_none() => name_start = Some(at),
                _ => {}
            }
            at += 1;
        }
        self.declaring += usize::from(declares);
        if attributes > self.attributes.0 {
            self.attributes = (attributes, start);
        }
        if self.depth + 1 > self.deepest.0 {
            self.deepest = (self.depth + 1, start);
        }
        let is_empty = end >= 2 && bytes[end - 2] == b'/' && bytes[end - 1] == b'>';
        self.depth += usize::from(!is_empty);
        end
    }

    /// Whether an attribute declares a namespace.
    fn attribute(&mut self, name: &'a str, is_root: bool) -> bool {
        let declared = if name == "xmlns" { Some("") } else { name.strip_prefix("xmlns:") };
        match declared {
            Some(prefix) => {
                self.declared.insert(prefix);
                if is_root {
                    self.declared_at_root.insert(prefix);
                }
            }
            None => self.use_prefix(name),
        }
        declared.is_some()
    }

    fn use_prefix(&mut self, name: &'a str) {
        if let Some((prefix, _)) = name.split_once(':') {
            self.used.insert(prefix);
        }
    }

    /// Notes the entities of a declaration that `rest` begins with; its length.
    fn document_type(&mut self, rest: &'a str) -> usize {
        let Some(bracket) = rest.find(['[', '>']).filter(|at| rest.as_bytes()[*at] == b'[') else {
            return after(rest, ">");
        };
        let mut at = bracket + 1;
        loop {
            let inner = &rest[at..];
            let Some(next) = inner.find(['<', ']']) else { return rest.len() };
            at += next;
            let inner = &rest[at..];
            at += if let Some(end) = inner.strip_prefix(']') {
                return at + 1 + after(end, ">");
            } else if inner.starts_with("<!--") {
                after(inner, "-->")
            } else if inner.starts_with("<?") {
                after(inner, "?>")
            } else {
                self.declaration(inner)
            };
        }
    }

    /// Notes the entity, if one is declared; the length of the declaration.
    fn declaration(&mut self, inner: &'a str) -> usize {
        let mut end = 0;
        let mut quoted: Option<&str> = None;
        while let Some(found) = inner[end..].find(['>', '"', '\'']) {
            end += found;
            let quote = inner.as_bytes()[end];
            end += 1;
            if quote == b'>' {
                break;
            }
            let value = &inner[end..];
            let length = value.find(char::from(quote)).unwrap_or(value.len());
            quoted = quoted.or(Some(&value[..length]));
            end = (end + length + 1).min(inner.len());
        }
        if end == 0 || quoted.is_none() && !inner[..end].ends_with('>') {
            end = inner.len();
        }
        let name = inner.strip_prefix("<!ENTITY").and_then(|rest| rest.split_ascii_whitespace().next());
        if let (Some(name), Some(value)) = (name, quoted) {
            self.entities.entry(name).or_insert(value);
        }
        end
    }
}

/// Where the first `end` ends; all of the text where there is none.
fn after(text: &str, end: &str) -> usize {
    text.find(end).map_or(text.len(), |at| at + end.len())
}

fn ends_name(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b'>' || byte == b'/'
}

/// Whether it can be declared: not a name that XML has for itself, nor that of macros, which are
/// told.
fn is_prefix(prefix: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    let starts = prefix.starts_with(|c: char| c.is_alphabetic() || c == '_');
    starts && prefix.chars().all(is_name) && !matches!(prefix, "xml" | "xmlns" | "xacro")
}

fn references(text: &str) -> HashMap<&str, usize> {
    let mut all = HashMap::new();
    add_references(text, &mut all);
    all
}

/// Counts what stands between `&` and `;`.
fn add_references<'a>(text: &'a str, all: &mut HashMap<&'a str, usize>) {
    let mut rest = text;
    while let Some(at) = rest.find('&') {
        rest = &rest[at + 1..];
        let end = rest.find([';', '&', '<']).unwrap_or(rest.len());
        if rest[end..].starts_with(';') && !rest.starts_with('#') {
            *all.entry(&rest[..end]).or_default() += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str, limits: &LoadLimits) -> String {
        Scan::of(text).check("f", text, limits).map_or_else(|error| error.to_string(), |()| "taken".into())
    }

    #[test]
    fn attributes_depth_and_namespaces_are_counted() {
        let limits = LoadLimits::default().with(LoadLimit::XmlAttributes, 3).with(LoadLimit::XmlDepth, 4);
        let taken = "<?xml version='1.0' a='1' b='2'?><!-- < ' > --><r><a x='1' y=\"'>\" z = '/>'/><b><![CDATA[<<<<<]]><c><d/></c></b></r>";
        assert_eq!(message(taken, &limits), "taken");
        let many = "<r>\n<a x='1' y='2' z='3' w='4'/></r>";
        assert!(message(many, &limits).starts_with("f: line 2: got 4 attributes"), "{}", message(many, &limits));
        assert!(
            message("<a><b/>\n<c><d>\n<e><f/>", &limits).starts_with("f: line 3: got 5 elements within each other")
        );
        let copied = format!("<r {}>{}", " xmlns:a='a' xmlns:b='b' xmlns:c='c'", "<x xmlns='d'/>".repeat(500_001));
        assert!(message(&copied, &limits).contains("namespaces: got 500002 elements"), "{}", message(&copied, &limits));
    }

    #[test]
    fn entities_are_counted_as_often_as_they_are_named() {
        let limits = LoadLimits::default().with(LoadLimit::EntityBytes, 1000);
        let text = |body: &str| {
            let x = "x".repeat(100);
            format!("<!DOCTYPE r [<!ENTITY % p 'q'><!-- ' --> <!ENTITY a '{x}'>\n<!ENTITY b \"&a;&a;&a;\">]>{body}")
        };
        assert_eq!(message(&text("<r n='&a;&lt;&#60;&b;'>&b; &c; & a;</r>"), &limits), "taken");
        assert!(
            message(&text(&format!("<r>{}</r>", "&a;".repeat(11))), &limits).contains("got 1100 bytes from entities")
        );
        assert!(message(&text("<r a='&b;'>&b;&b;&b;</r>"), &limits).contains("entity-bytes"));
        let circle = "<!DOCTYPE r [<!ENTITY a '&b;&b;'><!ENTITY b '&a;&a;'>]><r>&a;</r>";
        assert!(message(circle, &LoadLimits::default().with(LoadLimit::EntityBytes, 100)).contains("entity-bytes"));
        let attributes = "<!DOCTYPE r [<!ENTITY a '<x a=\"\" b=\"\" c=\"\"/>'>]><r>&a;</r>";
        assert!(
            message(attributes, &LoadLimits::default().with(LoadLimit::XmlAttributes, 2)).contains("xml-attributes")
        );
    }

    #[test]
    fn broken_texts_end() {
        for text in [
            "",
            "<",
            "<!",
            "<!--",
            "<![CDATA[",
            "<?",
            "</",
            "<a",
            "<a b",
            "<a b=",
            "<a b='",
            "<!DOCTYPE",
            "<!DOCTYPE a [",
        ] {
            assert_eq!(message(text, &LoadLimits::default()), "taken", "{text}");
        }
        for text in [
            "<!DOCTYPE a [<",
            "<!DOCTYPE a [<!ENTITY",
            "<!DOCTYPE a [<!ENTITY a '",
            "<!DOCTYPE a [<!ENTITY a ''",
            "<a &",
            "&;",
        ] {
            assert_eq!(message(text, &LoadLimits::default()), "taken", "{text}");
        }
    }

    #[test]
    fn prefixes_are_found() {
        let scan = |text: &'static str| Scan::of(text).undeclared;
        assert_eq!(scan("<r xmlns:k='k'><k:a/><s:b c:d='1' xml:space='x'/><xacro:m/></r>"), ["c", "s"]);
        assert_eq!(Scan::of("<!-- <a> --><robot n='1'/>").end_of_root_name, Some(18));
    }
}
