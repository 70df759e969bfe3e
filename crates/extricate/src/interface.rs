//! What every public type of a kind has: setters of options, and words of choices.

/// Gives structs a method for each field that sets it and gives the whole back. A struct that may
/// get more fields cannot be written out elsewhere.
macro_rules! setters {
    ($($options:ident { $($field:ident: $kind:ty $(= $some:ident)?),+ $(,)? })+) => {$(
        impl $options {$(
            #[doc = concat!("Sets [`", stringify!($options), "::", stringify!($field), "`](Self#structfield.", stringify!($field), ").")]
            #[must_use]
            pub fn $field(mut self, $field: $kind) -> Self {
                self.$field = $($some)?($field);
                self
            }
        )+}
    )+};
}

/// Gives an enum the words that it is written as: `name`, `ALL`, `Display`, and `FromStr`, which
/// refuses any other word.
macro_rules! words {
    ($choice:ident as $option:literal { $($variant:ident = $word:literal),+ $(,)? }) => {
        impl $choice {
            /// All variants, in the order in which they are declared.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The word that files, the command line and the other languages have for it.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word),+
                }
            }
        }

        impl std::fmt::Display for $choice {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $choice {
            type Err = crate::error::Error;

            fn from_str(word: &str) -> crate::error::Result<Self> {
                let found = Self::ALL.iter().find(|known| known.name() == word);
                found.copied().ok_or_else(|| crate::error::Error::Option {
                    name: $option,
                    value: format!("\"{word}\""),
                    expected: crate::interface::one_of(&[$($word),+]),
                })
            }
        }
    };
}

pub(crate) use {setters, words};

/// The words of a choice, as an error lists them.
pub fn one_of(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}
