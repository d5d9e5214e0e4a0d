//! What learning came to, in words.

use super::disturbance_levels::DisturbanceLevels;
use super::learned_session::LearnedSession;
use super::learning_options::LearningOptions;
use crate::creature::Creature;
use crate::learning::{BodyChange, Learned, LimbFrames, Verdict, What};
use crate::record::Session;

/// What the report says of how it was learned.
pub fn facts(session: &Session, options: &LearningOptions, result: &LearnedSession) -> Vec<(String, String)> {
    let mut facts =
        vec![("learner", options.learner.name().to_string()), ("knowledge", options.knowledge().to_string())];
    if options.frames == LimbFrames::Limb {
        facts.push(("frames of limbs", "their own, learned".to_string()));
    }
    if let Some(known) = options.known_words(session.agent.creature()) {
        facts.push(("prior knowledge of joints", known));
    }
    if options.disturbances != DisturbanceLevels::default() {
        facts.push(("disturbances", options.disturbances.to_string()));
    }
    facts.push(("random initial guesses", result.learned.initial_guesses.to_string()));
    facts.push(("learning", format!("{:.2} s", result.seconds)));
    facts.extend(result.changes.iter().map(|change| ("change", change.clone())));
    facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// How the body changed as the learner understood it, in sentences.
pub fn changes(creature: &Creature, learned: &Learned) -> Vec<String> {
    let sentence = |change: &BodyChange| {
        let what = match &change.what {
            What::Joint { joint, distance } => {
                format!("{} moved by {:.1} mm", creature.joints()[*joint].name, 1e3 * distance)
            }
            What::Corrected { joint, distance } => {
                let name = &creature.joints()[*joint].name;
                format!("{name} had been learned wrongly, by {:.1} mm", 1e3 * distance)
            }
            What::Tool(tool) => {
                let length = 1e3 * (tool.tip - tool.grip).norm();
                format!("{} holds a stick of {length:.0} mm", creature.limbs()[tool.limb])
            }
            What::Beyond => "the body changed beyond what one joint or a stick explains".to_string(),
        };
        format!("from touch {} on, understood at touch {}: {what}", change.since + 1, change.touch + 1)
    };
    learned.changes.iter().map(sentence).collect()
}

/// The verdict in a sentence.
pub fn sentence(creature: &Creature, learned: &Learned) -> String {
    match &learned.verdict {
        Verdict::Converged => match learned.undetermined.len() {
            0 => "converged: it explains touches that it was not fitted to".to_string(),
            left_out => format!(
                "converged but for {left_out} of {} joints: the rest explains touches that it was not fitted to",
                creature.joints().len()
            ),
        },
        Verdict::Failed(why) => format!("NOT learned: {why}"),
        Verdict::Unjudged(why) => format!("not judged: {why}"),
    }
}
