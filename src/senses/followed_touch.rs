//! Something that touches, followed from step to step until it is understood, and its way over the skin: the receptors that
//! fired one after the other.

use nalgebra::Vector3;

use super::firing::{Firing, fire};
use super::mapped_skin::{BARE, Following, MappedSkin};
use super::touch_sensor::RELEASE;
use super::{LimbSensation, Sensation, SensationSide, SkinContact, TouchKind};

/// A touch that stays on its patch and is shorter than this is a tap, seconds.
const TAP: f64 = 0.25;
/// What fires together for less than this is no stay, seconds: a touch cuts a corner, or begins to press.
const PASSING: f64 = 0.02;
/// How far a touch may go on that leaves a receptor whose neighbours are ahead, metres: over a hole between patches.
const HOLE: f64 = 0.02;
/// How long it is waited for there at the most, seconds.
const LONGEST: f64 = 0.2;

/// Something that touches, followed from step to step.
#[derive(Clone, Debug)]
pub(super) struct FollowedTouch {
    /// Counted from 0.
    pub number: u64,
    began: f64,
    /// When it touched last, seconds.
    pub last: f64,
    /// Its contacts in the last step in which it touched.
    pub heads: Vec<SkinContact>,
    trails: Vec<Trail>,
    peak: f64,
    sum: f64,
    steps: usize,
}

impl FollowedTouch {
    /// What begins at `time` with these contacts.
    pub fn new(number: u64, time: f64, contacts: &[SkinContact], skin: &MappedSkin) -> FollowedTouch {
        let trails = contacts[0].spots().map(|_| Trail::default()).collect();
        let heads = vec![contacts[0]];
        let mut touch =
            FollowedTouch { number, began: time, last: time, heads, trails, peak: 0.0, sum: 0.0, steps: 0 };
        touch.add(time, contacts, skin);
        touch
    }

    /// How a contact of a step at `time` follows it. `None` if it does not.
    pub fn following(&self, time: f64, contact: &SkinContact, skin: &MappedSkin) -> Option<Following> {
        let following = self.heads.iter().filter_map(|head| skin.following(head, contact)).min();
        // While it is waited for it comes back from beyond where it was; what stayed on its patch was lifted.
        let waits = time - self.last > RELEASE;
        following.filter(|following| match following {
            Following::Same => !waits || self.trails.iter().any(|trail| trail.moves().0),
            Following::Adjacent => true,
            Following::Beyond => waits,
        })
    }

    /// Goes on with the contacts of a step.
    pub fn add(&mut self, time: f64, contacts: &[SkinContact], skin: &MappedSkin) {
        let before = self.heads[0];
        self.heads = contacts.iter().map(|contact| skin.turned_like(&before, contact)).collect();
        for (k, trail) in self.trails.iter_mut().enumerate() {
            let spots = self.heads.iter().filter_map(|contact| contact.spots().nth(k));
            trail.add(time, spots.map(|spot| spot.receptor));
        }
        self.last = time;
        let force: f64 = self.heads.iter().map(|contact| contact.force).sum();
        self.peak = self.peak.max(force);
        self.sum += force;
        self.steps += 1;
    }

    /// Whether nothing has touched for so long that it has ended.
    pub fn is_over(&self, time: f64, skin: &MappedSkin) -> bool {
        let silent = time - self.last;
        let patience = || self.trails.iter().map(|trail| trail.patience(skin)).fold(0.0, f64::max);
        silent > RELEASE && (silent > RELEASE + LONGEST || silent > RELEASE + patience())
    }

    /// What it was.
    pub fn sensation(self, skin: &MappedSkin) -> Sensation {
        let duration = self.last - self.began;
        let moves: Vec<(bool, bool)> = self.trails.iter().map(Trail::moves).collect();
        let kind = match (moves.iter().any(|(along, _)| *along), moves.iter().any(|(_, back)| *back)) {
            (_, true) => TouchKind::Rub,
            (true, false) => TouchKind::Stroke,
            (false, false) if duration < TAP => TouchKind::Tap,
            (false, false) => TouchKind::Press,
        };
        Sensation {
            began: self.began,
            ended: self.last,
            kind,
            by: self.heads[0].by,
            sides: self.trails.iter().map(|trail| trail.side(skin, duration)).collect(),
            peak_force: self.peak,
            mean_force: self.sum / self.steps as f64,
        }
    }
}

/// One side of what is being followed.
#[derive(Clone, Debug, Default)]
struct Trail {
    /// In the order in which they began.
    firings: Vec<Firing>,
}

/// What fired together for a while.
#[derive(Clone, Debug)]
struct Stay {
    /// In their order.
    receptors: Vec<usize>,
    /// The one that began last.
    newest: usize,
    span: [f64; 2],
}

