//! What a study plots: lines and dots over two axes.

/// What an axis counts.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisScale {
    /// A logarithmic scale.
    Logarithmic,
    /// Names, each at its number counted from 0.
    Names(Vec<String>),
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotAxis {
    /// What it shows, with its unit.
    pub title: &'static str,
    /// How it counts.
    pub scale: AxisScale,
}

/// Points of one colour and one entry in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotSeries {
    /// Its name in the legend.
    pub name: String,
    /// Points to join by a line.
    pub line: Vec<(f64, f64)>,
    /// Points to draw as dots.
    pub dots: Vec<(f64, f64)>,
}

/// A plot; points with a value that is not finite are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPlot {
    /// The axis to the right.
    pub x: PlotAxis,
    /// The axis upwards; names stand from the top down.
    pub y: PlotAxis,
    /// What is drawn.
    pub series: Vec<PlotSeries>,
}
