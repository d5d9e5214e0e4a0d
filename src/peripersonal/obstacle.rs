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
    /// All that lies below the top of a table and beyond its edge.
    Table(TablePlane),
}

/// A horizontal plane and where one faces over it, all in the root's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePlane {
    /// Unit vector against gravity.
    pub up: Vector3<f64>,
    /// Horizontal unit vector that leads over the table.
    pub front: Vector3<f64>,
    /// The height of the top along `up`, metres.
    pub height: f64,
    /// Where it can begin, along `front`, metres.
    pub edge: f64,
}

impl TablePlane {
    /// How far forward, to the left and above the table a point is, metres.
    pub fn coordinates(&self, point: &Vector3<f64>) -> [f64; 3] {
        let left = self.up.cross(&self.front);
        [point.dot(&self.front), point.dot(&left), point.dot(&self.up) - self.height]
    }

    /// The point so far forward, to the left and above the table, metres.
    pub fn point(&self, [forward, left, above]: [f64; 3]) -> Vector3<f64> {
        self.front * forward + self.up.cross(&self.front) * left + self.up * (self.height + above)
    }
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
            Obstacle::Table(plane) => {
                let [forward, _, above] = plane.coordinates(point);
                forward >= plane.edge && above <= near
            }
        }
    }

    /// No body inside a ball is nearer than this, metres.
    pub(super) fn bound(&self, ball: &Ball) -> f64 {
        match self {
            Obstacle::Capsule(capsule) => capsule.distance_to(ball),
            Obstacle::Dome { centre, radius, .. } => (ball.centre - centre).norm() - radius - ball.radius,
            Obstacle::Table(_) => f64::NEG_INFINITY,
        }
    }

    /// The gap to a body, metres, below 0 where they overlap; a lower bound, no worse than 5 % below it, for a body that
    /// is neither ball nor capsule, and for what is beside the rim of a dome. Of a table only its top counts, for what reaches over its edge.
    pub(super) fn gap(&self, body: &dyn ConvexBody) -> f64 {
        self.nearest(body, Precision::LowerBound).map_or(f64::INFINITY, |gap| gap.distance)
    }

    /// Where a body is nearest to it, the normal from it to the body; `None` if it does not matter to the body.
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
            Obstacle::Table(TablePlane { up, height, front, edge }) => {
                let Overhang { radius, over, .. } = Overhang::of(body, up, front, *edge);
                let points = over.iter().map(|[point, _]| point - up * radius);
                let lowest = points.min_by(|a, b| a.dot(up).total_cmp(&b.dot(up)))?;
                let distance = lowest.dot(up) - height;
                Some(Gap { distance, normal: *up, points: [lowest, lowest - up * distance] })
            }
        }
    }

    /// The places at which a body may come closest, each with the greatest margin that is asked there: of a table its lowest
    /// ones over it, or those that reach over the edge where it takes less to draw them back behind that.
    pub(super) fn near(&self, body: &dyn ConvexBody) -> Vec<(Gap, f64)> {
        match self {
            Obstacle::Capsule(_) | Obstacle::Dome { .. } => {
                let gap = self.nearest(body, Precision::ExactWhereShallow);
                gap.map(|gap| (gap, f64::INFINITY)).into_iter().collect()
            }
            Obstacle::Table(TablePlane { up, height, front, edge }) => {
                let Overhang { ends, radius, over } = Overhang::of(body, up, front, *edge);
                let place = |point: Vector3<f64>, normal: Vector3<f64>, distance: f64| Gap {
                    distance: distance - radius,
                    normal,
                    points: [point; 2],
                };
                let behind = ends.map(|point| place(point, -front, edge - point.dot(front))).to_vec();
                let above =
                    over.into_iter().map(|[point, normal]| place(point, normal, point.dot(up) - height));
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

/// What of a body reaches over the edge of a table.
struct Overhang {
    /// The ends of its segment if it is a capsule, or else the points farthest to the front and down.
    ends: [Vector3<f64>; 2],
    radius: f64,
    /// The points that may be the lowest of those beyond the edge, each with how the height there changes as the body moves.
    over: Vec<[Vector3<f64>; 2]>,
}

impl Overhang {
    fn of(body: &dyn ConvexBody, up: &Vector3<f64>, front: &Vector3<f64>, edge: f64) -> Overhang {
        let Some(Capsule { ends, radius }) = body.as_capsule() else {
            let ends = [body.support(front), body.support(&-up)];
            let over = if ends[0].dot(front) > edge { vec![[ends[1], *up]] } else { Vec::new() };
            return Overhang { ends, radius: 0.0, over };
        };
        let beyond = ends.map(|end| end.dot(front) - (edge - radius));
        let mut over: Vec<_> = (0..2).filter(|&k| beyond[k] >= 0.0).map(|k| [ends[k], *up]).collect();
        if over.len() == 1 {
            // Where the edge cuts the segment, the cut goes along it.
            let along = ends[1] - ends[0];
            let point = ends[0] + along * (beyond[0] / (beyond[0] - beyond[1]));
            over.push([point, up - front * (along.dot(up) / along.dot(front))]);
        }
        Overhang { ends, radius, over }
    }
}
