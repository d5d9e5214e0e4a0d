//! How sure a learned schema is, so that whoever opens the session knows it as the learner did.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::creature::Creature;
use crate::learning::observability::Observability;
use crate::learning::{AxisModel, Basis, Learned, Parameters};
use crate::record::error::ContentFault;

/// What a learner knows of how good its schema is.
#[derive(Clone, Debug)]
pub struct Account {
    /// With what it was learned.
    pub basis: Basis,
    /// Standard deviation of what the learner compares, as the touches themselves show it, metres; none where it
    /// cannot tell.
    pub deviation: Option<f64>,
    /// What the touches determine and how well; none where the learner cannot tell.
    pub observability: Option<Observability>,
}

impl Account {
    /// The account that a learner gives.
    pub fn of(learned: &Learned) -> Account {
        Account {
            basis: learned.basis,
            deviation: learned.deviation,
            observability: learned.observability.clone(),
        }
    }
}

/// An account as it is written.
#[derive(Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct AccountEntry {
    basis: Basis,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    touch_deviation: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    determined: Option<DeterminedEntry>,
}

/// What touches determine, as it is written: the information that they hold, from which all else follows.
#[derive(Serialize, Deserialize)]
#[serde(expecting = "an object")]
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
    /// The number of residuals that the information is of.
    residuals: usize,
    /// Its lower triangle, row by row.
    information: Vec<Vec<f64>>,
}

const MEND: &str = "learn again with `bodyschema learn`";

impl AccountEntry {
    /// The account by names; without what touches determine where a number of it is not finite.
    pub fn new(account: &Account, creature: &Creature) -> AccountEntry {
        let finite = |found: &&Observability| found.information().iter().all(|x| x.is_finite());
        AccountEntry {
            basis: account.basis,
            touch_deviation: account.deviation.filter(|deviation| deviation.is_finite()),
            determined: account
                .observability
                .as_ref()
                .filter(finite)
                .map(|found| DeterminedEntry::new(found, creature)),
        }
    }

    /// The account, of a creature.
    ///
    /// # Errors
    /// A sentence where it is of another creature.
    pub fn account(&self, creature: &Creature) -> Result<Account, ContentFault> {
        let observability =
            self.determined.as_ref().map(|found| found.observability(creature)).transpose()?;
        Ok(Account { basis: self.basis, deviation: self.touch_deviation, observability })
    }
}

impl DeterminedEntry {
    fn new(found: &Observability, creature: &Creature) -> DeterminedEntry {
        let (joints, limbs) = (creature.joints(), creature.limbs());
        let named = |holds: &dyn Fn(usize) -> bool| {
            let held = joints.iter().enumerate().filter(|(joint, _)| holds(*joint));
            held.map(|(_, joint)| joint.name.clone()).collect()
        };
        let parameters = &found.parameters;
        let posed = |joint: &usize| parameters.limb_origins[*joint].is_some();
        let information = found.information();
        DeterminedEntry {
            joints: named(&|joint| parameters.positions[joint].is_some()),
            limb_poses: (0..joints.len()).filter(posed).map(|joint| limbs[joint + 1].clone()).collect(),
            known: named(&|joint| found.known()[joint]),
            unplaced_limbs: limbs
                .iter()
                .zip(found.placed())
                .filter(|(_, placed)| !**placed)
                .map(|(limb, _)| limb.clone())
                .collect(),
            residuals: found.residuals(),
            information: (0..information.nrows())
                .map(|i| (0..=i).map(|j| information[(i, j)]).collect())
                .collect(),
        }
    }

    fn observability(&self, creature: &Creature) -> Result<Observability, ContentFault> {
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
        let n = parameters.len();
        if self.information.len() != n
            || self.information.iter().enumerate().any(|(i, row)| row.len() != i + 1)
        {
            return Err(
                format!("its information is not the lower triangle over {n} parameters: {MEND}").into()
            );
        }
        let information = DMatrix::from_fn(n, n, |i, j| self.information[i.max(j)][i.min(j)]);
        let found = Observability::new(creature, parameters, &known, information, self.residuals);
        Ok(found.with_placed(unplaced.into_iter().map(|unplaced| !unplaced).collect()))
    }
}

/// Of each of `all` names whether it is among `some`.
fn marks(all: &[&str], some: &[String]) -> Result<Vec<bool>, ContentFault> {
    if let Some(name) = some.iter().find(|name| !all.contains(&name.as_str())) {
        return Err(format!("its account names \"{name}\", which the creature does not have: {MEND}").into());
    }
    Ok(all.iter().map(|name| some.iter().any(|other| other == name)).collect())
}
