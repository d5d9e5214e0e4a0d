//! Numbers from the command line.

/// A number of touches from the command line.
pub fn touch_count(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(0) => Err("there is nothing to learn from 0 touches: give at least 1".into()),
        Ok(n) if n <= 100_000_000 => Ok(n),
        _ => Err("give a whole number from 1 to 100000000".into()),
    }
}

/// A number above 0 from the command line.
pub fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "give a number".to_string())?;
    if number > 0.0 && number.is_finite() { Ok(number) } else { Err("give a number above 0".into()) }
}
