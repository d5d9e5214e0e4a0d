//! Putting what is held somewhere else: far away, near, leaning where the arm is too short.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Trouble;
use crate::creature::Posture;
use crate::interaction::actor::{Actor, CAREFUL, Hand, SWIFT};
use crate::kinematics::{Facing, InverseKinematics, Place, REACHED};
use crate::peripersonal::{OutOfReach, OwnBody, PosturePath};
use crate::senses::{SkinContact, Toucher};

/// Steps to the side in which the farthest spot is looked for, how many to either side, and how finely forward, metres.
const ASIDE: f64 = 0.05;
const LATERAL: u32 = 11;
const FINEST: f64 = 1e-3;
/// How high a thing is lifted, metres: the highest of these that its way allows.
const LIFTS: [f64; 3] = [0.12, 0.08, 0.05];
/// How far a hand is raised off what it let go, metres.
const LIFT: f64 = 0.05;
/// Least size of a thing's height, metres: the table is not felt through what is lower.
const SETTLE: f64 = 0.002;
/// How clear an arm stays of everything while the trunk leans, metres, …
const CLEAR: f64 = 0.03;
/// … at so many steps of leaning; …
const LEANINGS: u32 = 5;
/// … postures drawn for it.
const IDLE_POSTURES: usize = 400;
/// What a radian is worth in metres where a grip is to stay upright, at first and at the last.
const UPRIGHT: [f64; 2] = [0.05, 0.02];

/// A place on the table, or above it, where something can be put.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Where the grip comes to be, in the root's frame, metres.
    pub point: Vector3<f64>,
    /// The posture.
    pub posture: Posture,
}

impl Actor {
    /// The spot farthest in front at which the receptor that grips can be over the table at a height, the grip upright
    /// as it is now: `upright` is the direction of the limb that is up now, in the limb's frame.
    pub fn farthest(
        &mut self,
        receptor: usize,
        height: f64,
        upright: Vector3<f64>,
        lean: bool,
        effort: usize,
    ) -> Option<Spot> {
        let hand = self.arm_of(receptor)?;
        let joints = self.hands[hand].joints(lean).to_vec();
        let place = Place { direction: upright, ..self.own.place(receptor) };
        let (front, left, up, side) = (self.front, self.left(), self.up, self.side(hand));
        let from = self.posture();
        let own = &self.own;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut starts = vec![from.clone(), own.at_ease()];
        if lean {
            let bent = self.bent_forward(hand, &place, &from);
            starts.insert(0, Posture::between(own.creature(), &from, &bent, 0.7));
            starts.insert(0, bent);
        }
        starts.resize_with(starts.len() + effort, || own.random_posture(&from, &joints, &mut rng));
        let solve = |forward: f64, across: f64, start: &[f64]| {
            let point = front * forward + left * across + up * height;
            let target = Place { limb: 0, point, direction: up };
            let reach = upright_at(own, &joints, [place, target]).with_steps([20, 25]).solve(start);
            let fits = reach.miss <= REACHED
                && reach.facing > 0.99
                && self.clearance.free(&own.frames(&reach.posture), 0.002);
            fits.then_some(reach.posture)
        };
        // From where it is, sideways in steps, and from each forward as far as there is a posture.
        let here = self.feels_at(receptor).0;
        let (near, middle) = (here.dot(&front), here.dot(&left));
        let anew = |forward: f64, across: f64| starts.iter().find_map(|start| solve(forward, across, start));
        let mut best: Option<(f64, Spot)> = None;
        for sideways in [side, -side] {
            let mut beside = from.clone();
            for k in 0..LATERAL {
                let across = middle + sideways * ASIDE * f64::from(k);
                let Some(begin) = solve(near, across, &beside).or_else(|| anew(near, across)) else { break };
                beside.clone_from(&begin);
                let (mut forward, mut posture, mut step) = (near, begin, 2.0 * ASIDE);
                while step > FINEST {
                    let further = forward + step;
                    let reached = solve(further, across, &posture).or_else(|| {
                        let farthest =
                            best.as_ref().and_then(|(_, spot)| solve(further, across, &spot.posture));
                        farthest.or_else(|| anew(further, across))
                    });
                    match reached {
                        Some(reached) => (forward, posture) = (further, reached),
                        None => step *= 0.5,
                    }
                }
                if best.as_ref().is_none_or(|(before, _)| forward > *before) {
                    let point = front * forward + left * across + up * height;
                    best = Some((forward, Spot { point, posture }));
                }
            }
        }
        best.map(|(_, spot)| spot)
    }

