//! Reads XML and its attributes; messages say the place, what was found and what was expected.
//! Knows no format.

use std::borrow::Cow;
use std::collections::HashSet;

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::{Error, Result, quoted};
use crate::math::FARTHEST;
use crate::robot::{LoadLimit, LoadLimits};

/// Largest number of namespaces that the parser may copy: each element that declares one gets all
/// that are in scope.
const MAX_NAMESPACE_COPIES: usize = 2_000_000;

/// Parses a document; `what` names the format in the message.
pub(crate) fn document<'a>(file: &str, text: &'a str, what: &str, limits: &LoadLimits) -> Result<Document<'a>> {
    check_before(file, text, limits)?;
    let document = parsed(text, limits).map_err(|error| match error {
        roxmltree::Error::UnknownNamespace(prefix, position) if prefix == "xacro" => {
            Error::input(file, format!("line {}", position.row), NEEDS_XACRO)
        }
        roxmltree::Error::DtdDetected => {
            let problem = "got a declaration of XML entities, expected XML without: write in their place what they are";
            Error::input(file, "document type", problem)
        }
        roxmltree::Error::NodesLimitReached => {
            let found = limits.get(LoadLimit::XmlNodes).saturating_add(1);
            Error::input(file, "elements", limits.exceeded(LoadLimit::XmlNodes, found))
        }
        error => Error::input(
            file,
            format!("line {}", error.pos().row),
            format!("got text that is not XML ({}), expected {what}", quoted(&error.to_string())),
        ),
    })?;
    check_depth(file, &document, limits)?;
    Ok(document)
}

fn parsed<'a>(text: &'a str, limits: &LoadLimits) -> std::result::Result<Document<'a>, roxmltree::Error> {
    let nodes_limit = u32::try_from(limits.get(LoadLimit::XmlNodes)).unwrap_or(u32::MAX);
    // Entities would be parsed as often as they are named.
    let allow_dtd = !text.contains("<!ENTITY");
    Document::parse_with_options(text, ParsingOptions { allow_dtd, nodes_limit, ..ParsingOptions::default() })
}

/// Refuses text for which the parser's time or memory grows with a square: it compares every
/// attribute of an element with all others, and copies namespaces from element to element.
fn check_before(file: &str, text: &str, limits: &LoadLimits) -> Result<()> {
    let mut line = 1;
    // No attribute contains `<`; comments and declarations begin with `!` or `?`.
    for piece in text.split('<') {
        if !piece.starts_with(['!', '?']) {
            let attributes = attributes_in(piece);
            if attributes > limits.get(LoadLimit::XmlAttributes) {
                let problem = limits.exceeded(LoadLimit::XmlAttributes, attributes);
                return Err(Error::input(file, format!("line {line}"), problem));
            }
        }
        line += piece.bytes().filter(|&byte| byte == b'\n').count();
    }
    let declared = || text.split("xmlns").skip(1);
    let names: HashSet<&str> = declared().filter_map(|rest| rest.split('=').next()).collect();
    let count = declared().count();
    if count.saturating_mul(names.len()) > MAX_NAMESPACE_COPIES {
        let problem = format!(
            "got {count} declarations of {}, expected less than {MAX_NAMESPACE_COPIES} pairs of both",
            names.len()
        );
        return Err(Error::input(file, "namespaces", problem));
    }
    Ok(())
}

/// Counts the attributes of the tag that begins a piece of text between two `<`: its quoted values.
fn attributes_in(piece: &str) -> usize {
    let (mut quote, mut count) = (None, 0);
    for byte in piece.bytes() {
        match quote {
            Some(open) if byte == open => quote = None,
            Some(_) => {}
            None if byte == b'"' || byte == b'\'' => (quote, count) = (Some(byte), count + 1),
            None if byte == b'>' => break,
            None => {}
        }
    }
    count
}

fn check_depth(file: &str, document: &Document, limits: &LoadLimits) -> Result<()> {
    let most = limits.get(LoadLimit::XmlDepth);
    // Parents come before their children.
    let mut depths: Vec<usize> = Vec::new();
    for node in document.descendants() {
        let depth = node.parent().map_or(0, |parent| depths[parent.id().get_usize()] + 1);
        if depth > most && node.is_element() {
            let line = format!("line {}", document.text_pos_at(node.range().start).row);
            return Err(Error::input(file, line, limits.exceeded(LoadLimit::XmlDepth, depth)));
        }
        depths.push(depth);
    }
    Ok(())
}

