//! How far the map that is learned from strokes agrees with the one that the geometry gives.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::evaluation::MapAgreement;
use crate::experiment::ExperimentError;
use crate::senses::{FiringRecorder, learn_map};
use crate::simulation::partner::stroke_for;
use crate::skin::SomatotopicMap;

/// The study `map`.
pub const STUDY: Study = Study {
    name: "map",
    about: "how far a somatotopic map learned from 20 minutes of random strokes agrees with the geometric one",
    touches: false,
    several: false,
    trials: Trials::of::<MapTrial>(),
};

/// After how many minutes of strokes the map is learned.
const MINUTES: [f64; 4] = [2.5, 5.0, 10.0, 20.0];

row! {
    /// A measurement of the study `map`.
    pub struct MapMeasurement {
        seed: u64 = "seed",
        minutes: f64 = "minutes",
        strokes: usize = "strokes",
        visited: usize = "receptors visited",
        learned: usize = "pairs learned",
        geometric: usize = "of the geometry",
        shared: usize = "shared",
        recall: f64 = "recall",
        precision: f64 = "precision",
        agreement: f64 = "agreement",
        recall_within: f64 = "recall within limbs",
        precision_within: f64 = "precision within limbs",
        recall_across: f64 = "recall across joints",
        precision_across: f64 = "precision across joints",
    }
}

row! {
    /// A row of the summary of the study `map`.
    pub struct MapSummary {
        minutes: f64 = "minutes",
        trials: usize = "trials",
        strokes: f64 = "strokes",
        visited: f64 = "visited, share",
        recall: f64 = "recall",
        precision: f64 = "precision",
        agreement: f64 = "agreement",
        recall_within: f64 = "recall within limbs",
        precision_within: f64 = "precision within limbs",
        recall_across: f64 = "recall across joints",
        precision_across: f64 = "precision across joints",
    }
}

/// One of the measures of a map.
type MapMeasure = fn(&MapMeasurement) -> f64;

/// What came of one trial.
#[derive(Debug, Serialize, Deserialize)]
pub struct MapTrial {
    /// One for each of [`MINUTES`].
    measurements: Vec<MapMeasurement>,
    /// Receptors of the skin.
    receptors: usize,
}

impl Trial for MapTrial {
    type Setting = ();
    type Measurement = MapMeasurement;
    type Summary = MapSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<MapTrial, ExperimentError> {
        subject.tell(seed, "stroking");
        let stage = subject.stage()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let limbs: Vec<usize> = stage.skin().receptors.iter().map(|receptor| receptor.limb).collect();
        let geometric = SomatotopicMap::at_ease(stage.body(), stage.skin())?;
        let (mut recorder, mut firings, mut before) = (FiringRecorder::default(), Vec::new(), 0.0);
        let mut measurements = Vec::new();
        for minutes in MINUTES {
            let room = stroke_for::<ExperimentError>(
                &stage,
                60.0 * (minutes - before),
                &mut rng,
                |_, time, contacts, _| {
                    firings.extend(recorder.step(time, contacts));
                    Ok(())
                },
            )?;
            if !room {
                return Err(ExperimentError::Refused(format!(
                    "{}: there is no room to stroke it",
                    subject.model().display()
                )));
            }
            before = minutes;
            let learned = learn_map(&limbs, &firings);
            let agreement = MapAgreement::of_all(&learned.map, &geometric);
            let [within, across] = MapAgreement::within_and_across(&learned.map, &geometric, stage.skin());
            measurements.push(MapMeasurement {
                seed,
                minutes,
                strokes: learned.strokes,
                visited: learned.firings.iter().filter(|count| **count > 0).count(),
                learned: agreement.learned,
                geometric: agreement.geometric,
                shared: agreement.shared,
                recall: agreement.recall(),
                precision: agreement.precision(),
                agreement: agreement.agreement(),
                recall_within: within.recall(),
                precision_within: within.precision(),
                recall_across: across.recall(),
                precision_across: across.precision(),
            });
        }
        Ok(MapTrial { measurements, receptors: limbs.len() })
    }

    fn findings(_subject: &Subject, trials: &[MapTrial]) -> Findings<MapMeasurement, MapSummary> {
        findings(trials)
    }
}

fn findings(trials: &[MapTrial]) -> Findings<MapMeasurement, MapSummary> {
    let of = |k: usize| trials.iter().filter_map(move |trial| trial.measurements.get(k));
    let middle = |k: usize, measure: MapMeasure| median(of(k).map(measure));
    let visited = |k: usize| {
        let visited =
            |trial: &MapTrial| Some(trial.measurements.get(k)?.visited as f64 / trial.receptors as f64);
        median(trials.iter().filter_map(visited))
    };
    let summary = MINUTES.into_iter().enumerate().map(|(k, minutes)| MapSummary {
        minutes,
        trials: of(k).count(),
        strokes: middle(k, |row| row.strokes as f64),
        visited: visited(k),
        recall: middle(k, |row| row.recall),
        precision: middle(k, |row| row.precision),
        agreement: middle(k, |row| row.agreement),
        recall_within: middle(k, |row| row.recall_within),
        precision_within: middle(k, |row| row.precision_within),
        recall_across: middle(k, |row| row.recall_across),
        precision_across: middle(k, |row| row.precision_across),
    });
    let measures: [(&str, MapMeasure); 3] = [
        ("recall", |row| row.recall),
        ("precision", |row| row.precision),
        ("agreement", |row| row.agreement),
    ];
    let last = MINUTES.len() - 1;
    let numbers = measures.into_iter().chain([("accuracy", measures[1].1)]);
    let numbers = numbers.map(|(name, measure)| (name, json!(middle(last, measure)))).collect();
    let notes = vec![
        "Medians over the trials. Recall: pairs of the geometry that were learned. Precision, in JSON also accuracy: \
         learned pairs that are the geometry's. Agreement: their harmonic mean."
            .to_string(),
    ];
    let series = measures.into_iter().map(|(name, measure)| PlotSeries {
        name: name.to_string(),
        line: MINUTES.into_iter().enumerate().map(|(k, minutes)| (minutes, middle(k, measure))).collect(),
        dots: Vec::new(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "minutes of strokes", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "share", scale: AxisScale::Logarithmic },
        series: series.collect(),
    };
    let measurements = trials.iter().flat_map(|trial| trial.measurements.clone()).collect();
    Findings { measurements, summary: summary.collect(), notes, plot, numbers }
}
