//! Reading of XML attributes with messages that say where, what and what instead. Knows no format.

use std::borrow::Cow;

use encoding_rs::Encoding;
use roxmltree::{Document, Node, ParsingOptions};

use super::xml_scan::Scan;
use crate::error::{Error, Result, quoted};
use crate::math::FARTHEST;
use crate::robot::{LoadLimit, LoadLimits};

/// Parses a document; `what` names the format in the message.
pub(crate) fn document<'a>(file: &str, text: &'a str, what: &str, limits: &LoadLimits) -> Result<Document<'a>> {
    Scan::of(text).check(file, text, limits)?;
    let nodes_limit = u32::try_from(limits.get(LoadLimit::XmlNodes)).unwrap_or(u32::MAX);
    let options = ParsingOptions { allow_dtd: true, nodes_limit, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::UnknownNamespace(prefix, position) if prefix == "xacro" => {
            Error::input(file, format!("line {}", position.row), NEEDS_XACRO)
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
    })
}

/// The text of an XML file in the encoding that its byte order mark or its first line declares;
/// else in UTF-8, where bytes that are none become replacement characters (in comments they do not
/// matter; in names and numbers they are met later).
pub fn decoded(bytes: &[u8]) -> String {
    let first = bytes.split(|&byte| byte == b'>').next().unwrap_or_default();
    let first = String::from_utf8_lossy(first);
    let label = first.trim_start().strip_prefix("<?xml").and_then(|line| line.split_once("encoding"));
    let label = label.and_then(|(_, rest)| rest.trim_start_matches([' ', '=', '\t']).split(['"', '\'']).nth(1));
    // A first line that could be read byte by byte is not in UTF-16, whatever it says.
    let declared = label.and_then(|label| Encoding::for_label(label.as_bytes())).unwrap_or(encoding_rs::UTF_8);
    declared.output_encoding().decode(bytes).0.into_owned()
}

/// What a ROS `package.xml` calls its package.
pub fn package_name(text: &str) -> Option<String> {
    let document = document("package.xml", text, "a package", &LoadLimits::default()).ok()?;
    Some(child(document.root_element(), "name")?.text()?.trim().to_owned())
}

/// The namespace of prefixes that a file does not declare.
const UNDECLARED: &str = "undeclared";

/// `text` with the namespaces declared that it uses without: readers that know no namespaces take
/// such files, and simulators' extensions are full of them. Macros are left for [`document`] to
/// refuse.
pub(crate) fn with_declared_prefixes(text: &str) -> Cow<'_, str> {
    let scan = Scan::of(text);
    let Some(end) = scan.end_of_root_name.filter(|_| !scan.undeclared.is_empty()) else { return Cow::Borrowed(text) };
    let declarations = scan.undeclared.iter().take(MOST_PREFIXES);
    let declarations: String = declarations.map(|prefix| format!(" xmlns:{prefix}=\"{UNDECLARED}\"")).collect();
    Cow::Owned([&text[..end], &declarations, &text[end..]].concat())
}

/// More prefixes than this in one file are not declared.
const MOST_PREFIXES: usize = 64;

/// What to say about a macro that is not expanded.
pub(crate) const NEEDS_XACRO: &str = "got a xacro macro, expected plain URDF: expand it first, with `xacro robot.urdf.xacro > robot.urdf`, or in Python with \
     `extricate.Robot.from_xacro(path)`";

/// `<joint> "elbow"` for messages: tag, name where there is one, line otherwise.
pub(crate) fn label(node: Node) -> String {
    let tag = node.tag_name().name();
    match own_attribute(node, "name").or_else(|| own_attribute(node, "id")) {
        Some(name) => format!("{tag} \"{}\"", quoted(name)),
        None => format!("<{}> in line {}", quoted(tag), node.document().text_pos_at(node.range().start).row),
    }
}

/// An attribute of an element, if it has one of this name without a prefix; those with one are
/// extensions.
pub(crate) fn own_attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attributes().find(|attribute| attribute.namespace().is_none() && attribute.name() == name).map(|a| a.value())
}

/// Child elements, whatever their namespace, if the file declares it.
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

/// The value of an attribute that must be there; `element` names the place in the message.
pub(crate) fn required<'a>(file: &str, element: &str, node: Node<'a, '_>, attribute: &str) -> Result<&'a str> {
    own_attribute(node, attribute).ok_or_else(|| {
        let tag = node.tag_name().name();
        Error::input(file, element, format!("got <{tag}> without the attribute `{attribute}`, expected one"))
    })
}

/// `N` numbers within 1e9, separated by blanks, from the text `value` of `name`.
pub(crate) fn numbers<const N: usize>(file: &str, element: &str, name: &str, value: &str) -> Result<[f64; N]> {
    numbers_within(FARTHEST, file, element, name, value)
}

/// `N` finite numbers of size `most` at most.
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

/// `N` finite numbers from an attribute, or `default` where it is missing.
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
        // Undeclared bytes in a comment.
        assert!(document("a", &decoded(b"<!-- 90\xb0 --><r/>"), "URDF", &LoadLimits::default()).is_ok());
        assert_eq!(decoded(b"\xef\xbb\xbf<r/>"), "<r/>");
    }

    #[test]
    fn prefixes_may_be_undeclared() {
        let text = "<?xml version='1.0'?>\n<!-- <a> -->\n<!DOCTYPE robot [<!ENTITY e '<x/>'>]>\n<robot xmlns:k='known'>\n\
            <k:link/><s:link b:c='1'/><link d:name='no' name='yes'/></robot>";
        let declared = with_declared_prefixes(text);
        let parsed = document("a.urdf", &declared, "URDF", &LoadLimits::default()).unwrap();
        let links: Vec<_> = children(parsed.root_element(), "link").map(|link| own_attribute(link, "name")).collect();
        assert_eq!(links, [None, Some("yes")], "those of the file's own namespaces count");
        assert_eq!(declared.lines().count(), text.lines().count());
        assert!(matches!(with_declared_prefixes("<robot xmlns:k='k'><k:a/></robot>"), Cow::Borrowed(_)));
        assert!(
            document("a", &with_declared_prefixes("<robot><xacro:a/></robot>"), "URDF", &LoadLimits::default())
                .is_err()
        );
        for broken in ["", "<", "<!--", "<a:b", "<a:b/>", "<!DOCTYPE [", "<a x:y='1'", "text"] {
            with_declared_prefixes(broken);
        }
        assert!(document("a", &with_declared_prefixes("<a:b/>"), "URDF", &LoadLimits::default()).is_ok());
    }

    #[test]
    fn broken_documents_name_the_line() {
        let error =
            document("a.urdf", "<robot>\n<link>\n</robot>", "URDF", &LoadLimits::default()).unwrap_err().to_string();
        assert!(error.starts_with("a.urdf: line 3: got text that is not XML"), "{error}");
    }
}
