//! How far the body's surfaces are from each other and from what is known to be there, by the schema.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::own_body::OwnBody;
use crate::kinematics::{Chain, Frame, closest_points};
use crate::skin::{Shape, Surface, separation};

/// Pieces that were in each other by more than this in a posture that was lived through do not feel each other, metres.
const PASSING: f64 = 2e-3;
/// How much nearer than in a harmless pose things may come, metres: rounding on the way.
const EASED: f64 = 1e-4;

/// Something that is known to be there, in the root's frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// All that is within a radius of a segment, or of a point where both ends are one; metres.
    Capsule {
        /// The ends of the segment.
        ends: [Vector3<f64>; 2],
        /// The radius.
        radius: f64,
    },
    /// All that lies below a plane and in front of another, as a table does.
    Table {
        /// Unit vector against gravity.
        up: Vector3<f64>,
        /// The height of the top, along `up`, metres.
        height: f64,
        /// Horizontal unit vector that leads over the table.
        front: Vector3<f64>,
        /// Where the table begins, along `front`, metres.
        edge: f64,
    },
}

/// A convex piece of a limb.
#[derive(Clone, Debug)]
enum Solid {
    /// A sphere or capsule: a segment in the limb's frame, and a radius.
    Swept([Vector3<f64>; 2], f64),
    Other(Surface),
}

#[derive(Clone, Debug)]
struct Part {
    solid: Solid,
    middle: Vector3<f64>,
    /// No point of it is farther from its middle, metres.
    radius: f64,
}

/// Two limbs that feel each other.
#[derive(Clone, Debug)]
struct Pair {
    limbs: [usize; 2],
    /// The pieces of one and the other that do.
    parts: Vec<[usize; 2]>,
    /// No greater margin is asked of them, metres.
    eased: f64,
}

/// The surfaces of a body, and what is known to be about it.
#[derive(Clone, Debug)]
pub struct Clearance {
    parts: Vec<Vec<Part>>,
    /// Per limb, a ball about its parts; none where it has none.
    bounds: Vec<Option<(Vector3<f64>, f64)>>,
    pairs: Vec<Pair>,
    /// Per limb, whether obstacles matter to it.
    exposed: Vec<bool>,
    /// Per obstacle and limb, the greatest margin that is asked of them, metres; none where there is no limit.
    eased: Vec<Vec<f64>>,
    /// What is known to be there.
    pub obstacles: Vec<Obstacle>,
}

impl Clearance {
    /// The surfaces of a body with nothing about it. Limbs that carry each other, and pieces that overlap at ease or
    /// that overlapped in a posture that was lived through, are taken not to feel each other.
    pub fn new(own: &OwnBody) -> Clearance {
        let mut parts: Vec<Vec<Part>> = vec![Vec::new(); own.creature.limbs().len()];
        for surface in own.skin.surfaces.iter().filter(|surface| surface.shape != Shape::Mesh) {
            let bounds = surface.shape.half_bounds();
            let swept = |radius: f64, half_length: f64| {
                let along: Vector3<f64> = surface.rotation.column(2) * half_length;
                let ends = [surface.origin - along, surface.origin + along];
                (Solid::Swept(ends, radius), half_length + radius)
            };
            let (solid, radius) = match surface.shape {
                Shape::Sphere { radius } => swept(radius, 0.0),
                Shape::Capsule { radius, half_length } => swept(radius, half_length),
                _ => (Solid::Other(surface.clone()), bounds.norm()),
            };
            parts[surface.limb].push(Part { solid, middle: surface.origin, radius });
        }
        let bound = |parts: &Vec<Part>| {
            let middle = parts.iter().map(|part| part.middle).sum::<Vector3<f64>>() / parts.len() as f64;
            let reach = parts.iter().map(|part| (part.middle - middle).norm() + part.radius);
            (!parts.is_empty()).then(|| (middle, reach.fold(0.0, f64::max)))
        };
        let bounds: Vec<_> = parts.iter().map(bound).collect();
        let limbs = own.creature.limbs().len();
        let all = (0..limbs).flat_map(|a| (a + 1..limbs).map(move |b| [a, b]));
        let pairs = all.filter(|&[a, b]| !own.creature.neighbouring(a, b)).map(|limbs| {
            let [a, b] = limbs.map(|limb| parts[limb].len());
            let parts = (0..a).flat_map(|i| (0..b).map(move |j| [i, j])).collect();
            Pair { limbs, parts, eased: f64::INFINITY }
        });
        let mut pairs: Vec<Pair> = pairs.collect();
        let at_ease = own.at_ease();
        for posture in own.experienced.iter().chain([&at_ease]) {
            let frames = own.frames(posture);
            for Pair { limbs: [a, b], parts: felt, .. } in &mut pairs {
                if ball_gap(&bounds, &frames, [*a, *b]) < -PASSING {
                    felt.retain(|&[i, j]| {
                        gap(&parts[*a][i], &frames[*a], &parts[*b][j], &frames[*b]) >= -PASSING
                    });
                }
            }
        }
        pairs.retain(|pair| !pair.parts.is_empty());
        // The root stays where it is, whatever is there.
        let exposed = (0..limbs).map(|limb| limb > 0).collect();
        Clearance { bounds, pairs, parts, exposed, eased: Vec::new(), obstacles: Vec::new() }
    }