impl Stay {
    fn lasted(&self) -> f64 {
        self.span[1] - self.span[0]
    }
}

/// Stays of the same receptors one after the other as one.
fn merge(stays: &mut Vec<Stay>) {
    stays.dedup_by(|next, last| {
        let same = next.receptors == last.receptors;
        if same {
            last.span[1] = next.span[1];
        }
        same
    });
}

impl Trail {
    /// Takes in the receptors that fire in a step.
    pub fn add(&mut self, time: f64, receptors: impl Iterator<Item = usize>) {
        fire(&mut self.firings, time, receptors);
    }

    /// Which receptors fired together, one stay after the other.
    fn stays(&self) -> Vec<Stay> {
        let mut times: Vec<f64> = self.firings.iter().flat_map(|firing| firing.span).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let fire = |pair: &[f64]| {
            let fires = |firing: &&Firing| firing.span[0] <= pair[0] && pair[1] <= firing.span[1];
            let mut receptors: Vec<usize> =
                self.firings.iter().filter(fires).map(|firing| firing.receptor).collect();
            let newest = receptors.last().copied()?;
            receptors.sort_unstable();
            Some(Stay { receptors, newest, span: [pair[0], pair[1]] })
        };
        let mut stays: Vec<Stay> = times.windows(2).filter_map(fire).collect();
        merge(&mut stays);
        let longest = stays.iter().map(Stay::lasted).fold(0.0, f64::max);
        stays.retain(|stay| stay.lasted() >= PASSING.min(longest));
        merge(&mut stays);
        stays
    }

    /// Whether it went along the skin, and whether it came back to where it had been.
    pub fn moves(&self) -> (bool, bool) {
        let stays = self.stays();
        let back = |row: &&[Stay]| row[0].receptors == row[2].receptors;
        // A straight way may lead over a patch that lies within another, once.
        let within =
            |row: &[Stay]| row[0].receptors.iter().all(|receptor| row[1].receptors.contains(receptor));
        let (over, turns): (Vec<_>, Vec<_>) = stays.windows(3).filter(back).partition(|row| within(row));
        (stays.len() > 1, !turns.is_empty() || over.len() > 1)
    }

    /// How long nothing must touch beyond the release before it has ended, seconds: until it would have got over a hole as
    /// fast as it went. What has not moved is not waited for.
    pub fn patience(&self, skin: &MappedSkin) -> f64 {
        let stays = self.stays();
        let mut places: Vec<usize> = stays.iter().map(|stay| stay.newest).collect();
        places.dedup();
        let [.., from, to] = places[..] else { return 0.0 };
        let way: f64 = places.windows(2).map(|pair| skin.way(pair[0], pair[1])).sum();
        let took = stays[stays.len() - 1].span[1] - stays[0].span[0];
        let wait = if skin.leads_off(from, to) { BARE } else { HOLE };
        (wait * took / way).min(LONGEST)
    }

    /// What it was, all in all.
    pub fn side(&self, skin: &MappedSkin, duration: f64) -> SensationSide {
        let mut visits: Vec<(usize, [f64; 2])> =
            self.stays().into_iter().map(|stay| (stay.newest, stay.span)).collect();
        if visits.is_empty() {
            // Of what lasted a single step there is no stay.
            visits.push((self.firings[0].receptor, self.firings[0].span));
        }
        let mut limbs: Vec<LimbSensation> = Vec::new();
        let (mut path, mut before) = (0.0, visits[0].0);
        for (receptor, span) in visits {
            let (limb, end) = (skin.limb(receptor), skin.centre(receptor));
            let way = skin.way(before, receptor);
            let along = if skin.limb(before) == limb { way } else { 0.0 };
            match limbs.iter_mut().find(|part| part.limb == limb) {
                Some(part) => {
                    (part.end, part.span[1]) = (end, span[1]);
                    part.direction = (end - part.point).try_normalize(1e-9).unwrap_or_default();
                    part.path += along;
                }
                None => {
                    let (point, direction) = (end, Vector3::zeros());
                    limbs.push(LimbSensation { limb, point, end, span, path: 0.0, direction });
                }
            }
            (path, before) = (path + way, receptor);
        }
        let mut receptors: Vec<(usize, [f64; 2])> = Vec::new();
        for firing in &self.firings {
            match receptors.iter_mut().find(|(receptor, _)| *receptor == firing.receptor) {
                Some((_, span)) => span[1] = firing.span[1],
                None => receptors.push((firing.receptor, firing.span)),
            }
        }
        let speed = if duration > 0.0 { path / duration } else { 0.0 };
        SensationSide { limb: limbs[0].limb, last_limb: skin.limb(before), receptors, path, speed, limbs }
    }
}
