//! Where a part of its own body is that is called by name: skin, found by what a creature's limbs and joints are called,
//! by the schema and by where on a limb it lies.
//!
//! A creature's own names come first, then everyday ones: the nose is the foremost skin of the head, an elbow is the skin
//! behind the joint of this name.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::actor::Actor;
use super::conversation::grammar::{EVERYDAY, PartName, name_words, patch_name};
use crate::geometry::{Capsule, ConvexBody, Frame};
use crate::peripersonal::STICK_TIP;

/// How far from a joint the skin is that is taken for it, metres: half a limb's thickness.
const ABOUT_JOINT: f64 = 0.04;

/// A part of the body: what it is called, and its skin.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPart {
    /// What it is called: `left elbow`.
    pub name: String,
    /// Its receptors, the one that it is first.
    pub receptors: Vec<usize>,
    /// The limb and the point of it that it is about, in the limb's frame, metres.
    place: (usize, Vector3<f64>),
    /// Whether all of its skin is as good as any: a whole limb.
    whole: bool,
}

impl BodyPart {
    /// Where it is in the root's frame, by the limbs' poses, metres.
    pub fn at(&self, frames: &[Frame]) -> Vector3<f64> {
        frames[self.place.0].point(&self.place.1)
    }

    /// What it takes up in the root's frame, by the limbs' poses: the surfaces of a whole limb's skin, else its place alone.
    pub fn extent<'a>(&self, actor: &'a Actor, frames: &[Frame]) -> Vec<Box<dyn ConvexBody + 'a>> {
        let skin = actor.own.skin();
        let surfaces: BTreeSet<usize> = match self.whole {
            true => self.receptors.iter().filter_map(|&r| skin.receptors[r].surface).collect(),
            false => BTreeSet::new(),
        };
        let mut extent: Vec<Box<dyn ConvexBody + 'a>> = Vec::new();
        for surface in surfaces.into_iter().map(|surface| &skin.surfaces[surface]) {
            if let Some(placed) = surface.placed(&frames[surface.limb]) {
                extent.push(Box::new(placed));
            }
        }
        if extent.is_empty() {
            extent.push(Box::new(Capsule::ball(self.at(frames), 0.0)));
        }
        extent
    }

    /// How far a receptor is from the nearest of those that are this part, in the posture now, metres.
    pub fn off(&self, actor: &Actor, receptor: usize) -> f64 {
        let frames = actor.frames();
        let at = |receptor: usize| {
            let receptor = &actor.own.skin().receptors[receptor];
            frames[receptor.limb].point(&receptor.position)
        };
        let half = |receptor: usize| {
            let [a, b] = actor.own.skin().receptors[receptor].half_extents;
            a.max(b)
        };
        let Some(&first) = self.receptors.first() else { return f64::NAN };
        if self.receptors.contains(&receptor) && self.whole {
            return 0.0;
        }
        ((at(receptor) - at(first)).norm() - half(first)).max(0.0)
    }
}

/// The parts that a name may mean, most often one; both where there is one on either side and none is named. `touching` is
/// the hand that acts now, of which the other is "the other".
///
/// # Errors
/// Why it is not known, in words.
pub(super) fn find(actor: &Actor, part: &PartName, touching: Option<usize>) -> Result<Vec<BodyPart>, String> {
    let body = PosedBody::new(actor);
    let mut words: Vec<String> = part.words.clone();
    if words.first().is_some_and(|word| word == "other") {
        let which = "I do not know which is the other one: say left or right";
        let other = 1 - touching.ok_or(which)?;
        words[0] = if other == actor.hand_towards(&actor.left()) { "left" } else { "right" }.into();
    }
    words.retain(|word| word != "both" && word != "own");
    let tip = words.len() > 1 && words.last().is_some_and(|last| last == "tip");
    let (name, words) = (words.join(" "), &words[..words.len() - usize::from(tip)]);
    let found = body
        .by_own_name(&name, words, tip)
        .or_else(|| body.by_everyday_name(words, tip))
        .or_else(|| body.by_part_of_name(name, words, tip));
    found.filter(|found| !found.is_empty()).ok_or(format!("I know of no {} on my body", part.text()))
}

/// A body in the rest posture, in which skin is told apart by where it lies.
struct PosedBody<'a> {
    actor: &'a Actor,
    frames: Vec<Frame>,
    /// Per receptor, the words of all names that it has: its own, its limb's, its aura's.
    names: Vec<Vec<Vec<String>>>,
}