    /// The same for motions of some joints alone: what they cannot change is left out.
    pub fn moved_by(&self, own: &OwnBody, joints: &[usize]) -> Clearance {
        let mut moved = self.clone();
        moved.pairs.retain(|pair| {
            let [a, b] = pair.limbs;
            Chain::between(&own.creature, a, b).joints().any(|joint| joints.contains(&joint))
        });
        moved.exposed.iter_mut().zip(own.moved_by(joints)).for_each(|(exposed, carried)| *exposed &= carried);
        moved
    }

    /// The same without the obstacles that a point is on, within `near` metres, and those.
    pub fn but_at(&self, point: &Vector3<f64>, near: f64) -> (Clearance, Vec<Obstacle>) {
        let mut others = self.clone();
        others.eased.clear();
        let (at, obstacles) = others.obstacles.into_iter().partition(|obstacle| match obstacle {
            Obstacle::Capsule { ends, radius } => {
                let [p, q] = closest_points(&[*point, *point], ends);
                (p - q).norm() - radius <= near
            }
            Obstacle::Table { up, height, front, edge } => {
                point.dot(front) >= *edge && point.dot(up) - height <= near
            }
        });
        others.obstacles = obstacles;
        (others, at)
    }

    /// The same where a limb may be met by some others.
    pub fn but_between(&self, limb: usize, others: &BTreeSet<usize>) -> Clearance {
        let mut rest = self.clone();
        rest.pairs.retain(|Pair { limbs: [a, b], .. }| {
            !(*a == limb && others.contains(b) || *b == limb && others.contains(a))
        });
        rest
    }

    /// The same where some poses are taken for harmless, by their limbs' frames: what is nearer there than `margin` need
    /// not be farther apart elsewhere.
    pub fn eased_at(&self, poses: &[Vec<Frame>], margin: f64) -> Clearance {
        let mut eased = self.clone();
        let limbs = self.parts.len();
        eased.eased = vec![vec![f64::INFINITY; limbs]; self.obstacles.len()];
        for frames in poses {
            for (pair, before) in eased.pairs.iter_mut().zip(&self.pairs) {
                let gap = self.between(frames, before, margin);
                if gap < margin {
                    pair.eased = pair.eased.min(gap - EASED);
                }
            }
            for (obstacle, eased) in self.obstacles.iter().zip(&mut eased.eased) {
                for limb in (0..limbs).filter(|&limb| self.exposed[limb]) {
                    let gap = self.to_obstacle(frames, limb, obstacle, margin);
                    if gap < margin {
                        eased[limb] = eased[limb].min(gap - EASED);
                    }
                }
            }
        }
        eased
    }

    /// The gap between two limbs that feel each other where it is below `below`, metres, negative where they overlap;
    /// more than that elsewhere. `frames` are the limbs' poses in the root's frame.
    fn between(&self, frames: &[Frame], pair: &Pair, below: f64) -> f64 {
        let [a, b] = pair.limbs;
        let bound = ball_gap(&self.bounds, frames, pair.limbs);
        if bound > below {
            return bound;
        }
        let mut least = f64::INFINITY;
        for &[i, j] in &pair.parts {
            let (p, q) = (&self.parts[a][i], &self.parts[b][j]);
            let apart = (frames[a].point(&p.middle) - frames[b].point(&q.middle)).norm();
            let bound = apart - p.radius - q.radius;
            least =
                least.min(if bound > below.min(least) { bound } else { gap(p, &frames[a], q, &frames[b]) });
        }
        least
    }

