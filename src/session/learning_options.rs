//! How to learn: the kind of learner, what a touch reports to it, what it knows, and what disturbs it.

use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::agent::Agent;
use crate::babbling::PolicyName;
use crate::creature::{Creature, DofKind};
use crate::deadline::Deadline;
use crate::error::Error;
#[cfg(feature = "cli")]
use crate::given_number::not_negative;
use crate::learning::growth::Growth;
use crate::learning::initial_guess::random_guess;
use crate::learning::learners::{
    LEARNERS, LearnerGivens, LearnerKind, LearnerUses, PartByPart, learner_kind,
};
use crate::learning::{
    Input, KnownJoint, Learner, LearnerInUnit, LengthUnit, LimbFrames, SecondOrder, SkinKnowledge,
};
use crate::named::listed;
use crate::schema::BodySchema;
use crate::senses::Disturbances;
use crate::session::{Session, read_known};
use crate::skin::Receptor;

/// How to learn. What is left open is chosen by the touches.
#[derive(Clone, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args), command(next_help_heading = "Learning"))]
pub struct LearningOptions {
    /// The learner [default: growth for touches made by stages, if surfaces are known and nothing is disturbed; else lm]
    #[cfg_attr(feature = "cli", arg(long, value_parser = learners()))]
    pub learner: Option<&'static dyn LearnerKind>,
    /// What a touch reports [default: receptor; for a recording, whatever it contains]
    #[cfg_attr(feature = "cli", arg(long, value_enum))]
    pub input: Option<Input>,
    /// What the agent knows about its skin
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t))]
    pub skin: SkinKnowledge,
    /// The frames in which points on limbs are given (limb needs the learner lm and --input contact)
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t))]
    pub frames: LimbFrames,
    /// Prior knowledge of joints, for the learner lm: a schema.json with all or some of its joints. A joint without deviations
    /// is exact and stays fixed; position_std (metres) and axis_std (radians) are standard deviations of a prior
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    pub known: Option<PathBuf>,
    /// What is wrong with the agent's senses.
    #[cfg_attr(feature = "cli", command(flatten))]
    #[serde(flatten)]
    pub disturbances: DisturbanceLevels,
    /// The joints in the file `known`, once it is read.
    #[cfg_attr(feature = "cli", arg(skip))]
    #[serde(skip)]
    pub known_joints: Vec<KnownJoint>,
    /// After which it learns from what it has.
    #[cfg_attr(feature = "cli", arg(skip))]
    #[serde(skip)]
    pub deadline: Deadline,
}

