//! The touch sensor: from contacts, step by step, to sensations.
//!
//! "A central component, that fuses these stimulations of the receptors into a coherent touch sensation, forms our
//! touch sensor" (IVA 2009, section 2). What touches is followed over the skin from step to step, across joints, too,
//! wherever the somatotopic map has neighbours on two limbs; contacts of one party that one fingertip spans are one,
//! those farther apart are as many touches. What is followed until nothing has touched for [`RELEASE`] is one sensation; what
//! was about to come to a gap at a joint, or to skin without receptors, is waited for. It is told by how long it lasted and
//! how it moved over the skin: the words are those of Yohanan and MacLean, "The Role of Affective Touch in Human-Robot
//! Interaction" (2012), without what only pictures of a hand tell apart.
//!
//! Nothing of this needs to know where the limbs are: ways are measured on each limb, and from one to the next by where
//! their skins meet, which is the same in every posture.

use super::felt_surface::FeltSurface;
use super::followed_touch::{FollowedTouch, earlier_first, fused};
use super::{Sense, SensedStep, SensingBody, SkinContact, TouchEvent};
use crate::error::Result;
use crate::skin::{Skin, SomatotopicMap};

/// How long nothing must touch before a sensation has ended, seconds: a fingertip that bounces over an edge comes
/// back sooner.
pub const RELEASE: f64 = 0.03;
/// A contact goes on where the last one of the same party was, if its point is no farther along the skin, metres: so
/// far a finger of 1 m/s gets until [`RELEASE`] has passed.
const NEAR: f64 = 0.03;
/// Contacts of one party no farther apart are one touch, metres: the two sides of a crease that a fingertip lies in are
/// that far apart at the most, and two fingers side by side are farther.
const TOGETHER: f64 = 0.018;
/// The same over a joint, where the way is known less exactly, metres.
const TOGETHER_ACROSS: f64 = 0.025;

/// Follows what touches the skin.
#[derive(Clone, Debug)]
pub struct TouchSensor {
    surface: FeltSurface,
    touches: Vec<FollowedTouch>,
    count: u64,
    /// What touched in the last step, limb by limb.
    present: Vec<SkinContact>,
    /// The events of the last step.
    events: Vec<TouchEvent>,
}

impl Sense for TouchSensor {
    fn step(&mut self, step: &SensedStep) -> Result<()> {
        self.events = self.follow(step.time, step.contacts);
        Ok(())
    }
}

impl TouchSensor {
    /// A sensor of a skin that feels nothing yet.
    pub fn new(map: SomatotopicMap, skin: &Skin) -> TouchSensor {
        TouchSensor {
            surface: FeltSurface::new(map, skin),
            touches: Vec::new(),
            count: 0,
            present: Vec::new(),
            events: Vec::new(),
        }
    }

    /// The sensor of a creature on a stage, by the map of its skin in the reference posture.
    pub(super) fn of(own: &SensingBody) -> Result<TouchSensor> {
        let skin = own.agent.skin();
        Ok(TouchSensor::new(SomatotopicMap::at_ease(own.body, skin)?, skin))
    }

    /// The events of the last step.
    pub fn events(&self) -> &[TouchEvent] {
        &self.events
    }

    /// Which receptors it takes for neighbours.
    pub fn map(&self) -> &SomatotopicMap {
        self.surface.map()
    }

    /// Takes in the contacts of one step at `time`, seconds, later than the last one.
    pub fn follow(&mut self, time: f64, contacts: &[SkinContact]) -> Vec<TouchEvent> {
        let mut events = Vec::new();
        for (touch, contacts) in self.shared_out(time, contacts) {
            match touch {
                Some(touch) => self.touches[touch].add(time, contacts, &self.surface),
                None => {
                    let touch = FollowedTouch::new(self.count, time, contacts);
                    events.push(TouchEvent::Began { number: self.count, contact: touch.contact() });
                    self.touches.push(touch);
                    self.count += 1;
                }
            }
        }
        self.present = if contacts.is_empty() { Vec::new() } else { self.patches(time) };
        let surface = &self.surface;
        for touch in self.touches.extract_if(.., |touch| touch.is_over(time, surface)) {
            events.push(TouchEvent::Sensed { number: touch.number, sensation: touch.sensation() });
        }
        events
    }

    /// What touches in the last step, the contacts of one party on one patch of a limb's skin as one; what began first,
    /// first.
    pub fn present(&self) -> impl Iterator<Item = &SkinContact> {
        self.present.iter()
    }