    /// The gap between a limb and an obstacle where it is below `below`, metres; more than that elsewhere.
    pub fn to_obstacle(&self, frames: &[Frame], limb: usize, obstacle: &Obstacle, below: f64) -> f64 {
        let gaps = self.parts[limb].iter().map(|part| match (&part.solid, obstacle) {
            (_, Obstacle::Capsule { ends, radius }) => {
                let middle = frames[limb].point(&part.middle);
                let [p, q] = closest_points(&[middle, middle], ends);
                let bound = (p - q).norm() - part.radius - radius;
                if bound > below {
                    return bound;
                }
                let solid = Solid::Swept(*ends, *radius);
                let obstacle = Part { solid, middle: 0.5 * (ends[0] + ends[1]), radius: 0.0 };
                gap(part, &frames[limb], &obstacle, &Frame::identity())
            }
            (Solid::Swept(ends, radius), Obstacle::Table { up, height, front, edge }) => {
                let ends = ends.map(|end| frames[limb].point(&end));
                over_table(&ends, *radius, up, front, *edge).map_or(f64::INFINITY, |low| low - height)
            }
            (Solid::Other(surface), Obstacle::Table { up, height, front, edge }) => {
                let farthest = |direction: &Vector3<f64>| {
                    let found = surface.support(&frames[limb].rotation.tr_mul(direction));
                    found.map(|p| frames[limb].point(&p))
                };
                let reaches = farthest(front).is_some_and(|p| p.dot(front) > *edge);
                match farthest(&-up) {
                    Some(lowest) if reaches => lowest.dot(up) - height,
                    _ => f64::INFINITY,
                }
            }
        });
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// The least gap anywhere, up to `below`, metres.
    pub fn least(&self, frames: &[Frame], below: f64) -> f64 {
        let own = self.pairs.iter().map(|pair| self.between(frames, pair, below));
        let limbs = (0..self.parts.len()).filter(|&limb| self.exposed[limb]);
        let others = limbs.flat_map(|limb| {
            self.obstacles.iter().map(move |obstacle| self.to_obstacle(frames, limb, obstacle, below))
        });
        own.chain(others).fold(below, f64::min)
    }

    /// Whether limbs that feel each other are at least `margin` apart, but for those `left_out`.
    fn parted(&self, frames: &[Frame], margin: f64, left_out: &dyn Fn([usize; 2]) -> bool) -> bool {
        self.pairs.iter().all(|pair| {
            let margin = margin.min(pair.eased);
            left_out(pair.limbs) || self.between(frames, pair, margin) >= margin
        })
    }

    /// Whether no limb is in another.
    pub fn untangled(&self, frames: &[Frame]) -> bool {
        self.parted(frames, 0.0, &|_| false)
    }

    /// Whether all gaps are at least `margin`.
    pub fn free(&self, frames: &[Frame], margin: f64) -> bool {
        self.free_but(frames, margin, &[])
    }

    /// The same, but for some pairs of limbs that are to meet.
    pub fn free_but(&self, frames: &[Frame], margin: f64, but: &[[usize; 2]]) -> bool {
        let left_out = |[a, b]: [usize; 2]| but.contains(&[a, b]) || but.contains(&[b, a]);
        self.parted(frames, margin, &left_out)
            && (0..self.parts.len()).filter(|&limb| self.exposed[limb]).all(|limb| {
                self.obstacles.iter().enumerate().all(|(k, obstacle)| {
                    let margin = margin.min(self.eased.get(k).map_or(f64::INFINITY, |eased| eased[limb]));
                    self.to_obstacle(frames, limb, obstacle, margin) >= margin
                })
            })
    }
}

/// The gap between the balls about two limbs, metres.
fn ball_gap(bounds: &[Option<(Vector3<f64>, f64)>], frames: &[Frame], [a, b]: [usize; 2]) -> f64 {
    match (&bounds[a], &bounds[b]) {
        (Some((p, p_radius)), Some((q, q_radius))) => {
            (frames[a].point(p) - frames[b].point(q)).norm() - p_radius - q_radius
        }
        _ => f64::INFINITY,
    }
}

/// The gap between two convex pieces, metres.
fn gap(a: &Part, frame_a: &Frame, b: &Part, frame_b: &Frame) -> f64 {
    if let (Solid::Swept(ends_a, radius_a), Solid::Swept(ends_b, radius_b)) = (&a.solid, &b.solid) {
        let [p, q] =
            closest_points(&ends_a.map(|end| frame_a.point(&end)), &ends_b.map(|end| frame_b.point(&end)));
        return (p - q).norm() - radius_a - radius_b;
    }
    let support = |part: &Part, frame: &Frame, d: &Vector3<f64>| match &part.solid {
        Solid::Swept(ends, radius) => {
            let [p, q] = ends.map(|end| frame.point(&end));
            let far = if p.dot(d) > q.dot(d) { p } else { q };
            far + d.try_normalize(f64::MIN_POSITIVE).unwrap_or_default() * *radius
        }
        Solid::Other(surface) => {
            let local = frame.rotation.tr_mul(d);
            frame.point(&surface.support(&local).unwrap_or(surface.origin))
        }
    };
    let guess = frame_a.point(&a.middle) - frame_b.point(&b.middle);
    let guess = guess.try_normalize(1e-9).unwrap_or(Vector3::x());
    separation(|d| support(a, frame_a, d) - support(b, frame_b, &-d), &guess).0
}

/// The lowest point, along `up`, of what is within a radius of a segment and may be beyond the edge of a table.
fn over_table(
    ends: &[Vector3<f64>; 2],
    radius: f64,
    up: &Vector3<f64>,
    front: &Vector3<f64>,
    edge: f64,
) -> Option<f64> {
    let beyond = ends.map(|end| end.dot(front) - (edge - radius));
    if beyond[0].max(beyond[1]) <= 0.0 {
        return None;
    }
    // The part of the segment that is over the table ends where it crosses the edge.
    let crossing = |from: usize, to: usize| {
        let share = beyond[from] / (beyond[from] - beyond[to]);
        ends[from] + (ends[to] - ends[from]) * share
    };
    let inside = [0, 1].map(|k| if beyond[k] >= 0.0 { ends[k] } else { crossing(1 - k, k) });
    Some(inside[0].dot(up).min(inside[1].dot(up)) - radius)
}
