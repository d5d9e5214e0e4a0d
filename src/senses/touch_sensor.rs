//! The touch sensor: from receptors that fire, step by step, to sensations.
//!
//! "A central component, that fuses these stimulations of the receptors into a coherent touch sensation, forms our
//! touch sensor" (IVA 2009, section 2). What touches is followed over the skin from step to step, across joints, too, by
//! the receptors that fire and by which of them the somatotopic map has as neighbours. Nothing else is known of where it
//! is: what stays on one patch does not move, and receptors of one party that fire at once are one touch if they are
//! neighbours. What is followed until nothing has touched for [`RELEASE`] is one sensation; what was about to come to a
//! gap at a joint, or to skin without receptors, is waited for. It is told by how long it lasted and how it moved over
//! the skin: the words are those of Yohanan and MacLean, "The Role of Affective Touch in Human-Robot Interaction"
//! (2012), without what only pictures of a hand tell apart.

use super::followed_touch::FollowedTouch;
use super::mapped_skin::MappedSkin;
use super::{Sense, SensedStep, SensingBody, SkinContact, TouchEvent, Toucher};
use crate::error::Result;
use crate::skin::{Skin, SomatotopicMap};

/// How long nothing must touch before a sensation has ended, seconds: a fingertip that bounces over an edge comes
/// back sooner.
pub const RELEASE: f64 = 0.03;

/// Follows what touches the skin.
#[derive(Clone, Debug)]
pub struct TouchSensor {
    skin: MappedSkin,
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
            skin: MappedSkin { map, skin: skin.clone() },
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
        &self.skin.map
    }

    /// Takes in the contacts of one step at `time`, seconds, later than the last one.
    pub fn follow(&mut self, time: f64, contacts: &[SkinContact]) -> Vec<TouchEvent> {
        let mut events = Vec::new();
        for (touch, contacts) in self.shared_out(time, contacts) {
            match touch {
                Some(touch) => self.touches[touch].add(time, &contacts, &self.skin),
                None => {
                    let touch = FollowedTouch::new(self.count, time, &contacts, &self.skin);
                    let contact = SkinContact::fused(&touch.heads);
                    events.push(TouchEvent::Began { number: self.count, contact });
                    self.touches.push(touch);
                    self.count += 1;
                }
            }
        }
        self.present = if contacts.is_empty() { Vec::new() } else { self.patches(time) };
        let skin = &self.skin;
        for touch in self.touches.extract_if(.., |touch| touch.is_over(time, skin)) {
            events.push(TouchEvent::Sensed { number: touch.number, sensation: touch.sensation(skin) });
        }
        events
    }

    /// What touches in the last step, the contacts of one party on one patch of a limb's skin as one; what began first,
    /// first.
    pub fn present(&self) -> impl Iterator<Item = &SkinContact> {
        self.present.iter()
    }

    /// Which contacts of a step are of which touch. `None` if they begin one.
    fn shared_out(&self, time: f64, contacts: &[SkinContact]) -> Vec<(Option<usize>, Vec<SkinContact>)> {
        let (mut shares, mut fresh) = (vec![Vec::new(); self.touches.len()], Vec::new());
        for &contact in contacts {
            let following =
                |(t, touch): (usize, &FollowedTouch)| Some((touch.following(time, &contact, &self.skin)?, t));
            match self.touches.iter().enumerate().filter_map(following).min() {
                Some((_, touch)) => shares[touch].push(contact),
                None => fresh.push(contact),
            }
        }
        let follow = shares.into_iter().enumerate().filter(|(_, share)| !share.is_empty());
        let follow = follow.map(|(touch, share)| (Some(touch), share));
        let begin = joined(fresh, |a, b| self.skin.adjoin(a, b)).into_iter().map(|share| (None, share));
        follow.chain(begin).collect()
    }

    /// Contacts of the last step, at `time`, of one party and of one patch of a limb's skin as one.
    fn patches(&self, time: f64) -> Vec<SkinContact> {
        let touching = self.touches.iter().filter(|touch| touch.last == time);
        let heads = touching.flat_map(|touch| &touch.heads).map(|contact| match contact.by {
            Toucher::Own(own) if own.limb < contact.spot.limb => contact.turned(),
            _ => *contact,
        });
        let is_one = |a: &SkinContact, b: &SkinContact| a.has_parties_of(b) && self.skin.adjoin(a, b);
        joined(heads.collect(), is_one).iter().map(|patch| SkinContact::fused(patch)).collect()
    }
}

