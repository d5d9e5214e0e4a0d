//! What a robot's pose depends on: values, and what is known of each before any touch.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::geometry::tangent_basis;
use crate::named::named;

/// A value of a quantity, of one to three parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A point or an offset, metres: three parameters.
    Position(Vector3<f64>),
    /// A unit vector: two parameters, by which it turns aside.
    Direction(Vector3<f64>),
    /// A rotation: three parameters, a rotation vector in the frame outside it.
    Orientation(Matrix3<f64>),
    /// A number in the quantity's own unit.
    Number(f64),
}

impl Value {
    /// What its parameters are called, one by one.
    pub fn parts(&self) -> &'static [&'static str] {
        match self {
            Value::Position(_) | Value::Orientation(_) => &["x", "y", "z"],
            Value::Direction(_) => &["u", "v"],
            Value::Number(_) => &[""],
        }
    }

    /// How many parameters it has.
    pub fn size(&self) -> usize {
        self.parts().len()
    }

    /// The vector of a position or a direction.
    pub fn vector(&self) -> Vector3<f64> {
        match self {
            Value::Position(vector) | Value::Direction(vector) => *vector,
            Value::Orientation(_) | Value::Number(_) => Vector3::zeros(),
        }
    }

    /// The number, 0 of what is none.
    pub fn number(&self) -> f64 {
        if let Value::Number(number) = self { *number } else { 0.0 }
    }

    /// Its numbers, as files and readers have them: the rotation vector of an orientation.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Value::Position(vector) | Value::Direction(vector) => vector.iter().copied().collect(),
            Value::Orientation(rotation) => {
                Rotation3::from_matrix_unchecked(*rotation).scaled_axis().iter().copied().collect()
            }
            Value::Number(number) => vec![*number],
        }
    }

    /// The value after a step of its parameters.
    pub fn stepped(&self, step: &[f64]) -> Value {
        match self {
            Value::Position(at) => Value::Position(at + Vector3::from_column_slice(step)),
            Value::Direction(axis) => {
                let aside = tangent_basis(axis) * nalgebra::Vector2::from_column_slice(step);
                Value::Direction((axis + aside).normalize())
            }
            Value::Orientation(rotation) => {
                let turn = Rotation3::new(Vector3::from_column_slice(step));
                Value::Orientation(turn.matrix() * rotation)
            }
            Value::Number(number) => Value::Number(number + step[0]),
        }
    }

    /// How far it is from another value of its kind, per coordinate: metres, radians or the quantity's unit. Of directions the
    /// difference as vectors, of orientations the rotation vector from the other.
    pub fn difference(&self, other: &Value) -> Vector3<f64> {
        match (self, other) {
            (Value::Orientation(a), Value::Orientation(b)) => {
                Rotation3::from_matrix_unchecked(a * b.transpose()).scaled_axis()
            }
            (Value::Number(a), Value::Number(b)) => Vector3::new(a - b, 0.0, 0.0),
            _ => self.vector() - other.vector(),
        }
    }

    /// The size of the difference: of directions and orientations the angle, radians.
    pub fn distance(&self, other: &Value) -> f64 {
        match (self, other) {
            (Value::Direction(a), Value::Direction(b)) => a.cross(b).norm().atan2(a.dot(b)),
            _ => self.difference(other).norm(),
        }
    }
}

/// What is known of a parameter before any touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Knowledge {
    /// It is as it is given.
    Known,
    /// It is as given to this standard deviation, in its own unit.
    Near(f64),
    /// Nothing: what is given is where the search begins.
    Free,
}

named! {
    "unit",
    /// What a quantity's numbers are measured in.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Unit {
        /// Metres; millimetres for a reader.
        Metre = "m",
        /// Radians; degrees for a reader.
        Radian = "rad",
        /// A ratio.
        One = "",
        /// Radians a newton metre.
        Compliance = "rad/(N m)",
    }
}

impl Unit {
    /// What a number is multiplied by for a reader, and what the reader's unit is called.
    pub fn for_readers(self) -> (f64, &'static str) {
        match self {
            Unit::Metre => (1e3, "mm"),
            Unit::Radian => (180.0 / std::f64::consts::PI, "°"),
            Unit::One => (1.0, ""),
            Unit::Compliance => (180.0 / std::f64::consts::PI, "°/Nm"),
        }
    }
}

/// Something about a robot that may be unknown: a joint's position, an encoder's offset, a sphere's radius.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The thing and what of it, as `elbow.position`.
    pub name: String,
    /// What its parameters are measured in.
    pub unit: Unit,
    /// Its value before any touch.
    pub nominal: Value,
    /// What is known of each of its parameters; of a direction both are alike.
    pub knowledge: [Knowledge; 3],
}

impl Quantity {
    /// Whether any of its parameters is to be found.
    pub fn is_open(&self) -> bool {
        self.knowledge[..self.nominal.size()].iter().any(|knowledge| *knowledge != Knowledge::Known)
    }

    /// The name of one of its parameters.
    pub fn component_name(&self, component: usize) -> String {
        match self.nominal.parts()[component] {
            "" => self.name.clone(),
            part => format!("{}.{part}", self.name),
        }
    }
}