/// Decodes an XML file by its byte order mark or the encoding that its first line declares, else as
/// UTF-8. Invalid bytes become replacement characters: they do not matter in comments, and names
/// and numbers are checked later.
pub fn decoded(bytes: &[u8]) -> String {
    let first = bytes.split(|&byte| byte == b'>').next().unwrap_or_default();
    let first = String::from_utf8_lossy(first);
    let label = first.trim_start().strip_prefix("<?xml").and_then(|line| line.split_once("encoding"));
    let label = label.and_then(|(_, rest)| rest.trim_start_matches([' ', '=', '\t']).split(['"', '\'']).nth(1));
    in_encoding(label, bytes)
}

#[cfg(feature = "meshes")]
fn in_encoding(label: Option<&str>, bytes: &[u8]) -> String {
    // A first line that could be read byte by byte is not in UTF-16, whatever it says.
    let declared = label.and_then(|label| encoding_rs::Encoding::for_label(label.as_bytes()));
    declared.unwrap_or(encoding_rs::UTF_8).output_encoding().decode(bytes).0.into_owned()
}

#[cfg(not(feature = "meshes"))]
fn in_encoding(_: Option<&str>, bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).into_owned()
}

/// Returns the name of the package in a ROS `package.xml`.
pub fn package_name(text: &str) -> Option<String> {
    let document = document("package.xml", text, "a package", &LoadLimits::default()).ok()?;
    Some(child(document.root_element(), "name")?.text()?.trim().to_owned())
}

/// The namespace of prefixes that a file does not declare.
const UNDECLARED: &str = "undeclared";

/// Declares the namespaces that `text` uses without a declaration. Readers that know no namespaces
/// take such files, and simulators' extensions are full of them. Other faults, also macros, are
/// left for [`document`] to report.
///
/// # Errors
/// Text that exceeds the limits.
pub(crate) fn with_declared_prefixes<'a>(file: &str, text: &'a str, limits: &LoadLimits) -> Result<Cow<'a, str>> {
    check_before(file, text, limits)?;
    let (mut declared, mut known) = (Cow::Borrowed(text), HashSet::new());
    let Some(end) = end_of_root_name(text) else { return Ok(declared) };
    while known.len() < MAX_PREFIXES {
        let Err(roxmltree::Error::UnknownNamespace(prefix, _)) = parsed(&declared, limits) else { break };
        if prefix == "xacro" || known.contains(&prefix) {
            break;
        }
        // The parser reports one at a time, so those of elements are declared with the first.
        let of_elements = if known.is_empty() { undeclared_prefixes(text) } else { Vec::new() };
        for prefix in of_elements.into_iter().chain([prefix]) {
            if known.len() < MAX_PREFIXES && known.insert(prefix.clone()) {
                declared.to_mut().insert_str(end, &format!(" xmlns:{prefix}=\"{UNDECLARED}\""));
            }
        }
    }
    Ok(declared)
}

/// Largest number of prefixes to declare in one file.
const MAX_PREFIXES: usize = 128;

/// Finds the prefixes of element names that seem to be declared nowhere, in order.
fn undeclared_prefixes(text: &str) -> Vec<String> {
    let names =
        text.split('<').skip(1).map(|piece| piece.split([' ', '\t', '\r', '\n', '/', '>']).next().unwrap_or(""));
    let mut prefixes: Vec<&str> = Vec::new();
    let mut seen = HashSet::new();
    for (prefix, _) in names.filter_map(|name| name.split_once(':')) {
        let is_name = prefix.starts_with(char::is_alphabetic)
            && prefix.chars().all(|c| c.is_alphanumeric() || ['_', '-', '.'].contains(&c));
        let is_ours = is_name && !["xacro", "xml", "xmlns"].contains(&prefix);
        if is_ours && prefixes.len() < MAX_PREFIXES && seen.insert(prefix) {
            prefixes.push(prefix);
        }
    }
    prefixes.retain(|prefix| !text.contains(&format!("xmlns:{prefix}")));
    prefixes.into_iter().map(String::from).collect()
}

/// Returns the position at which the name of the first element ends.
fn end_of_root_name(text: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        at += match rest.as_bytes().get(1)? {
            b'?' => rest.find("?>")?,
            b'!' if rest.starts_with("<!--") => rest.find("-->")?,
            // Declarations within brackets begin with `<` again.
            b'!' => 2,
            _ => return Some(at + rest.find(|c: char| c.is_ascii_whitespace() || matches!(c, '>' | '/'))?),
        };
    }
}

/// Message about a macro that is not expanded.
pub(crate) const NEEDS_XACRO: &str = "got a xacro macro, expected plain URDF: expand it first, with `xacro robot.urdf.xacro > robot.urdf`, or in Python with \
     `extricate.Robot.from_xacro(path)`";

