//! The joints between two places of the body, some of which move: where the places are, how they move, and damped steps
//! that bring them together.
//!
//! All that stays still is folded into a chain of offsets and axes, which are given in one frame at the zero of every
//! coordinate: `p = o_1 + R(a_1, θ_1) (o_2 + R(a_2, θ_2) (… + R(a_n, θ_n) p_n))`, a product of exponentials
//! (Brockett 1984), on either side of the two limbs' common ancestor. A step is damped least squares (Wampler 1986,
//! Nakamura and Hanafusa 1986) on the coordinates that move: each stays within its range, and one that is at its limit and
//! would leave it is held for that step.

use nalgebra::{Const, Matrix3, SMatrix, SVector, Vector3};

use super::chain::Chain;
use super::forward::DofTransform;
use crate::creature::{Coupling, Creature, DofKind, turn_ball};
use crate::geometry::Frame;
use crate::schema::BodySchema;

/// A place that is fixed to a limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The limb.
    pub limb: usize,
    /// The point in its frame, metres.
    pub point: Vector3<f64>,
    /// A unit direction in its frame; zero where there is none.
    pub direction: Vector3<f64>,
}

impl Place {
    /// The same as seen from what faces it: its direction reversed.
    pub fn reversed(self) -> Place {
        Place { direction: -self.direction, ..self }
    }
}

/// One degree of freedom of a chain.
#[derive(Clone, Debug)]
struct Link {
    side: usize,
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

/// The joints between two places.
#[derive(Clone, Debug)]
pub struct PlaceChain {
    /// From the common ancestor outwards, those to the first place before those to the second.
    links: Vec<Link>,
    /// Per side, from its last link to the frame of its limb.
    tails: [Frame; 2],
    ends: [Place; 2],
    /// The place of each of its coordinates in a posture of the whole body.
    coordinates: Vec<usize>,
}

/// What a step is worked out in; kept by the caller so that its buffers are used again.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    /// Per link, its axis in the frame and where it turns.
    placed: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Per ball, the axes about which it turns.
    balls: Vec<Matrix3<f64>>,
    columns: Vec<Column>,
    held: Vec<bool>,
    steps: Vec<f64>,
}

/// Damping and longest step of [`PlaceChain::seek`].
const SEEKING: Damping = Damping { damping: 0.005, longest: 0.5 };
/// The share of a box, from its middle, that is aimed at first; a point that comes to a stop aims at all of it.
const INNER: f64 = 0.5;
/// The share that is aimed at in the end: not all of it, so that the point comes to lie inside.
const OUTER: f64 = 0.99;
/// A step that leaves more than this share of the way has come to a stop.
const STOPPED: f64 = 0.9;
/// The share of the way to the rest posture that is left free and gone in one step.
const EASE: f64 = 0.2;

/// How the first place moves against the second with one coordinate, or a ball's turn about one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    link: usize,
    part: usize,
    pub side: usize,
    pub moves: Vector3<f64>,
    /// How the side's limb turns, by its own sign.
    pub turns: Vector3<f64>,
}

/// How far a step may go.
#[derive(Clone, Copy, Debug)]
pub struct Damping {
    /// Metres per radian.
    pub damping: f64,
    /// The longest step of one coordinate, radians or metres.
    pub longest: f64,
}

