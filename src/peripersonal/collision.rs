//! How far the body's surfaces are from each other and from what is known to be there, by the schema.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};

use super::obstacle::Obstacle;
use super::own_body::OwnBody;
use crate::creature::Creature;
use crate::geometry::{Ball, Capsule, ConvexBody, Frame, Gap, PlacedShape, Precision, Shape, gap};
use crate::kinematics::Chain;
use crate::skin::Surface;

/// Pieces that were in each other by more than this in a posture that was lived through do not feel each other, metres.
const PASSING: f64 = 2e-3;
/// How much nearer than in a harmless pose things may come, metres: rounding on the way.
const EASED: f64 = 1e-4;
/// Nearer than this to the nearest place of two capsules, metres, another one is the same.
const APART: f64 = 0.01;

/// A convex piece of a limb.
#[derive(Clone, Debug)]
struct LimbPiece {
    surface: Surface,
    /// No point of it is outside this ball in the limb's frame.
    ball: Ball,
}

/// Two limbs that feel each other.
#[derive(Clone, Debug)]
struct GuardedPair {
    limbs: [usize; 2],
    /// The pieces of one and the other that do.
    pieces: Vec<[usize; 2]>,
    /// No greater margin is asked of them, metres.
    eased: f64,
}

/// A limb that is near another one, or near something that is known to be there.
#[derive(Clone, Copy, Debug)]
pub struct Nearness {
    /// The limb.
    pub limb: usize,
    /// The other limb; none where it is an obstacle.
    pub other: Option<usize>,
    /// Where they are nearest, in the root's frame, the normal from the other to the limb.
    pub gap: Gap,
}

/// The surfaces of a body, and what is known to be about it.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    /// Per limb, what it is made of.
    pieces: Vec<Vec<LimbPiece>>,
    /// Per limb, a ball about its pieces; none where it has none.
    bounds: Vec<Option<Ball>>,
    pairs: Vec<GuardedPair>,
    /// Per limb, whether obstacles matter to it.
    exposed: Vec<bool>,
    /// Per obstacle and limb, the greatest margin that is asked of them, metres; none where there is no limit.
    eased: Vec<Vec<f64>>,
    /// What is known to be there.
    pub obstacles: Vec<Obstacle>,
}

/// A place at which two surfaces are near each other, or a surface and an obstacle.
#[derive(Clone, Copy, Debug)]
pub struct NearPieces {
    /// The limb that the first surface is of, and the other's; none for an obstacle.
    pub limbs: (usize, Option<usize>),
    /// The gap there, metres, negative where they overlap.
    pub distance: f64,
    /// How it grows with the first point, and shrinks with the second, in the root's frame.
    pub normal: Vector3<f64>,
    /// A point of each limb, of a capsule on its axis, in the root's frame, metres.
    pub points: [Vector3<f64>; 2],
    /// No greater margin is asked of them, metres.
    pub eased: f64,
}

impl CollisionChecker {
    /// The surfaces of a body with nothing about it. Limbs that carry each other, and pieces that overlap at ease or
    /// that overlapped in a posture that was lived through, are taken not to feel each other.
    pub fn new(own: &OwnBody) -> CollisionChecker {
        let mut pieces: Vec<Vec<LimbPiece>> = vec![Vec::new(); own.creature().limbs().len()];
        for surface in own.skin().surfaces.iter().filter(|surface| surface.shape.is_solid()) {
            let ball = Ball { centre: surface.origin, radius: surface.shape.bounding_radius() };
            pieces[surface.limb].push(LimbPiece { surface: surface.clone(), ball });
        }
        let bound =
            |pieces: &Vec<LimbPiece>| Ball::about(&pieces.iter().map(|piece| piece.ball).collect::<Vec<_>>());
        let bounds: Vec<_> = pieces.iter().map(bound).collect();
        let limbs = own.creature().limbs().len();
        let all = (0..limbs).flat_map(|a| (a + 1..limbs).map(move |b| [a, b]));
        let pairs = all.filter(|&[a, b]| !own.creature().neighbouring(a, b)).map(|limbs| {
            let [a, b] = limbs.map(|limb| pieces[limb].len());
            let pieces = (0..a).flat_map(|i| (0..b).map(move |j| [i, j])).collect();
            GuardedPair { limbs, pieces, eased: f64::INFINITY }
        });
        let mut pairs: Vec<GuardedPair> = pairs.collect();
        let at_ease = own.at_ease();
        for posture in own.experienced.iter().chain([&at_ease]) {
            let frames = own.frames(posture);
            for GuardedPair { limbs: [a, b], pieces: felt, .. } in &mut pairs {
                if ball_gap(&bounds, &frames, [*a, *b]) < -PASSING {
                    felt.retain(|&[i, j]| {
                        let (first, second) = (&pieces[*a][i], &pieces[*b][j]);
                        let (first, second) = (first.placed(&frames[*a]), second.placed(&frames[*b]));
                        gap(&first, &second, Precision::LowerBound).distance >= -PASSING
                    });
                }
            }
        }
        pairs.retain(|pair| !pair.pieces.is_empty());
        // The root stays where it is, whatever is there.
        let exposed = (0..limbs).map(|limb| limb > 0).collect();
        CollisionChecker { bounds, pairs, pieces, exposed, eased: Vec::new(), obstacles: Vec::new() }
    }

