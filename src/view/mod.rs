//! What people look at: pages, charts, pictures, films, and files for the viewers of others.
//!
//! ```text
//! skin, schema, posture ─ body (one mesh, one viewer) ─┬─ report (a session as one page)
//! numbers ─ charts (SVG with what each mark says) ─────┴─ live (a page of what happens now)
//! model, posture, marks ─ picture (MuJoCo's renderer: stills and films)
//! ```

mod body;
mod charts;
#[cfg(feature = "live")]
pub mod live;
#[cfg(feature = "render")]
pub mod picture;
pub mod report;
pub(crate) mod table;
pub(crate) mod text;
pub mod tone;

/// How pages look, the body and charts in them as well.
const STYLE: &str =
    concat!(include_str!("style.css"), include_str!("body/body.css"), include_str!("charts/charts.css"));

/// The head of a page that stands alone, until what it shows.
fn page(title: &str, own_style: &str, content: &str, own_script: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n<link rel=\"icon\" href=\"data:,\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}{own_style}</style>\n</head>\n<body>\n<main>\n{content}</main>\n\
         <script>{script}</script>\n</body>\n</html>\n",
        title = text::escape(title),
        script = script(own_script),
    )
}

/// All that runs in a page that has a script of its own.
fn script(own: &str) -> String {
    format!("\n{}{own}", body::SCRIPT)
}

/// A chart of a page with its caption, which is HTML.
fn figure(id: &str, chart: &charts::Chart, caption: &str) -> String {
    format!(
        "<figure>\n<div class=\"wide\" tabindex=\"0\" id=\"{id}\">\n{}</div>\n<figcaption>{caption}</figcaption>\n</figure>\n",
        chart.in_page()
    )
}
