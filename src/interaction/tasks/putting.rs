//! Putting a held thing somewhere else: far away, near, leaning if the arm is too short.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Trouble;
use super::carrying::CarryingPlan;
use crate::creature::Posture;
use crate::interaction::actor::Actor;
use crate::kinematics::Place;
use crate::peripersonal::{PosedPlace, PosturePath, PostureProgram, farthest_postures};

/// How clear limbs are of each other and of the table where something is put, metres, …
const MARGIN: f64 = 0.002;
/// … and a little more, for what is but nearly kept.
const AIMED_MARGIN: f64 = 0.0023;
/// Random postures that the search begins with for each unit of effort, with the trunk as it is bent and with any.
const DRAWN: usize = 4;
/// How much less far than the farthest something is put if no path leads there, metres.
const NEARER: [f64; 5] = [0.0, 0.005, 0.015, 0.03, 0.06];
/// How clear an arm stays of everything while the trunk leans, metres, …
const CLEAR: f64 = 0.03;
/// … at so many steps of leaning; …
const LEANINGS: u32 = 5;
/// … postures drawn for it.
const IDLE_POSTURES: usize = 400;

/// A place on the table, or above it, where something can be put.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Where the grip comes to be, in the root's frame, metres.
    pub point: Vector3<f64>,
    /// The posture.
    pub posture: Posture,
    /// The way there from where it was chosen.
    pub(super) plan: CarryingPlan,
    /// How it was chosen, where it is the farthest.
    pub(super) chosen: Option<FarthestChoice>,
}

/// What a farthest spot is chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FarthestChoice {
    /// The hand that holds.
    pub hand: usize,
    /// The grip's height, metres.
    pub height: f64,
    pub lean: bool,
    pub effort: usize,
}

