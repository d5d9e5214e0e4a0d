//! How far the body's surfaces are from each other and from what is known to be there, by the schema.

use nalgebra::{Matrix3, Vector3};

use super::obstacle::Obstacle;
use super::own_body::OwnBody;
use crate::agent::Agent;
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

/// What limbs are made of.
#[derive(Clone, Debug)]
pub struct LimbPieces {
    /// Per limb, its solid pieces.
    of: Vec<Vec<LimbPiece>>,
    /// Per limb, a ball about its pieces; `None` if it has none.
    bounds: Vec<Option<Ball>>,
}

impl LimbPieces {
    /// The surfaces of an agent's limbs.
    pub fn new(agent: &Agent) -> LimbPieces {
        let mut of: Vec<Vec<LimbPiece>> = vec![Vec::new(); agent.creature().limbs().len()];
        for surface in agent.skin().surfaces.iter().filter(|surface| surface.shape.is_solid()) {
            of[surface.limb].push(LimbPiece::new(surface.clone()));
        }
        let bounds = of.iter().map(|pieces| bound(pieces)).collect();
        LimbPieces { of, bounds }
    }

    /// Whether a limb has any.
    pub fn has(&self, limb: usize) -> bool {
        self.bounds[limb].is_some()
    }

    /// All pairs of pieces of two limbs.
    fn pairs(&self, [a, b]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [a, b] = [a, b].map(|limb| self.of[limb].len());
        (0..a).flat_map(move |i| (0..b).map(move |j| [i, j]))
    }

    /// The exact gap of two limbs at `frames` where it is below a limit, metres; infinite elsewhere.
    pub fn gap(&self, frames: &[Frame], limbs: [usize; 2], below: f64) -> f64 {
        let near = self.near(frames, limbs, self.pairs(limbs), below);
        near.map(|[p, q]| gap(&p, &q, Precision::Exact).distance).fold(f64::INFINITY, f64::min)
    }

    /// Those of some pairs of pieces of two limbs that may be nearer to each other than `below`, metres, where the limbs are
    /// at `frames` in the root's frame.
    fn near<'a>(
        &'a self,
        frames: &'a [Frame],
        [a, b]: [usize; 2],
        pairs: impl Iterator<Item = [usize; 2]> + 'a,
        below: f64,
    ) -> impl Iterator<Item = [PlacedShape<'a>; 2]> {
        let apart = self.ball_gap(frames, [a, b]) > below;
        pairs.filter(move |_| !apart).filter_map(move |[i, j]| {
            let (p, q) = (&self.of[a][i], &self.of[b][j]);
            let near = p.ball_gap(&frames[a], q, &frames[b]) <= below;
            near.then(|| [p.placed(&frames[a]), q.placed(&frames[b])])
        })
    }

    /// The gap between the balls about two limbs, metres.
    fn ball_gap(&self, frames: &[Frame], [a, b]: [usize; 2]) -> f64 {
        match (&self.bounds[a], &self.bounds[b]) {
            (Some(p), Some(q)) => p.gap_at(&frames[a].point(&p.centre), q, &frames[b].point(&q.centre)),
            _ => f64::INFINITY,
        }
    }
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

/// A place at which a limb is near another one, or near something that is known to be there.
#[derive(Clone, Copy, Debug)]
pub struct Nearness {
    /// The limb.
    pub limb: usize,
    /// The other limb; `None` if it is an obstacle.
    pub other: Option<usize>,
    /// The gap there, in the root's frame, the normal from the other to the limb.
    pub gap: Gap,
    /// No greater margin is asked here, metres; of obstacles [`CollisionChecker::near_places`] alone has it.
    pub most: f64,
}

/// The surfaces of a body, and what is known to be about it.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    pieces: LimbPieces,
    pairs: Vec<GuardedPair>,
    /// Per limb, whether obstacles matter to it.
    exposed: Vec<bool>,
    /// Per obstacle and limb, the greatest margin that is asked of them, metres; `None` if there is no limit.
    eased: Vec<Vec<f64>>,
    /// What is known to be there.
    pub obstacles: Vec<Obstacle>,
}

