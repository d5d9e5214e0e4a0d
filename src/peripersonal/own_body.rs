//! What a creature knows of its own body when it acts: its tree, its skin, the schema it learned, and how sure of it
//! its touches make it.

use std::fmt;

use nalgebra::{Matrix3, Vector3};
use rand::{Rng, RngExt};

use crate::babbling::start_posture;
use crate::creature::{Creature, DofKind};
use crate::kinematics::{Chain, Frame, Place, limb_frames};
use crate::learning::observability::Observability;
use crate::learning::{Input, Learner, SecondOrder};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

/// A body is known well enough to act where skin is expected within this, metres: a fingertip's radius.
pub const TRUSTED: f64 = 0.008;

/// A creature's knowledge of its body.
#[derive(Clone, Debug)]
pub struct OwnBody {
    /// The tree of joints, and the limbs.
    pub creature: Creature,
    /// Receptors and surfaces of the limbs.
    pub skin: Skin,
    /// Where the joints are and how they turn.
    pub schema: BodySchema,
    /// What the touches make sure; none where nobody asks.
    pub certainty: Option<Observability>,
    /// Postures that it was in without harm: those of its touches.
    pub experienced: Vec<Vec<f64>>,
}

/// Why a creature does not trust its schema.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The joints whose place or axis is not known well enough, or the whole chain where none stands out.
    pub joints: Vec<usize>,
    /// How far off skin beyond them may be, metres: one standard deviation; none where nothing bounds it.
    pub deviation: Option<f64>,
    names: Vec<String>,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joints = match self.names.as_slice() {
            [] => "the joints between".to_string(),
            [one] => one.clone(),
            [first @ .., last] => format!("{} and {last}", first.join(", ")),
        };
        match self.deviation {
            Some(metres) => write!(f, "I may be {:.0} mm off, for I hardly know {joints}", 1e3 * metres),
            None => write!(f, "I have not found out where {joints} is and how it turns"),
        }
    }
}

impl OwnBody {
    /// What is known after learning `schema` from touches of a kind.
    pub fn new(
        creature: &Creature,
        skin: &Skin,
        schema: BodySchema,
        touches: &[Touch],
        input: Input,
    ) -> OwnBody {
        let mut learner = SecondOrder::new(creature, skin, input, 0);
        touches.iter().for_each(|touch| learner.touch(touch));
        let certainty = (!touches.is_empty()).then(|| learner.observe(&schema).0);
        let experienced = touches.iter().map(|touch| touch.posture.clone()).collect();
        OwnBody { creature: creature.clone(), skin: skin.clone(), schema, certainty, experienced }
    }

    /// The same body with another schema, taken as it is.
    pub fn with_schema(&self, schema: BodySchema) -> OwnBody {
        OwnBody { schema, certainty: None, ..self.clone() }
    }

    /// `X_RL` of every limb in the root's frame.
    pub fn frames(&self, posture: &[f64]) -> Vec<Frame> {
        limb_frames(&self.creature, &self.schema, posture)
    }

    /// The posture at ease: that of the reference, or as near to it as ranges allow.
    pub fn at_ease(&self) -> Vec<f64> {
        start_posture(&self.creature)
    }

    /// A posture drawn from the ranges of some joints; the others, and balls, stay as they are in `base`.
    pub fn random_posture(&self, base: &[f64], joints: &[usize], rng: &mut impl Rng) -> Vec<f64> {
        let mut posture = base.to_vec();
        for &joint in joints {
            let joint = &self.creature.joints()[joint];
            let mut q = joint.first_coordinate();
            for dof in &joint.dofs {
                let [low, high] = dof.range;
                if dof.kind != DofKind::Ball && dof.follows.is_none() && high > low {
                    posture[q] = rng.random_range(low..high);
                }
                q += dof.kind.coordinates();
            }
        }
        self.creature.couple(&mut posture);
        posture
    }

    /// A place of a limb's skin under a receptor's middle: on the surface itself, where the patch is but flat.
    pub fn place(&self, receptor: usize) -> Place {
        let place = self.skin.receptors[receptor].place(0.0);
        self.on_surface(receptor, &place.point).unwrap_or(place)
    }