    /// The same for motions of some joints alone: what they cannot change is left out.
    pub fn moved_by(&self, own: &OwnBody, joints: &[usize]) -> CollisionChecker {
        let mut moved = self.clone();
        moved.pairs.retain(|pair| {
            let [a, b] = pair.limbs;
            Chain::between(own.creature(), a, b).joints().any(|joint| joints.contains(&joint))
        });
        moved.exposed.iter_mut().zip(own.moved_by(joints)).for_each(|(exposed, carried)| *exposed &= carried);
        moved
    }

    /// The same without the obstacles that a point is on, within `near` metres, and those.
    pub fn but_at(&self, point: &Vector3<f64>, near: f64) -> (CollisionChecker, Vec<Obstacle>) {
        let mut others = self.clone();
        others.eased.clear();
        let (at, obstacles) = others.obstacles.into_iter().partition(|obstacle| obstacle.is_at(point, near));
        others.obstacles = obstacles;
        (others, at)
    }

    /// The same where a limb may be met by some others.
    pub fn but_between(&self, limb: usize, others: &BTreeSet<usize>) -> CollisionChecker {
        let mut rest = self.clone();
        rest.pairs.retain(|GuardedPair { limbs: [a, b], .. }| {
            !(*a == limb && others.contains(b) || *b == limb && others.contains(a))
        });
        rest
    }

    /// The same where a limb carries something that fills some balls in its frame: they keep clear of obstacles as the limb
    /// does; that they touch the body is left out.
    pub fn carrying(&self, limb: usize, balls: &[Ball]) -> CollisionChecker {
        let mut carrying = self.clone();
        carrying.pieces[limb].extend(balls.iter().map(|ball| {
            let surface = Surface {
                limb,
                origin: ball.centre,
                rotation: Matrix3::identity(),
                shape: Shape::Sphere { radius: ball.radius },
                geom: 0,
            };
            LimbPiece { surface, ball: *ball }
        }));
        carrying
    }

    /// The same where a limb has one more surface, which meets all limbs that its limb can meet.
    pub(super) fn with_surface(&self, creature: &Creature, surface: Surface) -> CollisionChecker {
        let mut more = self.clone();
        let limb = surface.limb;
        let ball = Ball { centre: surface.origin, radius: surface.shape.bounding_radius() };
        let piece = more.pieces[limb].len();
        more.pieces[limb].push(LimbPiece { surface, ball });
        let balls: Vec<Ball> = more.pieces[limb].iter().map(|piece| piece.ball).collect();
        more.bounds[limb] = Ball::about(&balls);
        for other in (0..more.pieces.len()).filter(|&other| !creature.neighbouring(limb, other)) {
            let limbs = [limb.min(other), limb.max(other)];
            let meets =
                (0..more.pieces[other].len()).map(|k| if limb < other { [piece, k] } else { [k, piece] });
            match more.pairs.iter_mut().find(|pair| pair.limbs == limbs) {
                Some(pair) => pair.pieces.extend(meets),
                None => {
                    let pieces: Vec<_> = meets.collect();
                    if !pieces.is_empty() {
                        more.pairs.push(GuardedPair { limbs, pieces, eased: f64::INFINITY });
                    }
                }
            }
        }
        more
    }

    /// The same as if some limbs were not there: per limb, whether it is one of them.
    pub fn without(&self, left_out: &[bool]) -> CollisionChecker {
        let mut rest = self.clone();
        rest.pairs.retain(|pair| pair.limbs.iter().all(|&limb| !left_out[limb]));
        rest.exposed.iter_mut().zip(left_out).for_each(|(exposed, out)| *exposed &= !out);
        rest
    }

