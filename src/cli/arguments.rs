//! Numbers from the command line.

use clap::builder::RangedU64ValueParser;

/// How many of something, at least one.
pub fn count() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..=100_000_000)
}

/// A number above 0 from the command line.
pub fn positive(text: &str) -> Result<f64, String> {
    not_negative(text).ok().filter(|number| *number > 0.0).ok_or_else(|| "give a number above 0".into())
}

/// A number from the command line that is not negative.
pub fn not_negative(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number >= 0.0 && number.is_finite());
    number.ok_or_else(|| "give a number that is not negative".into())
}
