//! What is known to be about the body, and how far it is from a convex body.

use nalgebra::Vector3;

use crate::geometry::{Ball, Capsule, ConvexBody, Gap, Precision, gap};

/// Something that is known to be there, in the root's frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// A capsule, or a ball.
    Capsule(Capsule),
    /// The part of a ball that lies beyond a plane through its centre: where a convex thing of no known size may be that was
    /// touched there.
    Dome {
        /// The centre of the ball, metres.
        centre: Vector3<f64>,
        /// The unit vector that leads from the plane into the dome.
        into: Vector3<f64>,
        /// The radius of the ball, metres.
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

impl Obstacle {
    /// Whether a point is on it, within `near` metres.
    pub(super) fn is_at(&self, point: &Vector3<f64>, near: f64) -> bool {
        match self {
            Obstacle::Capsule(capsule) => capsule.distance_to(&Ball { centre: *point, radius: 0.0 }) <= near,
            Obstacle::Dome { centre, into, radius } => {
                let offset = point - centre;
                offset.dot(into) >= -near && offset.norm() <= radius + near
            }
            Obstacle::Table { up, height, front, edge } => {
                point.dot(front) >= *edge && point.dot(up) - height <= near
            }
        }
    }

    /// No body inside a ball is nearer than this, metres.
    pub(super) fn bound(&self, ball: &Ball) -> f64 {
        match self {
            Obstacle::Capsule(capsule) => capsule.distance_to(ball),
            Obstacle::Dome { centre, radius, .. } => (ball.centre - centre).norm() - radius - ball.radius,
            Obstacle::Table { .. } => f64::NEG_INFINITY,
        }
    }

    /// The gap to a body, metres, below 0 where they overlap; a lower bound, no worse than 5 % below it, for a body that
    /// is neither ball nor capsule, and for what is beside the rim of a dome. Of a table only its top counts, for what reaches over its edge.
    pub(super) fn gap(&self, body: &dyn ConvexBody) -> f64 {
        self.nearest(body, Precision::LowerBound).map_or(f64::INFINITY, |gap| gap.distance)
    }

    /// Where a body is nearest to it, the normal from it to the body; none where it does not matter to the body.
    pub(super) fn nearest(&self, body: &dyn ConvexBody, precision: Precision) -> Option<Gap> {
        match self {
            Obstacle::Capsule(capsule) => Some(gap(body, capsule, precision)),
            // What is clear of the ball or of the plane is clear of the dome, if only of its rim a little farther.
            Obstacle::Dome { centre, into, radius } => {
                let ball = gap(body, &Capsule::ball(*centre, *radius), precision);
                let lowest = body.support(into);
                let before = (centre - lowest).dot(into);
                Some(match before > ball.distance {
                    true => Gap { distance: before, normal: -into, points: [lowest, lowest + into * before] },
                    false => ball,
                })
            }
            Obstacle::Table { up, height, front, edge } => {
                let lowest = match body.as_capsule() {
                    Some(capsule) => lowest_over(&capsule, up, front, *edge),
                    None => (body.support(front).dot(front) > *edge).then(|| body.support(&-up)),
                }?;
                let distance = lowest.dot(up) - height;
                Some(Gap { distance, normal: *up, points: [lowest, lowest - up * distance] })
            }
        }
    }
}

impl Obstacle {
    /// The places at which a body may come closest, each with the greatest margin that is asked there: of a table its lowest
    /// ones over it, or those that reach over the edge where it takes less to draw them back behind that.
    pub(super) fn near(&self, body: &dyn ConvexBody) -> Vec<(Gap, f64)> {
        match self {
            Obstacle::Capsule(_) | Obstacle::Dome { .. } => {
                let gap = self.nearest(body, Precision::ExactWhereShallow);
                gap.map(|gap| (gap, f64::INFINITY)).into_iter().collect()
            }
            Obstacle::Table { up, height, front, edge } => {
                let (ends, radius) = match body.as_capsule() {
                    Some(Capsule { ends, radius }) => (ends.to_vec(), radius),
                    None => (vec![body.support(front), body.support(&-up)], 0.0),
                };
                let is_capsule = body.as_capsule().is_some();
                let behind = ends.iter().map(|&point| {
                    let distance = edge - point.dot(front) - radius;
                    Gap { distance, normal: -front, points: [point; 2] }
                });
                let behind: Vec<Gap> = behind.collect();
                let mut lowest: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::new();
                if is_capsule {
                    let over = |k: usize| behind[k].distance <= 0.0;
                    lowest.extend((0..2).filter(|&k| over(k)).map(|k| (ends[k], *up)));
                    if over(0) != over(1) {
                        lowest.push(cut(&ends, [behind[0].distance, behind[1].distance], up, front));
                    }
                } else if behind[0].distance <= 0.0 {
                    lowest.push((ends[1], *up));
                }
                let above = lowest.into_iter().map(|(point, normal)| Gap {
                    distance: point.dot(up) - radius - height,
                    normal,
                    points: [point; 2],
                });
                let above: Vec<Gap> = above.collect();
                let least =
                    |places: &[Gap]| places.iter().map(|place| place.distance).fold(f64::INFINITY, f64::min);
                let (places, most) = match above.is_empty() || least(&behind) > least(&above) {
                    true => (behind, 0.0),
                    false => (above, f64::INFINITY),
                };
                places.into_iter().map(|gap| (gap, most)).collect()
            }
        }
    }
}

/// Where the edge of a table cuts a segment, by how far its ends are behind the edge, and how the height there changes as
/// the segment moves: the cut goes along it.
fn cut(
    ends: &[Vector3<f64>],
    behind: [f64; 2],
    up: &Vector3<f64>,
    front: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let along = ends[1] - ends[0];
    let point = ends[0] + along * (behind[0] / (behind[0] - behind[1]));
    (point, up - front * (along.dot(up) / along.dot(front)))
}

/// The lowest point, along `up`, of the part of a capsule that may be beyond the edge of a table.
fn lowest_over(
    capsule: &Capsule,
    up: &Vector3<f64>,
    front: &Vector3<f64>,
    edge: f64,
) -> Option<Vector3<f64>> {
    let Capsule { ends, radius } = capsule;
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
    let lowest = if inside[0].dot(up) < inside[1].dot(up) { inside[0] } else { inside[1] };
    Some(lowest - up * *radius)
}
