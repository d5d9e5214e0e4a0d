//! `bodyschema report`: a session as one page to read.

use std::path::{Path, PathBuf};

use super::learn_options::{InputName, LearnOptions, session_truth, warn_truncated};
use super::{Failure, Outcome, output};
use crate::creature::Creature;
use crate::evaluation::evaluate_claims;
use crate::evaluation::report::{ReportInput, html};
use crate::ground_truth::GroundTruth;
use crate::learning::Input;
use crate::record::{
    Host, LearningRecord, SCHEMA_FILE, Session, SpaceRecord, TOUCHES_FILE, read_predictions,
    read_schema_with_std, read_touches,
};
use crate::schema::SchemaStd;
use crate::senses::Touch;

/// The report, in a session's folder.
pub const REPORT_FILE: &str = "report.html";

/// Write a session's report anew: one page that opens in any browser, without a network.
///
/// It shows the learned body over the true one in three dimensions and on the way from the onset, the receptors by
/// how often they were touched, who touched whom, the learning curve beside its bound, the error of every joint, the
/// residuals, how sure the learner is and of what it is not, and where the hands can get to, once `bodyschema
/// space` has worked that out. `babble` and `learn` write it by themselves.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema report sessions/max-1
  bodyschema space sessions/max-1
  bodyschema report sessions/max-1
  bodyschema report sessions/max-1 --model mjcf/max/max.xml")]
pub struct Args {
    /// The session's folder
    session: PathBuf,
    /// The model to measure against, where it is not at the path in the session
    #[arg(long)]
    model: Option<PathBuf>,
}

pub fn run(args: &Args) -> Outcome {
    let folder = &args.session;
    let session = Session::read(folder)?;
    let log = read_touches(&folder.join(TOUCHES_FILE), &session.creature, &session.skin)?;
    warn_truncated(&log, folder);
    let truth = known_truth(&session, args.model.as_deref())?;
    write_report(folder, &session, &log.touches, truth.as_ref())?;
    say!("{}", folder.join(REPORT_FILE).display());
    Ok(())
}

/// The truth, where a model is at hand; a recording has one only if it is named.
pub(super) fn known_truth(session: &Session, model: Option<&Path>) -> Result<Option<GroundTruth>, Failure> {
    if session.model.is_empty() && model.is_none() {
        return Ok(None);
    }
    match session_truth(session, model) {
        Ok(truth) => Ok(Some(truth)),
        Err(error) if model.is_some() => Err(error),
        Err(Failure(sentence)) => {
            tell!("not measured: {sentence}");
            Ok(None)
        }
    }
}

/// Writes the report of a session from what its folder holds. Of its touches those count that were learned from.
pub(super) fn write_report(
    folder: &Path,
    session: &Session,
    touches: &[Touch],
    truth: Option<&GroundTruth>,
) -> Outcome {
    let (creature, skin) = (&session.creature, &session.skin);
    let (schema, std) = read_schema_with_std(&folder.join(SCHEMA_FILE), creature)?;
    let found = LearningRecord::read(folder, creature)?;
    // Sessions from before there was a record still have their schema and touches.
    let record = found.clone().unwrap_or_else(|| LearningRecord {
        seed: session.seed,
        touches: touches.len(),
        verdict: "the session does not say whether it converged: `bodyschema learn` learns it again".into(),
        undetermined: std.as_ref().map_or(Vec::new(), |std| open_joints(creature, std)),
        ..LearningRecord::default()
    });
    let touches = &touches[..record.touches.min(touches.len())];
    let joints = creature.joints();
    let undetermined: Vec<usize> =
        (0..joints.len()).filter(|&joint| record.undetermined.contains(&joints[joint].name)).collect();
    let limbs = creature.limbs();
    let undetermined_limbs: Vec<usize> =
        (0..limbs.len()).filter(|&limb| record.undetermined_limbs.contains(&limbs[limb])).collect();
    let evaluation = truth.map(|truth| {
        let mut evaluation =
            evaluate_claims(creature, skin, truth, &schema, &undetermined, &undetermined_limbs);
        evaluation.bound_mm = record.bound;
        evaluation
    });
    let options = LearnOptions::default().for_session(session)?;
    let points = session.options.input.as_deref() == Some(&InputName::Contact.to_string());
    let input =
        if points || options.input_name() == InputName::Contact { Input::Contact } else { Input::Receptor };
    let predictions = read_predictions(folder)?;
    let space = SpaceRecord::read(folder)?;
    let report = ReportInput {
        creature,
        skin,
        schema: &schema,
        std: std.as_ref(),
        truth: truth.map(|truth| &truth.schema),
        evaluation: evaluation.as_ref(),
        touches,
        input,
        checkpoints: &record.checkpoints,
        predictions: &predictions,
        space: space.as_ref(),
        seed: record.seed,
        commands: commands(session, found.as_ref()),
        facts: facts(session, found.as_ref()),
        verdict: record.verdict.clone(),
        undetermined: &undetermined,
        undetermined_limbs: &record.undetermined_limbs,
        open_directions: &record.open_directions,
    };
    output::file(&folder.join(REPORT_FILE), &html(&report))
}

/// The joints of which some coordinate or axis is known to be open.
fn open_joints(creature: &Creature, std: &SchemaStd) -> Vec<String> {
    let open = |joint: &usize| std.positions[*joint].iter().any(Option::is_none);
    let names = |joint: usize| creature.joints()[joint].name.clone();
    (0..creature.joints().len()).filter(open).map(names).collect()
}

/// The command lines that made the session and, if by another, what was learned from it.
fn commands(session: &Session, learned: Option<&LearningRecord>) -> Vec<(String, String)> {
    let again = learned.map(|learned| &learned.command).filter(|command| **command != session.command);
    let commands = [("Made by", Some(&session.command)), ("Learned by", again)].into_iter();
    let kept = commands.filter_map(|(what, command)| Some((what, command?))).filter(|(_, c)| !c.is_empty());
    kept.map(|(what, command)| (what.to_string(), shell_words(command))).collect()
}

/// How the session came about, and how it was learned from.
fn facts(session: &Session, learned: Option<&LearningRecord>) -> Vec<(String, String)> {
    let mut facts = Vec::new();
    let mut fact = |name: &str, value: String| facts.push((name.to_string(), value));
    fact("program", session.program.clone());
    match &session.recording {
        Some(recording) => {
            fact("creature", recording.creature.clone());
            fact("log", recording.log.clone());
        }
        None => {
            fact("model", session.model.clone());
            fact("engine", format!("MuJoCo {}", session.engine));
        }
    }
    let host = learned.and_then(|learned| learned.host.as_ref()).or(session.host.as_ref());
    if let Some(Host { cpu, cores, os }) = host {
        fact("processor", cpu.clone());
        fact("cores", cores.to_string());
        fact("operating system", os.clone());
    }
    if let Some(effort) = &session.effort {
        fact("motions", effort.motions.to_string());
        fact("babbling", format!("{:.2} s", effort.babbling_s));
        if let Some(seconds) = effort.simulated_s {
            fact("simulated", format!("{seconds:.0} s"));
        }
    }
    facts.extend(learned.into_iter().flat_map(|learned| learned.facts.iter().cloned()));
    facts
}

/// A command line as a shell takes it.
fn shell_words(words: &[String]) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    let quoted = |word: &String| {
        if !word.is_empty() && word.chars().all(plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_as_a_shell_takes_it() {
        let words = ["bodyschema", "babble", "my model.xml", "--known", "it's", ""].map(String::from);
        assert_eq!(shell_words(&words), r"bodyschema babble 'my model.xml' --known 'it'\''s' ''");
    }
}
