//! A point of the body on its way through space: fast kinematics of one point, and postures that bring it into a box.
//!
//! All that stays still is folded into a chain of offsets and axes, which are told in one frame at the zero of every
//! coordinate: `p = o_1 + R(a_1, θ_1) (o_2 + R(a_2, θ_2) (… + R(a_n, θ_n) p_n))`, a product of exponentials
//! (Brockett 1984). Only the point matters here, no direction, so a step solves for three rows: damped least squares
//! (Wampler 1986) within the ranges, as in [`InverseKinematics`](crate::kinematics::InverseKinematics), which brings
//! places of any two limbs together, and directions too.

use nalgebra::{Matrix3, Vector3};

use super::own_body::OwnBody;
use crate::creature::{Coupling, DofKind, turn_ball};
use crate::geometry::Frame;
use crate::kinematics::{DofTransform, Place};

/// Damping, metres per radian.
const DAMPING: f64 = 0.005;
/// The longest step of one coordinate, radians or metres.
const LONGEST_STEP: f64 = 0.5;
/// The share of a box, from its middle, that is aimed at first; a point that comes to a stop aims at all of it.
const INNER: f64 = 0.5;
/// The share that is aimed at in the end: not all of it, so that the point comes to lie inside.
const OUTER: f64 = 0.99;
/// A step that leaves more than this share of the way has come to a stop.
const STOPPED: f64 = 0.9;

/// One degree of freedom of a chain.
#[derive(Clone, Debug)]
struct TipLink {
    kind: DofKind,
    /// Its first coordinate among those of the chain.
    at: usize,
    /// From the link before, metres.
    offset: Vector3<f64>,
    axis: Vector3<f64>,
    /// From the axes of a ball's coordinates to those of the frame; identity elsewhere.
    turned: Matrix3<f64>,
    range: [f64; 2],
    /// The chain's coordinate that it follows, and how.
    follows: Option<(usize, Coupling)>,
}

/// The joints that carry a point from the root, some of which move.
#[derive(Clone, Debug)]
pub struct TipChain {
    links: Vec<TipLink>,
    /// From the last link, metres.
    tip: Vector3<f64>,
    /// The place of each of its coordinates in a posture of the whole body.
    coordinates: Vec<usize>,
    /// How far from its beginning the point can be, metres.
    length: f64,
}

/// What a solution is worked out in; kept by the caller so that its buffers are used again.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    /// Per link, its axis in the frame and where it turns.
    placed: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Per ball, the axes about which it turns.
    turned: Vec<Matrix3<f64>>,
    /// TipLink, which axis of a ball, and how the point moves with it.
    columns: Vec<(usize, usize, Vector3<f64>)>,
    held: Vec<bool>,
    steps: Vec<f64>,
}

impl TipChain {
    /// The chain to a place, told in a frame `X_RF` that stays still in the root's frame: the joints for which `moves`
    /// says yes move, all others stay as they are in `posture`.
    pub fn new(
        own: &OwnBody,
        place: &Place,
        frame: &Frame,
        posture: &[f64],
        moves: impl Fn(usize) -> bool,
    ) -> TipChain {
        let (creature, schema) = (own.creature(), &own.schema);
        // From the frame, or the last link: what stays still is carried along.
        let mut still = frame.inverse();
        let (mut links, mut coordinates, mut leaders): (Vec<TipLink>, _, _) =
            (Vec::new(), Vec::new(), Vec::new());
        let joints = own.joints_to(place.limb);
        let leads = |dof: usize| {
            joints.iter().any(|&j| moves(j) && creature.joints()[j].dof_indices().contains(&dof))
        };
        for &j in &joints {
            let joint = &creature.joints()[j];
            still.origin += still.direction(&schema.positions[j]);
            for element in joint.elements() {
                let (dof, index) = (element.dof(), element.axis());
                let axis = &schema.axes[index];
                let leader = dof.follows.map(|coupling| coupling.leader);
                if moves(j) && dof.range[1] > dof.range[0] && leader.is_none_or(leads) {
                    let at = coordinates.len();
                    coordinates.extend(element.coordinates());
                    leaders.push((index, at));
                    let turned = if dof.kind == DofKind::Ball { still.rotation } else { Matrix3::identity() };
                    let follows = dof.follows.map(|coupling| (coupling.leader, coupling));
                    let (kind, range, axis) = (dof.kind, dof.range, still.direction(axis));
                    let offset = std::mem::replace(&mut still.origin, Vector3::zeros());
                    links.push(TipLink { kind, at, offset, axis, turned, range, follows });
                } else {
                    DofTransform::at(dof.kind, element.of(posture)).carry(axis, &mut still);
                }
            }
            if let Some(pose) = schema.limb_poses.get(j) {
                still = still * *pose;
            }
        }
        // A leader may come after what follows it.
        for link in &mut links {
            link.follows = link.follows.and_then(|(leader, coupling)| {
                leaders.iter().find(|(dof, _)| *dof == leader).map(|(_, at)| (*at, coupling))
            });
        }
        let tip = still.point(&place.point);
        let tail = if links.is_empty() { 0.0 } else { tip.norm() };
        let offsets = links.iter().skip(1).map(|link| link.offset.norm());
        let slides = links.iter().filter(|link| link.kind == DofKind::Slide);
        let shifts = slides.map(|link| link.range[0].abs().max(link.range[1].abs()));
        let length = tail + offsets.sum::<f64>() + shifts.sum::<f64>();
        TipChain { links, tip, coordinates, length }
    }

