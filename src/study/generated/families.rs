//! The families of bodies: how limbs hang on each other.

use nalgebra::{UnitQuaternion, Vector3};

use super::draw::{Draw, quaternion};
use super::joints::{Freedom, Joining};
use super::limb::{limb_shapes, palm_shape};
use super::tree::{Mount, Tree};
use crate::creature::DofKind;
use crate::named::named;

named! {
    "family",
    /// A family of bodies.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Family {
        /// Limbs one after the other.
        Chain = "chain",
        /// Many short limbs one after the other, each bending in another plane.
        Snake = "snake",
        /// Arms all alike about a ball.
        Star = "star",
        /// A trunk with a chest, a head, two arms and two legs.
        Humanoid = "humanoid",
        /// A trunk on four, six or eight legs.
        Walker = "walker",
        /// Robot arms on a base, with hands.
        Arms = "arms",
        /// One hand.
        Hand = "hand",
        /// Limbs anywhere on limbs that are there.
        Tree = "tree",
    }
}

impl Family {
    /// Draws a body of it, of limbs about so long, metres.
    pub fn body(self, mut draw: Draw, scale: f64) -> Tree {
        match self {
            Family::Chain => chain(trunk(draw, scale, [(0.2, 0.4), (0.2, 0.4), (0.2, 0.4)])),
            Family::Snake => snake(Tree::new(draw, scale, [0.25, 0.25, 0.5])),
            Family::Star => {
                let half = draw.between(0.25, 0.6);
                star(Tree::new(draw, scale, [half; 3]))
            }
            Family::Humanoid => humanoid(trunk(draw, scale, [(0.4, 0.55), (0.2, 0.3), (0.2, 0.4)])),
            Family::Walker => walker(trunk(draw, scale, [(0.3, 0.5), (0.7, 1.2), (0.15, 0.3)])),
            Family::Arms => arms(trunk(draw, scale, [(0.3, 0.8), (0.3, 0.6), (0.15, 0.4)])),
            Family::Hand => hand(trunk(draw, scale, [(0.15, 0.3), (0.15, 0.3), (0.2, 0.4)])),
            Family::Tree => random_tree(trunk(draw, scale, [(0.2, 0.5), (0.2, 0.5), (0.2, 0.5)])),
        }
    }
}

/// A trunk alone, whose half extents lie between such shares of the scale.
fn trunk(mut draw: Draw, scale: f64, half_between: [(f64, f64); 3]) -> Tree {
    let half = half_between.map(|(least, most)| draw.between(least, most));
    Tree::new(draw, scale, half)
}

/// Limbs in a row, with lengths about some shares of the typical one; the last one's number.
fn row(tree: &mut Tree, name: &str, mut mount: Mount, shares: &[f64]) -> usize {
    for (k, &share) in shares.iter().enumerate() {
        let length = tree.length(share);
        let radius = tree.radius(length);
        let limb = tree.limb(format!("{name}_{}", k + 1), mount.sized(length, radius));
        mount = Mount::on(limb, tree.end_of(limb), Vector3::z(), mount.spread);
    }
    mount.parent
}

fn chain(mut tree: Tree) -> Tree {
    let shares = vec![1.0; tree.draw.count(3, 9)];
    let (at, spread) = (tree.on_trunk(&Vector3::z()), tree.draw.between(0.0, 0.7));
    row(&mut tree, "link", Mount::on(0, at, Vector3::z(), spread), &shares);
    tree
}

fn snake(mut tree: Tree) -> Tree {
    tree.style.width *= 0.7;
    tree.thickness = tree.draw.between(0.2, 0.35);
    let shares = vec![1.0; tree.draw.count(8, 16)];
    let (at, spread) = (tree.on_trunk(&Vector3::z()), tree.draw.between(0.0, 0.2));
    row(&mut tree, "segment", Mount::on(0, at, Vector3::z(), spread), &shares);
    tree
}

fn star(mut tree: Tree) -> Tree {
    let (count, segments) = (tree.draw.count(3, 8), tree.draw.count(2, 4));
    let flat = tree.draw.chance(0.4);
    let mut directions: Vec<Vector3<f64>> = Vec::new();
    for arm in 0..count {
        // Of several directions that which is farthest from all before it.
        let mut best = (f64::NEG_INFINITY, Vector3::x());
        for _ in 0..20 {
            let mut towards = tree.draw.direction();
            if flat {
                towards.z *= 0.1;
                towards.normalize_mut();
            }
            let nearest = directions.iter().map(|other| (other - towards).norm()).fold(2.0, f64::min);
            if nearest > best.0 {
                best = (nearest, towards);
            }
        }
        directions.push(best.1);
        let at = tree.on_trunk(&best.1);
        row(&mut tree, &format!("arm_{}", arm + 1), Mount::on(0, at, best.1, 0.15), &vec![1.0; segments]);
    }
    tree
}

