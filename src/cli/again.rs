//! A command line that is given once more, with other options.

/// A command line with an option set to something else, where it stands or at the end; without it where that is none.
pub fn with_option(command: &[String], option: &str, value: Option<&str>) -> Vec<String> {
    let mut value = value;
    let mut words = Vec::with_capacity(command.len());
    let mut rest = command.iter();
    while let Some(word) = rest.next() {
        let joined = word.strip_prefix(option).is_some_and(|after| after.starts_with('='));
        if !joined && word != option {
            words.push(word.clone());
            continue;
        }
        if !joined {
            rest.next();
        }
        words.extend(value.take().into_iter().flat_map(|value| [option.to_string(), value.to_string()]));
    }
    words.extend(value.into_iter().flat_map(|value| [option.to_string(), value.to_string()]));
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_is_set_where_it_stands_or_at_the_end_or_taken_away() {
        let words = |line: &str| line.split(' ').map(str::to_string).collect::<Vec<_>>();
        let line = |command: &str, option: &str, value: Option<&str>| {
            with_option(&words(command), option, value).join(" ")
        };
        assert_eq!(
            line("babble --touches 3 --root a", "--touches", Some("9")),
            "babble --touches 9 --root a"
        );
        assert_eq!(
            line("babble --touches=3 --out-x b", "--touches", Some("9")),
            "babble --touches 9 --out-x b"
        );
        assert_eq!(line("babble m.xml", "--touches", Some("9")), "babble m.xml --touches 9");
        assert_eq!(line("babble --out s m.xml", "--out", None), "babble m.xml");
    }
}