    /// How many numbers its coordinates are.
    pub fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Its coordinates in a posture of the whole body.
    pub fn of_posture(&self, posture: &[f64]) -> Vec<f64> {
        self.coordinates.iter().map(|&q| posture[q]).collect()
    }

    /// Puts its coordinates into a posture of the whole body.
    pub fn put_into(&self, coordinates: impl IntoIterator<Item = f64>, posture: &mut [f64]) {
        self.coordinates.iter().zip(coordinates).for_each(|(&q, value)| posture[q] = value);
    }

    /// Where it begins, and how far from there the point can be, metres.
    pub fn reach(&self) -> (Vector3<f64>, f64) {
        (self.links.first().map_or(self.tip, |link| link.offset), self.length)
    }

    /// Puts every coordinate where what it follows has it, and within its range.
    fn settle(&self, q: &mut [f64]) {
        for link in self.links.iter().filter(|link| link.kind != DofKind::Ball) {
            if let Some((leader, coupling)) = &link.follows {
                q[link.at] = coupling.follow(q[*leader]);
            } else {
                q[link.at] = q[link.at].clamp(link.range[0], link.range[1]);
            }
        }
    }

    /// Draws coordinates by numbers between 0 and 1, one for each and two more for a ball; `wide` favours the ends of
    /// the ranges.
    pub fn draw(&self, q: &mut [f64], wide: bool, mut number: impl FnMut() -> f64) {
        for link in &self.links {
            let [low, high] = link.range;
            if link.kind == DofKind::Ball {
                let (z, turn) = (2.0 * number() - 1.0, std::f64::consts::TAU * number());
                let ring = (1.0 - z * z).max(0.0).sqrt();
                let angle = if wide { number().sqrt() } else { number() } * high;
                q[link.at..link.at + 4].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
                let axis = Vector3::new(ring * turn.cos(), ring * turn.sin(), z);
                turn_ball(&mut q[link.at..], &(axis * angle), high);
            } else {
                let share = number();
                // More of the numbers go to the ends of the range where those are favoured.
                let share = if wide { 0.5 - 0.5 * (std::f64::consts::PI * share).cos() } else { share };
                q[link.at] = low + (high - low) * share;
            }
        }
        self.settle(q);
    }

    /// Where the point is.
    pub fn point(&self, q: &[f64], workspace: &mut Workspace) -> Vector3<f64> {
        let Workspace { placed, turned: balls, .. } = workspace;
        placed.clear();
        balls.clear();
        let mut frame = Frame::identity();
        for link in &self.links {
            frame.origin += frame.direction(&link.offset);
            placed.push((frame.direction(&link.axis), frame.origin));
            match DofTransform::at(link.kind, &q[link.at..]) {
                DofTransform::Ball { rotation } => {
                    balls.push(frame.rotation * link.turned);
                    frame.rotation *= link.turned * rotation * link.turned.transpose();
                }
                transform => transform.carry(&link.axis, &mut frame),
            }
        }
        frame.point(&self.tip)
    }

    /// The way into a box about `middle`, `half` metres to each side: to the middle half of it.
    pub(super) fn way_into(point: &Vector3<f64>, middle: &Vector3<f64>, half: f64) -> Vector3<f64> {
        let offset = point - middle;
        offset.map(|x| x.clamp(-INNER * half, INNER * half)) - offset
    }

    /// Brings the point into a box about `middle`, `half` metres to each side, in so many steps at the most, from the
    /// coordinates given. Tells how far it stays outside, metres: 0 where it is inside.
    pub fn seek(
        &self,
        q: &mut [f64],
        middle: &Vector3<f64>,
        half: f64,
        steps: usize,
        workspace: &mut Workspace,
    ) -> f64 {
        let (mut share, mut left) = (INNER, f64::INFINITY);
        for step in 0.. {
            let point = self.point(q, workspace);
            let offset = point - middle;
            let outside = (offset - offset.map(|x| x.clamp(-half, half))).norm();
            if outside == 0.0 || step == steps {
                return outside;
            }
            let aim = |share: f64| offset.map(|x| x.clamp(-share * half, share * half)) - offset;
            let way = aim(share);
            if way.norm() > STOPPED * left {
                if share == OUTER {
                    return outside;
                }
                (share, left) = (OUTER, f64::INFINITY);
            } else {
                left = way.norm();
            }
            self.differentiate(q, &point, workspace);
            self.step(q, &aim(share), workspace);
        }
        f64::INFINITY
    }