impl LearningOptions {
    /// The learner: the default one unless another was chosen.
    pub fn kind(&self) -> &'static dyn LearnerKind {
        self.learner.unwrap_or(LEARNERS[0])
    }

    /// Whether a body can grow part by part with what is given: by receptors on known surfaces or from contact points,
    /// undisturbed.
    pub fn grows(&self) -> bool {
        self.skin == SkinKnowledge::Surface
            && self.frames == LimbFrames::Joint
            && self.known.is_none()
            && self.disturbances == DisturbanceLevels::default()
    }

    /// What touches report.
    pub fn input(&self) -> Input {
        self.input.unwrap_or_default()
    }

    /// What the learner is given beside a body.
    pub(crate) fn givens(&self) -> LearnerGivens {
        LearnerGivens {
            input: self.input(),
            skin: self.skin,
            frames: self.frames,
            known: self.known_joints.clone(),
            grown: None,
        }
    }

    /// These options for a creature, with all that was left open: the learner that suits touches by a policy (`None` if they
    /// were recorded), and the joints in the file of prior knowledge.
    ///
    /// # Errors
    /// If that file cannot be read, or the options exclude one another.
    pub(super) fn chosen(
        mut self,
        policy: Option<PolicyName>,
        creature: &Creature,
    ) -> Result<LearningOptions, Error> {
        let grown = policy == Some(PolicyName::Stages) && self.grows();
        let learner = self.learner.unwrap_or(if grown { &PartByPart } else { LEARNERS[0] });
        self.learner = Some(learner);
        self.check(creature)?;
        if let Some(path) = &self.known {
            if !learner.uses().known_joints {
                let reason = format!(
                    "the learner {} does not use prior knowledge: use --learner {}, or leave out --known",
                    learner.name(),
                    learners_that(|uses| uses.known_joints)
                );
                return Err(Error::unfit(path, reason));
            }
            self.known_joints = read_known(path, creature)?;
        }
        Ok(self)
    }

    /// Whether a creature can be learned with these options.
    pub(crate) fn check(&self, creature: &Creature) -> Result<(), Error> {
        if self.kind().uses().surfaces_alone && self.skin != SkinKnowledge::Surface {
            return Err(Error::usage(format!(
                "--learner {} needs the surfaces under receptors: leave out --skin, or use --learner {}",
                self.kind().name(),
                LEARNERS[0].name()
            )));
        }
        self.check_frames(creature)
    }

    /// Whether the limbs' frames can be found.
    fn check_frames(&self, creature: &Creature) -> Result<(), Error> {
        if self.frames == LimbFrames::Joint {
            return Ok(());
        }
        let refuse = |why: &str| Err(Error::usage(format!("--frames limb: {why}")));
        if !self.kind().uses().limb_frames {
            let able = learners_that(|uses| uses.limb_frames);
            return refuse(&format!(
                "only the learner {able} estimates the limbs' frames: use --learner {able}"
            ));
        }
        if self.input() != Input::Contact {
            return refuse(
                "receptors are too coarse to determine the orientation of a round limb in its frame: use --input contact",
            );
        }
        if self.known.is_some() {
            return refuse("joints cannot have prior knowledge: leave out --known");
        }
        match creature.dofs().find(|dof| dof.kind == DofKind::Ball) {
            Some(ball) => refuse(&format!(
                "{} is a ball, whose angles refer to the axes of the joint's frame: select hinges and slides with \
                 --joints, or use --frames joint",
                ball.name
            )),
            None => Ok(()),
        }
    }

    /// These options for a session's touches, with all that was left open; those of a recording report what the recording
    /// holds.
    ///
    /// # Errors
    /// If receptors are asked for and the recording has none, the file of prior knowledge cannot be read, or the options exclude
    /// one another.
    pub fn for_session(&self, session: &Session) -> Result<LearningOptions, Error> {
        let mut options = self.clone();
        if let Some(recording) = &session.recording {
            let bare = |receptor: &Receptor| receptor.surface.is_none() && receptor.half_extents == [0.0; 2];
            if self.input == Some(Input::Receptor) && session.agent.skin().receptors.iter().any(bare) {
                return Err(Error::unfit(
                    Path::new(&recording.log),
                    "its touches are points on limbs without a skin: use --input contact, or leave out --input",
                ));
            }
            let recorded = session.options.input.as_deref().and_then(|input| input.parse().ok());
            options.input = self.input.or(recorded);
        }
        let policy = session.options.policy.as_deref().and_then(|policy| policy.parse().ok());
        options.chosen(policy, session.agent.creature())
    }

    /// The learner of a body, whose random numbers come from `seed`.
    pub fn learner(&self, agent: &Agent, seed: u64) -> Box<dyn Learner> {
        self.learner_from(agent, None, seed)
    }

    /// The same that goes on from what was learned while the touches were made, where the learner is one that can.
    pub fn learner_from(&self, agent: &Agent, grown: Option<&Growth>, seed: u64) -> Box<dyn Learner> {
        let given = LearnerGivens { grown: grown.cloned(), ..self.givens() };
        LearnerInUnit::of(agent, |agent, unit| {
            let known = given.known.iter().map(|known| known.scaled(1.0 / unit.metres())).collect();
            self.kind().learner(agent, &LearnerGivens { known, ..given }, seed)
        })
    }

    /// What the learner was allowed to know, in words.
    pub fn knowledge(&self) -> &'static str {
        match (self.input(), self.skin) {
            (Input::Contact, _) => "contact points",
            (Input::Receptor, SkinKnowledge::Surface) if self.kind().uses().surfaces => {
                "receptors and the surfaces under them"
            }
            (Input::Receptor, _) => "receptor centres",
        }
    }

    /// What is believed before the first touch: the initial guess of a learner that has but one, else one like those that
    /// it starts from.
    pub(crate) fn initial_guess(&self, agent: &Agent, seed: u64) -> BodySchema {
        let creature = agent.creature();
        let unit = LengthUnit::of(agent).metres();
        let initial_guess = random_guess(creature, &mut ChaCha8Rng::seed_from_u64(seed)).scaled(unit);
        if self.frames == LimbFrames::Limb { initial_guess.with_limb_poses() } else { initial_guess }
    }

    /// The learner of all touches at once, with this input and this knowledge of skin and frames.
    pub(crate) fn second_order(&self, agent: &Agent, seed: u64) -> SecondOrder {
        SecondOrder::new(agent, self.input(), seed).with_frames(self.frames).with_skin(self.skin)
    }

    /// The prior knowledge, in JSON: the file, and its joints with whether they were exact.
    pub(crate) fn known_json(&self, creature: &Creature) -> Value {
        let Some(file) = &self.known else { return Value::Null };
        let joint = |known: &KnownJoint| json!({ "joint": creature.joints()[known.joint].name, "exact": known.exact });
        json!({ "file": file, "joints": self.known_joints.iter().map(joint).collect::<Vec<_>>() })
    }

    /// The same in words.
    pub(crate) fn known_words(&self, creature: &Creature) -> Option<String> {
        self.known.as_ref()?;
        let named = |exact: bool| {
            let joints = self.known_joints.iter().filter(|known| known.exact == exact);
            listed(&joints.map(|known| creature.joints()[known.joint].name.clone()).collect::<Vec<_>>())
        };
        Some(format!("exactly {}; nearly {}", named(true), named(false)))
    }
}

