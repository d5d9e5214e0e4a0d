//! How sure a learned schema is, so that whoever opens the session knows it as the learner did.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::creature::Creature;
use crate::learning::observability::Observability;
use crate::learning::{Account, AxisModel, Basis, Learned, LengthUnit, Parameters, Witnesses};
use crate::plausible::GREATEST_LEARNED;

/// What a learner tells of how good its schema is, as it is kept.
#[derive(Clone, Debug)]
pub struct RecordedAccount {
    /// With what it was learned.
    pub basis: Basis,
    /// Standard deviation of what the learner compares, as the touches themselves show it, metres; `None` if it cannot tell.
    pub deviation: Option<f64>,
    /// What is known of the body; `None` if the learner cannot tell, and in records from before limbs were accounted for.
    pub account: Option<Account>,
}

impl RecordedAccount {
    /// The account that a learner gives.
    pub fn of(learned: &Learned) -> RecordedAccount {
        RecordedAccount {
            basis: learned.basis,
            deviation: learned.deviation,
            account: learned.account.clone(),
        }
    }
}

/// An account as it is written.
#[derive(Serialize, Deserialize)]
pub(super) struct AccountEntry {
    basis: Basis,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    touch_deviation: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    determined: Option<DeterminedEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    placed: Option<PlacedEntry>,
}

/// How far off the skin of limbs may be in each other's frames, as it is written.
#[derive(Serialize, Deserialize)]
struct PlacedEntry {
    /// Standard deviation of the points that touches tell, metres; 0 where they tell surfaces.
    point_deviation: f64,
    /// Whether the touches fit to numerical precision.
    at_floor: bool,
    /// The limbs that have skin, in the creature's order.
    limbs: Vec<PlacedLimb>,
}

/// A limb that has skin.
#[derive(Serialize, Deserialize)]
struct PlacedLimb {
    limb: String,
    /// Its touches that support the schema.
    touches: usize,
    /// All its touches; none in records from before they were counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    made: Option<usize>,
    /// How far off its skin may be in the frame of each limb before it in the list, at 95 %, metres; `None` if
    /// nothing bounds that.
    distances: Vec<Option<f64>>,
}

/// What touches determine, as it is written: the information that they hold, from which all else follows.
#[derive(Serialize, Deserialize)]
struct DeterminedEntry {
    /// The joints of which position and axes are parameters, by name: three coordinates of the position, then two
    /// across each axis that is no ball's, joint by joint.
    joints: Vec<String>,
    /// The limbs whose own poses are parameters, which come after these: three coordinates and a rotation vector.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    limb_poses: Vec<String>,
    /// The joints that were known exactly before the first touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    known: Vec<String>,
    /// The limbs of which it is not known where points in their frames are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unplaced_limbs: Vec<String>,
    /// The unit of length that it was learned in, metres: all lengths are metres nevertheless.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<f64>,
    /// The number of residuals that the information is of.
    residuals: usize,
    /// Its lower triangle, row by row.
    information: Vec<Vec<f64>>,
}

/// How far rounding may take an information beyond what it can be.
const ROUNDING: f64 = 1e-6;

const MEND: &str = "learn again with `bodyschema learn`";

/// Whether something can be a distance or a deviation.
fn is_possible(x: &f64) -> bool {
    (0.0..=GREATEST_LEARNED).contains(x)
}

impl AccountEntry {
    /// The account by names; without what touches determine where a number of it is not finite. What lies farther off than
    /// anything can is not bounded.
    pub fn new(recorded: &RecordedAccount, creature: &Creature) -> AccountEntry {
        let finite = |account: &&Account| {
            let numbers = account.observability.information().iter();
            numbers.copied().all(f64::is_finite) && is_possible(&account.witnesses.point_deviation)
        };
        let account = recorded.account.as_ref().filter(finite);
        AccountEntry {
            basis: recorded.basis,
            touch_deviation: recorded.deviation.filter(is_possible),
            determined: account.map(|account| DeterminedEntry::new(&account.observability, creature)),
            placed: account.map(|account| PlacedEntry::new(account, creature)),
        }
    }

