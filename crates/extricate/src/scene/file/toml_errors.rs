//! Translates errors of `toml` and `serde` into words of the format.

use crate::error::Error;

/// Converts an error of `toml` for `text`; adds line, column and the text there.
pub fn explain(file: &str, text: &str, error: &toml::de::Error) -> Error {
    let element = match error.span() {
        Some(span) => place(text, span.start),
        None => "scene".into(),
    };
    Error::input(file, element, in_toml_words(error.message().trim()))
}

/// Largest part of a line that a message quotes \[characters\].
const MAX_QUOTED_CHARS: usize = 60;

fn place(text: &str, at: usize) -> String {
    let at = at.min(text.len());
    let before = &text.as_bytes()[..at];
    let number = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
    let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
    let column = at - start + 1;
    let line = String::from_utf8_lossy(&text.as_bytes()[start..]);
    let line = line.lines().next().unwrap_or("").trim();
    let printed = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    let quoted: String = line.chars().take(MAX_QUOTED_CHARS).map(printed).collect();
    let cut = if line.chars().nth(MAX_QUOTED_CHARS).is_some() { ".." } else { "" };
    format!("line {number}, column {column} (`{quoted}{cut}`)")
}

/// Replaces the names of Rust's types, which `serde` uses, by those of TOML.
fn in_toml_words(message: &str) -> String {
    let mut words = message.to_string();
    for (from, to) in [
        ("invalid type: map", "got a table"),
        ("invalid type: sequence", "got an array"),
        ("invalid type: ", "got "),
        ("invalid value: ", "got "),
        ("unknown field ", "got the unknown key "),
        ("unknown variant ", "got "),
        ("expected f64", "expected a number"),
        ("expected a map", "expected a table"),
        ("expected a sequence", "expected an array"),
    ] {
        words = words.replace(from, to);
    }
    match words.strip_prefix("missing field ") {
        Some(key) => format!("got no key {key}, expected it"),
        None => words,
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::file::parse;

    #[test]
    fn messages_quote_the_line_and_know_no_rust() {
        let message = |text: &str| parse("s.toml", text).unwrap_err().to_string();
        assert_eq!(
            message("# scene\nclearance = 'x'"),
            "s.toml: line 2, column 13 (`clearance = 'x'`): got string \"x\", expected a number, or a table `{ world = .., self = .. }`"
        );
        let robot = |line: &str| message(&format!("[[robot]]\nurdf = 'a'\n{line}"));
        assert!(robot("locked = ['a']").ends_with("got an array, expected a table"), "{}", robot("locked = ['a']"));
        assert!(robot("pose = 3").contains("got integer `3`, expected a table `{ xyz = [..], rpy = [..] }`"));
        assert!(robot("packages = '.'").ends_with("expected an array"));
        assert!(message("metric = 'joint'").contains("expected a table `{ kind = .., weights = .. }`"));
        assert!(message("[robot]\nurdf = 'a'").contains("(`[robot]`): got a table, expected an array"));
        assert!(message("[[robot]]\nname = 'a'").contains("got no key `urdf`, expected it"));
        assert!(message(&format!("x = '{}'", "y".repeat(1000))).len() < 250);
        assert!(message("a = \u{1}").contains("`a = \\u{1}`"));
    }
}
