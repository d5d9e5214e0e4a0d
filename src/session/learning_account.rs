//! What learning came to, in words.

use super::disturbance_levels::DisturbanceLevels;
use super::learning_options::LearningOptions;
use crate::creature::Creature;
use crate::learning::{Account, BodyChange, Learned, LimbFrames, Verdict, What};
use crate::named::listed;
use crate::session::Session;

/// What the report says of how it was learned.
pub fn facts(
    session: &Session,
    options: &LearningOptions,
    learned: &Learned,
    seconds: f64,
) -> Vec<(String, String)> {
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
    facts.push(("random initial guesses", learned.initial_guesses.to_string()));
    facts.push(("learning", format!("{seconds:.2} s")));
    facts.extend(changes(session.agent.creature(), learned).into_iter().map(|change| ("change", change)));
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

/// The joints and limbs that are not located, by name; `None` where all are.
fn exceptions(creature: &Creature, learned: &Learned) -> Option<String> {
    let joints = learned.undetermined().into_iter().map(|joint| creature.joints()[joint].name.clone());
    let limbs = learned.undetermined_limbs().into_iter().map(|limb| creature.limbs()[limb].clone());
    let named = |kind: &str, names: Vec<String>| match names.as_slice() {
        [] => None,
        [one] => Some(format!("{kind} {one}")),
        several => Some(format!("{kind}s {}", listed(several))),
    };
    let parts = [named("joint", joints.collect()), named("limb", limbs.collect())];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(" and "))
}

/// How many limbs are located, as `all 17 limbs` or `4 of 5 limbs`; limbs without skin are not counted.
fn count_of_located(creature: &Creature, account: &Account) -> String {
    let (located, all) = (account.located().len(), account.limbs().len());
    let limbs = if all == creature.limbs().len() { "limbs" } else { "limbs with skin" };
    if located == all { format!("all {all} {limbs}") } else { format!("{located} of {all} {limbs}") }
}

/// The verdict in a sentence: how much is known comes first.
pub fn sentence(creature: &Creature, learned: &Learned) -> String {
    match (&learned.verdict, &learned.account) {
        (Verdict::Converged, Some(account)) => {
            let located = count_of_located(creature, account);
            match exceptions(creature, learned) {
                None => format!("Learned: {located} are located. The schema predicts held-out touches."),
                Some(names) => format!(
                    "Partly learned: {located} are located, but not {names}. What is located predicts held-out touches."
                ),
            }
        }
        (Verdict::Converged, None) => "Learned. The schema predicts held-out touches.".to_string(),
        (Verdict::Failed(why), _) => format!("NOT learned: {why}"),
        (Verdict::Unjudged(why), _) => format!("Not judged: {why}"),
    }
}