impl PosedBody<'_> {
    fn new(actor: &Actor) -> PosedBody<'_> {
        let own = &actor.own;
        let frames = own.frames(&own.at_ease());
        let (limbs, auras) = (own.creature().limbs().iter(), own.creature().aura_limbs().iter());
        let known: Vec<Vec<String>> =
            limbs.chain(auras.map(|aura| &aura.name)).map(|name| name_words(name)).collect();
        let names = own.skin().receptors.iter().map(|receptor| {
            // The tip of a stick is no part of the body that has a name.
            if receptor.id == STICK_TIP {
                return Vec::new();
            }
            let aura = own.creature().aura_of(receptor.limb);
            let aura = aura.map(|aura| name_words(&own.creature().aura_limbs()[aura].name));
            let limb = name_words(&own.creature().limbs()[receptor.limb]);
            let patch = name_words(patch_name(&receptor.id));
            // Skin that is called otherwise than its limb is not that limb's: legs that do not move are the pelvis'.
            let foreign = aura.as_ref().is_some_and(|aura| *aura != patch)
                && !known.contains(&patch)
                && !patch.is_empty();
            let others = std::iter::once(limb).chain(aura).filter(|_| !foreign);
            std::iter::once(patch).chain(others).collect()
        });
        let names = names.collect();
        PosedBody { actor, frames, names }
    }

    fn at(&self, receptor: usize) -> Vector3<f64> {
        let receptor = &self.actor.own.skin().receptors[receptor];
        self.frames[receptor.limb].point(&receptor.position)
    }

    fn outward(&self, receptor: usize) -> Vector3<f64> {
        let receptor = &self.actor.own.skin().receptors[receptor];
        self.frames[receptor.limb].rotation * receptor.normal
    }

    /// The receptors that have a name.
    fn region(&self, words: &[String]) -> Vec<usize> {
        let named = |r: &usize| self.names[*r].iter().any(|name| same(name, words));
        (0..self.names.len()).filter(named).collect()
    }

    fn regions(&self, names: &[&str], side: Option<&str>) -> Vec<usize> {
        let mut found = Vec::new();
        for name in names {
            let mut words = name_words(name);
            let whole = self.region(&words);
            if let (Some(side), true) = (side, whole.is_empty()) {
                words.insert(0, side.to_string());
            }
            found.extend(if whole.is_empty() { self.region(&words) } else { whole });
        }
        found
    }

    /// To the front, to a side, up: in the root's frame.
    fn direction(&self, [front, side, up]: [f64; 3], of: Option<&str>) -> Vector3<f64> {
        let outward = if of == Some("right") { -self.actor.left() } else { self.actor.left() };
        (self.actor.front * front + outward * side + self.actor.up * up).normalize()
    }

    /// A part of skin, or its tip; `None` if there is no such skin.
    fn part(&self, name: String, receptors: Vec<usize>, tip: bool) -> Option<BodyPart> {
        if tip { self.tip(name, receptors) } else { self.whole(name, receptors) }
    }

    /// A part of skin that is as good everywhere: that nearest to its middle first.
    fn whole(&self, name: String, receptors: Vec<usize>) -> Option<BodyPart> {
        let count = receptors.len().max(1) as f64;
        let middle = receptors.iter().map(|&r| self.at(r)).sum::<Vector3<f64>>() / count;
        // What faces the front is easier met than what lies behind.
        let front = self.actor.front;
        let cost = |r: usize| (self.at(r) - middle).norm() - 0.05 * self.outward(r).dot(&front);
        Some(BodyPart { whole: true, ..self.sorted(name, receptors, cost, None)? })
    }

    fn sorted(
        &self,
        name: String,
        mut receptors: Vec<usize>,
        cost: impl Fn(usize) -> f64,
        about: Option<(usize, Vector3<f64>)>,
    ) -> Option<BodyPart> {
        receptors.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)));
        receptors.dedup();
        let first = &self.actor.own.skin().receptors[*receptors.first()?];
        let place = about.unwrap_or((first.limb, first.position));
        Some(BodyPart { name, receptors, place, whole: false })
    }

    fn tip(&self, name: String, receptors: Vec<usize>) -> Option<BodyPart> {
        let own = &self.actor.own;
        let first = *receptors.iter().min_by_key(|&&r| own.skin().receptors[r].limb)?;
        let root = self.frames[own.skin().receptors[first].limb].origin;
        self.sorted(name, receptors, |r| -(self.at(r) - root).norm(), None)
    }

    /// By a name that a limb, an aura, a patch of skin or a joint has.
    fn by_own_name(&self, name: &str, words: &[String], tip: bool) -> Option<Vec<BodyPart>> {
        let exact = self.region(words);
        if !exact.is_empty() {
            return Some(self.part(name.to_string(), exact, tip).into_iter().collect());
        }
        let both = ["left", "right"].into_iter().filter_map(|side| {
            let sided: Vec<String> = std::iter::once(side.to_string()).chain(words.iter().cloned()).collect();
            self.part(format!("{side} {name}"), self.region(&sided), tip)
        });
        Some(both.collect()).filter(|both: &Vec<BodyPart>| !both.is_empty())
    }

    /// By what everybody calls it.
    fn by_everyday_name(&self, words: &[String], tip: bool) -> Option<Vec<BodyPart>> {
        let is_side = |word: &&str| ["left", "right"].contains(word);
        let side = words.iter().map(String::as_str).find(is_side);
        let noun: Vec<&str> = words.iter().map(String::as_str).filter(|word| !is_side(word)).collect();
        let noun = noun.join(" ");
        let rows = EVERYDAY.iter().filter_map(|row| row.split_once(": "));
        let named = |nouns: &str| nouns.trim_end_matches('*').split(',').any(|other| other == noun);
        let (nouns, rule) = rows.into_iter().find(|(nouns, _)| named(nouns))?;
        let (sided, mut numbers) =
            (nouns.ends_with('*'), rule.split(' ').filter_map(|word| word.parse().ok()));
        let toward = [(); 3].map(|()| numbers.next().unwrap_or(0.0));
        let rule: Vec<&str> = rule.split(' ').filter(|word| word.parse::<f64>().is_err()).collect();
        // "Your hands" are the left hand and the right hand.
        let one = nouns.split([',', '*']).next();
        let one = one.filter(|one| noun == format!("{one}s") || ["feet", "calves"].contains(&&*noun));
        let noun = one.filter(|_| sided).unwrap_or(&noun);
        let sides: Vec<Option<&str>> = match (sided, side) {
            (false, _) => vec![None],
            (true, Some(side)) => vec![Some(side)],
            (true, None) => vec![Some("left"), Some("right")],
        };
        let found = sides.into_iter().filter_map(|side| {
            let name = side.map_or(noun.to_string(), |side| format!("{side} {noun}"));
            let toward = self.direction(toward, side);
            match rule.as_slice() {
                [_, "of", ..] if tip => None,
                ["all" | "tip", names @ ..] | names if tip => {
                    self.tip(format!("{name} tip"), self.regions(names, side))
                }
                ["all", names @ ..] => self.whole(name, self.regions(names, side)),
                ["tip", names @ ..] => self.tip(name, self.regions(names, side)),
                [joint, "of", names @ ..] => self.about(name, joint, names, toward, side),
                names => {
                    let skin = self.regions(names, side);
                    let facing = |r: usize| -(self.at(r).dot(&toward) + 0.02 * self.outward(r).dot(&toward));
                    self.sorted(name, skin, facing, None)
                }
            }
        });
        Some(found.collect())
    }

    /// Skin about a joint; where there is none of the name, about where two regions meet.
    fn about(
        &self,
        name: String,
        joint: &str,
        regions: &[&str],
        toward: Vector3<f64>,
        side: Option<&str>,
    ) -> Option<BodyPart> {
        let own = &self.actor.own;
        let wanted: Vec<String> = side.iter().chain(&[joint]).map(|word| word.to_string()).collect();
        let called = |j: &usize| {
            let words = name_words(&own.creature().joints()[*j].name);
            wanted.iter().all(|word| words.contains(word))
        };
        let [a, b] = [regions[0], regions[1]].map(|name| self.regions(&[name], side));
        let joint = (0..own.creature().joints().len()).find(called);
        let (centre, about) = match joint {
            Some(j) => (self.frames[j + 1].origin, Some((j + 1, Vector3::zeros()))),
            None => {
                let pairs = a.iter().flat_map(|&r| b.iter().map(move |&s| (r, s)));
                let gap = |(r, s): &(usize, usize)| (self.at(*r) - self.at(*s)).norm();
                let (r, s) = pairs.min_by(|x, y| gap(x).total_cmp(&gap(y)))?;
                (0.5 * (self.at(r) + self.at(s)), None)
            }
        };
        let meant = centre + toward * ABOUT_JOINT;
        let skin: Vec<usize> = a.into_iter().chain(b).collect();
        self.sorted(name, skin, |r| (self.at(r) - meant).norm() - 0.02 * self.outward(r).dot(&toward), about)
    }

    /// By some words of a creature's own names: "front left leg" of `left_front_leg_upper`. "Leg" and the like may be what no
    /// name has, where the rest tells limbs apart.
    fn by_part_of_name(&self, name: String, words: &[String], tip: bool) -> Option<Vec<BodyPart>> {
        let general = ["leg", "arm", "limb", "foot", "paw", "claw", "hand", "wing", "finger"];
        let having = |wanted: &[&String]| -> Vec<usize> {
            let has =
                |r: &usize| self.names[*r].iter().any(|name| wanted.iter().all(|word| name.contains(word)));
            (0..self.names.len()).filter(has).collect()
        };
        let all: Vec<&String> = words.iter().collect();
        let mut skin = having(&all);
        let telling: Vec<&String> = words.iter().filter(|word| !general.contains(&word.as_str())).collect();
        if skin.is_empty() && !telling.is_empty() && telling.len() < words.len() {
            skin = having(&telling);
        }
        self.part(name, skin, tip).map(|part| vec![part])
    }
}

/// Whether two names are of the same words, in whatever order.
fn same(a: &[String], b: &[String]) -> bool {
    a.len() == b.len() && a.iter().all(|word| b.contains(word))
}