impl PlaceChain {
    /// The chain between two places, given in a frame that stays still in the common ancestor's at `X_CF`: the joints for
    /// which `moves` says yes move, all others stay as they are in `posture`.
    pub fn new(
        creature: &Creature,
        schema: &BodySchema,
        ends: [Place; 2],
        frame: &Frame,
        posture: &[f64],
        moves: impl Fn(usize) -> bool,
    ) -> PlaceChain {
        let joints = Chain::between(creature, ends[0].limb, ends[1].limb).sides;
        let (mut links, mut coordinates, mut leaders): (Vec<Link>, _, _) =
            (Vec::new(), Vec::new(), Vec::new());
        let leads = |dof: usize| {
            let mut moving = joints.iter().flatten().filter(|&&j| moves(j));
            moving.any(|&j| creature.joints()[j].dof_indices().contains(&dof))
        };
        let mut tails = [frame.inverse(); 2];
        for (side, tail) in tails.iter_mut().enumerate() {
            // From the frame, or the last link: what stays still is carried along.
            for &j in &joints[side] {
                let joint = &creature.joints()[j];
                tail.origin += tail.direction(&schema.positions[j]);
                for element in joint.elements() {
                    let (dof, index) = (&*element, element.axis());
                    let axis = &schema.axes[index];
                    let leader = dof.follows.map(|coupling| coupling.leader);
                    if moves(j) && dof.range[1] > dof.range[0] && leader.is_none_or(leads) {
                        let at = coordinates.len();
                        coordinates.extend(element.coordinates());
                        leaders.push((index, at));
                        links.push(Link {
                            side,
                            kind: dof.kind,
                            at,
                            axis: tail.direction(axis),
                            turned: if dof.kind == DofKind::Ball {
                                tail.rotation
                            } else {
                                Matrix3::identity()
                            },
                            range: dof.range,
                            follows: dof.follows.map(|coupling| (coupling.leader, coupling)),
                            offset: std::mem::take(&mut tail.origin),
                        });
                    } else {
                        DofTransform::at(dof.kind, element.of(posture)).carry(axis, tail);
                    }
                }
                if let Some(pose) = schema.limb_poses.get(j) {
                    *tail = *tail * *pose;
                }
            }
        }
        // A leader may come after what follows it.
        for link in &mut links {
            link.follows = link.follows.and_then(|(leader, coupling)| {
                leaders.iter().find(|(dof, _)| *dof == leader).map(|(_, at)| (*at, coupling))
            });
        }
        PlaceChain { links, tails, ends, coordinates }
    }

    /// The number of its coordinates.
    pub fn count(&self) -> usize {
        self.coordinates.len()
    }

    /// Its coordinates in a posture of the whole body.
    pub fn of_posture(&self, posture: &[f64]) -> Vec<f64> {
        self.coordinates.iter().map(|&q| posture[q]).collect()
    }

    /// Puts its coordinates into a posture of the whole body.
    pub fn put_into(&self, coordinates: impl IntoIterator<Item = f64>, posture: &mut [f64]) {
        self.coordinates.iter().zip(coordinates).for_each(|(&q, value)| posture[q] = value);
    }