impl CollisionChecker {
    /// The surfaces of a body with nothing about it. Limbs that carry each other, and pieces that overlap in the rest posture or
    /// that overlapped in a posture that was lived through, are taken not to feel each other.
    pub fn new(own: &OwnBody) -> CollisionChecker {
        let pieces = LimbPieces::new(own.agent());
        let limbs = own.creature().limbs().len();
        let all = (0..limbs).flat_map(|a| (a + 1..limbs).map(move |b| [a, b]));
        let pairs = all.filter(|&[a, b]| !own.creature().neighbouring(a, b)).map(|limbs| GuardedPair {
            limbs,
            pieces: pieces.pairs(limbs).collect(),
            eased: f64::INFINITY,
        });
        let mut pairs: Vec<GuardedPair> = pairs.collect();
        let at_ease = own.at_ease();
        for posture in own.experienced.iter().chain([&at_ease]) {
            let frames = own.frames(posture);
            for GuardedPair { limbs: [a, b], pieces: felt, .. } in &mut pairs {
                if pieces.ball_gap(&frames, [*a, *b]) < -PASSING {
                    felt.retain(|&[i, j]| {
                        let (first, second) = (&pieces.of[*a][i], &pieces.of[*b][j]);
                        let (first, second) = (first.placed(&frames[*a]), second.placed(&frames[*b]));
                        gap(&first, &second, Precision::LowerBound).distance >= -PASSING
                    });
                }
            }
        }
        pairs.retain(|pair| !pair.pieces.is_empty());
        // The root stays where it is, whatever is there.
        let exposed = (0..limbs).map(|limb| limb > 0).collect();
        CollisionChecker { pairs, pieces, exposed, eased: Vec::new(), obstacles: Vec::new() }
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

    /// The same where some limbs may meet some others.
    pub fn but_between(&self, limbs: &[usize], others: &[usize]) -> CollisionChecker {
        let mut rest = self.clone();
        let meet = |a: &usize, b: &usize| limbs.contains(a) && others.contains(b);
        rest.pairs.retain(|GuardedPair { limbs: [a, b], .. }| !(meet(a, b) || meet(b, a)));
        rest
    }

    /// The same where a limb carries something that fills some balls in its frame: they keep clear of obstacles as the limb
    /// does; that they touch the body is left out.
    pub fn carrying(&self, limb: usize, balls: &[Ball]) -> CollisionChecker {
        let mut carrying = self.clone();
        carrying.pieces.of[limb].extend(balls.iter().map(|ball| {
            LimbPiece::new(Surface {
                limb,
                origin: ball.centre,
                rotation: Matrix3::identity(),
                shape: Shape::Sphere { radius: ball.radius },
                geom: 0,
            })
        }));
        carrying
    }

    /// The same where a limb has one more surface, which meets all limbs that its limb can meet.
    pub(super) fn with_surface(&self, creature: &Creature, surface: Surface) -> CollisionChecker {
        let mut more = self.clone();
        let limb = surface.limb;
        let piece = more.pieces.of[limb].len();
        more.pieces.of[limb].push(LimbPiece::new(surface));
        more.pieces.bounds[limb] = bound(&more.pieces.of[limb]);
        for other in (0..more.pieces.of.len()).filter(|&other| !creature.neighbouring(limb, other)) {
            let limbs = [limb.min(other), limb.max(other)];
            let meets =
                (0..more.pieces.of[other].len()).map(|k| if limb < other { [piece, k] } else { [k, piece] });
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
        let limbs = self.pieces.of.len();
        eased.eased = vec![vec![f64::INFINITY; limbs]; self.obstacles.len()];
        for frames in poses {
            for (pair, before) in eased.pairs.iter_mut().zip(&self.pairs) {
                let gap = self.between(frames, before, margin);
                if gap < margin {
                    pair.eased = pair.eased.min(gap - EASED);
                }
            }
            for (obstacle, eased) in self.obstacles.iter().zip(&mut eased.eased) {
                for limb in self.exposed() {
                    let gap = self.to_obstacle(frames, limb, obstacle, margin);
                    if gap < margin {
                        eased[limb] = eased[limb].min(gap - EASED);
                    }
                }
            }
        }
        eased
    }

    /// The pieces of two limbs that feel each other and may be nearer than `below`, metres.
    fn pieces_of<'a>(
        &'a self,
        frames: &'a [Frame],
        pair: &'a GuardedPair,
        below: f64,
    ) -> impl Iterator<Item = [PlacedShape<'a>; 2]> {
        self.pieces.near(frames, pair.limbs, pair.pieces.iter().copied(), below)
    }

    /// The pieces of a limb that may be nearer to something than `below`, metres, given how near it is at the least to what
    /// is in a ball.
    fn pieces_near<'a>(
        &'a self,
        frames: &'a [Frame],
        limb: usize,
        below: f64,
        bound: impl Fn(&Ball) -> f64 + 'a,
    ) -> impl Iterator<Item = PlacedShape<'a>> {
        self.pieces.of[limb].iter().filter_map(move |piece| {
            let ball = Ball { centre: frames[limb].point(&piece.ball.centre), ..piece.ball };
            (bound(&ball) <= below).then(|| piece.placed(&frames[limb]))
        })
    }

    /// The limbs that obstacles matter to.
    fn exposed(&self) -> impl Iterator<Item = usize> {
        (0..self.exposed.len()).filter(|&limb| self.exposed[limb])
    }

    /// The greatest margin that is asked of an obstacle and a limb, metres.
    fn eased(&self, obstacle: usize, limb: usize) -> f64 {
        self.eased.get(obstacle).map_or(f64::INFINITY, |eased| eased[limb])
    }

    /// The gap between two limbs that feel each other where it is below `below`, metres, negative where they overlap;
    /// infinite elsewhere.
    fn between(&self, frames: &[Frame], pair: &GuardedPair, below: f64) -> f64 {
        let gaps =
            self.pieces_of(frames, pair, below).map(|[p, q]| gap(&p, &q, Precision::LowerBound).distance);
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// The gap between a limb and an obstacle where it is below `below`, metres; infinite elsewhere.
    pub fn to_obstacle(&self, frames: &[Frame], limb: usize, obstacle: &Obstacle, below: f64) -> f64 {
        let pieces = self.pieces_near(frames, limb, below, |ball| obstacle.bound(ball));
        pieces.map(|piece| obstacle.gap(&piece)).fold(f64::INFINITY, f64::min)
    }

    /// The exact gap between two limbs by their pieces that feel each other, metres, negative where they are in each other;
    /// `None` if none do.
    pub fn gap(&self, frames: &[Frame], limbs: [usize; 2]) -> Option<f64> {
        let [a, b] = limbs;
        let pair = self.pairs.iter().find(|pair| pair.limbs == [a.min(b), a.max(b)])?;
        let gaps = self.pieces_of(frames, pair, f64::INFINITY).map(|[p, q]| gap(&p, &q, Precision::Exact));
        gaps.map(|gap| gap.distance).reduce(f64::min)
    }

    /// Whether obstacles matter to a limb: whether it moves.
    pub fn is_exposed(&self, limb: usize) -> bool {
        self.exposed[limb]
    }

    /// The least gap between limbs that obstacles matter to and an obstacle, up to `below`, metres.
    pub fn least_to(&self, frames: &[Frame], obstacle: &Obstacle, below: f64) -> f64 {
        self.exposed().fold(below, |least, limb| least.min(self.to_obstacle(frames, limb, obstacle, least)))
    }

    /// The gap between a limb and a capsule where it is below `below`, metres, negative by how deep they are in each other;
    /// infinite elsewhere. The root limb is measured, too.
    pub fn to_capsule(&self, frames: &[Frame], limb: usize, body: &Capsule, below: f64) -> f64 {
        let pieces = self.pieces_near(frames, limb, below, |ball| body.distance_to(ball));
        let gaps = pieces.map(|piece| gap(&piece, body, Precision::ExactWhereShallow).distance);
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// All pairs of limbs that feel each other, and limbs and obstacles, that are nearer than `below`, metres: where they
    /// are nearest.
    pub fn near(&self, frames: &[Frame], below: f64) -> Vec<Nearness> {
        let mut found = Vec::new();
        for pair in &self.pairs {
            let gaps = self.pieces_of(frames, pair, below).map(|[p, q]| gap(&p, &q, Precision::Exact));
            let [limb, other] = pair.limbs;
            let nearness = |gap| Nearness { limb, other: Some(other), gap, most: pair.eased };
            found.extend(nearest(gaps, below).map(nearness));
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
        self.exposed().filter_map(move |limb| {
            let pieces = self.pieces_near(frames, limb, below, |ball| obstacle.bound(ball));
            let gaps = pieces.filter_map(|piece| obstacle.nearest(&piece, Precision::Exact));
            let nearness = |gap| Nearness { limb, other: None, gap, most: f64::INFINITY };
            nearest(gaps, below).map(nearness)
        })
    }

    /// The least gap anywhere, up to `below`, metres.
    pub fn least(&self, frames: &[Frame], below: f64) -> f64 {
        self.near(frames, below).iter().map(|near| near.gap.distance).fold(below, f64::min)
    }

    /// Where anything is nearer to something else than `below`, metres: all places of pieces that may become the nearest of
    /// theirs, so that who keeps each of them apart keeps the pieces apart. Points of capsules are on their axes.
    pub fn near_places(&self, frames: &[Frame], below: f64) -> Vec<Nearness> {
        let mut near = Vec::new();
        for pair in &self.pairs {
            let [limb, other] = pair.limbs;
            let gaps = self.pieces_of(frames, pair, below).flat_map(|[p, q]| near_places(&p, &q));
            near.extend(gaps.map(|gap| Nearness { limb, other: Some(other), gap, most: pair.eased }));
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            for limb in self.exposed() {
                let pieces = self.pieces_near(frames, limb, below, |ball| obstacle.bound(ball));
                let eased = self.eased(k, limb);
                let places = pieces.flat_map(|piece| obstacle.near(&piece));
                near.extend(places.map(|(gap, most)| Nearness {
                    limb,
                    other: None,
                    gap,
                    most: eased.min(most),
                }));
            }
        }
        near.retain(|near| near.gap.distance <= below);
        near
    }

    /// Whether all gaps are at least `margin`.
    pub fn free(&self, frames: &[Frame], margin: f64) -> bool {
        let parted = |pair: &GuardedPair| {
            let margin = margin.min(pair.eased);
            self.between(frames, pair, margin) >= margin
        };
        let clear = |limb: usize| {
            self.obstacles.iter().enumerate().all(|(k, obstacle)| {
                let margin = margin.min(self.eased(k, limb));
                self.to_obstacle(frames, limb, obstacle, margin) >= margin
            })
        };
        self.pairs.iter().all(parted) && self.exposed().all(clear)
    }
}

impl LimbPiece {
    fn new(surface: Surface) -> LimbPiece {
        LimbPiece { ball: Ball { centre: surface.origin, radius: surface.shape.bounding_radius() }, surface }
    }

    /// The gap between the balls about two pieces whose limbs are at these frames, metres.
    fn ball_gap(&self, limb: &Frame, other: &LimbPiece, other_limb: &Frame) -> f64 {
        self.ball.gap_at(&limb.point(&self.ball.centre), &other.ball, &other_limb.point(&other.ball.centre))
    }

    /// Where the limb's frame is at `X_RL`.
    fn placed(&self, limb: &Frame) -> PlacedShape<'_> {
        self.surface.placed(limb).expect("pieces are solid")
    }
}

/// A ball about pieces; `None` if there is none.
fn bound(pieces: &[LimbPiece]) -> Option<Ball> {
    Ball::about(&pieces.iter().map(|piece| piece.ball).collect::<Vec<_>>())
}

/// The least of some gaps, where it is no more than `below`, metres.
fn nearest(gaps: impl Iterator<Item = Gap>, below: f64) -> Option<Gap> {
    gaps.min_by(|a, b| a.distance.total_cmp(&b.distance)).filter(|gap| gap.distance <= below)
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