    /// The account, of a creature.
    ///
    /// # Errors
    /// A sentence where it is of another creature.
    pub fn account(&self, creature: &Creature) -> Result<RecordedAccount, String> {
        let placed = self.placed.iter();
        let distances =
            placed.clone().flat_map(|placed| placed.limbs.iter().flat_map(|limb| &limb.distances).flatten());
        let deviations = placed.map(|placed| &placed.point_deviation).chain(&self.touch_deviation);
        if let Some(wrong) = distances.chain(deviations).find(|x| !is_possible(x)) {
            return Err(format!("its account contains a distance or deviation of {wrong} m: {MEND}"));
        }
        let account = match (&self.determined, &self.placed) {
            (Some(found), Some(placed)) => Some(placed.account(found.observability(creature)?, creature)?),
            _ => None,
        };
        Ok(RecordedAccount { basis: self.basis, deviation: self.touch_deviation, account })
    }
}

impl PlacedEntry {
    fn new(account: &Account, creature: &Creature) -> PlacedEntry {
        let limbs = account.limbs();
        let entry = |(number, &limb): (usize, &usize)| {
            let bounded = |&other: &usize| Some(account.distance(limb, other)).filter(is_possible);
            PlacedLimb {
                limb: creature.limbs()[limb].clone(),
                touches: account.witnesses.of_limbs[limb],
                made: Some(account.witnesses.made_of_limbs[limb]),
                distances: limbs[..number].iter().map(bounded).collect(),
            }
        };
        PlacedEntry {
            point_deviation: account.witnesses.point_deviation,
            at_floor: account.witnesses.at_floor,
            limbs: limbs.iter().enumerate().map(entry).collect(),
        }
    }

    fn account(&self, found: Observability, creature: &Creature) -> Result<Account, String> {
        let mut touches = vec![0; creature.limbs().len()];
        let mut made = touches.clone();
        let mut limbs = Vec::with_capacity(self.limbs.len());
        for (number, entry) in self.limbs.iter().enumerate() {
            let limb = creature.limb(&entry.limb).filter(|limb| !limbs.contains(limb));
            let limb = limb.ok_or_else(|| unknown_name(&entry.limb))?;
            if entry.distances.len() != number {
                return Err(format!(
                    "its account of limb \"{}\" does not have {number} distances: {MEND}",
                    entry.limb
                ));
            }
            touches[limb] = entry.touches;
            made[limb] = entry.made.unwrap_or(entry.touches);
            limbs.push(limb);
        }
        let distances = DMatrix::from_fn(limbs.len(), limbs.len(), |i, j| match i == j {
            true => 0.0,
            false => self.limbs[i.max(j)].distances[i.min(j)].unwrap_or(f64::INFINITY),
        });
        let witnesses = Witnesses {
            of_limbs: touches,
            made_of_limbs: made,
            point_deviation: self.point_deviation,
            at_floor: self.at_floor,
        };
        Ok(Account::of_distances(creature, found, limbs, distances, witnesses))
    }
}

impl DeterminedEntry {
    fn new(found: &Observability, creature: &Creature) -> DeterminedEntry {
        let joints = |holds: &dyn Fn(usize) -> bool| {
            let held = creature.joints().iter().enumerate().filter(|(joint, _)| holds(*joint));
            held.map(|(_, joint)| joint.name.clone()).collect()
        };
        let limbs = |holds: &dyn Fn(usize) -> bool| {
            let held = creature.limbs().iter().enumerate().filter(|(limb, _)| holds(*limb));
            held.map(|(_, limb)| limb.clone()).collect()
        };
        let (parameters, information) = (&found.parameters, found.information());
        DeterminedEntry {
            joints: joints(&|joint| parameters.positions[joint].is_some()),
            limb_poses: limbs(&|limb| limb > 0 && parameters.limb_origins[limb - 1].is_some()),
            known: joints(&|joint| found.known()[joint]),
            unplaced_limbs: limbs(&|limb| !found.placed()[limb]),
            unit: Some(found.unit()).filter(|unit| *unit != LengthUnit::METRE).map(LengthUnit::metres),
            residuals: found.residuals(),
            information: (0..information.nrows())
                .map(|i| (0..=i).map(|j| information[(i, j)]).collect())
                .collect(),
        }
    }

