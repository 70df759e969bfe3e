//! Reports each kind of message about lines once: a file may have twenty thousand bad lines, and
//! users need to know the fault, not every line.

use std::collections::HashMap;

use crate::report::count;

/// Largest number of kinds of messages that are reported.
const MAX_KINDS: usize = 8;
/// Largest number of lines that are listed for a kind.
const MAX_LINES: usize = 5;

/// Messages so far.
#[derive(Default)]
pub struct Repeated {
    /// Index into `kinds` of each kind of message, by the words that its messages share.
    index: HashMap<String, usize>,
    kinds: Vec<Kind>,
    /// Number of messages of other kinds, which are not kept.
    others: usize,
}

struct Kind {
    /// The line whose message was printed.
    first: usize,
    /// Some later lines with the same message, which were not printed.
    lines: Vec<usize>,
    more: usize,
}

impl Repeated {
    /// Counts a message, and returns whether to report it now.
    pub fn is_new(&mut self, line: usize, message: &str) -> bool {
        let of = common(message);
        if let Some(kind) = self.index.get(&of).map(|at| &mut self.kinds[*at]) {
            kind.more += 1;
            if kind.lines.len() < MAX_LINES {
                kind.lines.push(line);
            }
            return false;
        }
        if self.kinds.len() == MAX_KINDS {
            self.others += 1;
            return false;
        }
        self.index.insert(of, self.kinds.len());
        self.kinds.push(Kind { first: line, lines: Vec::new(), more: 0 });
        true
    }

    /// Describes the messages that were counted but not reported.
    pub fn in_words(&self) -> Vec<String> {
        let mut words: Vec<String> = self.kinds.iter().filter(|kind| kind.more > 0).map(Kind::in_words).collect();
        if self.others > 0 {
            words.push(format!("and {} more that are none of these", count(self.others)));
        }
        words
    }
}

impl Kind {
    fn in_words(&self) -> String {
        let Self { first, lines, more } = self;
        let named: Vec<String> = lines.iter().map(usize::to_string).collect();
        let rest = if *more > lines.len() { ", .." } else { "" };
        let word = if *more == 1 { "line" } else { "lines" };
        format!("line {first}: and {} more like it: {word} {}{rest}", count(*more), named.join(", "))
    }
}

/// Returns what messages about different values share: everything but the value and numbers.
fn common(message: &str) -> String {
    let found = message.find("got ").zip(message.rfind(", expected"));
    let text = match found {
        // Text in brackets is a hint about the value.
        Some((from, to)) if from < to => {
            let expected = message[to..].split(" (").next().unwrap_or_default();
            format!("{}{expected}", &message[..from])
        }
        _ => message.to_string(),
    };
    text.chars().filter(|c| !c.is_ascii_digit()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_told_once_and_counted() {
        let mut repeated = Repeated::default();
        let message = |value: usize| format!("configuration: `a`: got {value}, expected a value within [0, 1]");
        assert!(repeated.is_new(1, &message(7)));
        assert!(!repeated.is_new(3, &message(88)));
        assert!(repeated.is_new(4, "not JSON (column 3), got {, expected an array"));
        assert_eq!(repeated.in_words(), ["line 1: and 1 more like it: line 3"]);
        (5..5000).for_each(|line| assert!(!repeated.is_new(line, &message(line))));
        assert_eq!(repeated.in_words(), ["line 1: and 4,996 more like it: lines 3, 5, 6, 7, 8, .."]);
        for kind in ["b", "c", "d", "g", "h", "i"] {
            assert!(repeated.is_new(9, kind));
        }
        assert!(!repeated.is_new(9, "e") && !repeated.is_new(9, "f"));
        assert_eq!(repeated.in_words()[1..], ["and 2 more that are none of these"]);
    }
}
