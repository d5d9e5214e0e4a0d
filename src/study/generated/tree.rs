//! A body while it is put together, limb by limb, so that in the reference posture nothing lies in anything else.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::draw::{Draw, z_to};
use super::joints::{Freedom, Joining, JointStyle};
use super::limb::{LimbPart, limb_shapes, trunk_shape};
use crate::geometry::Capsule;

/// Directions that are tried for a limb until one keeps clear of the others.
const TRIES: usize = 24;
/// Share of a limb's length that is bare about its joint.
const BARE: f64 = 0.12;

/// A limb as it is drawn.
#[derive(Clone, Debug)]
pub struct Limb {
    /// Its name.
    pub name: String,
    /// The limb that carries it; none for the trunk.
    pub parent: Option<usize>,
    /// Its pose in its parent's frame in the reference posture: it lies along z.
    pub pose: Isometry3<f64>,
    /// From its joint to where it ends, metres.
    pub length: f64,
    /// What it is made of.
    pub shapes: Vec<LimbPart>,
    /// How it is joined.
    pub joining: Joining,
    /// Its degrees of freedom.
    pub freedoms: Vec<Freedom>,
}

/// Where the next limb goes, and how it is.
#[derive(Clone, Copy)]
pub struct Mount {
    /// The limb that carries it.
    pub parent: usize,
    /// Where it begins, in its parent's frame, metres.
    pub at: Vector3<f64>,
    /// Where it is to point, in its parent's frame.
    pub towards: Vector3<f64>,
    /// How far off that it may point: 0 not at all, 1 and more anywhere.
    pub spread: f64,
    /// From its joint to where it ends, metres.
    pub length: f64,
    /// How thick it is, metres.
    pub radius: f64,
}

impl Mount {
    /// A place on a limb, for limbs of no size yet.
    pub fn on(parent: usize, at: Vector3<f64>, towards: Vector3<f64>, spread: f64) -> Mount {
        Mount { parent, at, towards, spread, length: 0.0, radius: 0.0 }
    }

    /// The same for a limb of a size, metres.
    pub fn sized(self, length: f64, radius: f64) -> Mount {
        Mount { length, radius, ..self }
    }
}

/// A body that grows.
pub struct Tree {
    /// What is drawn from.
    pub draw: Draw,
    /// How its joints are.
    pub style: JointStyle,
    /// The typical length of a limb, metres.
    pub scale: f64,
    /// How thick limbs are, in units of their length.
    pub thickness: f64,
    /// Its limbs, parents first.
    pub limbs: Vec<Limb>,
    /// Where each is in the reference posture, and the capsule about it there.
    placed: Vec<(Isometry3<f64>, Capsule)>,
}

impl Tree {
    /// A trunk of some size, half its sides in units of the typical length.
    pub fn new(mut draw: Draw, scale: f64, half: [f64; 3]) -> Tree {
        let style = JointStyle::drawn(&mut draw);
        let thickness = draw.between(0.09, 0.22);
        let half = Vector3::from(half) * scale;
        let shape = trunk_shape(&mut draw, half);
        let radius = half.x.max(half.y);
        let along = Vector3::z() * (half.z - radius).max(0.0);
        let trunk = Limb {
            name: "trunk".into(),
            parent: None,
            pose: Isometry3::identity(),
            length: 2.0 * half.z,
            shapes: vec![shape],
            joining: Joining::Welded,
            freedoms: Vec::new(),
        };
        let capsule = Capsule { ends: [-along, along], radius };
        let placed = vec![(Isometry3::identity(), capsule)];
        Tree { draw, style, scale, thickness, limbs: vec![trunk], placed }
    }

    /// A length about a share of the typical one.
    pub fn length(&mut self, share: f64) -> f64 {
        self.scale * share * self.draw.between(0.75, 1.3)
    }

    /// How thick a limb of some length is, metres.
    pub fn radius(&mut self, length: f64) -> f64 {
        length * self.thickness * self.draw.between(0.8, 1.2)
    }

    /// The end of a limb, in its own frame.
    pub fn end_of(&self, limb: usize) -> Vector3<f64> {
        Vector3::z() * self.limbs[limb].length
    }

    /// A place on the trunk's surface, and somewhat out of it.
    pub fn on_trunk(&self, towards: &Vector3<f64>) -> Vector3<f64> {
        self.trunk_half().component_mul(towards) * 1.12
    }

    /// Half the trunk's sides, metres.
    pub fn trunk_half(&self) -> Vector3<f64> {
        self.limbs[0].shapes[0].shape.half_bounds()
    }

    /// Adds a limb joined as the body's style draws it; its number.
    pub fn limb(&mut self, name: String, mount: Mount) -> usize {
        let joining = self.style.joining(&mut self.draw);
        self.joined_limb(name, mount, joining)
    }

    /// Adds a limb that is joined in some way; its number.
    pub fn joined_limb(&mut self, name: String, mount: Mount, joining: Joining) -> usize {
        let (length, radius) = (mount.length, mount.radius);
        let turned = self.direction(&mount);
        let turned = turned * self.draw.twist();
        let shapes = limb_shapes(&mut self.draw, [BARE * length, (1.0 - 0.3 * BARE) * length], radius);
        let freedoms = self.style.freedoms(&mut self.draw, joining, length);
        self.push(name, &mount, turned, shapes, joining, freedoms)
    }

    /// Adds a limb of which all is known; its number.
    pub fn push(
        &mut self,
        name: String,
        mount: &Mount,
        turned: UnitQuaternion<f64>,
        shapes: Vec<LimbPart>,
        joining: Joining,
        freedoms: Vec<Freedom>,
    ) -> usize {
        let pose = Isometry3::from_parts(Translation3::from(mount.at), turned);
        let placed = self.placed[mount.parent].0 * pose;
        let capsule = capsule_of(&placed, mount.length, mount.radius);
        self.placed.push((placed, capsule));
        let (parent, length) = (Some(mount.parent), mount.length);
        self.limbs.push(Limb { name, parent, pose, length, shapes, joining, freedoms });
        self.limbs.len() - 1
    }

    /// A direction for a limb that keeps it clear of all others, or the clearest of those tried.
    fn direction(&mut self, mount: &Mount) -> UnitQuaternion<f64> {
        let mut best = (f64::NEG_INFINITY, UnitQuaternion::identity());
        for attempt in 0..TRIES {
            // The longer it takes the farther off it may be.
            let spread = mount.spread * (1.0 + attempt as f64 / 6.0) + if attempt > 6 { 0.3 } else { 0.0 };
            let turned = z_to(&self.draw.about(&mount.towards, spread));
            let pose = Isometry3::from_parts(Translation3::from(mount.at), turned);
            let own = capsule_of(&(self.placed[mount.parent].0 * pose), mount.length, mount.radius);
            let others = self.placed.iter().enumerate().filter(|(other, _)| *other != mount.parent);
            let clear = others.map(|(_, (_, other))| own.gap(other).distance).fold(mount.radius, f64::min);
            if clear > best.0 {
                best = (clear, turned);
            }
            if clear > 0.3 * mount.radius {
                break;
            }
        }
        best.1
    }
}

/// The capsule about a limb, wherever it is.
fn capsule_of(pose: &Isometry3<f64>, length: f64, radius: f64) -> Capsule {
    let at = |z: f64| pose.transform_point(&Point3::new(0.0, 0.0, z)).coords;
    Capsule {
        ends: [at(BARE * length + radius), at(length.max(BARE * length + radius))],
        radius: 1.2 * radius,
    }
}
