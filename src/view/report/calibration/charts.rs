//! What is left of the touches, drawn: by the links that touched, by joints, and by places.

use std::collections::BTreeMap;

use super::{CalibrationReport, ReportedTouch};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Ruler, Scale};
use crate::view::figure;
use crate::view::report::joint_errors::{box_marks, quartiles};
use crate::view::text::{plain, short_number as number, thinned, touches as count_of};

/// Rows of a chart at the most.
const MOST_ROWS: usize = 30;
/// Height of a row and width of a chart of rows, pixels.
const ROW: f64 = 17.0;
const WIDTH: f64 = 560.0;
/// Joints that are drawn at the most, so many side by side, each so large, pixels.
const MOST_JOINTS: usize = 24;
const SIDE_BY_SIDE: usize = 3;
const SMALL: [f64; 2] = [245.0, 120.0];
/// Dots of a small chart at the most.
const MOST_DOTS: usize = 300;
/// Stretches of a joint's angle in which the mean is taken, and touches in each at the least.
const STRETCHES: usize = 8;
const FEWEST: usize = 3;
/// A point of a link that occurs so often recurs.
const RECURS: usize = 3;

/// What a chart says where there is nothing to draw.
fn nothing(sentence: &str) -> String {
    format!("<p class=\"note\">{sentence}</p>\n")
}

fn says(touch: &ReportedTouch) -> String {
    let [a, b] = &touch.between;
    let what = if touch.is_false() { ", taken to be false" } else { "" };
    format!("line {}: {a} and {b} are {} mm apart{what}", touch.line, number(touch.millimetres()))
}

/// A chart of rows with names, and how far apart what touched is put to the right.
fn rows(names: Vec<String>, title: &str, scale: Scale, groups: Vec<ChartGroup>) -> Panel {
    let height = ROW * names.len().max(1) as f64;
    Panel {
        title: String::new(),
        x: Ruler { title: title.into(), scale },
        y: Ruler { title: String::new(), scale: Scale::Names(names) },
        groups,
        plot: [WIDTH, height],
    }
}

/// The marks of touches that are taken to be false.
fn false_group(marks: Vec<ChartMark>) -> Option<ChartGroup> {
    (!marks.is_empty()).then(|| ChartGroup { name: "taken to be false".into(), ink: Ink::Orange, marks })
}

fn cross(at: [f64; 2], touch: &ReportedTouch) -> ChartMark {
    ChartMark::Dot { at, radius: 3.0, cross: true, says: says(touch) }
}

