//! What a creature knows of its own body when it acts: its tree, its skin, the schema it learned, and how sure of it
//! its touches make it.

use std::fmt;

use nalgebra::{Matrix3, Vector3};
use rand::{Rng, RngExt};

use crate::agent::Agent;
use crate::creature::{Creature, Posture};
use crate::geometry::Frame;
use crate::kinematics::{Chain, InverseKinematics, Place, limb_frames};
use crate::learning::{Account, Certainty, Learned};
use crate::named::enumerated;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// A body is known well enough to act where skin is expected within this, metres: a fingertip's radius.
const TRUSTED: f64 = 0.008;

/// A creature's knowledge of its body.
#[derive(Clone, Debug)]
pub struct OwnBody {
    pub(super) agent: Agent,
    /// Where the joints are and how they turn.
    pub schema: BodySchema,
    /// How sure that is.
    pub certainty: Certainty,
    /// Postures that it was in without harm: those of its touches.
    pub experienced: Vec<Posture>,
}

/// Why a creature does not trust its schema.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// Nothing tells how far off it is.
    Unknown,
    /// The touches do not tell where skin is. Named are the joints whose place or axis they do not bound.
    Undetermined(Vec<String>),
    /// Skin may be too far off. Named are the joints whose place or axis is not known well enough.
    Inexact {
        /// The joints, or `None` if no single one stands out.
        joints: Vec<String>,
        /// One standard deviation, metres.
        deviation: f64,
    },
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |joints: &[String]| match joints {
            [] => "the joints between".to_string(),
            joints => enumerated(joints),
        };
        match self {
            Doubt::Unknown => f.write_str(
                "I cannot say how far off I may be, because no held-out touch confirms what I learned",
            ),
            Doubt::Inexact { joints, deviation } => {
                write!(f, "I may be {:.0} mm off, for I hardly know {}", 1e3 * deviation, list(joints))
            }
            Doubt::Undetermined(joints) => match joints.as_slice() {
                [one] => write!(f, "I have not found out where {one} is and how it turns"),
                joints => write!(f, "I have not found out where {} are and how they turn", list(joints)),
            },
        }
    }
}

