//! What `bodyschema babble` is asked, and what a session that begins and one that goes on share.

use std::cell::Cell;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::arguments::{positive, touch_count};
use super::folders::Force;
use super::learned::{learn_and_report, print_learned};
use super::learning_arguments::{KNOWN_HELP, LearningArguments};
use super::live::{Live, LiveOptions, Place};
use super::open::{MAX, ModelArguments, embodied, is_there};
use super::progress::Bars;
use super::{Failure, Outcome};
use crate::babbling::PolicyName;
use crate::creature::JointSelection;
use crate::session::{
    BabbledSession, BabbledShares, BabblingSession, Embodied, FolderLock, Observer, SessionRequest,
    SessionSetup,
};
use crate::share::Share;
use crate::simulation::MotionName;

/// Babble, touch, learn the body schema, and measure it.
///
/// The creature moves about, few joints at first, and stops where its skin touches its skin. From the pairs of
/// receptors and the joint angles alone it learns where its joints are and how they turn, and touches what it does not
/// know yet; the model's own kinematics serve only to measure the result. All goes into a session folder.
#[derive(clap::Args, Clone, Serialize, Deserialize)]
#[command(after_help = format!("Examples:
  bodyschema babble                                                          # Max, mjcf/max/max.xml
  bodyschema babble mjcf/hexapod/hexapod.xml
  bodyschema babble mjcf/max/max.xml --touches 500 --input contact --json
  bodyschema babble mjcf/max/max.xml --joints all --touches 5000 --jobs 4    # takes minutes
  bodyschema babble mjcf/max/max.xml --touches 300 --motion dynamic          # takes minutes
  bodyschema babble mjcf/max/max.xml --learner hersch --json
  bodyschema babble mjcf/max/max.xml --touches 500 --live                    # watch it in a browser
  bodyschema babble --resume sessions/max-1
  bodyschema babble mjcf/max/max.xml --touches 100000 --shard 3/16 --out sessions/big  # takes minutes
  bodyschema babble mjcf/max/max.xml --touches 60 --known known.json\n\n{KNOWN_HELP}"))]
pub struct BabbleArguments {
    /// The MJCF or URDF file of a creature; without touch sensors it gets some in memory
    #[arg(default_value = MAX, value_name = "MODEL")]
    model: PathBuf,
    /// Touches to make; stages end by themselves where all is known that can be touched [default: 1000; of stages 4000 at the
    /// most]
    #[arg(long, value_parser = touch_count, help_heading = "Babbling")]
    touches: Option<usize>,
    /// Seconds after which the session comes to its end with what is known by then: what that is depends on what else the
    /// computer does [default: none]
    #[arg(long, value_parser = positive, conflicts_with = "work", help_heading = "Babbling")]
    seconds: Option<f64>,
    /// Work after which it does so, the same on any computer: about what one core does in so many seconds [default: 50; none with
    /// --seconds, --touches or --motion dynamic]
    #[arg(long, value_parser = positive, help_heading = "Babbling")]
    work: Option<f64>,
    /// Seed of all random numbers: the same seed gives the same touches
    #[arg(long, default_value_t = 1, help_heading = "Babbling")]
    pub seed: u64,
    /// The joints that move: a set that the model names (torso), all, or names separated by commas
    /// [default: torso where the model names it, else all]
    #[arg(long, help_heading = "Babbling")]
    joints: Option<JointSelection>,
    /// Threads; they change nothing but the time [default: one per core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = "Babbling")]
    #[serde(skip)]
    pub jobs: Option<u16>,
    /// How motions are chosen; all but random learn a schema on the way to choose by, on one thread [default: stages for
    /// known surfaces, undisturbed, without physics and known joints, unless another learner than growth is
    /// named; else random]
    #[arg(long, value_enum, help_heading = "Babbling")]
    policy: Option<PolicyName>,
    /// How the body is moved: straight through its postures, or by servos in a simulation with gravity
    #[arg(long, value_enum, default_value_t, help_heading = "Babbling")]
    pub motion: MotionName,
    #[command(flatten)]
    #[serde(flatten)]
    open: ModelArguments,
    #[command(flatten)]
    #[serde(flatten)]
    learning: LearningArguments,
    /// The session's folder [default: the first free of sessions/CREATURE-1, -2, …]
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    #[serde(skip)]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    #[serde(skip)]
    pub force: Force,
    /// Go on with a session that was interrupted, with the options that are in its session.json: its touches become
    /// what they would have been. Takes --jobs, --json and --live beside it
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    #[serde(skip)]
    pub resume: Option<PathBuf>,
    /// Babble only this share of the session, as in 3/16: other processes, here or elsewhere, make the others, and
    /// `bodyschema study merge DIR` makes of all what one process would have made. Babbles at random; the same command goes on
    /// with a share that was interrupted
    #[arg(
        long,
        value_name = "SHARE",
        requires = "out",
        conflicts_with_all = ["resume", "seconds", "work", "force"],
        help_heading = "Output"
    )]
    #[serde(skip)]
    pub shard: Option<Share>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    #[serde(skip)]
    pub json: bool,
    #[command(flatten)]
    #[serde(skip)]
    pub live: LiveOptions,
}