    /// How the point moves with each coordinate, from where [`TipChain::point`] found it.
    pub(super) fn differentiate(&self, q: &[f64], point: &Vector3<f64>, workspace: &mut Workspace) {
        let Workspace { placed, turned, columns, .. } = workspace;
        columns.clear();
        let mut balls = turned.iter();
        for (k, (link, (axis, origin))) in self.links.iter().zip(placed.iter()).enumerate() {
            match link.kind {
                DofKind::Hinge => columns.push((k, 0, axis.cross(&(point - origin)))),
                DofKind::Slide => columns.push((k, 0, *axis)),
                DofKind::Ball => {
                    let axes = balls.next().copied().unwrap_or_else(Matrix3::identity);
                    let column = |i: usize| (k, i, axes.column(i).cross(&(point - origin)));
                    columns.extend([0, 1, 2].map(column));
                }
            }
        }
        // What follows moves the point on behalf of its leader.
        for c in 0..columns.len() {
            let Some((leader, coupling)) = &self.links[columns[c].0].follows else { continue };
            let [less, more] = [-1e-6, 1e-6].map(|h| coupling.follow(q[*leader] + h));
            let moved = columns[c].2 * ((more - less) / 2e-6);
            columns[c].2 = Vector3::zeros();
            if let Some(led) = columns.iter_mut().find(|(k, ..)| self.links[*k].at == *leader) {
                led.2 += moved;
            }
        }
    }

    /// One damped step of the point by `way`, within the ranges, by what [`TipChain::differentiate`] found. Tells by
    /// what way the point goes to first order, and how far off that is at the most, metres.
    pub(super) fn step(
        &self,
        q: &mut [f64],
        way: &Vector3<f64>,
        workspace: &mut Workspace,
    ) -> (Vector3<f64>, f64) {
        let Workspace { columns, held, steps, .. } = workspace;
        held.clear();
        held.resize(columns.len(), false);
        steps.clear();
        steps.resize(columns.len(), 0.0);
        // Three rounds are enough for coordinates at their limits to be found out.
        for _ in 0..3 {
            let mut normal = Normal::default();
            let free = columns.iter().zip(held.iter()).filter(|(_, held)| !**held);
            free.for_each(|((.., column), _)| normal.add(column));
            let dual = normal.solve(way);
            let mut stopped = false;
            for (c, (k, _, column)) in columns.iter().enumerate() {
                if held[c] {
                    continue;
                }
                let link = &self.links[*k];
                steps[c] = column.dot(&dual);
                let [low, high] = link.range;
                let at = q[link.at];
                let stuck = (at <= low && steps[c] < 0.0) || (at >= high && steps[c] > 0.0);
                if link.kind != DofKind::Ball && stuck {
                    (held[c], stopped, steps[c]) = (true, true, 0.0);
                }
            }
            if !stopped {
                break;
            }
        }
        let longest = steps.iter().fold(0.0f64, |most, step| most.max(step.abs()));
        let scale = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        let (mut ball_turn, mut gone) = (Vector3::zeros(), Vector3::zeros());
        let (mut turns, mut shifts) = (0.0, 0.0);
        for ((k, i, column), step) in columns.iter().zip(steps.iter()) {
            let link = &self.links[*k];
            let mut by = step * scale;
            if link.kind == DofKind::Ball {
                ball_turn[*i] = by;
                if *i == 2 {
                    turn_ball(&mut q[link.at..], &ball_turn, link.range[1]);
                }
            } else {
                let to = (q[link.at] + by).clamp(link.range[0], link.range[1]);
                by = to - q[link.at];
                q[link.at] = to;
            }
            gone += column * by;
            *(if link.kind == DofKind::Slide { &mut shifts } else { &mut turns }) += by.abs();
        }
        self.settle(q);
        // Taylor's remainder: no second derivative by two angles is longer than the whole chain, none by an angle and a
        // shift longer than 1. What follows others, or a ball that came to its end, goes another way.
        let plain = self.links.iter().all(|link| link.follows.is_none() && link.kind != DofKind::Ball);
        let off = 0.5 * self.length * turns * turns + turns * shifts;
        (gone, if plain { off } else { f64::INFINITY })
    }
}

/// `J Jᵀ + λ² I` of three rows.
struct Normal([f64; 6]);

impl Default for Normal {
    fn default() -> Normal {
        let square = DAMPING * DAMPING;
        Normal([square, 0.0, 0.0, square, 0.0, square])
    }
}

impl Normal {
    #[inline]
    fn add(&mut self, c: &Vector3<f64>) {
        let more = [c.x * c.x, c.x * c.y, c.x * c.z, c.y * c.y, c.y * c.z, c.z * c.z];
        self.0.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
    }

    /// By Cramer's rule: the damping keeps the determinant from 0.
    #[inline]
    fn solve(&self, b: &Vector3<f64>) -> Vector3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        let rows = [Vector3::new(xx, xy, xz), Vector3::new(xy, yy, yz), Vector3::new(xz, yz, zz)];
        let inverse = [rows[1].cross(&rows[2]), rows[2].cross(&rows[0]), rows[0].cross(&rows[1])];
        let determinant = rows[0].dot(&inverse[0]);
        (inverse[0] * b.x + inverse[1] * b.y + inverse[2] * b.z) / determinant
    }
}
