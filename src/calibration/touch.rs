//! What a touch says about a robot: two features of it, or of the world about it, are in one place.

use nalgebra::Vector3;

use super::robot::{Form, Mover, Posed, Robot};
use crate::geometry::{Frame, Gap, PlacedShape, Precision, Shape, gap};
use crate::kinematics::Twist;

/// What touched on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// A point of a link: the link, and where in its frame, metres.
    Point(usize, Vector3<f64>),
    /// A surface, an index into the robot's; where it was touched is not known.
    Surface(usize),
}

/// A feature, and how exactly it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// What touched.
    pub feature: Feature,
    /// Standard deviation of each coordinate, or of the distance from a surface, metres; none where it is not known.
    pub deviation: Option<f64>,
}

/// A touch, or several in one posture of which nobody knows which of one side met which of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// The line of the log that it is on, or begins on.
    pub line: usize,
    /// What the encoders read.
    pub posture: Vec<f64>,
    /// What was felt on either side.
    pub ends: [Vec<End>; 2],
    /// How far apart the two are, metres: 0 where they touched.
    pub distance: f64,
    /// When, where the log says: in any unit.
    pub time: Option<f64>,
}

/// The residuals of one pair of ends and how they change; one where a surface is touched or a distance given, three where points
/// meet.
#[derive(Clone, Debug, Default)]
pub struct Residuals {
    /// How many there are: 1 or 3.
    pub size: usize,
    /// The residuals, metres.
    pub value: Vector3<f64>,
    /// A parameter's place and the residuals' derivative by it.
    pub slopes: Vec<(usize, Vector3<f64>)>,
    /// Their derivative by each degree of freedom as it is.
    pub by_dof: Vec<(usize, Vector3<f64>)>,
}

impl Feature {
    /// The link that it is on.
    pub fn link(&self, robot: &Robot) -> usize {
        match *self {
            Feature::Point(link, _) => link,
            Feature::Surface(surface) => robot.surfaces[surface].link,
        }
    }
}

impl Touch {
    /// What was felt where two of its ends met.
    pub fn features(&self, [i, j]: [usize; 2]) -> [&Feature; 2] {
        [&self.ends[0][i].feature, &self.ends[1][j].feature]
    }

    /// Two of its ends.
    pub fn pair(&self, [i, j]: [usize; 2]) -> [&End; 2] {
        [&self.ends[0][i], &self.ends[1][j]]
    }
}

