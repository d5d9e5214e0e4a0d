//! What a model says about one body, joint, geom, site, sensor or tuple.
//!
//! Each structure is a small copy, made when asked for; the model itself stays in the engine.

use std::ops::Range;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::ffi;

/// A body (limb) of the kinematic tree; body 0 is the world.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelBody<'m> {
    /// Its name in the file, if it has one.
    pub name: Option<&'m str>,
    /// The body that carries it; the world carries itself.
    pub parent: usize,
    /// The body that moves as one with it: itself, or the ancestor that it has no joint to.
    pub weld: usize,
    /// Its origin in the parent body's frame, in metres, at `qpos0`.
    pub pos: Vector3<f64>,
    /// Its orientation in the parent body's frame, at `qpos0`.
    pub quat: UnitQuaternion<f64>,
    /// The joints that connect it with its parent, in the order in which they turn it.
    pub joints: Range<usize>,
    /// Its geoms.
    pub geoms: Range<usize>,
    /// Its mass, kilograms.
    pub mass: f64,
    /// Its centre of mass in its frame, in metres.
    pub ipos: Vector3<f64>,
    /// The orientation of its principal axes in its frame.
    pub iquat: UnitQuaternion<f64>,
    /// Its moments of inertia about these, kg·m².
    pub inertia: Vector3<f64>,
}

/// A joint between a body and its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelJoint<'m> {
    /// Its name in the file, if it has one.
    pub name: Option<&'m str>,
    /// How it moves.
    pub kind: JointKind,
    /// The body that it moves.
    pub body: usize,
    /// Where its coordinates start in `qpos`; it has [`JointKind::nq`] of them.
    pub qposadr: usize,
    /// Where its velocities start in `qvel`; it has [`JointKind::nv`] of them.
    pub dofadr: usize,
    /// Its anchor in the body's frame, in metres.
    pub pos: Vector3<f64>,
    /// Its axis in the body's frame, of length 1; without meaning for ball and free joints.
    pub axis: Vector3<f64>,
    /// Whether `range` limits it.
    pub limited: bool,
    /// Least and greatest coordinate, in radians (hinge) or metres (slide); a ball joint's second
    /// number is its greatest rotation angle.
    pub range: [f64; 2],
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// Free flight: a position and a quaternion.
    Free,
    /// Any rotation about the anchor: a quaternion.
    Ball,
    /// A shift along the axis.
    Slide,
    /// A rotation about the axis.
    Hinge,
}

impl JointKind {
    /// The number of coordinates in `qpos`.
    pub fn nq(self) -> usize {
        match self {
            Self::Free => 7,
            Self::Ball => 4,
            Self::Slide | Self::Hinge => 1,
        }
    }

    /// The number of degrees of freedom.
    pub fn nv(self) -> usize {
        match self {
            Self::Free => 6,
            Self::Ball => 3,
            Self::Slide | Self::Hinge => 1,
        }
    }

    pub(super) fn from_raw(raw: i32) -> Self {
        match raw as u32 {
            ffi::mjJNT_FREE => Self::Free,
            ffi::mjJNT_BALL => Self::Ball,
            ffi::mjJNT_SLIDE => Self::Slide,
            _ => Self::Hinge,
        }
    }
}

/// A shape that is fixed to a body and may touch others.
#[derive(Debug, Clone, PartialEq)]
pub struct Geom<'m> {
    /// Its name in the file, if it has one.
    pub name: Option<&'m str>,
    /// Its shape.
    pub kind: GeomKind,
    /// The body that it is fixed to.
    pub body: usize,
    /// Sphere: radius. Capsule, cylinder: radius, half length along z. Ellipsoid, box: half axes.
    /// Plane: half sides, 0 where infinite. Metres.
    pub size: [f64; 3],
    /// Its centre in the body's frame, in metres.
    pub pos: Vector3<f64>,
    /// Its orientation in the body's frame.
    pub quat: UnitQuaternion<f64>,
    /// The contact types it has, as bits.
    pub contype: u32,
    /// The contact types it meets, as bits.
    pub conaffinity: u32,
    /// Its visibility group.
    pub group: i32,
    /// Radius of the sphere about its centre that holds it, in metres; 0 for a plane.
    pub rbound: f64,
}

/// Visibility groups of geoms that a viewer shows unless told otherwise; shapes for collision are by custom in others.
const SHOWN_GROUPS: std::ops::Range<i32> = 0..3;

impl Geom<'_> {
    /// Whether viewers show it unless they are told otherwise.
    pub fn is_shown(&self) -> bool {
        SHOWN_GROUPS.contains(&self.group)
    }
}

/// The shape of a geom or a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GeomKind {
    /// A plane through the centre, its normal along z.
    Plane,
    /// A height field.
    HeightField,
    /// A sphere.
    Sphere,
    /// A capsule along z.
    Capsule,
    /// An ellipsoid.
    Ellipsoid,
    /// A cylinder along z.
    Cylinder,
    /// A box.
    Box,
    /// The convex hull of a mesh.
    Mesh,
    /// A shape that the crate does not know, by MuJoCo's number.
    Other(i32),
}

impl GeomKind {
    pub(super) fn from_raw(raw: i32) -> Self {
        match raw as u32 {
            ffi::mjGEOM_PLANE => Self::Plane,
            ffi::mjGEOM_HFIELD => Self::HeightField,
            ffi::mjGEOM_SPHERE => Self::Sphere,
            ffi::mjGEOM_CAPSULE => Self::Capsule,
            ffi::mjGEOM_ELLIPSOID => Self::Ellipsoid,
            ffi::mjGEOM_CYLINDER => Self::Cylinder,
            ffi::mjGEOM_BOX => Self::Box,
            ffi::mjGEOM_MESH => Self::Mesh,
            _ => Self::Other(raw),
        }
    }