/// Contacts that belong together, directly or by others, in groups; in the order of their first ones.
fn joined(
    contacts: Vec<SkinContact>,
    together: impl Fn(&SkinContact, &SkinContact) -> bool,
) -> Vec<Vec<SkinContact>> {
    let mut groups: Vec<Vec<SkinContact>> = Vec::new();
    for contact in contacts {
        let belongs = |group: &Vec<SkinContact>| group.iter().any(|other| together(&contact, other));
        match groups.iter().position(belongs) {
            Some(first) => {
                let others: Vec<_> = groups.extract_if(first + 1.., |group| belongs(group)).collect();
                groups[first].extend(others.into_iter().flatten().chain([contact]));
            }
            None => groups.push(vec![contact]),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::senses::{Sensation, SkinSpot, TouchKind, Toucher};
    use crate::skin::Receptor;

    /// Length of a step, seconds.
    const STEP: f64 = 0.002;

    /// A sensor of a row of flat receptors on one limb, 2 cm wide each.
    fn row(receptors: usize) -> TouchSensor {
        row_without(receptors, 0)
    }

    /// The same whose map lacks the link to a receptor from the one before.
    fn row_without(receptors: usize, lacking: usize) -> TouchSensor {
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
        TouchSensor::new(
            SomatotopicMap::of_links(receptors, (1..receptors).filter(|k| *k != lacking).map(|k| [k - 1, k])),
            &skin,
        )
    }

    /// A contact of the thing 1 at a place along the row, metres.
    fn at(x: f64) -> SkinContact {
        let spot = SkinSpot { limb: 0, receptor: (x / 0.02).round() as usize };
        SkinContact { spot, by: Toucher::Thing(1), force: 1.0 }
    }

    /// The sensations of contacts step by step.
    fn felt(mut sensor: TouchSensor, steps: impl Iterator<Item = Vec<SkinContact>>) -> Vec<Sensation> {
        let silence = std::iter::repeat_n(Vec::new(), (1.0 / STEP) as usize);
        let mut felt = Vec::new();
        for (k, contacts) in steps.chain(silence).enumerate() {
            felt.extend(sensor.follow(STEP * k as f64, &contacts).into_iter().filter_map(
                |event| match event {
                    TouchEvent::Sensed { sensation, .. } => Some(sensation),
                    TouchEvent::Began { .. } => None,
                },
            ));
        }
        felt
    }

    /// The kinds of the sensations that contacts at these places, step by step, come to.
    fn kinds(places: impl Iterator<Item = Vec<f64>>) -> Vec<TouchKind> {
        let steps = places.map(|places| places.into_iter().map(at).collect());
        felt(row(6), steps).into_iter().map(|sensation| sensation.kind).collect()
    }

    #[test]
    fn contacts_on_neighbours_are_one_touch_and_those_with_silent_skin_between_are_two() {
        for (apart, touches) in [(0.02, 1), (0.04, 2)] {
            let kinds = kinds(std::iter::repeat_n(vec![0.02, 0.02 + apart], 200));
            assert_eq!(kinds, vec![TouchKind::Press; touches], "{apart} m apart");
        }
    }

    #[test]
    fn what_goes_on_at_a_receptor_that_is_no_neighbour_is_another_touch() {
        let jump = |way: f64| vec![vec![0.0]; 20].into_iter().chain(vec![vec![way]; 20]);
        assert_eq!(kinds(jump(0.02)).len(), 1);
        assert_eq!(kinds(jump(0.04)).len(), 2);
    }

    #[test]
    fn within_a_patch_nothing_moves_and_along_the_row_is_a_stroke_and_back_again_a_rub() {
        assert_eq!(kinds((0..=400).map(|k| vec![0.031 + 0.018 * f64::from(k) / 400.0])), [TouchKind::Press]);
        let along = || (0..=400).map(|k| 0.1 * f64::from(k) / 400.0);
        assert_eq!(kinds(along().map(|x| vec![x])), [TouchKind::Stroke]);
        let back: Vec<f64> = along().collect();
        assert_eq!(kinds(along().chain(back.into_iter().rev()).map(|x| vec![x])), [TouchKind::Rub]);
    }

    #[test]
    fn where_the_map_lacks_a_link_a_stroke_falls_apart() {
        let along = || (0..=400).map(|k| vec![at(0.1 * f64::from(k) / 400.0)]);
        let count = |sensor: TouchSensor| felt(sensor, along()).len();
        assert_eq!((count(row(6)), count(row_without(6, 3))), (1, 2));
    }
}