    fn observability(&self, creature: &Creature) -> Result<Observability, String> {
        let joint_names: Vec<&str> = creature.joints().iter().map(|joint| joint.name.as_str()).collect();
        let limb_names: Vec<&str> = creature.limbs().iter().map(String::as_str).collect();
        let joints = marks(&joint_names, &self.joints)?;
        let known = marks(&joint_names, &self.known)?;
        let posed = marks(&limb_names, &self.limb_poses)?;
        let unplaced = marks(&limb_names, &self.unplaced_limbs)?;
        let mut parameters = Parameters::new(creature, AxisModel::Unit, |joint| joints[joint]);
        if posed.contains(&true) {
            parameters = parameters.with_limb_poses(|joint| posed[joint + 1], None);
        }
        let unit = match self.unit {
            None => LengthUnit::METRE,
            Some(metres) => LengthUnit::from_metres(metres).ok_or_else(|| {
                format!("its account was learned in a unit of {metres} m, which is not a power of two suitable for a body: {MEND}")
            })?,
        };
        let (n, rows) = (parameters.len(), &self.information);
        if rows.len() != n || rows.iter().enumerate().any(|(i, row)| row.len() != i + 1) {
            return Err(format!(
                "its information matrix is not a lower triangle over {n} parameters: {MEND}"
            ));
        }
        // Information of two parameters together is at most the mean of that of each, which is not negative.
        let possible = |i: usize, j: usize| {
            let (x, [a, b]) = (rows[i][j], [i, j].map(|k| rows[k][k]));
            a >= 0.0 && x * x <= a * b * (1.0 + ROUNDING)
        };
        if let Some((i, j)) =
            (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).find(|&(i, j)| !possible(i, j))
        {
            let wrong = rows[i][j];
            return Err(format!(
                "its account has an impossible information of {wrong} for parameters {i} and {j}: {MEND}"
            ));
        }
        let information = DMatrix::from_fn(n, n, |i, j| rows[i.max(j)][i.min(j)]);
        let found = Observability::new(creature, parameters, &known, information, self.residuals, unit);
        Ok(found.with_placed(unplaced.into_iter().map(|unplaced| !unplaced).collect()))
    }
}

fn unknown_name(name: &str) -> String {
    format!("its account names \"{name}\", which the creature does not have: {MEND}")
}

/// Of each of `all` names whether it is among `some`.
fn marks(all: &[&str], some: &[String]) -> Result<Vec<bool>, String> {
    if let Some(name) = some.iter().find(|name| !all.contains(&name.as_str())) {
        return Err(unknown_name(name));
    }
    Ok(all.iter().map(|name| some.iter().any(|other| other == name)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creature::{Dof, DofKind, Joint};
    use crate::learning::Input;

    #[test]
    fn what_nothing_bounds_by_far_is_read_back_as_that() {
        let dof = Dof { name: "bend".into(), kind: DofKind::Hinge, range: [-1.0, 1.0], follows: None };
        let limbs = ["trunk", "arm"].map(String::from).to_vec();
        let creature =
            Creature::new("one arm".into(), limbs, vec![Joint::new("bend", 0, vec![dof])], Vec::new())
                .unwrap();
        for (distance, read) in [(1e71, f64::INFINITY), (0.25, 0.25), (f64::NAN, f64::INFINITY)] {
            let parameters = Parameters::new(&creature, AxisModel::Unit, |_| true);
            let information = DMatrix::zeros(parameters.len(), parameters.len());
            let found =
                Observability::new(&creature, parameters, &[false], information, 0, LengthUnit::METRE);
            let witnesses = Witnesses {
                of_limbs: vec![3, 3],
                made_of_limbs: vec![3, 4],
                point_deviation: 0.0,
                at_floor: false,
            };
            let distances = DMatrix::from_row_slice(2, 2, &[0.0, distance, distance, 0.0]);
            let account = Account::of_distances(&creature, found, vec![0, 1], distances, witnesses);
            let recorded = RecordedAccount {
                basis: Basis::points(Input::Receptor),
                deviation: Some(1e99),
                account: Some(account),
            };
            let again = AccountEntry::new(&recorded, &creature).account(&creature).unwrap();
            assert_eq!((again.deviation, again.account.unwrap().distance(0, 1)), (None, read));
        }
    }
}