impl Actor {
    /// The spot farthest in front at which the receptor that grips can be over the table at a height, the grip upright
    /// as it is now: `upright` is the direction of the limb that is up now, in the limb's frame. There is a way to it on
    /// which what is held is lifted. The search begins from more postures the greater the `effort`.
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
        let up = self.lifted_here(place, &joints)?;
        self.farthest_from(place, FarthestChoice { hand, height, lean, effort }, &joints, &up)
    }

    /// The farthest spot for a place that has been lifted on a way, its first posture that in which one is.
    pub(super) fn farthest_from(
        &mut self,
        place: Place,
        chosen: FarthestChoice,
        joints: &[usize],
        up: &PosturePath,
    ) -> Option<Spot> {
        let FarthestChoice { hand, height, lean, effort } = chosen;
        let mut found = self.farthest_postures(hand, place, height, lean, effort);
        for nearer in NEARER {
            for posed in &found {
                if let Ok(plan) = self.plan_after(place, up.clone(), &posed.posture, joints) {
                    let point = self.own.frames(&posed.posture)[place.limb].point(&place.point);
                    return Some(Spot { point, posture: posed.posture.clone(), plan, chosen: Some(chosen) });
                }
            }
            let best = found.first()?;
            let program = self.put_at(joints, place, height).at_level(self.front, best.along - nearer);
            found =
                found.iter().map(|posed| program.solve(&posed.posture)).filter(PosedPlace::kept).collect();
        }
        None
    }

    /// The place of a receptor, with the direction of its limb that is up now.
    pub fn upright(&self, receptor: usize) -> Place {
        let place = self.own.place(receptor);
        Place { direction: self.frames()[place.limb].rotation.tr_mul(&self.up), ..place }
    }

    /// The postures in which a place of a hand's limb is farthest in front, at a height and its direction up, the farthest
    /// first; whether there is a way to them is not looked at.
    pub fn farthest_postures(
        &self,
        hand: usize,
        place: Place,
        height: f64,
        lean: bool,
        effort: usize,
    ) -> Vec<PosedPlace> {
        let own = &self.own;
        let joints = self.hands[hand].joints(lean);
        let arm = &self.hands[hand].arm;
        let from = self.posture();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut starts = vec![from.clone()];
        if lean {
            let bent = self.bent_forward(&place, &from);
            for share in [0.3, 0.6, 1.0] {
                starts.push(Posture::between(own.creature(), &from, &bent, share));
            }
            starts.extend(
                self.made_way_for
                    .iter()
                    .map(|made| Posture::with_joints(own.creature(), &from, joints.iter().copied(), made)),
            );
            let drawn = (0..DRAWN * effort).map(|_| own.random_posture(&bent, arm, &mut rng));
            starts.extend(drawn);
        }
        starts.extend((0..DRAWN * effort).map(|_| own.random_posture(&from, joints, &mut rng)));
        let program = self.put_at(joints, place, height);
        let clearance = self.clearance.moved_by(own, joints);
        let mut found = farthest_postures(own, &program, joints, &starts, &mut rng);
        found.retain(|posed| clearance.free(&own.frames(&posed.posture), MARGIN));
        found
    }

    /// How a place that grips is to be where something is put: at a height and its direction up, as far in front as can be.
    fn put_at(&self, joints: &[usize], place: Place, height: f64) -> PostureProgram<'_> {
        PostureProgram::farthest(&self.own, &self.clearance, joints, place, self.front, AIMED_MARGIN)
            .at_level(self.up, height)
            .parallel_to(self.up)
    }

    /// A posture with the trunk bent to where a place is farthest in front.
    fn bent_forward(&self, place: &Place, from: &[f64]) -> Posture {
        self.bent(from, |frames| frames[place.limb].point(&place.point).dot(&self.front))
    }

    /// Takes the arm of the hand that does not hold to where it stays clear of the table and the body however far the trunk
    /// leans to where the receptor that holds is farthest, as if that arm were not there; where none is clear all the way,
    /// to where it is clearest.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn make_way_to_lean(&mut self, receptor: usize, effort: usize) -> Result<(), Trouble> {
        let Some(hand) = self.arm_of(receptor) else { return Ok(()) };
        let idle = self.hands[1 - hand].arm.clone();
        let from = self.posture();
        let height = self.feels_at(receptor).0.dot(&self.up);
        let place = self.upright(receptor);
        let all = self.clearance.clone();
        self.clearance = all.without(&self.own.moved_by(&idle));
        let farthest = self.farthest_postures(hand, place, height, true, effort);
        self.clearance = all;
        self.made_way_for = farthest.into_iter().map(|posed| posed.posture).collect();
        let bent = match self.made_way_for.first() {
            Some(farthest) => farthest.clone(),
            None => self.bent_forward(&place, &from),
        };
        let mut rng = self.new_rng();
        let clearance = self.clearance.moved_by(&self.own, &idle);
        let creature = self.own.creature();
        let with_arm =
            |posture: &[f64], arm: &[f64]| Posture::with_joints(creature, posture, idle.iter().copied(), arm);
        let clear = |arm: &[f64]| {
            let gaps = (0..=LEANINGS).map(|k| {
                let leaning = Posture::between(creature, &from, &bent, f64::from(k) / f64::from(LEANINGS));
                clearance.least(&self.own.frames(&with_arm(&leaning, arm)), CLEAR)
            });
            gaps.fold(f64::INFINITY, f64::min)
        };
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

    /// The spot at the first of some places, in the root's frame, metres, at which the receptor that grips can be upright as
    /// it is now; `None` if it can be at none.
    pub fn spot_at(
        &mut self,
        receptor: usize,
        places: impl IntoIterator<Item = Vector3<f64>>,
    ) -> Option<Spot> {
        let hand = self.arm_of(receptor)?;
        let joints = self.hands[hand].arm.clone();
        let (place, from) = (self.upright(receptor), self.posture());
        let clearance = self.clearance.moved_by(&self.own, &joints);
        places.into_iter().find_map(|point| {
            let reach = self.upright_at(place, point, &joints).solve(&from);
            let fits = reach.reached()
                && reach.facing > 0.98
                && clearance.free(&self.own.frames(&reach.posture), MARGIN);
            let plan = fits.then(|| self.plan_carrying(place, &reach.posture, &joints).ok()).flatten()?;
            Some(Spot { point, posture: reach.posture, plan, chosen: None })
        })
    }

    /// How far a point of the root's frame is from the surface of every limb that has one, metres; a stick that is held is
    /// none of it.
    pub fn distances(&self, point: &Vector3<f64>) -> Vec<(usize, f64)> {
        let distances = self.bare().distances(&self.frames(), point);
        distances.into_iter().enumerate().filter_map(|(limb, distance)| Some((limb, distance?))).collect()
    }
}