impl Posed<'_> {
    /// How far two features are from where they would be if they touched; `place` gives a quantity's parameter its place among
    /// the unknowns. Points that meet leave their difference in the frame of the last link on both ways; of surfaces, and of points
    /// at a distance, the gap's excess over `distance` is left.
    pub fn residuals(
        &self,
        [a, b]: [&Feature; 2],
        distance: f64,
        place: &dyn Fn(usize, usize) -> Option<usize>,
    ) -> Residuals {
        let paths = self.paths([a.link(self.robot), b.link(self.robot)]);
        let mut parameters: [Vec<(usize, Twist)>; 2] = Default::default();
        let mut dofs: [Vec<(usize, Twist)>; 2] = Default::default();
        let mut frames = [Frame::identity(); 2];
        for (side, path) in paths.iter().enumerate() {
            frames[side] = self.walk(path, |mover, twist| match mover {
                Mover::Dof(dof) => dofs[side].push((dof, twist)),
                // Most quantities are known: theirs are not kept.
                Mover::Parameter(quantity, part) => {
                    parameters[side].extend(place(quantity, part).map(|at| (at, twist)));
                }
            });
        }
        let met = self.meeting([a, b], distance, &frames);
        let mut found = Residuals { size: met.size, value: met.apart(distance), ..Residuals::default() };
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let slope = |(of, twist): &(usize, Twist)| {
                let by = twist.at(&met.points[side]) * sign;
                (*of, if met.size == 3 { by } else { Vector3::new(met.normal.dot(&by), 0.0, 0.0) })
            };
            found.slopes.extend(parameters[side].iter().map(slope));
            found.by_dof.extend(dofs[side].iter().map(slope));
        }
        for radius in met.radii.into_iter().flatten() {
            found.slopes.extend(place(radius, 0).map(|at| (at, Vector3::new(-1.0, 0.0, 0.0))));
        }
        found
    }

    /// The residuals alone, and how many they are.
    pub fn miss(&self, [a, b]: [&Feature; 2], distance: f64) -> (usize, Vector3<f64>) {
        let frames = self.paths([a.link(self.robot), b.link(self.robot)]).map(|path| self.frame(&path));
        let met = self.meeting([a, b], distance, &frames);
        (met.size, met.apart(distance))
    }

    fn meeting(&self, features: [&Feature; 2], distance: f64, frames: &[Frame; 2]) -> Meeting {
        let [a, b] = [0, 1].map(|side| self.placed(features[side], &frames[side]));
        if features.iter().all(|feature| matches!(feature, Feature::Point(..))) {
            let (points, radii) = ([a.pose.origin, b.pose.origin], [None; 2]);
            let apart = points[0] - points[1];
            // Points at a distance are on a sphere about each other.
            let normal = apart.try_normalize(0.0).unwrap_or(Vector3::z());
            let size = if distance == 0.0 { 3 } else { 1 };
            return Meeting { size, points, normal, gap: apart.norm(), radii };
        }
        let Gap { distance, normal, points } = gap_between(&a, &b);
        let radii = [a.radius, b.radius];
        let shrunk: f64 = radii.iter().flatten().map(|radius| self.values[*radius].number()).sum();
        Meeting { size: 1, points, normal, gap: distance - shrunk, radii }
    }

    fn placed(&self, feature: &Feature, frame: &Frame) -> Placed<'_> {
        let surface = match *feature {
            Feature::Point(_, p) => {
                let pose = Frame { origin: frame.point(&p), ..Frame::identity() };
                return Placed { pose, shape: Some(&POINT), radius: None };
            }
            Feature::Surface(surface) => &self.robot.surfaces[surface],
        };
        let (shape, radius) = match &surface.form {
            Form::Sphere(radius) => (Some(&POINT), Some(*radius)),
            Form::Plane => (None, None),
            Form::Solid(shape) => (Some(shape), None),
        };
        Placed { pose: *frame * surface.pose, shape, radius }
    }
}

/// Where two features come closest.
struct Meeting {
    size: usize,
    points: [Vector3<f64>; 2],
    /// From the second to the first.
    normal: Vector3<f64>,
    gap: f64,
    /// Quantities that are radii of the two.
    radii: [Option<usize>; 2],
}

impl Meeting {
    /// The residuals where the two are to be at a distance.
    fn apart(&self, distance: f64) -> Vector3<f64> {
        match self.size {
            3 => self.points[0] - self.points[1],
            _ => Vector3::new(self.gap - distance, 0.0, 0.0),
        }
    }
}

/// A feature in the common frame. Spheres count as their centres: their radii, quantities, are taken off the gap.
struct Placed<'a> {
    pose: Frame,
    /// `None` of a plane.
    shape: Option<&'a Shape>,
    radius: Option<usize>,
}

/// What a point is, and a sphere but for its radius.
const POINT: Shape = Shape::Sphere { radius: 0.0 };

/// The gap between two features of which one at least is a surface.
fn gap_between(a: &Placed, b: &Placed) -> Gap {
    let Some(shape) = b.shape else {
        let normal: Vector3<f64> = b.pose.rotation.column(2).into();
        // Of a plane, which has no farthest point, where it begins.
        let lowest = a.shape.and_then(|shape| shape.support(&a.pose.rotation.tr_mul(&-normal)));
        let lowest = lowest.map_or(a.pose.origin, |lowest| a.pose.point(&lowest));
        let distance = normal.dot(&(lowest - b.pose.origin));
        return Gap { distance, normal, points: [lowest, lowest - normal * distance] };
    };
    let Some(other) = a.shape else { return gap_between(b, a).reversed() };
    let placed = [(other, a.pose), (shape, b.pose)];
    match placed.map(|(shape, at)| PlacedShape::new(shape, Frame::identity(), at)) {
        [Some(a), Some(b)] => gap(&a, &b, Precision::Exact),
        // A mesh without a hull is nowhere: those who read robots refuse it.
        _ => Gap { distance: 0.0, normal: Vector3::z(), points: placed.map(|(_, at)| at.origin) },
    }
}
