//! `bodyschema talk`: a conversation with a creature among things.

use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use super::live::{LiveOptions, Place, serve};
use super::typed::Typed;
use super::{Failure, Outcome, output, progress};
use crate::creature::JointSelection;
use crate::interaction::{Actor, Conversation};
use crate::session::{model_hash, own_body};
use crate::simulation::{Stage, StageOptions};
use crate::view::live::{Asked, TableView};

/// How often a page that shows a scene is told of it.
const SHOWN_EVERY: Duration = Duration::from_millis(30);
/// How long a touch is seen before anything is done about it.
const SEEN: Duration = Duration::from_millis(300);
/// How late simulated time may be to be caught up with: what is later has stood still to think.
const LATE: Duration = Duration::from_millis(100);
/// Most requests of pages that wait while he is at one.
const MOST_ASKED: usize = 16;
/// The most that a limb grows at once, millimetres.
const LONGEST_GROWTH: f64 = 300.0;

/// Talk to a creature in a scene, line by line
///
/// It is blindfolded: all it knows of its body is the schema of a session, and all it knows of the scene is what it has
/// felt. From a terminal or through a pipe, ask it in plain English to
///
///   feel around for things, touch them, feel their shape, pick them up, put them far away or near, let go;
///   touch its own nose, left elbow or right knee; lean forward and try again, lean back, rest, get out of the way;
///   say where a thing or a part of its body is, how far, how many, how big, near or far, what it feels, what it did.
///
/// It moves only when commanded or politely asked to; it answers questions, remembers a "don't", and asks if it is unsure.
/// "Goodbye", Ctrl-D or the end of the input ends the conversation; empty lines are ignored. A hand can hold whatever it
/// touches: the thing is welded to the hand until it is put down. With --live, a page shows everything in real time, and
/// you can touch the creature's skin there.
///
/// The line "/grow LIMB MILLIMETRES" is not said to it but changes its body: the joint that moves the limb shifts outwards
/// by this much on its parent limb. The creature is not informed, and notices at the next self-touch.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
#[command(after_help = "Examples:
  bodyschema babble mjcf/max/max.xml
  bodyschema talk mjcf/max/table.xml sessions/max-1
  echo 'is there something in front of you?' | bodyschema talk mjcf/max/table.xml sessions/max-1 --json
  bodyschema talk mjcf/max/table.xml sessions/max-1 --live  # talk to it in a browser")]
pub struct TalkArguments {
    /// The MJCF file of the scene: the creature that learned the schema, at a table with things on it
    scene: PathBuf,
    /// The session whose schema it uses
    session: PathBuf,
    /// A limb that it acts with; give two
    #[arg(long, value_name = "LIMB", default_values = ["left_hand", "right_hand"])]
    hand: Vec<String>,
    /// Seed of the motions that it tries
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
            "--hand gives {} limbs: give two, as in --hand left_hand --hand right_hand",
            args.hand.len()
        )));
    };
    let page = args.live.place()?;
    // A file that is not there is told of as such, before anything is simulated.
    model_hash(&args.scene)?;
    let spinner = progress::spinner("getting ready");
    let (session, own) = own_body(&args.session)?;
    let selection: JointSelection = session.options.joints.parse().unwrap_or_default();
    let root = session.options.root.clone();
    let options = StageOptions { joints: selection, root, ..StageOptions::default() };
    let stage = Stage::new(&args.scene, &options);
    let stage = stage.map_err(|error| Failure::at(&args.scene, error))?;
    let actor = Actor::new(own, stage.handle(), [first, second], args.seed);
    let mut actor = actor.map_err(|error| Failure::at(&args.scene, error))?;
    stage.place(&actor.ready())?;
    let conversation = Conversation::new(actor)?;
    spinner.finish_and_clear();
    let name = session.agent.creature().name();
    let mut talk = Talk { conversation, stage: &stage, name, json: args.json, view: None };
    match page {
        Some(page) => talk.on_page(page),
        None => talk.typed(),
    }
}

/// A conversation with a creature on a stage, and what is printed of it.
struct Talk<'a> {
    conversation: Conversation,
    stage: &'a Stage,
    name: &'a str,
    json: bool,
    /// What a page shows of it, where there is one.
    view: Option<Arc<TableView>>,
}

