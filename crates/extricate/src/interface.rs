//! Macros for what public types have in common: setters of options, and words of choices.

/// Gives structs a method for each field that sets it and returns the struct. Other crates need it,
/// since they cannot construct a `non_exhaustive` struct.
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

            /// Returns the word that files, the command line and the other languages use.
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

/// Joins the words of a choice as an error lists them.
pub fn one_of(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}
