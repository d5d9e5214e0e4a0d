//! The parameters that are to be found, in the order of the normal equations, and what is known of them.

use nalgebra::{DMatrix, DVector};

use super::robot::{Knowledge, Robot, Unit, Value};
use crate::geometry::tangent_basis;
use crate::learning::least_squares::Linearization;

/// How far what is free may be off from the maker's value, metres, radians and ratios.
const OPEN_POSITION: f64 = 0.1;
const OPEN_ANGLE: f64 = 0.5;
const OPEN_RATIO: f64 = 0.2;

/// The open parameters of a robot.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// Quantity and which of its parameters.
    pub parameters: Vec<(usize, usize)>,
    /// Per quantity the places of its parameters.
    places: Vec<[Option<usize>; 3]>,
    /// Per parameter the standard deviation to which it is known before any touch.
    deviations: Vec<Option<f64>>,
}

impl Unknowns {
    /// Those of a robot whose knowledge says so.
    pub fn of(robot: &Robot) -> Unknowns {
        let places = vec![[None; 3]; robot.quantities.len()];
        let mut unknowns = Unknowns { parameters: Vec::new(), places, deviations: Vec::new() };
        // Which way an encoder counts is no matter of small steps.
        let signs: Vec<usize> = robot.encoders().map(|(_, own)| own.sign).collect();
        for (q, quantity) in robot.quantities.iter().enumerate().filter(|(q, _)| !signs.contains(q)) {
            for component in 0..quantity.nominal.size() {
                let deviation = match quantity.knowledge[component] {
                    Knowledge::Known => continue,
                    Knowledge::Near(deviation) => Some(deviation),
                    Knowledge::Free => None,
                };
                unknowns.places[q][component] = Some(unknowns.len());
                unknowns.parameters.push((q, component));
                unknowns.deviations.push(deviation);
            }
        }
        unknowns
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether nothing is to be found.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// Where a quantity's parameter is among them.
    pub fn place(&self, quantity: usize, component: usize) -> Option<usize> {
        self.places[quantity][component]
    }

    /// The places of a quantity's parameters.
    pub fn places(&self, quantity: usize) -> impl Iterator<Item = usize> {
        self.places[quantity].into_iter().flatten()
    }

    /// The name of a parameter.
    pub fn name(&self, robot: &Robot, place: usize) -> String {
        let (quantity, component) = self.parameters[place];
        robot.quantities[quantity].component_name(component)
    }

    /// The standard deviation to which a parameter is known before any touch.
    pub fn deviation_before(&self, place: usize) -> Option<f64> {
        self.deviations[place]
    }

    /// How far a parameter is from its nominal value.
    pub fn off(&self, robot: &Robot, values: &[Value], place: usize) -> f64 {
        let (q, component) = self.parameters[place];
        let difference = values[q].difference(&robot.quantities[q].nominal);
        match &values[q] {
            Value::Direction(axis) => tangent_basis(axis).column(component).dot(&difference),
            _ => difference[component],
        }
    }

    /// How far a parameter of which nothing is known may be off.
    pub fn open_deviation(&self, robot: &Robot, place: usize) -> f64 {
        match robot.quantities[self.parameters[place].0].unit {
            Unit::Metre => OPEN_POSITION,
            Unit::Radian => OPEN_ANGLE,
            Unit::One | Unit::Compliance => OPEN_RATIO,
        }
    }

    /// Values after a step of all parameters.
    pub fn step(&self, values: &[Value], step: &DVector<f64>) -> Vec<Value> {
        let mut values = values.to_vec();
        for (value, places) in values.iter_mut().zip(&self.places) {
            if places.iter().any(Option::is_some) {
                let own = places.map(|place| place.map_or(0.0, |place| step[place]));
                *value = value.stepped(&own[..value.size()]);
            }
        }
        values
    }

    /// `½ Σ (difference / deviation)²` of what is nearly known.
    pub fn prior_cost(&self, robot: &Robot, values: &[Value]) -> f64 {
        let squares = self.parameters.iter().zip(&self.deviations).map(|(&(q, component), deviation)| {
            let Some(deviation) = deviation else { return 0.0 };
            let difference = values[q].difference(&robot.quantities[q].nominal);
            match values[q] {
                // Both parameters of a direction share the difference of the vectors.
                Value::Direction(_) => 0.5 * difference.norm_squared() / (deviation * deviation),
                _ => (difference[component] / deviation).powi(2),
            }
        });
        0.5 * squares.sum::<f64>()
    }

    /// Adds what is nearly known to normal equations, its cost included.
    pub fn add_prior(&self, robot: &Robot, values: &[Value], model: &mut Linearization) {
        model.cost += self.prior_cost(robot, values);
        for (place, deviation) in self.deviations.iter().enumerate() {
            let Some(weight) = deviation.map(|deviation| deviation.powi(-2)) else { continue };
            model.hessian[(place, place)] += weight;
            model.scale[place] += weight;
            model.gradient[place] += weight * self.off(robot, values, place);
        }
    }

    /// Adds the information in what is nearly known.
    pub fn add_information(&self, information: &mut DMatrix<f64>) {
        for (place, deviation) in self.deviations.iter().enumerate() {
            information[(place, place)] += deviation.map_or(0.0, |deviation| deviation.powi(-2));
        }
    }
}
