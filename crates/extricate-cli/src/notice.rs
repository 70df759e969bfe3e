//! Prints messages to the user on standard error, all in one form: `extricate: error: ...`.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

pub fn error(message: impl Display) {
    write("error: ", message);
}

/// Prints something to know before the result is trusted.
pub fn warning(message: impl Display) {
    write("warning: ", message);
}

/// Prints help or a fault of the command line, and returns the exit code.
pub fn usage(error: &clap::Error) -> ExitCode {
    // Words of the command line may be names of files, for example from a pattern.
    let text = printable(&error.render().to_string(), &['\n', '\t']).into_owned();
    let _ = match error.use_stderr() {
        true => std::io::stderr().lock().write_all(text.as_bytes()),
        false => std::io::stdout().lock().write_all(text.as_bytes()),
    };
    ExitCode::from(error.exit_code() as u8)
}

/// Prints the state of a long job, or its result.
pub fn note(message: impl Display) {
    write("", message);
}

/// Prints a message as one line, whatever names of files it quotes. A closed standard error is no
/// reason to stop.
fn write(severity: &str, message: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "extricate: {severity}{}", printable(&message.to_string(), &[]));
}

/// Escapes characters of `text` that move the cursor, colour, or change the order of letters,
/// except those in `left`; `\u{1b}` is an example. So a stranger's file cannot forge what a
/// terminal shows.
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

/// Whether a character is a control, separates lines, or changes the direction of writing.
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