    /// Where the first side begins, and how far from there its place can be, metres: a bound.
    pub fn reach(&self) -> (Vector3<f64>, f64) {
        let tip = self.tails[0].point(&self.ends[0].point);
        let links = || self.links.iter().filter(|link| link.side == 0);
        let Some(first) = links().next() else { return (tip, 0.0) };
        let offsets = links().skip(1).map(|link| link.offset.norm());
        let slides = links().filter(|link| link.kind == DofKind::Slide);
        let shifts = slides.map(|link| link.range[0].abs().max(link.range[1].abs()));
        (first.offset, tip.norm() + offsets.sum::<f64>() + shifts.sum::<f64>())
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
                let share = if wide { 0.5 - 0.5 * (std::f64::consts::PI * share).cos() } else { share };
                q[link.at] = low + (high - low) * share;
            }
        }
        self.settle(q);
    }

    /// The limbs of both places.
    pub(super) fn place(&self, q: &[f64], workspace: &mut Workspace) -> [Frame; 2] {
        let Workspace { placed, balls, .. } = workspace;
        placed.clear();
        balls.clear();
        let mut frames = [Frame::identity(); 2];
        for link in &self.links {
            let frame = &mut frames[link.side];
            frame.origin += frame.direction(&link.offset);
            placed.push((frame.direction(&link.axis), frame.origin));
            match DofTransform::at(link.kind, &q[link.at..]) {
                DofTransform::Ball { rotation } => {
                    balls.push(frame.rotation * link.turned);
                    frame.rotation *= link.turned * rotation * link.turned.transpose();
                }
                transform => transform.carry(&link.axis, frame),
            }
        }
        [frames[0] * self.tails[0], frames[1] * self.tails[1]]
    }

    /// Where the first place is.
    pub fn point(&self, q: &[f64], workspace: &mut Workspace) -> Vector3<f64> {
        self.place(q, workspace)[0].point(&self.ends[0].point)
    }

    /// How the places, at some points, move with each coordinate, from where [`PlaceChain::place`] found them.
    pub(super) fn differentiate(&self, q: &[f64], points: &[Vector3<f64>; 2], workspace: &mut Workspace) {
        let Workspace { placed, balls, columns, .. } = workspace;
        columns.clear();
        let mut balls = balls.iter();
        for (k, (link, (axis, origin))) in self.links.iter().zip(placed.iter()).enumerate() {
            let sign = if link.side == 0 { 1.0 } else { -1.0 };
            let turning = |part: usize, axis: Vector3<f64>| Column {
                link: k,
                part,
                side: link.side,
                moves: axis.cross(&(points[link.side] - origin)) * sign,
                turns: axis * sign,
            };
            match link.kind {
                DofKind::Hinge => columns.push(turning(0, *axis)),
                DofKind::Slide => {
                    let moves = axis * sign;
                    columns.push(Column { moves, turns: Vector3::zeros(), ..turning(0, *axis) });
                }
                DofKind::Ball => {
                    let axes = balls.next().copied().unwrap_or_else(Matrix3::identity);
                    columns.extend([0, 1, 2].map(|part| turning(part, axes.column(part).into_owned())));
                }
            }
        }
        // What follows moves the places on behalf of its leader.
        for c in 0..columns.len() {
            let Some((leader, coupling)) = &self.links[columns[c].link].follows else { continue };
            let rate = coupling.rate(q[*leader]);
            let Column { moves, turns, .. } = columns[c];
            (columns[c].moves, columns[c].turns) = (Vector3::zeros(), Vector3::zeros());
            if let Some(led) = columns.iter_mut().find(|led| self.links[led.link].at == *leader) {
                led.moves += moves * rate;
                led.turns += turns * rate;
            }
        }
    }

    /// One damped step within the ranges by which `rows`, one column for each of [`PlaceChain::differentiate`], go as
    /// `wanted`; what freedom is left goes a share of the way to those of the rest posture.
    pub(super) fn step<const N: usize>(
        &self,
        q: &mut [f64],
        rows: impl Fn(&Column) -> SVector<f64, N>,
        wanted: &SVector<f64, N>,
        at_ease: Option<&[f64]>,
        damping: Damping,
        workspace: &mut Workspace,
    ) {
        let Workspace { columns, held, steps, .. } = workspace;
        held.clear();
        held.resize(columns.len(), false);
        steps.clear();
        steps.resize(columns.len(), 0.0);
        let eased = |column: &Column| {
            let link = &self.links[column.link];
            match at_ease {
                Some(at_ease) if link.kind != DofKind::Ball && link.follows.is_none() => {
                    EASE * (at_ease[link.at] - q[link.at])
                }
                _ => 0.0,
            }
        };
        // Three rounds are enough for coordinates at their limits to be found.
        for _ in 0..3 {
            let mut normal = SMatrix::<f64, N, N>::identity() * (damping.damping * damping.damping);
            let mut rest = *wanted;
            for (column, _) in columns.iter().zip(held.iter()).filter(|(_, held)| !**held) {
                let row = rows(column);
                normal.ger(1.0, &row, &row, 1.0);
                if at_ease.is_some() {
                    rest -= row * eased(column);
                }
            }
            let Some(factor) = nalgebra::Cholesky::<f64, Const<N>>::new(normal) else { return };
            let dual = factor.solve(&rest);
            let mut stopped = false;
            for (c, column) in columns.iter().enumerate() {
                if held[c] {
                    continue;
                }
                let link = &self.links[column.link];
                steps[c] = eased(column) + rows(column).dot(&dual);
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
        let scale = if longest > damping.longest { damping.longest / longest } else { 1.0 };
        let mut turn = Vector3::zeros();
        for (column, step) in columns.iter().zip(steps.iter()) {
            let link = &self.links[column.link];
            if link.kind == DofKind::Ball {
                turn[column.part] = step * scale;
                if column.part == 2 {
                    turn_ball(&mut q[link.at..], &turn, link.range[1]);
                }
            } else {
                q[link.at] += step * scale;
            }
        }
        self.settle(q);
    }

    /// Brings the first place into a box about `middle`, `half` metres to each side, in so many steps at the most, from the
    /// coordinates given. Returns how far it stays outside, metres: 0 where it is inside.
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
            self.differentiate(q, &[point; 2], workspace);
            self.step(q, |column| column.moves, &aim(share), None, SEEKING, workspace);
        }
        f64::INFINITY
    }
}