impl Talk<'_> {
    /// On standard input alone.
    fn typed(&mut self) -> Outcome {
        let mut typed = Typed::new()?;
        let terminal = typed.in_terminal();
        if terminal {
            let name = self.name;
            tell!(
                "{name} is listening. Say \"help\" to see what you can ask; \"goodbye\" or Ctrl-D ends the conversation."
            );
        }
        while !self.conversation.is_over()
            && let Some(request) = typed.line()?
        {
            if !request.is_empty() {
                self.hear(Asked::Say(request), terminal)?;
            }
        }
        Ok(())
    }

    /// On a page and on standard input, with which it ends.
    fn on_page(&mut self, place: Place) -> Outcome {
        let (ask, asked) = mpsc::sync_channel(MOST_ASKED);
        let view = Arc::new(TableView::new(self.stage, ask)?);
        let _server = serve(place, view.clone())?;
        self.view = Some(view.clone());
        let (looked_on, mut shown) = (view.clone(), Instant::now());
        let (mut clock, mut simulated) = (Instant::now(), self.stage.time());
        self.stage.watched_by(Box::new(move |stage, felt| {
            // No faster than it would really be.
            let here = Duration::from_secs_f64((stage.time() - simulated).max(0.0));
            let really = clock.elapsed();
            if really > here + LATE {
                (clock, simulated) = (Instant::now(), stage.time());
            }
            std::thread::sleep(here.saturating_sub(really));
            if shown.elapsed() >= SHOWN_EVERY {
                looked_on.shows(stage, felt);
                shown = Instant::now();
            }
        }));
        // `None` if standard input has ended.
        let (hear, heard) = mpsc::sync_channel::<Option<Asked>>(0);
        let typed = hear.clone();
        std::thread::spawn(move || {
            let Ok(mut lines) = Typed::new() else { return };
            // Who never typed a line, as where standard input is /dev/null, is no partner to end it.
            let mut partner = lines.in_terminal();
            while let Ok(Some(line)) = lines.line() {
                partner = true;
                if !line.is_empty() && typed.send(Some(Asked::Say(line))).is_err() {
                    return;
                }
            }
            if partner {
                let _ = typed.send(None);
            }
        });
        std::thread::spawn(move || asked.iter().try_for_each(|asked| hear.send(Some(asked))));
        tell!("{} is listening, on the page and here", self.name);
        while !self.conversation.is_over()
            && let Ok(Some(asked)) = heard.recv()
        {
            self.hear(asked, true)?;
        }
        view.ends();
        Ok(())
    }

    /// Does what is asked, and prints the answer. Who is `patient` is told what cannot happen, and goes on.
    fn hear(&mut self, asked: Asked, patient: bool) -> Outcome {
        let says = |who: &str, said: &str, busy: bool| {
            self.view.iter().for_each(|view| view.says(who, said, busy));
        };
        let text = match &asked {
            Asked::Say(text) => text.clone(),
            Asked::Show(_) => return Ok(()),
            Asked::Touch(receptor) => {
                format!("(touches {})", self.conversation.actor.own.skin().receptors[*receptor].id)
            }
        };
        if let Some(direction) = text.strip_prefix('/') {
            let told = match happens(self.stage, direction) {
                Err(Failure(why)) if patient => why,
                told => told?,
            };
            says("the scene", &told, false);
            self.view.iter().for_each(|view| view.shows(self.stage, &[]));
            tell!("{told}");
            return Ok(());
        }
        says("you", &text, true);
        let reply = match asked {
            Asked::Say(_) | Asked::Show(_) => self.conversation.hear(&text)?,
            Asked::Touch(receptor) => {
                self.view.iter().for_each(|view| view.feels(&[receptor]));
                std::thread::sleep(SEEN);
                self.conversation.touched(receptor)?
            }
        };
        self.view.iter().for_each(|view| view.shows(self.stage, &[]));
        self.view.iter().for_each(|view| view.says(self.name, &reply.said, false));
        if self.json {
            output::line(format_args!("{}", reply.to_json(&text)));
            return Ok(());
        }
        // A partner at a terminal without a page sees what was typed.
        if self.view.is_some() || !patient {
            say!("> {text}");
        }
        say!("{}", reply.said);
        Ok(())
    }
}

/// What happens on the stage by a line that begins with a slash, without it; what did, in words.
///
/// # Errors
/// Where nothing happens by it: how it is written.
pub fn happens(stage: &Stage, direction: &str) -> Result<String, Failure> {
    let words: Vec<&str> = direction.split_whitespace().collect();
    let ["grow", name, length] = words.as_slice() else {
        return Err(Failure(format!(
            "/{direction}: unknown command: write /grow LIMB MILLIMETRES, such as /grow left_hand 30"
        )));
    };
    let creature = &stage.body().creature;
    let limb = creature.limb(name).filter(|limb| *limb > 0).ok_or_else(|| {
        let limbs = creature.limbs()[1..].join(", ");
        Failure(format!("/{direction}: no joint moves a limb {name}: choose one of {limbs}"))
    })?;
    let millimetres = length.parse::<f64>().ok().filter(|x| x.abs() <= LONGEST_GROWTH).ok_or_else(|| {
        Failure(format!(
            "/{direction}: {length} is not a number of millimetres between -{LONGEST_GROWTH} and {LONGEST_GROWTH}"
        ))
    })?;
    stage.grow_limb(limb, 1e-3 * millimetres)?;
    Ok(format!("the joint of {name} has moved outwards by {millimetres} mm"))
}
