//! `bodyschema talk`: a conversation with a creature among things.

use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;

use super::live::LiveOptions;
use super::{Failure, Outcome, output, progress};
use crate::creature::JointSelection;
use crate::experiment::own_body;
use crate::interaction::{Actor, Conversation};
use crate::record::model_hash;
use crate::simulation::{Stage, StageOptions};

/// Talk to a creature among things: it answers what a partner asks of it, line by line.
///
/// It is blindfolded: all that it knows of its body is the schema of a session, and all that it knows of the scene it
/// has felt. Ask it in plain words, from a terminal or through a pipe: whether there is something in front of it, to
/// touch it with a hand, how far it is, where it feels it, to put it as far away as possible, to bring it near, to lean
/// forward and try again. What a hand touches it can hold: it is welded to the hand until it is put down. With --live
/// there is a page beside that shows it all as fast as it would really move, on which you can also touch its skin.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema babble mjcf/max/max.xml
  bodyschema talk mjcf/max/table.xml sessions/max-1
  echo 'is there something in front of you?' | bodyschema talk mjcf/max/table.xml sessions/max-1 --json
  bodyschema talk mjcf/max/table.xml sessions/max-1 --live  # talk to it in a browser")]
pub struct TalkArguments {
    /// The MJCF file of the scene: the creature that learned the schema, a table before it, things on the table
    scene: PathBuf,
    /// The session whose schema it acts by
    session: PathBuf,
    /// A limb that it acts with; given twice, for there are two
    #[arg(long, value_name = "LIMB", default_values = ["left_hand", "right_hand"])]
    hand: Vec<String>,
    /// Seed of the ways that it tries
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON object per answer: heard, intent, said, done, asks, felt
    #[arg(long, help_heading = "Output")]
    json: bool,
    #[command(flatten)]
    live: LiveOptions,
}

pub fn run(args: &TalkArguments) -> Outcome {
    let [first, second] = args.hand.as_slice() else {
        return Err(Failure(format!(
            "--hand names {} of the limbs: name two, as in --hand left_hand --hand right_hand",
            args.hand.len()
        )));
    };
    let place = args.scene.display();
    // A file that is not there is told of as such, before anything is simulated.
    model_hash(&args.scene)?;
    let spinner = progress::spinner("getting ready");
    let (session, own) = own_body(&args.session)?;
    let selection: JointSelection = session.options.joints.parse().unwrap_or_default();
    let root = session.options.root.clone();
    let options = StageOptions { joints: selection, root, ..StageOptions::default() };
    let stage = Stage::new(&args.scene, &options);
    let stage = stage.map_err(|error| Failure(format!("{place}: {error}")))?;
    let actor = Actor::new(own, stage.handle(), [first, second], args.seed);
    let mut actor = actor.map_err(|error| Failure(format!("{place}: {error}")))?;
    stage.place(&actor.ready())?;
    let mut conversation = Conversation::new(actor)?;
    spinner.finish_and_clear();
    if let Some(address) = args.live.address() {
        return super::live::talk(conversation, &stage, address, session.agent.creature().name(), args.json);
    }
    let terminal = std::io::stdin().is_terminal();
    if terminal {
        tell!(
            "{} listens. An empty line or end of file ends the conversation.",
            session.agent.creature().name()
        );
    }
    for line in prompted(terminal && !super::message::quiet()) {
        let line = line.map_err(|error| Failure(format!("standard input cannot be read: {error}")))?;
        let request = line.trim();
        if request.is_empty() && terminal {
            break;
        }
        if request.is_empty() {
            continue;
        }
        let reply = conversation.hear(request)?;
        if args.json {
            output::line(format_args!("{}", reply.to_json(request)));
        } else {
            if !terminal {
                say!("> {request}");
            }
            say!("{}", reply.said);
        }
    }
    Ok(())
}

/// The lines of standard input, each asked for where a person types.
fn prompted(terminal: bool) -> impl Iterator<Item = std::io::Result<String>> {
    let mut lines = std::io::stdin().lock().lines();
    std::iter::from_fn(move || {
        if terminal {
            eprint!("> ");
            let _ = std::io::stderr().flush();
        }
        lines.next()
    })
}
