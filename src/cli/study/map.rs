//! How far the map that is learned from strokes agrees with the one that the geometry gives.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Subject, median};
use super::table::{Column, Table};
use super::{Findings, Study};
use crate::cli::Failure;
use crate::evaluation::MapAgreement;
use crate::interaction::stroke_for;
use crate::senses::{FiringRecorder, learn_map};

pub const STUDY: Study = Study {
    name: "map",
    about: "how far a somatotopic map learned from 20 minutes of random strokes agrees with the geometric one",
    touches: false,
    measure,
};

/// After how many minutes of strokes the map is learned.
const MINUTES: [f64; 4] = [2.5, 5.0, 10.0, 20.0];

const MEASUREMENTS: &[Column] = &[
    Column { name: "seed", heading: "seed" },
    Column { name: "minutes", heading: "minutes" },
    Column { name: "strokes", heading: "strokes" },
    Column { name: "visited", heading: "receptors visited" },
    Column { name: "learned", heading: "pairs learned" },
    Column { name: "geometric", heading: "of the geometry" },
    Column { name: "shared", heading: "shared" },
    Column { name: "recall", heading: "recall" },
    Column { name: "precision", heading: "precision" },
    Column { name: "agreement", heading: "agreement" },
];

const SUMMARY: &[Column] = &[
    Column { name: "minutes", heading: "minutes" },
    Column { name: "trials", heading: "trials" },
    Column { name: "strokes", heading: "strokes" },
    Column { name: "visited", heading: "visited, share" },
    Column { name: "recall", heading: "recall" },
    Column { name: "precision", heading: "precision" },
    Column { name: "agreement", heading: "agreement" },
];

/// One of the measures of agreement.
type Measure = fn(&MapAgreement) -> f64;
/// What a map came to: strokes, share of receptors visited, and agreement.
type Learned = (usize, f64, MapAgreement);

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let mut measurements = Table::new(MEASUREMENTS);
    let mut found: [Vec<Learned>; MINUTES.len()] = Default::default();
    for &seed in &subject.seeds {
        subject.tell(seed, "stroking");
        let mut world = subject.world()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let limbs: Vec<usize> = world.skin.receptors.iter().map(|receptor| receptor.limb).collect();
        let (mut recorder, mut firings, mut before) = (FiringRecorder::default(), Vec::new(), 0.0);
        for (minutes, found) in MINUTES.into_iter().zip(&mut found) {
            let room = stroke_for::<Failure>(
                &mut world,
                60.0 * (minutes - before),
                &mut rng,
                |_, time, contacts, _| {
                    firings.extend(recorder.step(time, contacts));
                    Ok(())
                },
            )?;
            if !room {
                return Err(Failure(format!("{}: there is no room to stroke it", subject.model().display())));
            }
            before = minutes;
            let learned = learn_map(&limbs, &firings);
            let agreement = MapAgreement::of_all(&MapAgreement::by_limb(
                &learned.map,
                &world.skin,
                world.body.creature.limbs().len(),
            ));
            let visited = learned.firings.iter().filter(|count| **count > 0).count();
            measurements.row([
                seed.into(),
                minutes.into(),
                learned.strokes.into(),
                visited.into(),
                agreement.learned.into(),
                agreement.geometric.into(),
                agreement.shared.into(),
                agreement.recall().into(),
                agreement.precision().into(),
                agreement.agreement().into(),
            ]);
            found.push((learned.strokes, visited as f64 / limbs.len() as f64, agreement));
        }
    }
    let mut summary = Table::new(SUMMARY);
    for (minutes, found) in MINUTES.into_iter().zip(&found) {
        summary.row([
            minutes.into(),
            found.len().into(),
            median(found.iter().map(|(strokes, ..)| *strokes as f64)).into(),
            median(found.iter().map(|(_, visited, _)| *visited)).into(),
            median(found.iter().map(|(.., of)| of.recall())).into(),
            median(found.iter().map(|(.., of)| of.precision())).into(),
            median(found.iter().map(|(.., of)| of.agreement())).into(),
        ]);
    }
    let last = &found[MINUTES.len() - 1];
    let of = |measure: Measure| median(last.iter().map(|(.., of)| measure(of)));
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
    let measures: [(&str, Measure); 3] = [
        ("recall", MapAgreement::recall),
        ("precision", MapAgreement::precision),
        ("agreement", MapAgreement::agreement),
    ];
    let series = measures.into_iter().map(|(name, measure)| Series {
        name: name.to_string(),
        line: MINUTES
            .into_iter()
            .zip(&found)
            .map(|(minutes, found)| (minutes, median(found.iter().map(|(.., of)| measure(of)))))
            .collect(),
        dots: Vec::new(),
    });
    let plot = Plot {
        x: Axis { title: "minutes of strokes", scale: Scale::Logarithmic },
        y: Axis { title: "share", scale: Scale::Logarithmic },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}