fn humanoid(mut tree: Tree) -> Tree {
    let half = tree.trunk_half();
    let length = tree.length(0.9);
    let chest_radius = 0.4 * length;
    let mount = Mount::on(0, tree.on_trunk(&Vector3::z()), Vector3::z(), 0.05).sized(length, chest_radius);
    let joining =
        tree.draw.weighted(&[(Joining::Hinge, 0.3), (Joining::TwoHinges, 0.3), (Joining::ThreeHinges, 0.4)]);
    let chest = tree.joined_limb("chest".into(), mount, joining);
    let at = tree.end_of(chest) * 1.05;
    let length = tree.length(0.5);
    tree.limb("head".into(), Mount::on(chest, at, Vector3::z(), 0.1).sized(length, 0.35 * length));
    let hands = tree.draw.chance(0.5);
    let [shoulder, hip] = [0.85, 0.6].map(|share| share * tree.limbs[chest].length);
    // The chest may be turned about itself in its frame: arms go to both sides of it, whichever these are.
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let at = Vector3::new(sign * (chest_radius * 1.25), 0.0, shoulder);
        let mount = Mount::on(chest, at, Vector3::new(sign, 0.0, -0.7), 0.15);
        let lower = row(&mut tree, &format!("{side}_arm"), mount, &[1.0, 0.9]);
        hand_on(&mut tree, lower, side, hands);
    }
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let at = Vector3::new(sign * half.x.max(hip * 0.3) * 0.7, 0.0, -1.15 * half.z);
        let towards = Vector3::new(0.2 * sign, 0.0, -1.0);
        row(&mut tree, &format!("{side}_leg"), Mount::on(0, at, towards, 0.1), &[1.2, 1.1, 0.5]);
    }
    tree
}

/// A palm at the end of a limb, with fingers where it has such.
fn hand_on(tree: &mut Tree, limb: usize, side: &str, with_fingers: bool) {
    let (at, length) = (tree.end_of(limb) * 1.03, tree.length(0.4));
    let mount = Mount::on(limb, at, Vector3::z(), 0.0).sized(length, 0.0);
    let joining = tree.style.joining(&mut tree.draw);
    let (palm, size) = palm(tree, format!("{side}_hand"), mount, joining);
    if with_fingers {
        fingers(tree, palm, &format!("{side}_"), size);
    }
}

fn walker(mut tree: Tree) -> Tree {
    let half = tree.trunk_half();
    let pairs = tree.draw.count(2, 4);
    let rise = tree.draw.between(-0.6, 0.3);
    let segments = tree.draw.count(2, 3);
    for pair in 0..pairs {
        let y = half.y * (1.6 * (pair as f64 + 0.5) / pairs as f64 - 0.8);
        for (side, sign) in [("left", 1.0), ("right", -1.0)] {
            let at = Vector3::new(sign * 1.15 * half.x, y, 0.0);
            let towards = Vector3::new(sign, 0.6 * y / half.y, rise);
            let shares = &[0.5, 1.0, 1.2][3 - segments..];
            row(&mut tree, &format!("{side}_leg_{}", pair + 1), Mount::on(0, at, towards, 0.12), shares);
        }
    }
    tree
}

fn arms(mut tree: Tree) -> Tree {
    let half = tree.trunk_half();
    let (count, joints) = (tree.draw.count(1, 3), tree.draw.count(3, 6));
    let hands = tree.draw.chance(0.6);
    for arm in 0..count {
        let x = half.x * (1.6 * (arm as f64 + 0.5) / count as f64 - 0.8);
        let at = Vector3::new(x, 0.0, 1.15 * half.z);
        let towards = Vector3::new(0.7 * x / half.x, 0.0, 1.0);
        let side = format!("arm_{}", arm + 1);
        let shares: Vec<f64> = (0..joints).map(|k| [0.5, 1.2, 1.0, 0.8, 0.5, 0.4][k]).collect();
        let last = row(&mut tree, &side, Mount::on(0, at, towards, 0.2), &shares);
        if hands {
            hand_on(&mut tree, last, &side, true);
        }
    }
    tree
}

fn hand(mut tree: Tree) -> Tree {
    let length = tree.length(1.0);
    let mount = Mount::on(0, tree.on_trunk(&Vector3::z()), Vector3::z(), 0.0).sized(length, 0.0);
    let joining =
        tree.draw.weighted(&[(Joining::TwoHinges, 0.6), (Joining::Hinge, 0.2), (Joining::ThreeHinges, 0.2)]);
    let (palm, size) = palm(&mut tree, "palm".into(), mount, joining);
    fingers(&mut tree, palm, "", size);
    tree
}

fn random_tree(mut tree: Tree) -> Tree {
    let count = tree.draw.count(4, 18);
    for limb in 1..=count {
        let parent = tree.draw.count(0, limb - 1);
        let (at, towards) = if parent == 0 {
            let towards = tree.draw.direction();
            (tree.on_trunk(&towards), towards)
        } else if tree.draw.chance(0.6) {
            (tree.end_of(parent), tree.draw.about(&Vector3::z(), 1.0))
        } else {
            // From its side.
            let across = tree.draw.twist() * Vector3::x();
            let reach = tree.limbs[parent].length * (tree.thickness * 1.5);
            (tree.end_of(parent) * tree.draw.between(0.4, 0.9) + across * reach, across + Vector3::z() * 0.5)
        };
        let share = tree.draw.log_between(0.5, 1.6);
        let length = tree.length(share);
        let radius = tree.radius(length);
        let mount = Mount::on(parent, at, towards.normalize(), 0.3).sized(length, radius);
        tree.limb(format!("limb_{limb}"), mount);
    }
    tree
}

/// Shares of a palm's length that the bones of a finger have, from the palm on.
const BONES: [f64; 3] = [0.55, 0.4, 0.3];

/// Adds fingers to a palm; their names begin with `side`.
fn fingers(tree: &mut Tree, palm: usize, side: &str, [width, thickness]: [f64; 2]) {
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
fn palm(tree: &mut Tree, name: String, mount: Mount, joining: Joining) -> (usize, [f64; 2]) {
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