/// Labels an element in messages: `joint "elbow"` if it has a name or id, else `<joint> in line 3`.
pub(crate) fn label(node: Node) -> String {
    let tag = node.tag_name().name();
    match own_attribute(node, "name").or_else(|| own_attribute(node, "id")) {
        Some(name) => format!("{tag} \"{}\"", quoted(name)),
        None => format!("<{}> in line {}", quoted(tag), node.document().text_pos_at(node.range().start).row),
    }
}

/// Returns the attribute of this name without a prefix; those with one are extensions.
pub(crate) fn own_attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attributes().find(|attribute| attribute.namespace().is_none() && attribute.name() == name).map(|a| a.value())
}

/// Child elements, except those of a namespace that the file does not declare.
pub(crate) fn elements<'a, 'i: 'a>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(|child| child.is_element() && child.tag_name().namespace() != Some(UNDECLARED))
}

/// Child elements with this tag.
pub(crate) fn children<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    elements(node).filter(move |child| child.tag_name().name() == tag)
}

/// The first child element with this tag.
pub(crate) fn child<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Returns the value of an attribute, which has to exist; `element` names the place in the message.
pub(crate) fn required<'a>(file: &str, element: &str, node: Node<'a, '_>, attribute: &str) -> Result<&'a str> {
    own_attribute(node, attribute).ok_or_else(|| {
        let tag = node.tag_name().name();
        Error::input(file, element, format!("got <{tag}> without the attribute `{attribute}`, expected one"))
    })
}

/// Parses `N` numbers within 1e9, separated by blanks, from `value`; `name` is that of the
/// attribute.
pub(crate) fn numbers<const N: usize>(file: &str, element: &str, name: &str, value: &str) -> Result<[f64; N]> {
    numbers_within(FARTHEST, file, element, name, value)
}

/// As [`numbers`], but within `most`.
pub(crate) fn numbers_within<const N: usize>(
    most: f64,
    file: &str,
    element: &str,
    name: &str,
    value: &str,
) -> Result<[f64; N]> {
    let error = |within: &str| {
        let value = quoted(value);
        if value.contains("${") || value.contains("$(") {
            return Error::input(file, element, format!("{name}=\"{value}\": {NEEDS_XACRO}"));
        }
        let expected = if N == 1 { "a finite number".into() } else { format!("{N} finite numbers") };
        Error::input(file, element, format!("got {name}=\"{value}\", expected {expected}{within}"))
    };
    let mut words = value.split_whitespace();
    let mut out = [0.0; N];
    for slot in &mut out {
        let word = words.next().and_then(|word| word.parse().ok()).filter(|x: &f64| x.is_finite());
        *slot = word.ok_or_else(|| error(""))?;
    }
    if words.next().is_some() {
        return Err(error(""));
    }
    if out.iter().any(|x| x.abs() > most) {
        return Err(error(&format!(" within {most:e}")));
    }
    Ok(out)
}

