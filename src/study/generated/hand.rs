//! Hands: a palm and fingers on it.

use nalgebra::{UnitQuaternion, Vector3};

use super::draw::quaternion;
use super::joints::{Freedom, Joining};
use super::limb::{limb_shapes, palm_shape};
use super::tree::{Mount, Tree};
use crate::creature::DofKind;

/// Shares of a palm's length that the bones of a finger have, from the palm on.
const BONES: [f64; 3] = [0.55, 0.4, 0.3];

/// Adds fingers to a palm; their names begin with `side`.
pub fn fingers(tree: &mut Tree, palm: usize, side: &str, [width, thickness]: [f64; 2]) {
    let length = tree.limbs[palm].length;
    let count = tree.draw.count(2, 4);
    let bones = tree.draw.count(2, 3);
    let stretch = tree.draw.between(0.8, 1.4);
    // The last bone of a finger follows the one before it in some hands, as tendons make it.
    let coupled = tree.draw.chance(0.3);
    let bend = if tree.draw.chance(0.5) { 1.0 } else { -1.0 };
    for finger in 0..count {
        let x = width * ((finger as f64 + 0.5) / count as f64 - 0.5);
        let (at, towards) = (Vector3::new(x, 0.0, 1.03 * length), Vector3::new(0.3 * x / width, 0.0, 1.0));
        let radius = (0.4 * width / count as f64).min(thickness * 0.5);
        let mount = Mount::on(palm, at, towards, 0.0).sized(length * stretch, radius);
        let shape = Finger { bones, coupled, bend, spreads: finger == 0 };
        one(tree, &format!("{side}finger_{}", finger + 1), mount, &shape);
    }
    if tree.draw.chance(0.7) {
        let side_of = if tree.draw.chance(0.5) { 1.0 } else { -1.0 };
        let at = Vector3::new(side_of * 0.58 * width, 0.0, 0.45 * length);
        let mount = Mount::on(palm, at, Vector3::new(side_of, 0.4 * bend, 0.6), 0.0);
        let mount = mount.sized(0.9 * length * stretch, (0.12 * width).max(0.3 * thickness));
        one(tree, &format!("{side}thumb"), mount, &Finger { bones: 2, coupled: false, bend, spreads: true });
    }
}

/// Adds a palm, flat and along the arm; its number, width and thickness.
pub fn palm(tree: &mut Tree, name: String, mount: Mount, joining: Joining) -> (usize, [f64; 2]) {
    let (width, thickness) =
        (mount.length * tree.draw.between(0.6, 1.0), mount.length * tree.draw.between(0.18, 0.3));
    let shape = palm_shape(&mut tree.draw, [0.12 * mount.length, mount.length], width, thickness);
    let freedoms = tree.style.freedoms(&mut tree.draw, joining, mount.length);
    let turned = tree.draw.twist();
    let mount = Mount { radius: 0.5 * thickness, ..mount };
    (tree.push(name, &mount, turned, vec![shape], joining, freedoms), [width, thickness])
}

/// How a finger is.
struct Finger {
    bones: usize,
    /// Whether its last bone follows the one before it.
    coupled: bool,
    /// To which side it bends.
    bend: f64,
    /// Whether it can be spread.
    spreads: bool,
}

/// Adds a finger: where it is mounted, how long and how thick it is in all.
fn one(tree: &mut Tree, name: &str, mut mount: Mount, finger: &Finger) {
    let whole = mount;
    for bone in 0..finger.bones {
        let length = whole.length * BONES[bone] * tree.draw.between(0.9, 1.1);
        let radius = whole.radius * [1.0, 0.9, 0.8][bone];
        let turned = if bone == 0 { tipped(&whole.towards) } else { UnitQuaternion::identity() };
        let shapes = limb_shapes(&mut tree.draw, [0.12 * length, length], radius);
        let mut freedoms = Vec::new();
        if bone == 0 && finger.spreads {
            let axis = tree.draw.about(&Vector3::y(), 0.3 * tree.style.skew.min(1.0));
            freedoms.push(Freedom::new(
                DofKind::Hinge,
                axis,
                [-tree.draw.between(10.0, 25.0), tree.draw.between(10.0, 40.0)],
            ));
        }
        let axis = tree.draw.about(&(Vector3::x() * finger.bend), 0.3 * tree.style.skew.min(1.0));
        freedoms.push(Freedom::new(
            DofKind::Hinge,
            axis,
            [-tree.draw.between(5.0, 30.0), tree.draw.between(70.0, 115.0)],
        ));
        if bone + 1 == finger.bones && bone > 0 && finger.coupled {
            freedoms[0].follows = Some(tree.draw.between(0.5, 1.0));
        }
        let joining = if freedoms.len() > 1 { Joining::TwoHinges } else { Joining::Hinge };
        mount = mount.sized(length, radius);
        let limb = tree.push(format!("{name}_{}", bone + 1), &mount, turned, shapes, joining, freedoms);
        mount = Mount::on(limb, Vector3::z() * (1.06 * length), whole.towards, 0.0);
    }
}

/// The turn that brings z towards somewhere and leaves x across.
fn tipped(towards: &Vector3<f64>) -> UnitQuaternion<f64> {
    let to = towards.normalize();
    quaternion(1.0 + to.z, Vector3::z().cross(&to))
}
