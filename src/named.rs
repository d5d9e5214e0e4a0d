//! Enums whose values have names, in files and on the command line alike.

use crate::error::Error;

/// The error for a name of which there is none among the choices.
pub(crate) fn unknown_name(what: &str, name: &str, choices: &[&str]) -> Error {
    Error::usage(format!("unknown {what} {name}: choose one of {}", choices.join(", ")))
}

/// The name that is meant by one that is none of them, where it is likely a slip of the pen: two letters, whatever their
/// case, or one of a short name, which is near to many.
pub(crate) fn did_you_mean<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const SHORT: usize = 4;
    const SLIPS: usize = 2;
    let meant = name.to_lowercase();
    let length = meant.chars().count();
    // What is much longer or shorter is none, and takes long to be compared.
    let similar = names.into_iter().filter(|other| other.chars().count().abs_diff(length) <= SLIPS);
    let slips = |other: &str| strsim::osa_distance(&meant, &other.to_lowercase());
    let (near, slips) = similar.map(|other| (other, slips(other))).min_by_key(|(_, slips)| *slips)?;
    (slips <= if near.len() <= SHORT { 1 } else { SLIPS }).then_some(near)
}

/// Names in a row, or a word where there are none; long lists are cut.
pub(crate) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 8;
    match names.len() {
        0 => "none".to_string(),
        n if n <= SHOWN => names.join(", "),
        n => format!("{} and {} more", names[..SHOWN].join(", "), n - SHOWN),
    }
}

/// Names in a row as a person says them: `a, b and c`.
pub(crate) fn enumerated(names: &[String]) -> String {
    match names {
        [first @ .., next, last] if !first.is_empty() => format!("{}, {next} and {last}", first.join(", ")),
        names => names.join(" and "),
    }
}

/// A name of a model as a person says it.
pub(crate) fn in_words(name: &str) -> String {
    name.replace('_', " ")
}

/// `1 joint`, `2 joints`, `3 pairs of limbs`.
pub(crate) fn plural(count: usize, noun: &str) -> String {
    if count == 1 {
        return format!("1 {noun}");
    }
    let (head, rest) = noun.split_at(noun.find(" of ").unwrap_or(noun.len()));
    let hisses = head.ends_with("ch") || head.ends_with("ss");
    format!("{count} {head}{}{rest}", if hisses { "es" } else { "s" })
}

/// Defines an enum whose values have names, by which they are printed and read. `what` they are is named in errors.
macro_rules! named {
    ($what:literal, $(#[$about:meta])* $visibility:vis enum $type:ident {
        $($(#[$about_variant:meta])* $variant:ident = $name:literal),+ $(,)?
    }) => {
        $(#[$about])*
        $visibility enum $type {
            $($(#[$about_variant])* $variant),+
        }

        impl $type {
            /// All values, in the order in which they are named to the user.
            pub const ALL: [$type; [$($name),+].len()] = [$($type::$variant),+];

            /// Its name.
            pub fn name(self) -> &'static str {
                match self {
                    $($type::$variant => $name),+
                }
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::error::Error;

            fn from_str(name: &str) -> Result<$type, $crate::error::Error> {
                let found = $type::ALL.into_iter().find(|value| value.name() == name);
                found.ok_or_else(|| $crate::named::unknown_name($what, name, &[$($name),+]))
            }
        }
    };
}

pub(crate) use named;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_agree_with_their_nouns() {
        assert_eq!(plural(1, "joint"), "1 joint");
        assert_eq!(plural(3, "pair of limbs"), "3 pairs of limbs");
        assert_eq!([1, 2].map(|count| plural(count, "touch")), ["1 touch", "2 touches"]);
    }

    #[test]
    fn slips_of_the_pen_are_names_that_are_meant() {
        assert_eq!(did_you_mean("elbow_ptich", ["elbow_pitch", "wrist"]), Some("elbow_pitch"));
        assert_eq!(did_you_mean("Lower", ["lower", "upper"]), Some("lower"));
        assert_eq!(did_you_mean("xy", ["xyz", "rpy"]), Some("xyz"));
        assert_eq!(did_you_mean("id", ["xyz", "rpy"]), None);
    }
}
