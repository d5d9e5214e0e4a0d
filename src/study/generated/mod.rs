//! Random bodies: a seed determines one and its ground truth, the MJCF itself.
//!
//! They are drawn without a look at what can be learned of them: some touch themselves nowhere, and much of some nobody
//! could find out. The typical length of a limb is uniform in its logarithm from 1 cm to 10 m. The same seed gives the same
//! text on every machine.
//!
//! ```
//! use bodyschema::study::generated::GeneratedBody;
//!
//! let body = GeneratedBody::new(7);
//! assert!(body.mjcf.starts_with("<mujoco model=\"body-7\">"));
//! assert_eq!(body.mjcf, GeneratedBody::new(7).mjcf);
//! ```

mod draw;
mod families;
mod joints;
mod limb;
mod mjcf;
mod tree;

use serde::{Deserialize, Serialize};

use self::draw::Draw;
pub use self::families::Family;
use self::joints::Joining;
use self::tree::Tree;
use crate::creature::DofKind;

/// Typical lengths of a limb, metres.
pub const LENGTHS: [f64; 2] = [0.01, 10.0];

/// A body made from a seed.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneratedBody {
    /// Its seed.
    pub seed: u64,
    /// What was drawn.
    pub drawn: DrawnBody,
    /// The model, which is the truth.
    pub mjcf: String,
}

/// What was drawn for a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrawnBody {
    /// The name of its family.
    pub family: String,
    /// The typical length of its limbs, metres.
    pub length: f64,
    /// Limbs with shapes of their own, the trunk included; welded ones are part of those that carry them.
    pub limbs: usize,
    /// Limbs without any, between two hinges a way apart.
    pub bare: usize,
    /// Degrees of freedom; a ball counts three.
    pub dof: usize,
    /// Hinges, those included that give by a fraction of a degree, and those that follow others.
    pub hinges: usize,
    /// Slides.
    pub slides: usize,
    /// Balls.
    pub balls: usize,
    /// Hinges that give by a fraction of a degree.
    pub locked: usize,
    /// Hinges along limbs, which move little of what can be felt.
    pub spins: usize,
    /// Hinges that follow others.
    pub followers: usize,
    /// Limbs that are welded to those that carry them.
    pub welded: usize,
    /// How far axes are off straight ones: 0 not at all, 3 in any direction.
    pub skew: f64,
}

impl GeneratedBody {
    /// The body of a seed.
    pub fn new(seed: u64) -> GeneratedBody {
        let mut draw = Draw::new(seed);
        let family = Family::ALL[draw.count(0, Family::ALL.len() - 1)];
        let length = draw.log_between(LENGTHS[0], LENGTHS[1]);
        let mut tree = family.body(draw, length);
        let drawn = DrawnBody::of(&tree, family);
        let mjcf = mjcf::text(&mut tree, &GeneratedBody::name_of(seed), &drawn.in_words());
        GeneratedBody { seed, drawn, mjcf }
    }

    /// Its model's name.
    pub fn name(&self) -> String {
        GeneratedBody::name_of(self.seed)
    }

    fn name_of(seed: u64) -> String {
        format!("body-{seed}")
    }
}

impl DrawnBody {
    fn of(tree: &Tree, family: Family) -> DrawnBody {
        let freedoms = || tree.limbs.iter().flat_map(|limb| &limb.freedoms);
        let count = |kind: DofKind| freedoms().filter(|freedom| freedom.kind == kind).count();
        let [hinges, slides, balls] = [DofKind::Hinge, DofKind::Slide, DofKind::Ball].map(count);
        let joined = |joining: Joining| tree.limbs[1..].iter().filter(|limb| limb.joining == joining).count();
        DrawnBody {
            family: family.name().into(),
            length: draw::rounded(tree.scale),
            limbs: tree.limbs.len() - joined(Joining::Welded),
            bare: joined(Joining::Apart),
            dof: hinges + slides + 3 * balls,
            hinges,
            slides,
            balls,
            locked: joined(Joining::Locked),
            spins: joined(Joining::Spin),
            followers: freedoms().filter(|freedom| freedom.follows.is_some()).count(),
            welded: joined(Joining::Welded),
            skew: tree.style.skew,
        }
    }

    /// It in words.
    pub fn in_words(&self) -> String {
        let parts = [
            (self.hinges, "hinge", "hinges"),
            (self.slides, "slide", "slides"),
            (self.balls, "ball", "balls"),
            (self.locked, "of the hinges as good as locked", "of the hinges as good as locked"),
            (self.spins, "along its limb", "along their limbs"),
            (self.followers, "that follows another", "that follow others"),
            (self.welded, "limb welded", "limbs welded"),
        ];
        let counted = |(count, one, many)| format!("{count} {}", if count == 1 { one } else { many });
        let parts: Vec<String> = parts.into_iter().filter(|(count, ..)| *count > 0).map(counted).collect();
        format!(
            "{}: {} limbs of about {:.3} m, {} degrees of freedom: {}",
            self.family,
            self.limbs,
            self.length,
            self.dof,
            parts.join(", ")
        )
    }
}