    #[cfg(feature = "render")]
    /// The engine's number of a shape that its sizes say all of; none of others.
    pub(super) fn to_raw(self) -> Option<i32> {
        let number = match self {
            Self::Sphere => ffi::mjGEOM_SPHERE,
            Self::Capsule => ffi::mjGEOM_CAPSULE,
            Self::Ellipsoid => ffi::mjGEOM_ELLIPSOID,
            Self::Cylinder => ffi::mjGEOM_CYLINDER,
            Self::Box => ffi::mjGEOM_BOX,
            Self::Plane | Self::HeightField | Self::Mesh | Self::Other(_) => return None,
        };
        Some(number as i32)
    }
}

/// A constraint that couples parts of the model.
#[derive(Debug, Clone, PartialEq)]
pub enum Equality {
    /// A hinge or slide that follows another, or stands still.
    Joint {
        /// The joint that follows.
        follower: usize,
        /// The joint that it follows; `None` if it stands at the polynomial's constant.
        leader: Option<usize>,
        /// Coefficients of degree 0 to 4: the follower's coordinate from the leader's, both counted from the
        /// reference posture.
        polynomial: [f64; 5],
    },
    /// A constraint between bodies or tendons.
    Other,
}

/// A named place on a body, for instance a receptor.
#[derive(Debug, Clone, PartialEq)]
pub struct Site<'m> {
    /// Its name in the file, if it has one.
    pub name: Option<&'m str>,
    /// Its shape.
    pub kind: GeomKind,
    /// The body that it is fixed to.
    pub body: usize,
    /// As a geom's size, in metres.
    pub size: [f64; 3],
    /// Its centre in the body's frame, in metres.
    pub pos: Vector3<f64>,
    /// Its orientation in the body's frame.
    pub quat: UnitQuaternion<f64>,
}

/// A sensor: some numbers of [`Data::sensordata`](super::Data::sensordata).
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// What it measures.
    pub kind: SensorKind,
    /// The type of what it is attached to.
    pub object: ObjectKind,
    /// The index of what it is attached to, within its type; nothing for a clock.
    pub id: Option<usize>,
    /// Where its numbers start in `sensordata`.
    pub adr: usize,
    /// How many numbers it gives.
    pub dim: usize,
    /// The greatest amount that it tells, in the unit of its numbers; 0 where there is no such bound.
    pub cutoff: f64,
    /// The standard deviation of its noise, in the unit of its numbers.
    pub noise: f64,
}

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SensorKind {
    /// Sum of the normal contact forces in a site's zone, in newtons.
    Touch,
    /// The angle or shift of a hinge or slide joint, in radians or metres.
    JointPos,
    /// The quaternion of a ball joint, w x y z.
    BallQuat,
    /// A sensor that the crate has no word for, by MuJoCo's number.
    Other(i32),
}

impl SensorKind {
    pub(super) fn from_raw(raw: i32) -> Self {
        match raw as u32 {
            ffi::mjSENS_TOUCH => Self::Touch,
            ffi::mjSENS_JOINTPOS => Self::JointPos,
            ffi::mjSENS_BALLQUAT => Self::BallQuat,
            _ => Self::Other(raw),
        }
    }
}

/// The type of a model's element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ObjectKind {
    /// A body, by its regular frame or its inertial frame.
    Body,
    /// A joint.
    Joint,
    /// A geom.
    Geom,
    /// A site.
    Site,
    /// A sensor.
    Sensor,
    /// A tuple.
    Tuple,
    /// A camera.
    Camera,
    /// An element that the crate has no word for, by MuJoCo's number.
    Other(i32),
}

impl ObjectKind {
    pub(super) fn from_raw(raw: i32) -> Self {
        match raw as u32 {
            ffi::mjOBJ_BODY | ffi::mjOBJ_XBODY => Self::Body,
            ffi::mjOBJ_JOINT => Self::Joint,
            ffi::mjOBJ_GEOM => Self::Geom,
            ffi::mjOBJ_SITE => Self::Site,
            ffi::mjOBJ_SENSOR => Self::Sensor,
            ffi::mjOBJ_TUPLE => Self::Tuple,
            ffi::mjOBJ_CAMERA => Self::Camera,
            _ => Self::Other(raw),
        }
    }

    pub(super) fn to_raw(self) -> i32 {
        match self {
            Self::Body => ffi::mjOBJ_BODY as i32,
            Self::Joint => ffi::mjOBJ_JOINT as i32,
            Self::Geom => ffi::mjOBJ_GEOM as i32,
            Self::Site => ffi::mjOBJ_SITE as i32,
            Self::Sensor => ffi::mjOBJ_SENSOR as i32,
            Self::Tuple => ffi::mjOBJ_TUPLE as i32,
            Self::Camera => ffi::mjOBJ_CAMERA as i32,
            Self::Other(raw) => raw,
        }
    }
}

/// A named list of elements under `<custom>`.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuple<'m> {
    /// Its name in the file, if it has one.
    pub name: Option<&'m str>,
    /// Its elements, in the file's order.
    pub entries: Vec<TupleEntry>,
}

/// An element of a tuple.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TupleEntry {
    /// The type of the element.
    pub object: ObjectKind,
    /// Its index within its type.
    pub id: usize,
    /// The number that the file attaches to it, 0 by default.
    pub prm: f64,
}

/// The first three numbers of `values` as a vector.
pub(super) fn vector(values: &[f64]) -> Vector3<f64> {
    Vector3::new(values[0], values[1], values[2])
}

/// MuJoCo's w x y z as a unit quaternion; the engine keeps it normalised to rounding.
pub(super) fn quaternion(wxyz: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]))
}
