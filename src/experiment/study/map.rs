//! How far the map that is learned from strokes agrees with the one that the geometry gives.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::row;
use super::{Findings, Study};
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
    measure: |subject| Ok(measure(subject)?.into()),
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

/// One of the measures of agreement.
type AgreementMeasure = fn(&MapAgreement) -> f64;
/// What a map came to: strokes, share of receptors visited, and agreement: of all, within limbs and across joints.
type MapFigures = (usize, f64, [MapAgreement; 3]);

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(subject: &Subject) -> Result<Findings<MapMeasurement, MapSummary>, ExperimentError> {
    let mut measurements: Vec<MapMeasurement> = Vec::new();
    let mut found: [Vec<MapFigures>; MINUTES.len()] = Default::default();
    for &seed in &subject.seeds {
        subject.tell(seed, "stroking");
        let stage = subject.stage()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let limbs: Vec<usize> = stage.skin().receptors.iter().map(|receptor| receptor.limb).collect();
        let geometric = SomatotopicMap::at_ease(stage.body(), stage.skin())?;
        let (mut recorder, mut firings, mut before) = (FiringRecorder::default(), Vec::new(), 0.0);
        for (minutes, found) in MINUTES.into_iter().zip(&mut found) {
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
            let visited = learned.firings.iter().filter(|count| **count > 0).count();
            measurements.push(MapMeasurement {
                seed,
                minutes,
                strokes: learned.strokes,
                visited,
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
            found.push((learned.strokes, visited as f64 / limbs.len() as f64, [agreement, within, across]));
        }
    }
    let mut summary: Vec<MapSummary> = Vec::new();
    for (minutes, found) in MINUTES.into_iter().zip(&found) {
        summary.push(MapSummary {
            minutes,
            trials: found.len(),
            strokes: median(found.iter().map(|(strokes, ..)| *strokes as f64)),
            visited: median(found.iter().map(|(_, visited, _)| *visited)),
            recall: median(found.iter().map(|(.., [of, ..])| of.recall())),
            precision: median(found.iter().map(|(.., [of, ..])| of.precision())),
            agreement: median(found.iter().map(|(.., [of, ..])| of.agreement())),
            recall_within: median(found.iter().map(|(.., [_, of, _])| of.recall())),
            precision_within: median(found.iter().map(|(.., [_, of, _])| of.precision())),
            recall_across: median(found.iter().map(|(.., [.., of])| of.recall())),
            precision_across: median(found.iter().map(|(.., [.., of])| of.precision())),
        });
    }
    let last = &found[MINUTES.len() - 1];
    let of = |measure: AgreementMeasure| median(last.iter().map(|(.., [of, ..])| measure(of)));
    let numbers = vec![
        ("recall", json!(of(MapAgreement::recall))),
        ("precision", json!(of(MapAgreement::precision))),
        ("agreement", json!(of(MapAgreement::agreement))),
        ("accuracy", json!(of(MapAgreement::precision))),
    ];
    let notes = vec![
        "Medians over the trials. Recall: pairs of the geometry that were learned. Precision, in JSON also accuracy: \
         learned pairs that are the geometry's. Agreement: their harmonic mean."
            .to_string(),
    ];
    let measures: [(&str, AgreementMeasure); 3] = [
        ("recall", MapAgreement::recall),
        ("precision", MapAgreement::precision),
        ("agreement", MapAgreement::agreement),
    ];
    let series = measures.into_iter().map(|(name, measure)| PlotSeries {
        name: name.to_string(),
        line: MINUTES
            .into_iter()
            .zip(&found)
            .map(|(minutes, found)| (minutes, median(found.iter().map(|(.., [of, ..])| measure(of)))))
            .collect(),
        dots: Vec::new(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "minutes of strokes", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "share", scale: AxisScale::Logarithmic },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}
