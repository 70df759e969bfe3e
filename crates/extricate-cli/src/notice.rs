//! Messages to the user on standard error, all in one shape: `extricate: error: ...`.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

/// Something failed.
pub fn error(message: impl Display) {
    write("error: ", message);
}

/// Something is worth knowing before the result is trusted.
pub fn warning(message: impl Display) {
    write("warning: ", message);
}

/// The command line makes no sense, or asks for help.
pub fn usage(error: &clap::Error) -> ExitCode {
    // Words of the command line may be names of files, as of a pattern.
    let text = printable(&error.render().to_string(), &['\n', '\t']).into_owned();
    let _ = match error.use_stderr() {
        true => std::io::stderr().lock().write_all(text.as_bytes()),
        false => std::io::stdout().lock().write_all(text.as_bytes()),
    };
    ExitCode::from(error.exit_code() as u8)
}

/// Where a long job stands, or what was done.
pub fn note(message: impl Display) {
    write("", message);
}

/// A closed standard error is no reason to stop. A message is one line, whatever files and their
/// names say.
fn write(severity: &str, message: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "extricate: {severity}{}", printable(&message.to_string(), &[]));
}

/// `text` without what moves the cursor, colours, or changes the order of letters: such characters,
/// but for those `left` alone, stand as a program would write them, `\u{1b}`. Opening the file of a
/// stranger cannot forge what a terminal shows.
pub fn printable<'a>(text: &'a str, left: &[char]) -> Cow<'a, str> {
    let acts = |c: char| is_acting(c) && !left.contains(&c);
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if acts(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    Cow::Owned(shown)
}

/// Controls of both sets, separators of lines, and what changes the direction of writing.
fn is_acting(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_shown() {
        for (text, shown) in [
            ("a\u{1b}[31mb", r"a\u{1b}[31mb"),
            ("a\r\nextricate: b", r"a\r\nextricate: b"),
            ("a\u{9b}31m\u{7f}", r"a\u{9b}31m\u{7f}"),
            ("exe\u{202e}cod.exe \u{2066}\u{200f}\u{2028}", r"exe\u{202e}cod.exe \u{2066}\u{200f}\u{2028}"),
        ] {
            assert_eq!(printable(text, &[]), shown);
        }
        let plain = "schr\u{e4}g \u{5d0}\u{1f600} \"it's\"";
        assert!(matches!(printable(plain, &[]), Cow::Borrowed(same) if same == plain));
        assert_eq!(printable("a\n\tb\r", &['\n', '\t']), "a\n\tb\\r");
    }
}