    /// A posture bent as far to the front as the trunk that carries a hand goes, joint by joint from the hips, for a place
    /// of the hand.
    fn bent_forward(&self, hand: usize, place: &Place, from: &[f64]) -> Posture {
        let own = &self.own;
        let Hand { arm, leaning, .. } = &self.hands[hand];
        let mut bent = Posture::from(from);
        for &joint in leaning.iter().filter(|joint| !arm.contains(joint)) {
            let joint = &own.creature().joints()[joint];
            for at in joint.elements().filter(|at| !at.is_ball()) {
                let q = at.coordinate();
                let forward = |value: f64| {
                    let mut posture = bent.clone();
                    posture[q] = value;
                    own.frames(&posture)[place.limb].point(&place.point).dot(&self.front)
                };
                let farthest = at.range.into_iter().max_by(|a, b| forward(*a).total_cmp(&forward(*b)));
                bent[q] = farthest.unwrap_or(bent[q]);
            }
        }
        own.creature().couple(&mut bent);
        bent
    }

    /// Takes the arm of the hand that does not act to where it stays clear of the table and the body however far the trunk
    /// leans; where none is clear all the way, to where it is clearest.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn make_way_to_lean(&mut self, hand: usize) -> Result<(), Trouble> {
        let idle = self.hands[1 - hand].arm.clone();
        let from = self.posture();
        let place = self.own.place(self.hands[hand].tip);
        let bent = self.bent_forward(hand, &place, &from);
        let clearance = self.clearance.moved_by(&self.own, &idle);
        let creature = self.own.creature();
        let with_arm = |posture: &[f64], arm: &[f64]| {
            let mut posture = Posture::from(posture);
            for &joint in &idle {
                let q = creature.joints()[joint].coordinates();
                posture[q.clone()].copy_from_slice(&arm[q]);
            }
            posture
        };
        let clear = |arm: &[f64]| {
            let gaps = (0..=LEANINGS).map(|k| {
                let leaning = Posture::between(creature, &from, &bent, f64::from(k) / f64::from(LEANINGS));
                clearance.least(&self.own.frames(&with_arm(&leaning, arm)), CLEAR)
            });
            gaps.fold(f64::INFINITY, f64::min)
        };
        self.seed = self.seed.wrapping_add(1);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let drawn = (0..IDLE_POSTURES).map(|_| self.own.random_posture(&from, &idle, &mut rng));
        let mut best = (clear(&from), from.clone());
        for arm in std::iter::once(self.own.at_ease()).chain(drawn) {
            if best.0 >= CLEAR {
                break;
            }
            let gap = clear(&arm);
            if gap > best.0 {
                best = (gap, arm);
            }
        }
        let target = with_arm(&from, &best.1);
        self.go_by(&from, &target, &idle)
    }

    /// The spot at a place over the table, forward and to the hand's own side, at which the receptor that grips is upright
    /// as it is now; none where it cannot be there.
    pub fn spot_at(
        &mut self,
        receptor: usize,
        forward: f64,
        across: f64,
        height: f64,
        upright: Vector3<f64>,
    ) -> Option<Spot> {
        let hand = self.arm_of(receptor)?;
        let joints = self.hands[hand].arm.clone();
        let side = self.left() * self.side(hand);
        let place = Place { direction: upright, ..self.own.place(receptor) };
        let from = self.posture();
        let clearance = self.clearance.moved_by(&self.own, &joints);
        // A little farther away is near as well.
        (0..8).find_map(|k| {
            let point = self.front * (forward + 0.03 * f64::from(k)) + side * across + self.up * height;
            let target = Place { limb: 0, point, direction: self.up };
            let reach = upright_at(&self.own, &joints, [place, target]).solve(&from);
            let fits = reach.miss <= REACHED
                && reach.facing > 0.98
                && clearance.free(&self.own.frames(&reach.posture), 0.002);
            fits.then_some(Spot { point, posture: reach.posture })
        })
    }

    /// How far a point of the root's frame is from the surface of every limb that has one, metres.
    pub fn distances(&self, point: &Vector3<f64>) -> Vec<(usize, f64)> {
        let distances = self.own.distances(&self.frames(), point);
        distances.into_iter().enumerate().filter_map(|(limb, distance)| Some((limb, distance?))).collect()
    }

    /// Carries what a receptor holds to a spot: up, over, and down until it is felt to stand; then lets go and comes
    /// back.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn put(&mut self, receptor: usize, spot: &Spot, lean: bool) -> Result<(), Trouble> {
        let Some(hand) = self.arm_of(receptor) else { return Err(Trouble::Nothing) };
        let joints = self.hands[hand].joints(lean).to_vec();
        let up = self.up;
        let limb = self.own.place(receptor).limb;
        let upright = self.frames()[limb].rotation.tr_mul(&up);
        let place = Place { direction: upright, ..self.own.place(receptor) };
        let lifted = |actor: &Actor, point: Vector3<f64>, start: &[f64]| {
            let target = Place { limb: 0, point, direction: up };
            upright_at(&actor.own, &joints, [place, target]).solve(start).posture
        };
        let from = self.posture();
        let here = self.feels_at(receptor).0;
        let high = |actor: &Actor, point: Vector3<f64>, lift: f64, start: &[f64]| {
            let posture = lifted(actor, point + up * lift, start);
            let frame = actor.own.frames(&posture)[limb];
            ((frame.point(&place.point) - point).dot(&up) > 0.8 * lift).then_some(posture)
        };
        let raise = |actor: &Actor, point, start: &[f64]| {
            LIFTS.into_iter().find_map(|lift| Some((lift, high(actor, point, lift, start)?)))
        };
        let (Some((_, raised)), Some((lift, above))) =
            (raise(self, here, &from), raise(self, spot.point, &spot.posture))
        else {
            return Err(OutOfReach::Barred.into());
        };
        // What is held may scrape over what it stands on: that is no surprise.
        let expected = |_: &Actor, contact: &SkinContact| !matches!(contact.by, Toucher::Through(_));
        self.follow(&PosturePath(vec![raised.clone()]), CAREFUL, expected)?;
        let way = self.find_path([&raised, &above], &joints)?;
        self.pass(&way, SWIFT)?;
        let mut down = Vec::new();
        let mut posture = above.clone();
        for k in 1..=12 {
            let share = f64::from(k) / 12.0;
            let point = spot.point + up * (lift * (1.0 - share));
            posture = if k == 12 { spot.posture.clone() } else { lifted(self, point, &posture) };
            down.push(posture.clone());
        }
        let sinking = lifted(self, spot.point - up * SETTLE, &posture);
        down.push(sinking);
        self.follow(&PosturePath(down), CAREFUL, |_, contact| matches!(contact.by, Toucher::Through(_)))?;
        self.let_go();
        let stay = self.posture();
        self.wait(0.2)?;
        let point = self.feels_at(receptor).0;
        let back = lifted(self, point + up * LIFT, &stay);
        self.follow(&PosturePath(vec![back]), CAREFUL, |_, _| false)?;
        Ok(())
    }
}

/// Postures, moving some joints, in which a place of the body is at a target and keeps upright.
fn upright_at<'a>(own: &'a OwnBody, joints: &[usize], ends: [Place; 2]) -> InverseKinematics<'a> {
    InverseKinematics::new(own.creature(), &own.schema, ends)
        .with_facing(Facing::Parallel)
        .with_direction_lengths(UPRIGHT)
        .moving(|joint| joints.contains(&joint))
}
