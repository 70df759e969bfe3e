//! Reading of XML attributes with messages that say where, what and what instead. Knows no format.

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::{Error, Result};
use crate::math::FARTHEST;

/// Parses a document; `what` names the format in the message.
pub(super) fn document<'a>(file: &str, text: &'a str, what: &str) -> Result<Document<'a>> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::UnknownNamespace(prefix, position) if prefix == "xacro" => {
            Error::input(file, format!("line {}", position.row), NEEDS_XACRO)
        }
        error => Error::input(
            file,
            format!("line {}", error.pos().row),
            format!("got text that is not XML ({error}), expected {what}"),
        ),
    })
}

/// What to say about a macro that is not expanded.
pub(super) const NEEDS_XACRO: &str =
    "got a xacro macro, expected plain URDF: expand it first, with `xacro robot.urdf.xacro > robot.urdf`";

/// `<joint> "elbow"` for messages: tag, name where there is one, line otherwise.
pub(super) fn label(node: Node) -> String {
    let tag = node.tag_name().name();
    match node.attribute("name").or_else(|| node.attribute("id")) {
        Some(name) => format!("{tag} \"{name}\""),
        None => format!("<{tag}> in line {}", node.document().text_pos_at(node.range().start).row),
    }
}

/// Child elements with this tag, whatever their namespace.
pub(super) fn children<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == tag)
}

/// The first child element with this tag.
pub(super) fn child<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// The value of an attribute that must be there; `element` names the place in the message.
pub(super) fn required<'a>(file: &str, element: &str, node: Node<'a, '_>, attribute: &str) -> Result<&'a str> {
    node.attribute(attribute).ok_or_else(|| {
        let tag = node.tag_name().name();
        Error::input(file, element, format!("got <{tag}> without the attribute `{attribute}`, expected one"))
    })
}

/// `N` numbers within 1e9, separated by blanks, from the text `value` of `name`.
pub(super) fn numbers<const N: usize>(file: &str, element: &str, name: &str, value: &str) -> Result<[f64; N]> {
    numbers_within(FARTHEST, file, element, name, value)
}

/// `N` finite numbers of size `most` at most.
pub(super) fn numbers_within<const N: usize>(
    most: f64,
    file: &str,
    element: &str,
    name: &str,
    value: &str,
) -> Result<[f64; N]> {
    let error = |within: &str| {
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
pub(super) fn numbers_or<const N: usize>(
    file: &str,
    element: &str,
    node: Option<Node>,
    attribute: &str,
    default: [f64; N],
) -> Result<[f64; N]> {
    match node.and_then(|node| node.attribute(attribute)) {
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
    fn broken_documents_name_the_line() {
        let error = document("a.urdf", "<robot>\n<link>\n</robot>", "URDF").unwrap_err().to_string();
        assert!(error.starts_with("a.urdf: line 3: got text that is not XML"), "{error}");
    }
}