    /// Which contacts of a step are of which touch; of none where they begin one.
    fn shared_out(&self, time: f64, contacts: &[SkinContact]) -> Vec<(Option<usize>, Vec<SkinContact>)> {
        // Each touch goes on with the contact that is nearest to where it was, unless that is nearer to another.
        let mut near: Vec<(f64, usize, usize)> = Vec::new();
        for (t, touch) in self.touches.iter().enumerate() {
            // What has not touched for longer is waited for because it goes on where nothing feels it.
            let reach = if time - touch.last > RELEASE { NEAR + touch.gone_on(time) } else { NEAR };
            for (c, contact) in contacts.iter().enumerate() {
                let heads = touch.heads.iter().map(|head| self.surface.apart(head, contact));
                near.extend(heads.min_by(f64::total_cmp).filter(|d| *d <= reach).map(|d| (d, t, c)));
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut shares: Vec<(Option<usize>, Vec<SkinContact>)> = Vec::new();
        let mut taken = vec![false; contacts.len()];
        for (_, touch, contact) in near {
            if !taken[contact] && shares.iter().all(|(goes_on, _)| *goes_on != Some(touch)) {
                taken[contact] = true;
                shares.push((Some(touch), vec![contacts[contact].clone()]));
            }
        }
        // What else is within a fingertip belongs to it; what is left begins.
        loop {
            let mut nearest: Option<(f64, usize, usize)> = None;
            for c in (0..contacts.len()).filter(|&c| !taken[c]) {
                for (s, (_, share)) in shares.iter().enumerate() {
                    // How near it is, as a share of how near belongs together.
                    let near = share.iter().map(|other| {
                        let across = other.spot.limb != contacts[c].spot.limb;
                        let together = if across { TOGETHER_ACROSS } else { TOGETHER };
                        self.surface.apart(other, &contacts[c]) / together
                    });
                    let near = near.fold(f64::INFINITY, f64::min);
                    if near <= 1.0 && nearest.is_none_or(|(least, ..)| near < least) {
                        nearest = Some((near, s, c));
                    }
                }
            }
            if let Some((_, share, contact)) = nearest {
                taken[contact] = true;
                shares[share].1.push(contacts[contact].clone());
            } else if let Some(first) = taken.iter().position(|taken| !taken) {
                taken[first] = true;
                shares.push((None, vec![contacts[first].clone()]));
            } else {
                return shares;
            }
        }
    }

    /// Contacts of the last step, at `time`, of one party and of one patch of a limb's skin as one.
    fn patches(&self, time: f64) -> Vec<SkinContact> {
        let touching = self.touches.iter().filter(|touch| touch.last == time);
        let heads = touching.flat_map(|touch| &touch.heads).map(earlier_first);
        let mut patches: Vec<Vec<SkinContact>> = Vec::new();
        for contact in heads {
            let belongs = |patch: &Vec<SkinContact>| {
                patch.iter().any(|other| self.surface.is_one_patch(&contact, other))
            };
            match patches.iter().position(belongs) {
                Some(first) => {
                    let joined: Vec<_> = patches.extract_if(first + 1.., |patch| belongs(patch)).collect();
                    patches[first].extend(joined.into_iter().flatten().chain([contact]));
                }
                None => patches.push(vec![contact]),
            }
        }
        patches.iter().map(|patch| fused(patch.iter())).collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::senses::{SkinSpot, TouchKind, Toucher};
    use crate::skin::Receptor;

    /// Length of a step, seconds.
    const STEP: f64 = 0.002;

    /// A sensor of a row of flat receptors on one limb, 2 cm wide each.
    fn row(receptors: usize) -> TouchSensor {
        let receptor = |k: usize| Receptor {
            id: format!("r{k}"),
            limb: 0,
            position: Vector3::new(0.02 * k as f64, 0.0, 0.0),
            normal: Vector3::z(),
            tangent: Vector3::x(),
            half_extents: [0.01; 2],
            surface: None,
        };
        let skin = Skin { receptors: (0..receptors).map(receptor).collect(), surfaces: Vec::new() };
        TouchSensor::new(SomatotopicMap::of_links(receptors, (1..receptors).map(|k| [k - 1, k])), &skin)
    }

    /// A contact of the thing 1 at a place along the row, metres.
    fn at(x: f64) -> SkinContact {
        let receptor = (x / 0.02).round() as usize;
        let spot = SkinSpot { limb: 0, receptor, point: Vector3::new(x, 0.0, 0.0), sensor_force: None };
        SkinContact { spot, by: Toucher::Thing(1), force: 1.0 }
    }

    /// The kinds of the sensations that contacts at these places, step by step, come to.
    fn kinds(places: impl Iterator<Item = Vec<f64>>) -> Vec<TouchKind> {
        let mut sensor = row(6);
        let silence = std::iter::repeat_n(Vec::new(), (1.0 / STEP) as usize);
        let mut kinds = Vec::new();
        for (k, places) in places.chain(silence).enumerate() {
            let contacts: Vec<SkinContact> = places.into_iter().map(at).collect();
            kinds.extend(sensor.follow(STEP * k as f64, &contacts).into_iter().filter_map(
                |event| match event {
                    TouchEvent::Sensed { sensation, .. } => Some(sensation.kind),
                    TouchEvent::Began { .. } => None,
                },
            ));
        }
        kinds
    }

    #[test]
    fn contacts_within_a_fingertip_are_one_touch_and_those_of_two_fingers_are_two() {
        for (apart, touches) in [(0.9 * TOGETHER, 1), (1.1 * TOGETHER, 2)] {
            let kinds = kinds(std::iter::repeat_n(vec![0.02, 0.02 + apart], 200));
            assert_eq!(kinds, vec![TouchKind::Press; touches], "{apart} m apart");
        }
    }

    #[test]
    fn what_goes_on_farther_than_a_finger_gets_until_the_release_is_another_touch() {
        let jump = |way: f64| vec![vec![0.0]; 20].into_iter().chain(vec![vec![way]; 20]);
        assert_eq!(kinds(jump(0.9 * NEAR)).len(), 1);
        assert_eq!(kinds(jump(1.1 * NEAR)).len(), 2);
    }

    #[test]
    fn along_the_row_is_a_stroke_and_back_again_a_rub() {
        let along = || (0..=400).map(|k| 0.1 * f64::from(k) / 400.0);
        assert_eq!(kinds(along().map(|x| vec![x])), [TouchKind::Stroke]);
        let back: Vec<f64> = along().collect();
        assert_eq!(kinds(along().chain(back.into_iter().rev()).map(|x| vec![x])), [TouchKind::Rub]);
    }
}