/// A box for each pair of links that touched.
pub(super) fn by_pair(report: &CalibrationReport) -> String {
    let mut pairs: BTreeMap<[&str; 2], Vec<&ReportedTouch>> = BTreeMap::new();
    for touch in &report.touches {
        let mut pair = touch.between.each_ref().map(String::as_str);
        pair.sort_unstable();
        pairs.entry(pair).or_default().push(touch);
    }
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_by_key(|(_, touches)| std::cmp::Reverse(touches.len()));
    let count = pairs.len();
    pairs.truncate(MOST_ROWS);
    let (mut boxes, mut crosses, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (k, ([a, b], touches)) in pairs.iter().enumerate() {
        let name = format!("{a}, {b}");
        let row = k as f64;
        let honest: Vec<f64> =
            touches.iter().filter(|touch| !touch.is_false()).map(|touch| touch.millimetres()).collect();
        let about = format!("{name}, {}", count_of(honest.len()));
        boxes.extend(quartiles(honest).into_iter().flat_map(|values| box_marks(k, &about, values)));
        let wrong = touches.iter().filter(|touch| touch.is_false());
        crosses.extend(wrong.map(|touch| cross([touch.millimetres(), row], touch)));
        names.push(name);
    }
    if boxes.is_empty() && crosses.is_empty() {
        return nothing("There is no touch to look at.");
    }
    let scale = Scale::logarithmic(report.touches.iter().map(ReportedTouch::millimetres));
    let groups =
        [Some(ChartGroup { name: String::new(), ink: Ink::Blue, marks: boxes }), false_group(crosses)];
    let panel = rows(names, "apart, mm", scale, groups.into_iter().flatten().collect());
    let mut caption = String::from(
        "Per pair of links, most touches first: the middle half in the box, all within the whiskers.",
    );
    if count > MOST_ROWS {
        caption += &format!(" {} more pairs are not drawn.", count - MOST_ROWS);
    }
    figure("by-pair", &Chart::new("Residuals by pair of links", panel), &caption)
}

/// A small chart for each joint: what is left over what its encoder read, the joint first in which it depends most on that.
pub(super) fn by_joint(report: &CalibrationReport) -> String {
    let mut read: Vec<Vec<(f64, &ReportedTouch)>> = vec![Vec::new(); report.joints.len()];
    for touch in &report.touches {
        for (joint, angle) in &touch.joints {
            read[*joint].push((*angle, touch));
        }
    }
    let mut joints: Vec<(f64, usize)> = (0..read.len())
        .filter(|joint| !read[*joint].is_empty())
        .map(|joint| (explained(&read[joint]), joint))
        .collect();
    joints.sort_by(|a, b| b.0.total_cmp(&a.0));
    if joints.is_empty() {
        return nothing("No joint moved between what touched.");
    }
    let count = joints.len();
    let panels: Vec<Panel> = joints
        .into_iter()
        .take(MOST_JOINTS)
        .map(|(share, joint)| {
            let about = &report.joints[joint];
            let title = format!("{} ({:.0} %)", about.name, 100.0 * share);
            small(title, about.unit, std::mem::take(&mut read[joint]))
        })
        .collect();
    let mut charts = String::new();
    let mut panels = panels.into_iter().peekable();
    while panels.peek().is_some() {
        let panels = panels.by_ref().take(SIDE_BY_SIDE).collect();
        charts += &Chart { says: "Residuals by what joints' encoders read".into(), panels }.in_page();
    }
    let mut caption = String::from(
        "How far apart what touched is put, mm, by what each joint between the two read, ° (slides mm); crosses are touches that are taken \
         to be false. The line is the mean; of how much the touches differ it explains the share in brackets: a joint \
         of which much is explained is not yet as its encoder says.",
    );
    if count > MOST_JOINTS {
        caption += &format!(" {} joints of which less is explained are not drawn.", count - MOST_JOINTS);
    }
    format!(
        "<figure>\n<div class=\"wide\" tabindex=\"0\" id=\"by-joint\">\n{charts}</div>\n<figcaption>{caption}</figcaption>\n</figure>\n"
    )
}

/// Honest touches by stretches of an angle, of those that hold enough: the middle of each, and its touches' millimetres.
fn stretches(read: &[(f64, &ReportedTouch)]) -> Vec<(f64, Vec<f64>)> {
    let honest: Vec<(f64, f64)> = read
        .iter()
        .filter(|(_, touch)| !touch.is_false())
        .map(|(angle, touch)| (*angle, touch.millimetres()))
        .collect();
    let low = honest.iter().map(|(angle, _)| *angle).fold(f64::INFINITY, f64::min);
    let high = honest.iter().map(|(angle, _)| *angle).fold(f64::NEG_INFINITY, f64::max);
    let width = ((high - low) / STRETCHES as f64).max(f64::MIN_POSITIVE);
    let mut stretches = vec![Vec::new(); STRETCHES];
    for (angle, apart) in honest {
        stretches[(((angle - low) / width) as usize).min(STRETCHES - 1)].push(apart);
    }
    let middle = |k: usize| low + (k as f64 + 0.5) * width;
    stretches
        .into_iter()
        .enumerate()
        .filter(|(_, own)| own.len() >= FEWEST)
        .map(|(k, own)| (middle(k), own))
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The share of the variance that the means of stretches explain, less what as many stretches would explain of chance.
fn explained(read: &[(f64, &ReportedTouch)]) -> f64 {
    let stretches = stretches(read);
    let all: Vec<f64> = stretches.iter().flat_map(|(_, own)| own.iter().copied()).collect();
    let middle = mean(&all);
    let whole: f64 = all.iter().map(|x| (x - middle).powi(2)).sum();
    let within: f64 =
        stretches.iter().map(|(_, own)| own.iter().map(|x| (x - mean(own)).powi(2)).sum::<f64>()).sum();
    let (n, k) = (all.len(), stretches.len());
    if n <= k || whole <= 0.0 {
        return 0.0;
    }
    (1.0 - within / (n - k) as f64 * (n - 1) as f64 / whole).max(0.0)
}

fn small(title: String, unit: &str, read: Vec<(f64, &ReportedTouch)>) -> Panel {
    let honest_apart =
        read.iter().filter(|(_, touch)| !touch.is_false()).map(|(_, touch)| touch.millimetres());
    let line: Vec<[f64; 2]> = stretches(&read).into_iter().map(|(angle, own)| [angle, mean(&own)]).collect();
    let low = read.iter().map(|(angle, _)| *angle).fold(f64::INFINITY, f64::min);
    let high = read.iter().map(|(angle, _)| *angle).fold(f64::NEG_INFINITY, f64::max);
    let room = (0.04 * (high - low)).max(1e-6);
    // False touches are mostly far out: they are put at the edge.
    let y = Scale::linear(0.0, honest_apart);
    let top = if let Scale::Linear(_, top) = y { top } else { f64::INFINITY };
    let (wrong, honest): (Vec<_>, Vec<_>) =
        thinned(read, MOST_DOTS).into_iter().partition(|(_, touch)| touch.is_false());
    let dots = honest.into_iter().map(|(angle, touch)| {
        let says = format!("{} at {}{unit}", says(touch), plain((10.0 * angle).round() / 10.0));
        ChartMark::dot([angle, touch.millimetres()], 1.7, says)
    });
    let crosses = wrong.into_iter().map(|(angle, touch)| cross([angle, touch.millimetres().min(top)], touch));
    let group = |ink, marks| ChartGroup { name: String::new(), ink, marks };
    Panel {
        title,
        x: Ruler { title: String::new(), scale: Scale::Linear(low - room, high + room) },
        y: Ruler { title: String::new(), scale: y },
        groups: vec![
            group(Ink::Blue, dots.collect()),
            group(Ink::Orange, crosses.collect()),
            group(Ink::Letters, vec![ChartMark::line(line)]),
        ],
        plot: SMALL,
    }
}

/// The mean of what is left at each point or surface that recurs, the greatest first.
pub(super) fn by_place(report: &CalibrationReport) -> String {
    let mut places: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for touch in report.touches.iter().filter(|touch| !touch.is_false()) {
        for place in &touch.places {
            places.entry(place).or_default().push(touch.millimetres());
        }
    }
    let recurring = places.into_iter().filter(|(_, own)| own.len() >= RECURS);
    let mut means: Vec<(f64, usize, &str)> =
        recurring.map(|(place, own)| (mean(&own), own.len(), place)).collect();
    means.sort_by(|a, b| b.0.total_cmp(&a.0));
    if means.is_empty() {
        return nothing("No point or surface recurs in the touches.");
    }
    let count = means.len();
    means.truncate(MOST_ROWS);
    let bar = |(k, (mean, count, place)): (usize, &(f64, usize, &str))| ChartMark::Cell {
        from: [0.0, k as f64 - 0.32],
        to: [*mean, k as f64 + 0.32],
        opacity: 0.6,
        text: String::new(),
        says: format!("{place}: {} mm on average over {}", number(*mean), count_of(*count)),
    };
    let bars = means.iter().enumerate().map(bar).collect();
    let names = means.iter().map(|(_, _, place)| place.to_string()).collect();
    let scale = Scale::linear(0.0, means.iter().map(|(mean, ..)| *mean));
    let groups = vec![ChartGroup { name: String::new(), ink: Ink::Blue, marks: bars }];
    let panel = rows(names, "apart on average, mm", scale, groups);
    let mut caption = format!(
        "Points, in mm in the frame of their link, and surfaces that occur {RECURS} times or more in touches that are not false, the \
         greatest mean first. A receptor that is not where the log says stands out here: see <code>--places</code>."
    );
    if count > MOST_ROWS {
        caption += &format!(" {} more are not drawn.", count - MOST_ROWS);
    }
    figure("by-place", &Chart::new("Residuals by place", panel), &caption)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(line: usize, angle: f64, apart: f64) -> ReportedTouch {
        ReportedTouch {
            line,
            between: ["hand".into(), "plate".into()],
            places: ["hand".into(), "plate".into()],
            apart,
            honesty: 1.0,
            joints: vec![(0, angle)],
        }
    }

    #[test]
    fn an_angle_that_says_all_explains_all_and_one_that_says_nothing_nothing() {
        let touches: Vec<ReportedTouch> = (0..80).map(|k| touch(k, f64::from(k as u32 / 10), 1e-3)).collect();
        let read = |apart: &dyn Fn(usize) -> f64| {
            let touches: Vec<ReportedTouch> = touches
                .iter()
                .map(|touch| ReportedTouch { apart: apart(touch.line), ..touch.clone() })
                .collect();
            let read: Vec<(f64, &ReportedTouch)> =
                touches.iter().map(|touch| (touch.joints[0].1, touch)).collect();
            explained(&read)
        };
        assert!(read(&|k| (k / 10) as f64) > 0.999);
        assert!(read(&|k| (k % 10) as f64) < 0.1);
        assert_eq!(read(&|_| 1.0), 0.0);
    }
}