/// The learners on the command line, by name.
#[cfg(feature = "cli")]
fn learners() -> impl clap::builder::TypedValueParser<Value = &'static dyn LearnerKind> {
    use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
    let choices = LEARNERS.iter().map(|learner| PossibleValue::new(learner.name()).help(learner.about()));
    PossibleValuesParser::new(choices).try_map(|name| learner_kind(&name).ok_or("unknown learner"))
}

/// The names of the learners that can use something.
fn learners_that(can: fn(LearnerUses) -> bool) -> String {
    let names = LEARNERS.iter().filter(|learner| can(learner.uses())).map(|learner| learner.name());
    names.collect::<Vec<_>>().join(" or ")
}

/// How much is wrong with an agent's senses, in degrees and millimetres; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[cfg_attr(
    feature = "cli",
    command(next_help_heading = "Disturbances (applied to the exact log before learning)")
)]
pub struct DisturbanceLevels {
    /// Standard deviation of every joint angle in every touch, degrees
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = not_negative))]
    #[serde(rename = "joint_noise_deg")]
    pub joint_noise: f64,
    /// Standard deviation, per coordinate, of the receptor positions that the agent is given, millimetres
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM", default_value_t = 0.0, value_parser = not_negative))]
    #[serde(rename = "receptor_noise_mm")]
    pub receptor_noise: f64,
    /// Share of touches with a wrong receptor at one end, at least 0 and below 1
    #[cfg_attr(feature = "cli", arg(long, value_name = "FRACTION", default_value_t = 0.0, value_parser = share))]
    pub false_touches: f64,
    /// Standard deviation, per coordinate, of both points of contact in every touch, millimetres; affects only `--input
    /// contact`
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM", default_value_t = 0.0, value_parser = not_negative))]
    #[serde(rename = "point_noise_mm")]
    pub point_noise: f64,
}

impl DisturbanceLevels {
    /// Senses that are right.
    pub(crate) const NONE: DisturbanceLevels =
        DisturbanceLevels { joint_noise: 0.0, receptor_noise: 0.0, false_touches: 0.0, point_noise: 0.0 };

    /// The same in radians and metres.
    pub fn disturbances(&self) -> Disturbances {
        Disturbances {
            joint_noise: self.joint_noise.to_radians(),
            receptor_noise: 1e-3 * self.receptor_noise,
            false_touches: self.false_touches,
            point_noise: 1e-3 * self.point_noise,
        }
    }
}

