//! A still of the body, drawn without any script: what the page shows until the body can be turned.

use std::fmt::Write;

use nalgebra::Vector3;

/// A flat piece of a body.
pub(super) struct Piece {
    /// Corners counterclockwise as seen from outside, metres.
    pub corners: Vec<Vector3<f64>>,
    /// Red, green and blue, 0 to 255.
    pub colour: [f64; 3],
    /// How much nearer than it is it counts, metres: what lies on a surface must not sink into it.
    pub lift: f64,
}

/// What is drawn over the pieces, wherever it is: joints are inside of limbs.
pub(super) struct Over {
    /// The two ends of lines, and their colour.
    pub lines: Vec<[Vector3<f64>; 2]>,
    pub line_colour: &'static str,
    /// Points, each with its colour.
    pub points: Vec<(Vector3<f64>, &'static str)>,
}

/// How light a piece is that faces away from the light, and how much lighter one that faces it.
const LIGHT: [f64; 2] = [0.66, 0.36];

/// An SVG of what an eye far away in the direction `eye` sees, up being z; nothing where there is nothing.
pub(super) fn still(pieces: &[Piece], over: &Over, eye: &Vector3<f64>) -> String {
    let eye = eye.normalize();
    let right = Vector3::z().cross(&eye).normalize();
    let up = eye.cross(&right);
    // Millimetres, downwards as SVG has it.
    // Adding nothing makes a zero of what is a negative one.
    let place = |p: &Vector3<f64>| [p.dot(&right), -p.dot(&up)].map(|metres| (metres * 1e3).round() + 0.0);
    let light = (eye + right * 0.25 + up * 0.6).normalize();
    let mut seen: Vec<(f64, &Piece, f64)> = pieces
        .iter()
        .filter_map(|piece| {
            let [a, b, c] = piece.corners[..3] else { return None };
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            let middle = piece.corners.iter().sum::<Vector3<f64>>() / piece.corners.len() as f64;
            let shade = LIGHT[0] + LIGHT[1] * normal.dot(&light).max(0.0);
            (normal.dot(&eye) > 0.0).then(|| (middle.dot(&eye) + piece.lift, piece, shade))
        })
        .collect();
    // From the farthest to the nearest, which covers it.
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));

    let ends = over.lines.iter().flatten().chain(over.points.iter().map(|(point, _)| point));
    let all = seen.iter().flat_map(|(_, piece, _)| &piece.corners).chain(ends).map(place);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in all {
        for k in 0..2 {
            (low[k], high[k]) = (low[k].min(point[k]), high[k].max(point[k]));
        }
    }
    if !(0..2).all(|k| low[k].is_finite() && high[k].is_finite()) {
        return String::new();
    }
    let size = (high[0] - low[0]).max(high[1] - low[1]).max(1.0);
    let room = 0.04 * size;
    let mut svg = format!(
        "<svg class=\"still\" viewBox=\"{} {} {} {}\" fill=\"currentColor\" stroke=\"currentColor\" \
         stroke-width=\"{}\" stroke-linejoin=\"round\">\n",
        (low[0] - room).floor(),
        (low[1] - room).floor(),
        (high[0] - low[0] + 2.0 * room).ceil(),
        (high[1] - low[1] + 2.0 * room).ceil(),
        (size / 1000.0 * 10.0).round() / 10.0,
    );
    for (_, piece, shade) in seen {
        let [r, g, b] = piece.colour.map(|c| (c * shade).round().clamp(0.0, 255.0) as u8);
        let corners: Vec<String> = piece.corners.iter().map(place).map(|[x, y]| format!("{x} {y}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(svg, "<path color=\"#{r:02x}{g:02x}{b:02x}\" d=\"M{}Z\"/>", corners.join("L"));
    }
    let _ = write!(
        svg,
        "<path color=\"{}\" fill=\"none\" stroke-width=\"{:.0}\" d=\"",
        over.line_colour,
        size / 180.0
    );
    for [from, to] in &over.lines {
        let ([x, y], [u, v]) = (place(from), place(to));
        let _ = write!(svg, "M{x} {y}L{u} {v}");
    }
    svg.push_str("\"/>\n");
    for (point, colour) in &over.points {
        let [x, y] = place(point);
        let _ = writeln!(
            svg,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{:.0}\" fill=\"{colour}\" stroke=\"#fff\" stroke-width=\"{:.0}\"/>",
            size / 130.0,
            size / 600.0,
        );
    }
    svg.push_str("</svg>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, colour: [f64; 3]) -> Piece {
        let corner = |y: f64, z: f64| Vector3::new(x, y, z);
        let corners = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 2.0), corner(0.0, 2.0)];
        Piece { corners, colour, lift: 0.0 }
    }

    #[test]
    fn the_near_covers_the_far_and_backs_are_not_drawn() {
        let mut back = square(2.0, [0.0, 0.0, 255.0]);
        back.corners.reverse();
        let pieces = [square(1.0, [255.0, 0.0, 0.0]), back, square(0.0, [0.0, 255.0, 0.0])];
        let over = Over { lines: Vec::new(), line_colour: "#000", points: Vec::new() };
        let svg = still(&pieces, &over, &Vector3::x());
        // Seen from ahead, y is to the right and z up.
        assert!(svg.contains("d=\"M0 0L1000 0L1000 -2000L0 -2000Z\""), "{svg}");
        let colours: Vec<&str> = svg.split("color=\"#").skip(1).map(|rest| &rest[..6]).collect();
        assert!(colours[0].starts_with("00") && colours[0].ends_with("00"), "green first: {colours:?}");
        assert!(colours[1].ends_with("0000"), "red over it: {colours:?}");
        assert_eq!(svg.matches('Z').count(), 2, "{svg}");
        assert!(svg.contains("viewBox=\"-80 -2080 1160 2160\""), "{svg}");
    }

    #[test]
    fn nothing_has_no_picture() {
        let over = Over { lines: Vec::new(), line_colour: "#000", points: Vec::new() };
        assert_eq!(still(&[], &over, &Vector3::x()), "");
    }
}
