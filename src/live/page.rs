//! The page of a live view: the report's style, its way of drawing, and what moves the pictures.

use crate::evaluation::report::{picture, text::escape};

/// plotly.js.
pub fn library() -> String {
    let element = picture::library();
    let script = element.split_once('>').map_or("", |(_, rest)| rest);
    script.trim_end().trim_end_matches("</script>").to_string()
}

/// A page with a title, a sentence below it, and what it shows, which is HTML.
pub fn page(title: &str, about: &str, content: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n<link rel=\"icon\" href=\"data:,\"/>\n\
         <title>{title}, live</title>\n<style>\n{style}{own_style}</style>\n</head>\n<body>\n\
         <header>\n<h1>{title}</h1>\n<p>{about}</p>\n</header>\n{content}\
         <script src=\"plotly.js\"></script>\n<script>\n{script}{body}{own_script}</script>\n</body>\n</html>\n",
        title = escape(title),
        about = escape(about),
        style = crate::evaluation::report::STYLE,
        own_style = include_str!("live.css"),
        script = crate::evaluation::report::SCRIPT,
        body = include_str!("body.js"),
        own_script = include_str!("live.js"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_a_script_without_its_element() {
        let library = library();
        assert!(library.contains("Plotly") && library.len() > 1_000_000);
        assert!(!library.trim_start().starts_with('<') && !library.trim_end().ends_with('>'));
    }
}
