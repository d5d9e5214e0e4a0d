//! Numbers from the command line.

/// A number of touches from the command line.
pub fn touch_count(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(0) => Err("there is nothing to learn from 0 touches: give at least 1".into()),
        Ok(n) if n <= 100_000_000 => Ok(n),
        _ => Err("give a whole number from 1 to 100000000".into()),
    }
}
