//! What parts of a body are called: in everyday words, and as a creature's own limbs, joints and skin are named.

use crate::peripersonal::OwnBody;

/// What is said of a part before its name: which one of several it is.
const WHICH: &[&str] = &[
    "left", "right", "other", "upper", "lower", "front", "middle", "hind", "rear", "own", "both", "back",
    "fore", "top", "bottom",
];
/// Everyday names, with a star where there is one on either side, and how skin of the name is found: the farthest of some regions to
/// the front, to its own side (or to the left), and up; about a joint by its name, or where two regions meet, in such a direction;
/// the `tip` of a region, farthest from where that is carried; or `all` of some.
pub(in crate::interaction) const EVERYDAY: &[&str] = &[
    "nose,tip of nose: head 1 0 0",
    "mouth,lip,lips: head 1 0 -0.4",
    "chin,jaw: head 1 0 -1",
    "forehead,brow: head 1 0 0.8",
    "face: head 1 0 0",
    "back of head: head -1 0 0",
    "top of head,crown,scalp,hair: head 0 0 1",
    "cheek,cheeks*: head 1 0.9 -0.2",
    "eye,eyes*: head 1 0.5 0.35",
    "temple,temples*: head 0.5 1 0.3",
    "ear,ears,side of head*: head 0 1 0",
    "throat: neck 1 0 0",
    "nape,back of neck: neck -1 0 0",
    "belly,tummy,stomach,navel,belly button,waist: abdomen 1 0 0",
    "breastbone,sternum,breast,torso,trunk: chest 1 0 0",
    "heart: chest 1 0.3 0",
    "rib,ribs*: chest 0.2 1 -0.3",
    "collarbone,clavicle*: chest 1 0.6 1",
    "shoulder blade*: chest -1 0.6 0.5",
    "back,upper back,spine: chest -1 0 0",
    "lower back: abdomen -1 0 0",
    "hip,hips*: pelvis 0 1 0",
    "bottom,bum,buttocks,backside: pelvis -1 0 -0.3",
    "armpit*: shoulder of upper_arm chest 0 -0.3 -1",
    "shoulder,shoulders*: shoulder of upper_arm chest 0 1 0.6",
    "elbow,elbows*: elbow of upper_arm forearm -1 0.3 0",
    "wrist,wrists*: wrist of forearm hand 0 1 0",
    "lower arm*: all forearm",
    "arm,arms*: all upper_arm forearm hand",
    "upper arm,upper arms*: all upper_arm",
    "palm,palms,palm of hand*: hand 0 -1 0",
    "back of hand*: hand 0 1 0",
    "hand,hands,fist*: all hand",
    "knuckle,knuckles*: hand 0 1 -0.3",
    "thumb,thumbs*: hand 1 0 0",
    "finger,fingers,fingertip,fingertips,index,index finger,middle finger,ring finger,little finger*: tip hand",
    "lap*: thigh 1 0 0.6",
    "upper leg,thighs*: all thigh",
    "leg,legs*: all thigh shank foot",
    "knee,knees*: knee of thigh shank 1 0 0",
    "shin,shins,lower leg*: shank 1 0 0",
    "calf,calves*: shank -1 0 0",
    "ankle,ankles*: ankle of shank foot 0 1 0",
    "foot,feet*: all foot",
    "heel,heels*: foot -1 0 -0.5",
    "toe,toes,big toe*: foot 1 0 0",
    "sole,soles,sole of foot*: foot 0 0 -1",
];

/// Everyday nouns of a body that [`EVERYDAY`] does not locate: what it measures from, or what no creature has skin of.
const OTHERS: &str = "head,neck,abdomen,chest,pelvis,forearm,forearms,thigh,shank,limb,limbs,shoulder blades,upper body,tummy button,\
    eyebrow,eyebrows,earlobe,earlobes,nostril,nostrils,pinky,bellybutton,gut,butt,groin,eyelid,eyelids,tongue,teeth";
/// Nouns that mean something else as often: they are a part only after one of [`OWNERS`], or of a side where they are [`PAIRED`].
const DOUBTFUL: &[&str] = &[
    "back", "face", "head", "crown", "bottom", "index", "lap", "sole", "heart", "temple", "trunk", "calf",
    "middle", "tip",
];
/// Those of them of which there are a left and a right one.
const PAIRED: &[&str] = &["index", "sole", "temple", "calf"];
/// Words after which a doubtful noun is a part.
const OWNERS: &[&str] = &["your", "his", "own", "upper", "lower", "yourself"];
/// The nouns of what acts.
const HANDS: &str = "hand hands arm arms palm palms fist finger fingers fingertip fingertips";

/// A part of the body as it was named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartName {
    /// Its words without whose it is: `left elbow`.
    pub words: Vec<String>,
}

impl PartName {
    /// Its words in one.
    pub fn text(&self) -> String {
        self.words.join(" ")
    }

    /// Whether it is what acts: a hand, an arm, a finger.
    pub fn is_hand(&self) -> bool {
        let last = self.words.last().is_some_and(|last| HANDS.split(' ').any(|hand| hand == last));
        last && !self
            .words
            .iter()
            .any(|word| ["upper", "lower", "index", "ring", "little", "back"].contains(&word.as_str()))
    }
}