impl OwnBody {
    /// A schema, how sure it is, and the postures that it was learned in.
    pub fn new<'p>(
        agent: &Agent,
        schema: BodySchema,
        certainty: Certainty,
        experienced: impl IntoIterator<Item = &'p Posture>,
    ) -> OwnBody {
        let experienced = experienced.into_iter().cloned().collect();
        OwnBody { agent: agent.clone(), schema, certainty, experienced }
    }

    /// What is known after learning in some postures.
    pub fn of<'p>(
        agent: &Agent,
        learned: &Learned,
        experienced: impl IntoIterator<Item = &'p Posture>,
    ) -> OwnBody {
        OwnBody::new(agent, learned.schema.clone(), learned.certainty(), experienced)
    }

    /// Who it is.
    pub fn agent(&self) -> &Agent {
        &self.agent
    }

    /// The tree of joints, and the limbs.
    pub fn creature(&self) -> &Creature {
        self.agent.creature()
    }

    /// Receptors and surfaces of the limbs.
    pub fn skin(&self) -> &Skin {
        self.agent.skin()
    }

    /// The same body with another schema, taken as it is.
    pub fn with_schema(&self, schema: BodySchema) -> OwnBody {
        OwnBody { schema, certainty: Certainty::Exact, ..self.clone() }
    }

    /// What its touches determine of it; `None` if it is taken as it is, or nothing is known of that.
    pub fn account(&self) -> Option<&Account> {
        match &self.certainty {
            Certainty::Estimated(account) => Some(account),
            Certainty::Exact | Certainty::Unknown => None,
        }
    }

    /// `X_RL` of every limb in the root's frame.
    pub fn frames(&self, posture: &[f64]) -> Vec<Frame> {
        limb_frames(self.creature(), &self.schema, posture)
    }

    /// The rest posture: the reference, or as near to it as ranges allow.
    pub fn at_ease(&self) -> Posture {
        Posture::start(self.creature())
    }

    /// A posture drawn from the ranges of some joints; the others, and balls, stay as they are in `base`.
    pub fn random_posture(&self, base: &[f64], joints: &[usize], rng: &mut impl Rng) -> Posture {
        self.drawn(base, joints, |_, [low, high]| rng.random_range(low..high))
    }

    /// A posture in which some joints differ from `from` by at most `radius`, radians (or metres), and stay in their ranges;
    /// the others, and balls, stay as they are.
    pub fn posture_near(&self, from: &[f64], joints: &[usize], radius: f64, rng: &mut impl Rng) -> Posture {
        self.drawn(from, joints, |q, [low, high]| (q + rng.random_range(-radius..radius)).clamp(low, high))
    }

    /// A posture in which some joints are as `draw` has them by where they are in `base` and by their ranges.
    fn drawn(&self, base: &[f64], joints: &[usize], mut draw: impl FnMut(f64, [f64; 2]) -> f64) -> Posture {
        let mut posture = Posture::from(base);
        for joint in joints.iter().map(|&joint| &self.creature().joints()[joint]) {
            for at in joint.elements().filter(|at| !at.is_ball() && at.follows.is_none()) {
                if at.range[1] > at.range[0] {
                    posture[at.coordinate()] = draw(posture[at.coordinate()], at.range);
                }
            }
        }
        self.creature().couple(&mut posture);
        posture
    }

    /// A place of a limb's skin under a receptor's middle: on the surface itself, where the patch is but flat.
    pub fn place(&self, receptor: usize) -> Place {
        let place = self.skin().receptors[receptor].place(0.0);
        self.on_surface(receptor, &place.point).unwrap_or(place)
    }

    /// Inverse kinematics that moves some joints to bring a place of a limb to a point of the root's frame, facing in a unit
    /// direction; where that is zero, the place may face anywhere.
    pub fn bringing(
        &self,
        place: Place,
        point: Vector3<f64>,
        direction: Vector3<f64>,
        joints: &[usize],
    ) -> InverseKinematics<'_> {
        let facing = if direction == Vector3::zeros() { direction } else { place.direction };
        let ends = [Place { direction: facing, ..place }, Place { limb: 0, point, direction }];
        InverseKinematics::new(self.creature(), &self.schema, ends).moving(|joint| joints.contains(&joint))
    }

    /// The place of a receptor's patch that leads when its limb moves in a direction, in the limb's frame: where a patch
    /// is bent about a limb, that is where it meets what is there.
    pub fn leading(&self, receptor: usize, ahead: &Vector3<f64>) -> Place {
        const SAMPLES: i32 = 4;
        const SHARPNESS: i32 = 8;
        let found = &self.skin().receptors[receptor];
        let Some(surface) = found.surface.map(|surface| &self.skin().surfaces[surface]) else {
            return self.place(receptor);
        };
        let (mut point, mut weight) = (Vector3::zeros(), 0.0);
        for i in -SAMPLES..=SAMPLES {
            for j in -SAMPLES..=SAMPLES {
                let flat = found.patch_point([i, j].map(|k| f64::from(k) / f64::from(SAMPLES)));
                if let Some((distance, normal)) = surface.signed_distance(&flat) {
                    let leads = normal.dot(ahead).max(0.0).powi(SHARPNESS);
                    point += (flat - normal * distance) * leads;
                    weight += leads;
                }
            }
        }
        let leads = (weight > 1e-9).then(|| self.on_surface(receptor, &(point / weight))).flatten();
        leads.unwrap_or_else(|| self.place(receptor))
    }

    /// The place of the surface under a receptor that is nearest to a point of the limb; `None` if it is not known.
    pub fn on_surface(&self, receptor: usize, p_l: &Vector3<f64>) -> Option<Place> {
        let found = &self.skin().receptors[receptor];
        let (distance, normal) = self.skin().surfaces[found.surface?].signed_distance(p_l)?;
        Some(Place { limb: found.limb, point: p_l - normal * distance, direction: normal })
    }

    /// The receptors on some limbs.
    pub fn receptors_on(&self, limbs: &[usize]) -> Vec<usize> {
        let receptors = self.skin().receptors.iter().enumerate();
        receptors.filter(|(_, receptor)| limbs.contains(&receptor.limb)).map(|(r, _)| r).collect()
    }

    /// Some receptors by how far they are from a limb's joint in the rest posture, the farthest first.
    pub fn from_tip(&self, limb: usize, receptors: &[usize]) -> Vec<usize> {
        let frames = self.frames(&self.at_ease());
        let far = |&receptor: &usize| {
            let place = self.place(receptor);
            (frames[place.limb].point(&place.point) - frames[limb].origin).norm()
        };
        let mut sorted = receptors.to_vec();
        sorted.sort_by(|a, b| far(b).total_cmp(&far(a)));
        sorted
    }

    /// A limb and all that it carries: a hand with its fingers.
    pub fn hand_of(&self, limb: usize) -> Vec<usize> {
        let carried = self.carried_by(limb);
        (0..carried.len()).filter(|&limb| carried[limb]).collect()
    }

    /// The limbs that one limb carries, itself among them.
    pub fn carried_by(&self, limb: usize) -> Vec<bool> {
        self.creature().carried_by(limb)
    }

    /// The limbs that move with some joints.
    pub fn moved_by(&self, joints: &[usize]) -> Vec<bool> {
        let mut moved = vec![false; self.creature().limbs().len()];
        for &joint in joints {
            self.carried_by(joint + 1).into_iter().zip(&mut moved).for_each(|(by, any)| *any |= by);
        }
        moved
    }

    /// The joints between the root and a limb, root's side first.
    pub fn joints_to(&self, limb: usize) -> Vec<usize> {
        Chain::between(self.creature(), 0, limb).sides[1].clone()
    }

    /// The joints that carry this limb and none of `others`: those that move it alone, root's side first.
    pub fn joints_of(&self, limb: usize, others: &[usize]) -> Vec<usize> {
        let carries = |joint: usize| others.iter().any(|&other| self.joints_to(other).contains(&joint));
        self.joints_to(limb).into_iter().filter(|&joint| !carries(joint)).collect()
    }

    /// The covariance with which a point of a limb is put into another limb's frame, in that frame, m²: "given a
    /// proprioceptive input, together with input from a certain touch receptor to a corresponding particular posture, the
    /// body schema can predict proprioceptive sensor consequences for other touch receptors" (IVA 2009, section 3.1). `None`
    /// if nothing bounds it. All zero where a schema is taken as it is.
    pub fn covariance(&self, posture: &[f64], limbs: [usize; 2], p_a: &Vector3<f64>) -> Option<Matrix3<f64>> {
        match &self.certainty {
            Certainty::Exact => Some(Matrix3::zeros()),
            Certainty::Estimated(account) => {
                account.observability.point_covariance(self.creature(), &self.schema, posture, limbs, p_a)
            }
            Certainty::Unknown => None,
        }
    }

    /// Whether skin of a limb can be put into the frame of another at a posture: to what acting trusts, or as exactly as noisy touches tell
    /// at all.
    ///
    /// # Errors
    /// What is lacking, where it cannot.
    pub fn trusts(&self, posture: &[f64], limbs: [usize; 2], p_a: &Vector3<f64>) -> Result<(), Doubt> {
        let account = match &self.certainty {
            Certainty::Exact => return Ok(()),
            Certainty::Estimated(account) => account,
            Certainty::Unknown => return Err(Doubt::Unknown),
        };
        let found = &account.observability;
        let deviation = self.covariance(posture, limbs, p_a).map(|c| c.trace().max(0.0).sqrt());
        let as_told = account.claims(limbs[0], limbs[1]);
        if deviation.is_some_and(|metres| as_told || metres <= TRUSTED) {
            return Ok(());
        }
        let unsure = |&joint: &usize| {
            let position = found.position_std(joint);
            let axes = self.creature().joints()[joint].dof_indices();
            position.iter().any(|std| std.is_none_or(|metres| metres > 0.5 * TRUSTED))
                || axes
                    .into_iter()
                    .any(|dof| found.axis_std(self.creature(), dof).is_none_or(|std| std > 0.02))
        };
        let chain = Chain::between(self.creature(), limbs[0], limbs[1]);
        let name = |joint: usize| self.creature().joints()[joint].name.clone();
        let joints: Vec<String> = chain.joints().filter(unsure).map(name).collect();
        Err(match deviation {
            Some(deviation) => Doubt::Inexact { joints, deviation },
            None => Doubt::Undetermined(joints),
        })
    }
}
