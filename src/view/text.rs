//! Names, numbers and command lines as people are shown them.

/// Slack for powers of ten that are not exact.
const ROUNDING: f64 = 1e-9;
/// Below this a number of a linear axis is told by a power of ten.
const TINY: f64 = 1e-4;

/// An error in its unit, as people read it wherever it stands: to two or three digits, and below a thousandth as that.
pub(crate) fn error_number(value: f64) -> String {
    match value.abs() {
        tiny if tiny > 0.0 && tiny < 5e-4 => "< 0.001".into(),
        x if x < 0.01 => format!("{value:.3}"),
        _ => short_number(value),
    }
}

/// Text made safe for element content and for attributes.
pub(super) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            _ => safe.push(c),
        }
    }
    safe
}

/// An error to two or three digits, whatever its size; a dash for none.
pub(crate) fn short_number(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    match value.abs() {
        0.0 => "0".into(),
        x if !(1e-3..1e6).contains(&x) => {
            let text = format!("{value:.1e}");
            let (digits, exponent) = text.split_once('e').expect("scientific notation has an e");
            format!("{digits}·{}", power_of_ten(exponent.parse().expect("an exponent is whole")))
        }
        x if x >= 100.0 => format!("{value:.0}"),
        x if x >= 10.0 => format!("{value:.1}"),
        x if x >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// `10⁻³`, in plain characters.
fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// Where to label a logarithmic axis: at powers of ten, and with room also at 2 and 5 times them.
pub(super) fn ticks(range: &std::ops::Range<f64>) -> Vec<f64> {
    let (first, last) = (range.start.log10().floor() as i32, range.end.log10().ceil() as i32);
    let span = (range.end / range.start).log10();
    let multiples: &[f64] = if span <= 3.1 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let step = (span / 8.0).ceil().max(1.0) as usize;
    (first..=last)
        .step_by(step)
        .flat_map(|decade| multiples.iter().map(move |multiple| multiple * 10f64.powi(decade)))
        .filter(|tick| (range.start * (1.0 - ROUNDING)..=range.end * (1.0 + ROUNDING)).contains(tick))
        .collect()
}

/// A label of a logarithmic axis: a plain number, or a power of ten where that is shorter.
pub(super) fn tick_label(error: f64) -> String {
    let exponent = (error.log10() + ROUNDING).floor() as i32;
    match exponent {
        -3..=3 => format!("{error:.digits$}", digits = (-exponent).max(0) as usize),
        _ => {
            let multiple = (error / 10f64.powi(exponent)).round();
            let power = power_of_ten(exponent);
            if multiple == 1.0 { power } else { format!("{multiple}·{power}") }
        }
    }
}

/// A number of a linear axis, with a true minus sign.
pub(super) fn plain(value: f64) -> String {
    let text = match value.abs() {
        tiny if tiny > 0.0 && tiny < TINY => tick_label(tiny),
        x => format!("{}", (x * 1e9).round() / 1e9),
    };
    if value < 0.0 { format!("−{text}") } else { text }
}

/// JSON in a script of a page: no character may end the script or begin an element.
pub(super) fn harmless(json: &str) -> String {
    json.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e")
}

/// A command line as a shell takes it.
pub(crate) fn shell_words(words: &[String]) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    let quoted = |word: &String| {
        if !word.is_empty() && word.chars().all(plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_as_a_shell_takes_it() {
        let words = ["bodyschema", "babble", "my model.xml", "--known", "it's", ""].map(String::from);
        assert_eq!(shell_words(&words), r"bodyschema babble 'my model.xml' --known 'it'\''s' ''");
    }

    #[test]
    fn numbers_keep_their_digits_at_any_size() {
        let shown = [0.0, 2.34e-9, 9.996e-4, 0.0123, 1.2345, 56.78, 1234.5, f64::NAN];
        let texts = shown.map(short_number);
        assert_eq!(texts, ["0", "2.3·10⁻⁹", "1.0·10⁻³", "0.012", "1.23", "56.8", "1234", "–"]);
    }

    #[test]
    fn errors_below_a_thousandth_are_told_as_that() {
        let texts = [0.0, 2e-9, 6e-4, 0.0123, 1.2345, 302.1, f64::NAN].map(error_number);
        assert_eq!(texts, ["0.000", "< 0.001", "0.001", "0.012", "1.23", "302", "–"]);
    }

    #[test]
    fn names_cannot_leave_their_place() {
        assert_eq!(escape("<a href='x'>&\""), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;");
    }

    #[test]
    fn ticks_fill_short_axes_and_thin_out_on_long_ones() {
        assert_eq!(ticks(&(20.0..600.0)), [20.0, 50.0, 100.0, 200.0, 500.0]);
        assert!((2..=9).contains(&ticks(&(1e-12..1e3)).len()));
        assert_eq!([0.02, 1.0, 500.0, 1e-9, 2e-6].map(tick_label), ["0.02", "1", "500", "10⁻⁹", "2·10⁻⁶"]);
    }
}