/// Returns the `N` finite numbers of an attribute, or `default` if it is missing.
pub(crate) fn numbers_or<const N: usize>(
    file: &str,
    element: &str,
    node: Option<Node>,
    attribute: &str,
    default: [f64; N],
) -> Result<[f64; N]> {
    match node.and_then(|node| own_attribute(node, attribute)) {
        Some(value) => numbers(file, element, attribute, value),
        None => Ok(default),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_counted_and_finite() {
        let message = |value| numbers::<3>("f", "e", "xyz", value).unwrap_err().to_string();
        assert_eq!(numbers::<3>("f", "e", "xyz", " 1 -2e-1\t.5 ").unwrap(), [1.0, -0.2, 0.5]);
        for bad in ["1 2", "1 2 3 4", "1 x 3", "1 nan 3", "1 inf 3", ""] {
            assert_eq!(message(bad), format!("f: e: got xyz=\"{bad}\", expected 3 finite numbers"));
        }
        assert_eq!(message("1 2e9 3"), "f: e: got xyz=\"1 2e9 3\", expected 3 finite numbers within 1e9");
        assert!(message("${x} 0 0").contains("xacro"));
    }

    #[test]
    fn encodings_are_those_that_files_declare() {
        let text =
            |encoding: &str| format!("<?xml version='1.0' encoding = \"{encoding}\"?><!-- 90\u{b0} \u{20ac} --><r/>");
        let latin = |text: String| -> Vec<u8> {
            text.chars().map(|c| if c == '\u{20ac}' { 0x80 } else { u8::try_from(u32::from(c)).unwrap() }).collect()
        };
        for encoding in ["ISO-8859-1", "windows-1252"] {
            assert_eq!(decoded(&latin(text(encoding))), text(encoding));
        }
        for encoding in ["UTF-8", "utf-8", "unheard-of", "UTF-16"] {
            assert_eq!(decoded(text(encoding).as_bytes()), text(encoding));
        }
        let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            format!("\u{feff}{}", text("UTF-16")).encode_utf16().flat_map(order).collect()
        };
        assert_eq!(decoded(&wide(u16::to_le_bytes)), text("UTF-16"));
        assert_eq!(decoded(&wide(u16::to_be_bytes)), text("UTF-16"));
        // Bytes that are not UTF-8 do no harm in a comment.
        assert!(document("a", &decoded(b"<!-- 90\xb0 --><r/>"), "URDF", &LoadLimits::default()).is_ok());
        assert_eq!(decoded(b"\xef\xbb\xbf<r/>"), "<r/>");
    }

    fn declared(text: &str) -> Cow<'_, str> {
        with_declared_prefixes("a", text, &LoadLimits::default()).unwrap()
    }

    #[test]
    fn prefixes_may_be_undeclared() {
        let text = "<?xml version='1.0'?>\n<!-- <a> -->\n<!DOCTYPE robot [<!ELEMENT robot ANY><?p <q> ?><!-- <b> -->]>\n\
            <robot xmlns:k='known'>\n<k:link/><s:link b:c='1'/><link d:name='no' name='yes'/></robot>";
        let with = declared(text);
        let parsed = document("a.urdf", &with, "URDF", &LoadLimits::default()).unwrap();
        let links: Vec<_> = children(parsed.root_element(), "link").map(|link| own_attribute(link, "name")).collect();
        assert_eq!(links, [None, Some("yes")], "those of the file's own namespaces count");
        assert_eq!(with.lines().count(), text.lines().count());
        assert!(matches!(declared("<robot xmlns:k='k'><k:a/></robot>"), Cow::Borrowed(_)));
        assert!(document("a", &declared("<robot><xacro:a/></robot>"), "URDF", &LoadLimits::default()).is_err());
        for broken in ["", "<", "<!--", "<a:b", "<a:b/>", "<!DOCTYPE [", "<a x:y='1'", "text", "<xmlns:a/>"] {
            declared(broken);
        }
        assert!(document("a", &declared("<a:b/>"), "URDF", &LoadLimits::default()).is_ok());
        let many: String = (0..MAX_PREFIXES + 1).map(|k| format!("<p{k}:a/>")).collect();
        assert!(document("a", &declared(&format!("<r>{many}</r>")), "URDF", &LoadLimits::default()).is_err());
    }

    #[test]
    fn attributes_depth_namespaces_and_entities_are_limited() {
        let limits = LoadLimits::default().with(LoadLimit::XmlAttributes, 3).with(LoadLimit::XmlDepth, 4);
        let message =
            |text: &str| document("f", text, "XML", &limits).map_or_else(|error| error.to_string(), |_| "taken".into());
        let taken = "<?xml version='1.0'?><!-- a='' b='' c='' d='' --><r><a x='1' y=\"'>\" z = '='/><b><![CDATA[<<<<<]]>\
            <c><d/></c></b></r>";
        assert_eq!(message(taken), "taken");
        for many in ["<r>\n<a x='1' y='2' z =\n\"\" w= '4'/></r>", "<r>\n<a x='>' y='>' z='>' w='>'/></r>"] {
            assert!(message(many).starts_with("f: line 2: got 4 attributes"), "{}", message(many));
        }
        let deep = message("<a><b/>\n<c><d>\n<e/></d></c></a>");
        assert_eq!(deep, "taken");
        let deep = message("<a><b/>\n<c><d>\n<e><f/></e></d></c></a>");
        assert!(deep.starts_with("f: line 3: got 5 elements within each other"), "{deep}");
        let copied = format!("<r {}>{}</r>", " xmlns:a='a' xmlns:b='b' xmlns:c='c'", "<x xmlns='d'/>".repeat(500_001));
        let copied = message(&copied);
        assert!(copied.contains("namespaces: got 500004 declarations of 4"), "{copied}");
        let entity = message("<!DOCTYPE r [<!ENTITY e 'x'>]><r/>");
        assert!(entity.contains("document type: got a declaration of XML entities"), "{entity}");
        assert_eq!(message("<!DOCTYPE r SYSTEM 'r.dtd'><r/>"), "taken");
    }

    #[test]
    fn broken_documents_name_the_line() {
        let error =
            document("a.urdf", "<robot>\n<link>\n</robot>", "URDF", &LoadLimits::default()).unwrap_err().to_string();
        assert!(error.starts_with("a.urdf: line 3: got text that is not XML"), "{error}");
    }
}
