//! `bodyschema talk`: a conversation with a creature among things.

use std::path::PathBuf;

use super::happening::happens;
use super::live::LiveOptions;
use super::typed::Typed;
use super::{Failure, Outcome, output, progress};
use crate::creature::JointSelection;
use crate::interaction::{Actor, Conversation};
use crate::session::{model_hash, own_body};
use crate::simulation::{Stage, StageOptions};

/// Talk to a creature among things: it answers what a partner asks of it, line by line
///
/// It is blindfolded: all that it knows of its body is the schema of a session, and all that it knows of the scene it
/// has felt. Ask it in plain English, from a terminal or through a pipe, to
///
///   feel about for things, touch them, feel their shape, pick them up, put them far away or near, let go;
///   touch its own nose, left elbow or right knee; lean forward and try again, lean back, rest, get out of the way;
///   tell where a thing or a part of its body is, how far, how many, how big, near or far, what it feels, what it did.
///
/// It moves for a command or a polite request alone; a question it answers, "don't" it remembers, and where it is not sure
/// it asks. "Goodbye", Ctrl-D or the end of the input ends the talk; an empty line does nothing. What a hand touches it can
/// hold: it is welded to the hand until it is put down. With --live there is a page beside that shows it all as fast as it
/// would really move, on which you can also touch its skin.
///
/// A line "/grow LIMB MILLIMETRES" is no word to it but happens: from then on the joint that moves the limb is so much farther
/// out on the limb that carries it. It is not told, and notices when it touches itself.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
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
    let page = args.live.place()?;
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
    if let Some(page) = page {
        return super::live::talk(conversation, &stage, page, session.agent.creature().name(), args.json);
    }
    let mut typed = Typed::new()?;
    let terminal = typed.in_terminal();
    if terminal {
        tell!(
            "{} listens. Say goodbye, or end it with Ctrl-D; \"help\" tells what can be said.",
            session.agent.creature().name()
        );
    }
    while let Some(request) = typed.line()? {
        if request.is_empty() {
            continue;
        }
        if let Some(direction) = request.strip_prefix('/') {
            match happens(&stage, direction) {
                Ok(told) => tell!("{told}"),
                Err(Failure(why)) if terminal => tell!("{why}"),
                Err(failure) => return Err(failure),
            }
            continue;
        }
        let reply = conversation.hear(&request)?;
        if args.json {
            output::line(format_args!("{}", reply.to_json(&request)));
        } else {
            if !terminal {
                say!("> {request}");
            }
            say!("{}", reply.said);
        }
        if conversation.is_over() {
            break;
        }
    }
    Ok(())
}