    /// The place of a receptor's patch that leads when its limb moves in a direction, in the limb's frame: where a patch
    /// is bent about a limb, that is where it meets what is there.
    pub fn leading(&self, receptor: usize, ahead: &Vector3<f64>) -> Place {
        const SAMPLES: i32 = 4;
        const SHARPNESS: i32 = 8;
        let found = &self.skin.receptors[receptor];
        let Some(surface) = found.surface.map(|surface| &self.skin.surfaces[surface]) else {
            return self.place(receptor);
        };
        let (mut point, mut weight) = (Vector3::zeros(), 0.0);
        for i in -SAMPLES..=SAMPLES {
            for j in -SAMPLES..=SAMPLES {
                let [a, b] = [i, j].map(|k| f64::from(k) / f64::from(SAMPLES));
                let flat = found.position
                    + found.tangent * (a * found.half_extents[0])
                    + found.bitangent() * (b * found.half_extents[1]);
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

    /// The place of the surface under a receptor that is nearest to a point of the limb; none where it is not known.
    pub fn on_surface(&self, receptor: usize, p_l: &Vector3<f64>) -> Option<Place> {
        let found = &self.skin.receptors[receptor];
        let (distance, normal) = self.skin.surfaces[found.surface?].signed_distance(p_l)?;
        Some(Place { limb: found.limb, point: p_l - normal * distance, direction: normal })
    }

    /// The limbs of an aura limb by its name, or the limb of this name.
    pub fn limbs_called(&self, name: &str) -> Option<Vec<usize>> {
        let aura = self.creature.aura_limbs().iter().find(|aura| aura.name == name);
        aura.map(|aura| aura.limbs.clone()).or_else(|| Some(vec![self.creature.limb(name)?]))
    }

    /// The receptors on some limbs.
    pub fn receptors_on(&self, limbs: &[usize]) -> Vec<usize> {
        let receptors = self.skin.receptors.iter().enumerate();
        receptors.filter(|(_, receptor)| limbs.contains(&receptor.limb)).map(|(r, _)| r).collect()
    }

    /// A limb and all that it carries: a hand with its fingers.
    pub fn hand_of(&self, limb: usize) -> Vec<usize> {
        let carried = self.carried_by(limb);
        (0..carried.len()).filter(|&limb| carried[limb]).collect()
    }

    /// The limbs that one limb carries, itself among them.
    pub fn carried_by(&self, limb: usize) -> Vec<bool> {
        let mut carried = vec![false; self.creature.limbs().len()];
        carried[limb] = true;
        for (j, joint) in self.creature.joints().iter().enumerate() {
            carried[j + 1] |= carried[joint.parent];
        }
        carried
    }

    /// The limbs that move with some joints.
    pub fn moved_by(&self, joints: &[usize]) -> Vec<bool> {
        let mut moved = vec![false; self.creature.limbs().len()];
        for &joint in joints {
            self.carried_by(joint + 1).into_iter().zip(&mut moved).for_each(|(by, any)| *any |= by);
        }
        moved
    }

    /// The joints between the root and a limb, root's side first.
    pub fn joints_to(&self, limb: usize) -> Vec<usize> {
        Chain::between(&self.creature, 0, limb).sides[1].clone()
    }

    /// The joints that carry this limb and none of `others`: those that move it alone, root's side first.
    pub fn joints_of(&self, limb: usize, others: &[usize]) -> Vec<usize> {
        let carries = |joint: usize| others.iter().any(|&other| self.joints_to(other).contains(&joint));
        self.joints_to(limb).into_iter().filter(|&joint| !carries(joint)).collect()
    }

    /// The covariance with which a point of a limb is put into another limb's frame, in that frame, m²; none where
    /// nothing bounds it. All zero where a schema is taken as it is.
    pub fn covariance(&self, posture: &[f64], limbs: [usize; 2], p_a: &Vector3<f64>) -> Option<Matrix3<f64>> {
        match &self.certainty {
            None => Some(Matrix3::zeros()),
            Some(found) => found.point_covariance(&self.creature, &self.schema, posture, limbs, p_a),
        }
    }

    /// Whether skin of a limb can be put into the frame of another to [`TRUSTED`], at a posture.
    ///
    /// # Errors
    /// What is lacking, where it cannot.
    pub fn trusts(&self, posture: &[f64], limbs: [usize; 2], p_a: &Vector3<f64>) -> Result<(), Doubt> {
        let Some(found) = &self.certainty else { return Ok(()) };
        let deviation = self.covariance(posture, limbs, p_a).map(|c| c.trace().max(0.0).sqrt());
        if deviation.is_some_and(|metres| metres <= TRUSTED) {
            return Ok(());
        }
        let unsure = |&joint: &usize| {
            let position = found.position_std(joint);
            let axes = self.creature.joints()[joint].dof_indices();
            position.iter().any(|std| std.is_none_or(|metres| metres > 0.5 * TRUSTED))
                || axes
                    .into_iter()
                    .any(|dof| found.axis_std(&self.creature, dof).is_none_or(|std| std > 0.02))
        };
        let chain = Chain::between(&self.creature, limbs[0], limbs[1]);
        let joints: Vec<usize> = chain.joints().filter(unsure).collect();
        let names = joints.iter().map(|&joint| self.creature.joints()[joint].name.clone()).collect();
        Err(Doubt { joints, deviation, names })
    }
}