impl BabbleArguments {
    /// What is asked, from now on.
    fn request(&self) -> SessionRequest {
        SessionRequest {
            touches: self.touches,
            seconds: self.seconds,
            work: self.work,
            seed: self.seed,
            jobs: self.jobs,
            policy: self.policy,
            motion: self.motion,
            learner: self.learning.named(),
            learning: self.learning.open(),
            known: self.learning.known.clone(),
            share: self.shard,
            ..SessionRequest::default()
        }
    }
}

/// All that is made ready before the first touch.
pub struct Prepared {
    pub embodied: Embodied,
    pub setup: SessionSetup,
    /// Where a page is to be served, until it is.
    place: Cell<Option<Place>>,
}

impl Prepared {
    pub fn new(args: &BabbleArguments) -> Result<Prepared, Failure> {
        is_there(&args.model, "babble")?;
        let embodied = embodied(args.open.source(&args.model, args.joints.clone().unwrap_or_default()))?;
        let setup = args.request().setup(&embodied)?;
        // Whether it can be watched is told before any folder is made.
        let place = Cell::new(args.live.place()?);
        Ok(Prepared { embodied, setup, place })
    }

    /// What is asked with all that is chosen by default and by what else is asked, as a session keeps it: versions to come may
    /// choose otherwise.
    pub fn asked(&self, args: &BabbleArguments) -> Value {
        let SessionSetup { babbling, policy, learning, .. } = &self.setup;
        let asked = serde_json::to_value(BabbleArguments {
            touches: Some(babbling.touches),
            policy: Some(*policy),
            work: args.request().work(),
            learning: args.learning.chosen(learning.learner),
            ..args.clone()
        });
        // A session of files whose names are not in UTF-8 cannot be resumed.
        asked.unwrap_or_default()
    }

    /// Babbles what is missing, learns, and prints the result.
    pub fn babble(&self, args: &BabbleArguments, lock: FolderLock, session: BabblingSession) -> Outcome {
        let live = self.live(session.made())?;
        let (bars, live) = (Bars::default(), live.as_ref());
        let observers = observers(&bars, live);
        let babbled = session.babble(&observers)?;
        self.learn_with(args, lock, &babbled, &observers, live)
    }

    /// Puts shares together, learns, and prints the result.
    pub fn put_together(
        &self,
        args: &BabbleArguments,
        lock: FolderLock,
        session: BabblingSession,
        shares: &BabbledShares,
    ) -> Outcome {
        let bars = Bars::default();
        let babbled = session.put_together(shares, &bars)?;
        self.learn_with(args, lock, &babbled, &bars, None)
    }

    /// Learns from all touches, and prints the result.
    pub fn learn(&self, args: &BabbleArguments, lock: FolderLock, babbled: &BabbledSession) -> Outcome {
        let live = self.live(babbled.touches.len())?;
        let (bars, live) = (Bars::default(), live.as_ref());
        self.learn_with(args, lock, babbled, &observers(&bars, live), live)
    }

    fn learn_with(
        &self,
        args: &BabbleArguments,
        lock: FolderLock,
        babbled: &BabbledSession,
        observer: &dyn Observer,
        live: Option<&Live>,
    ) -> Outcome {
        let BabbledSession { session, touches, .. } = babbled;
        let learning = &self.setup.learning;
        let truth = Some(self.embodied.truth());
        let result = learn_and_report(&lock, babbled, learning, truth, observer)?;
        if let Some(limit) = session.effort.and_then(|effort| effort.ended_by) {
            tell!("babbling ended {limit}, after {} touches", touches.len());
        }
        if let Some(limit) = result.ended_by {
            tell!("the search for what explains them ended {limit}");
        }
        let folder = lock.place();
        if let Some(live) = live {
            live.done(folder, &result);
        }
        print_learned(folder, session, touches, learning, &result, args.json)?;
        // Who goes on looking keeps nobody from the folder.
        drop(lock);
        if let Some(live) = live {
            live.rest();
        }
        Ok(())
    }

    /// The page to watch it on, where one is asked for.
    fn live(&self, made: usize) -> Result<Option<Live>, Failure> {
        let place = self.place.take();
        place.map(|place| Live::new(place, &self.embodied, &self.setup, made)).transpose()
    }
}

/// Who looks on: progress bars, and the page if there is one.
fn observers<'a>(bars: &'a Bars, live: Option<&'a Live>) -> Vec<&'a dyn Observer> {
    let mut all: Vec<&dyn Observer> = vec![bars];
    all.extend(live.map(|live| live.view() as &dyn Observer));
    all
}