impl std::fmt::Display for DisturbanceLevels {
    /// Those that are not zero in words, or "none".
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        // Shares in percent are seldom exact in binary.
        let percent = (1e10 * self.false_touches).round() / 1e8;
        let all = [
            (self.joint_noise, format!("joint noise {}°", self.joint_noise)),
            (self.receptor_noise, format!("receptor noise {} mm", self.receptor_noise)),
            (self.false_touches, format!("false touches {percent} %")),
            (self.point_noise, format!("point noise {} mm", self.point_noise)),
        ];
        let present: Vec<String> =
            all.into_iter().filter(|(amount, _)| *amount > 0.0).map(|(_, words)| words).collect();
        f.write_str(if present.is_empty() { "none".to_string() } else { present.join(", ") }.as_str())
    }
}

/// A share from the command line.
#[cfg(feature = "cli")]
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|value| (0.0..1.0).contains(value));
    number.ok_or("give a number from 0 to below 1, such as 0.05 for one touch in twenty".into())
}

#[cfg(test)]
mod tests {
    use std::cmp::Ordering;

    use super::*;
    use crate::session::SessionRequest;

    /// The crane has slides, which are lengths in postures.
    const CRANE: &str = "mjcf/bodies/crane.xml";
    /// The longest limb of a body that is learned in metres, metres: at the least.
    const LEAST: f64 = 0.1;

    #[test]
    fn a_small_body_is_learned_as_a_large_one_to_the_digit() {
        let at_random = SessionRequest::at_random(400, 1);
        let babbled = Agent::from_mjcf(CRANE).unwrap().babble_as(&at_random).unwrap();
        let agent = babbled.embodied().agent();
        assert!(agent.creature().dofs().any(|dof| dof.kind == DofKind::Slide), "{CRANE} has no slide");
        let options = LearningOptions { input: Some(Input::Contact), ..LearningOptions::default() };
        // As small as a body may be that is learned in metres, and so small that it is learned in a unit of its own.
        let by = [0.0, 5.0]
            .map(|halvings: f64| (-(agent.skin().longest_limb() / LEAST).log2().floor() - halvings).exp2());
        let [large, small] = by.map(|by| {
            let scaled = agent.scaled(by);
            let mut learner = options.learner(&scaled, 1);
            let touches = babbled.touches().iter();
            touches
                .for_each(|touch| learner.touch(&touch.felt(options.input()).scaled(agent.creature(), by)));
            (LengthUnit::of(&scaled), learner.learn())
        });
        assert_eq!(large.0, LengthUnit::METRE);
        assert_eq!(small.0, LengthUnit::from_metres(1.0 / 32.0).unwrap());
        let (large, small) = (large.1, small.1);
        assert!(large.verdict.converged(), "{:?}", large.verdict);
        assert_eq!(small.verdict, large.verdict);
        assert_eq!(small.schema.scaled(32.0), large.schema);
        let (small, large) = (small.account.unwrap(), large.account.unwrap());
        assert_eq!(small.classes(), large.classes());
        assert_eq!(32.0 * small.limit(), large.limit());
        assert_eq!(small.observability.singular_values, large.observability.singular_values);
        for (a, b) in small.limbs().iter().flat_map(|&a| small.limbs().iter().map(move |&b| (a, b))) {
            assert_eq!(32.0 * small.distance(a, b), large.distance(a, b), "limbs {a} and {b}");
        }
    }

    #[test]
    fn bodies_of_a_persons_size_are_learned_in_metres() {
        for (model, unit) in [
            ("mjcf/max/max.xml", Ordering::Equal),
            ("mjcf/bodies/humanoid.xml", Ordering::Equal),
            ("mjcf/bodies/tiny.xml", Ordering::Less),
            ("mjcf/bodies/huge.xml", Ordering::Greater),
        ] {
            let found = LengthUnit::of(Agent::from_mjcf(model).unwrap().agent()).metres();
            assert_eq!(found.total_cmp(&1.0), unit, "{model}: {found}");
        }
    }
}