    /// The same where some poses are taken for harmless, by their limbs' frames: what is nearer there than `margin` need
    /// not be farther apart elsewhere.
    pub fn eased_at(&self, poses: &[Vec<Frame>], margin: f64) -> CollisionChecker {
        let mut eased = self.clone();
        let limbs = self.pieces.len();
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
    fn between(&self, frames: &[Frame], pair: &GuardedPair, below: f64) -> f64 {
        let [a, b] = pair.limbs;
        let bound = ball_gap(&self.bounds, frames, pair.limbs);
        if bound > below {
            return bound;
        }
        let mut least = f64::INFINITY;
        for &[i, j] in &pair.pieces {
            let (p, q) = (&self.pieces[a][i], &self.pieces[b][j]);
            let bound =
                p.ball.gap_at(&frames[a].point(&p.ball.centre), &q.ball, &frames[b].point(&q.ball.centre));
            least = least.min(if bound > below.min(least) {
                bound
            } else {
                gap(&p.placed(&frames[a]), &q.placed(&frames[b]), Precision::LowerBound).distance
            });
        }
        least
    }

    /// The gap between a limb and an obstacle where it is below `below`, metres; more than that elsewhere.
    pub fn to_obstacle(&self, frames: &[Frame], limb: usize, obstacle: &Obstacle, below: f64) -> f64 {
        let gaps = self.pieces[limb].iter().map(|piece| {
            let ball = Ball { centre: frames[limb].point(&piece.ball.centre), ..piece.ball };
            let bound = obstacle.bound(&ball);
            if bound > below { bound } else { obstacle.gap(&piece.placed(&frames[limb])) }
        });
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// The gap between a limb and a body that is all inside a capsule where it is below `below`, metres, negative by how deep
    /// they are in each other; more than that elsewhere. The root limb is measured, too.
    pub fn to_body(
        &self,
        frames: &[Frame],
        limb: usize,
        body: &dyn ConvexBody,
        about: &Capsule,
        below: f64,
    ) -> f64 {
        let gaps = self.pieces[limb].iter().map(|piece| {
            let ball = Ball { centre: frames[limb].point(&piece.ball.centre), ..piece.ball };
            let bound = about.distance_to(&ball);
            if bound > below {
                return bound;
            }
            gap(&piece.placed(&frames[limb]), body, Precision::ExactWhereShallow).distance
        });
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// All pairs of limbs that feel each other, and limbs and obstacles, that are nearer than `below`, metres.
    pub fn near(&self, frames: &[Frame], below: f64) -> Vec<Nearness> {
        let mut found = Vec::new();
        for pair in &self.pairs {
            let [a, b] = pair.limbs;
            if ball_gap(&self.bounds, frames, pair.limbs) > below {
                continue;
            }
            let gaps = pair.pieces.iter().filter_map(|&[i, j]| {
                let (p, q) = (&self.pieces[a][i], &self.pieces[b][j]);
                let [centre, other] = [frames[a].point(&p.ball.centre), frames[b].point(&q.ball.centre)];
                (p.ball.gap_at(&centre, &q.ball, &other) <= below)
                    .then(|| gap(&p.placed(&frames[a]), &q.placed(&frames[b]), Precision::Exact))
            });
            let nearest = gaps.min_by(|a, b| a.distance.total_cmp(&b.distance));
            let nearest = nearest.filter(|gap| gap.distance <= below);
            found.extend(nearest.map(|gap| Nearness { limb: a, other: Some(b), gap }));
        }
        for obstacle in &self.obstacles {
            found.extend(self.near_to(frames, obstacle, below));
        }
        found
    }

    /// The limbs that are nearer to an obstacle than `below`, metres.
    pub fn near_to<'a>(
        &'a self,
        frames: &'a [Frame],
        obstacle: &'a Obstacle,
        below: f64,
    ) -> impl Iterator<Item = Nearness> + 'a {
        (0..self.pieces.len()).filter(|&limb| self.exposed[limb]).filter_map(move |limb| {
            let gaps = self.pieces[limb].iter().filter_map(|piece| {
                let ball = Ball { centre: frames[limb].point(&piece.ball.centre), ..piece.ball };
                let far = obstacle.bound(&ball) > below;
                if far { None } else { obstacle.nearest(&piece.placed(&frames[limb]), Precision::Exact) }
            });
            let nearest = gaps.min_by(|a, b| a.distance.total_cmp(&b.distance));
            let nearest = nearest.filter(|gap| gap.distance <= below)?;
            Some(Nearness { limb, other: None, gap: nearest })
        })
    }

    /// The middle of a limb's surfaces in its own frame, metres; none where it has none.
    pub fn middle(&self, limb: usize) -> Option<Vector3<f64>> {
        self.bounds[limb].as_ref().map(|ball| ball.centre)
    }

    /// The least gap anywhere, up to `below`, metres.
    pub fn least(&self, frames: &[Frame], below: f64) -> f64 {
        let own = self.pairs.iter().map(|pair| self.between(frames, pair, below));
        let limbs = (0..self.pieces.len()).filter(|&limb| self.exposed[limb]);
        let others = limbs.flat_map(|limb| {
            self.obstacles.iter().map(move |obstacle| self.to_obstacle(frames, limb, obstacle, below))
        });
        own.chain(others).fold(below, f64::min)
    }

    /// Where anything is nearer to something else than `below`, metres: all places of pieces that may become the nearest of
    /// theirs, so that who keeps each of them apart keeps the pieces apart.
    pub fn near_places(&self, frames: &[Frame], below: f64) -> Vec<NearPieces> {
        let mut near = Vec::new();
        for pair in &self.pairs {
            let [a, b] = pair.limbs;
            if ball_gap(&self.bounds, frames, pair.limbs) > below {
                continue;
            }
            for &[i, j] in &pair.pieces {
                let (p, q) = (&self.pieces[a][i], &self.pieces[b][j]);
                let centres = [frames[a].point(&p.ball.centre), frames[b].point(&q.ball.centre)];
                if p.ball.gap_at(&centres[0], &q.ball, &centres[1]) > below {
                    continue;
                }
                let (p, q) = (p.placed(&frames[a]), q.placed(&frames[b]));
                let places = near_places(&p, &q).into_iter().filter(|gap| gap.distance <= below);
                near.extend(places.map(|Gap { distance, normal, points }| NearPieces {
                    limbs: (a, Some(b)),
                    distance,
                    normal,
                    points,
                    eased: pair.eased,
                }));
            }
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            for limb in (0..self.pieces.len()).filter(|&limb| self.exposed[limb]) {
                let eased = self.eased.get(k).map_or(f64::INFINITY, |eased| eased[limb]);
                for piece in &self.pieces[limb] {
                    let ball = Ball { centre: frames[limb].point(&piece.ball.centre), ..piece.ball };
                    if obstacle.bound(&ball) > below {
                        continue;
                    }
                    let places = obstacle.near(&piece.placed(&frames[limb]));
                    let places = places.into_iter().filter(|place| place.distance <= below);
                    near.extend(places.map(|place| NearPieces {
                        limbs: (limb, None),
                        distance: place.distance,
                        normal: place.normal,
                        points: [place.point; 2],
                        eased: eased.min(place.most),
                    }));
                }
            }
        }
        near
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
            && (0..self.pieces.len()).filter(|&limb| self.exposed[limb]).all(|limb| {
                self.obstacles.iter().enumerate().all(|(k, obstacle)| {
                    let margin = margin.min(self.eased.get(k).map_or(f64::INFINITY, |eased| eased[limb]));
                    self.to_obstacle(frames, limb, obstacle, margin) >= margin
                })
            })
    }
}

impl LimbPiece {
    /// Where the limb's frame is at `X_RL`.
    fn placed(&self, limb: &Frame) -> PlacedShape<'_> {
        self.surface.placed(limb).expect("pieces are solid")
    }
}

/// The gap between the balls about two limbs, metres.
fn ball_gap(bounds: &[Option<Ball>], frames: &[Frame], [a, b]: [usize; 2]) -> f64 {
    match (&bounds[a], &bounds[b]) {
        (Some(p), Some(q)) => p.gap_at(&frames[a].point(&p.centre), q, &frames[b].point(&q.centre)),
        _ => f64::INFINITY,
    }
}

/// Where two pieces come closest; of capsules also where an end of one is closest to the other, and the points on their axes.
fn near_places(p: &PlacedShape, q: &PlacedShape) -> Vec<Gap> {
    let (Some(a), Some(b)) = (p.as_capsule(), q.as_capsule()) else {
        return vec![gap(p, q, Precision::ExactWhereShallow)];
    };
    let least = a.gap_at_segments(&b);
    let ends = a.ends.iter().map(|&end| Capsule { ends: [end; 2], ..a }.gap_at_segments(&b));
    let others = b.ends.iter().map(|&end| a.gap_at_segments(&Capsule { ends: [end; 2], ..b }));
    let apart = |gap: &Gap| (gap.points[0] - least.points[0]).norm() > APART;
    std::iter::once(least).chain(ends.chain(others).filter(apart)).collect()
}