/// The names that a creature's parts have.
pub struct BodyNames {
    /// Everyday nouns and its own, each in words.
    names: Vec<Vec<String>>,
    adjectives: Vec<String>,
}

impl BodyNames {
    /// Everyday names alone.
    pub fn everyday() -> BodyNames {
        let located = EVERYDAY.iter().filter_map(|row| row.split_once(": "));
        let nouns = located.flat_map(|(nouns, _)| nouns.trim_end_matches('*').split(','));
        let names = nouns.chain(OTHERS.split(',')).map(|name| name.split(' ').map(String::from).collect());
        let adjectives = WHICH.iter().map(|word| word.to_string()).collect();
        let mut names: Vec<Vec<String>> = names.collect();
        names.sort_by_key(|name| std::cmp::Reverse(name.len()));
        BodyNames { names, adjectives }
    }

    /// Those, and the names of a creature's limbs, auras, joints and skin.
    pub fn of(own: &OwnBody) -> BodyNames {
        let mut all = BodyNames::everyday();
        for name in own_names(own) {
            let mut words = name_words(&name);
            // What tells sides apart stands where it is said.
            let which = words.iter().take_while(|word| WHICH.contains(&word.as_str())).count();
            let noun = words.split_off(which.min(words.len().saturating_sub(1)));
            // A name's every word may stand for it with others: the front leg.
            for word in &noun {
                if word.chars().count() > 2 {
                    all.names.push(vec![word.clone()]);
                }
            }
            all.names.push(noun);
        }
        all.names.sort_by_key(|name| std::cmp::Reverse(name.len()));
        all.names.dedup();
        all
    }

    /// All their words.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.names.iter().flatten().chain(&self.adjectives).map(String::as_str)
    }

    /// The part that some words begin with, and how many words of them it is: `your left elbow`, `the tip of your nose`.
    /// `None` if it is somebody else's, or no part.
    pub(super) fn at(&self, words: &[&str]) -> Option<(PartName, usize)> {
        let skipped =
            words.iter().take_while(|word| ["your", "the", "his", "its", "that"].contains(*word)).count();
        let owned = words[..skipped].iter().any(|word| ["your", "his"].contains(word));
        let rest = &words[skipped..];
        let which = rest.iter().take_while(|word| WHICH.contains(*word)).count();
        // The noun may begin with what tells which as well: "upper arm", "back".
        for before in (0..=which).rev() {
            for name in &self.names {
                let Some(length) = begins(&rest[before..], name) else { continue };
                let noun = &rest[before..before + length];
                let doubtful = name.len() == 1 && DOUBTFUL.contains(&name[0].as_str());
                let sides = PAIRED.contains(&name[0].as_str());
                let owner = |word: &&str| OWNERS.contains(word) || sides && ["left", "right"].contains(word);
                let told = owned || rest[..before].iter().any(owner);
                if doubtful && !told {
                    continue;
                }
                let named: Vec<String> =
                    rest[..before].iter().chain(noun).map(|word| word.to_string()).collect();
                let named = named.into_iter().filter(|word| !["your", "the", "own"].contains(&word.as_str()));
                let mut end = skipped + before + length;
                let mut words_of: Vec<String> = named.collect();
                if words.get(end) == Some(&"tip") {
                    words_of.push("tip".into());
                    end += 1;
                }
                return Some((PartName { words: words_of }, end));
            }
        }
        // "The tip of …".
        if rest.first() == Some(&"tip") && rest.get(1) == Some(&"of") {
            let (mut part, length) = self.at(&rest[2..])?;
            part.words.push("tip".into());
            return Some((part, skipped + 2 + length));
        }
        None
    }
}

/// How many of some words a name takes that they begin with; after "of" it may be told whose it is, or of which side.
fn begins(words: &[&str], name: &[String]) -> Option<usize> {
    let mut k = 0;
    for part in name {
        if k > 0 && words[k - 1] == "of" {
            k +=
                words[k..].iter().take_while(|word| ["your", "the", "left", "right"].contains(*word)).count();
        }
        if words.get(k) != Some(&part.as_str()) {
            return None;
        }
        k += 1;
    }
    Some(k)
}

/// The names of a creature's limbs, auras, joints, and of its skin's patches without their numbers.
fn own_names(own: &OwnBody) -> Vec<String> {
    let creature = own.creature();
    let mut names: Vec<String> = creature.limbs().to_vec();
    names.extend(creature.aura_limbs().iter().map(|aura| aura.name.clone()));
    names.extend(creature.joints().iter().map(|joint| joint.name.clone()));
    names.extend(own.skin().receptors.iter().map(|receptor| patch_name(&receptor.id).to_string()));
    names.sort_unstable();
    names.dedup();
    names
}

/// A patch's name without its number.
pub(in crate::interaction) fn patch_name(id: &str) -> &str {
    id.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches(['_', '-', '.', ' '])
}

/// The words of a name as models have them, small letters.
pub(in crate::interaction) fn name_words(name: &str) -> Vec<String> {
    let words = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect()
}
