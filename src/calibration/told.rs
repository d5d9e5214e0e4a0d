//! What touches tell of a robot, and what they leave open: covariances, and parameters that nothing tells apart.

use std::collections::BTreeSet;

use nalgebra::DMatrix;

use super::robot::Robot;
use super::unknowns::Unknowns;

/// Least share of a parameter's information that is its own, not that of others together: below it is rounding.
const OWN_SHARE: f64 = 1e-12;
/// Least part that a parameter has in what cannot be told, of the greatest part of any.
const LEAST_PART: f64 = 1e-4;

/// What is told, and what is not.
#[derive(Clone, Debug)]
pub struct Told {
    /// The parameters' covariance, in their own units. Of what is not told apart only as much as it takes is given, the rest
    /// held: predictions do not depend on which.
    pub covariance: DMatrix<f64>,
    /// Parameters that cannot be told apart: of each way in which all of them change together and nothing is felt of it, the
    /// parameters.
    pub ties: Vec<Vec<usize>>,
    /// Of every tie a parameter that is as any when the others are as they can be for it.
    pub dependent: Vec<usize>,
}

/// Quantities that touches do not tell apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Untold {
    /// Their names.
    pub names: Vec<String>,
    /// In how many ways they can change together and nothing is felt of it.
    pub ways: usize,
}

impl Told {
    /// Of the information about parameters, symmetric. Found by Cholesky's factors with pivots: what a parameter adds to
    /// those before it is its own; one that adds nothing is a combination of them, and they are tied.
    pub fn by(information: &DMatrix<f64>) -> Told {
        Told::above(information, OWN_SHARE)
    }

    /// The same, with the least share of its information that a parameter must have of its own.
    pub fn above(information: &DMatrix<f64>, own_share: f64) -> Told {
        let n = information.nrows();
        let scale: Vec<f64> = (0..n).map(|i| information[(i, i)].max(0.0).sqrt()).collect();
        let (mut order, mut dependent): (Vec<usize>, Vec<usize>) = (0..n).partition(|i| scale[*i] > 0.0);
        let mut ties: Vec<Vec<usize>> = dependent.iter().map(|i| vec![*i]).collect();
        let m = order.len();
        let mut left = DMatrix::from_fn(m, m, |i, j| {
            information[(order[i], order[j])] / (scale[order[i]] * scale[order[j]])
        });
        let mut rank = 0;
        while rank < m {
            let best = (rank..m).max_by(|a, b| left[(*a, *a)].total_cmp(&left[(*b, *b)])).unwrap_or(rank);
            if left[(best, best)] < own_share * m as f64 {
                break;
            }
            left.swap_rows(rank, best);
            left.swap_columns(rank, best);
            order.swap(rank, best);
            let root = left[(rank, rank)].sqrt();
            left[(rank, rank)] = root;
            let (next, others) = (rank + 1, m - rank - 1);
            let own = left.column(rank).rows(next, others) / root;
            left.view_mut((next, next), (others, others)).ger(-1.0, &own, &own, 1.0);
            left.column_mut(rank).rows_mut(next, others).copy_from(&own);
            rank = next;
        }
        dependent.extend(&order[rank..]);
        let factor = left.view((0, 0), (rank, rank)).lower_triangle();
        let mut covariance = DMatrix::zeros(n, n);
        if let Some(inverse) = factor.solve_lower_triangular(&DMatrix::identity(rank, rank)) {
            let block = inverse.tr_mul(&inverse);
            for (i, j) in (0..rank).flat_map(|i| (0..rank).map(move |j| (i, j))) {
                covariance[(order[i], order[j])] = block[(i, j)] / (scale[order[i]] * scale[order[j]]);
            }
            for i in rank..m {
                // What it is a combination of.
                let parts = inverse.tr_mul(&left.view((i, 0), (1, rank)).transpose());
                let tied = (0..rank).filter(|k| parts[*k].abs() > LEAST_PART * parts.amax());
                let mut tie: Vec<usize> = tied.map(|k| order[k]).chain([order[i]]).collect();
                tie.sort_unstable();
                ties.push(tie);
            }
        }
        Told { covariance, ties, dependent }
    }

    /// Whether a parameter is told by itself.
    pub fn is_told(&self, place: usize) -> bool {
        !self.ties.iter().any(|tie| tie.contains(&place))
    }

    /// The standard deviation of a parameter; infinite where it is not told.
    pub fn deviation(&self, place: usize) -> f64 {
        if self.is_told(place) { self.covariance[(place, place)].max(0.0).sqrt() } else { f64::INFINITY }
    }

    /// How much two parameters are known together: from −1 to 1.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let scale = (self.covariance[(i, i)] * self.covariance[(j, j)]).sqrt();
        if scale > 0.0 { self.covariance[(i, j)] / scale } else { 0.0 }
    }

    /// Confounded and unobservable quantities by name, and the number of directions in which they are.
    /// Ties that share a quantity are one.
    pub fn untold(&self, robot: &Robot, unknowns: &Unknowns) -> Vec<Untold> {
        let mut groups: Vec<(BTreeSet<usize>, usize)> = Vec::new();
        for tie in &self.ties {
            let mut quantities: BTreeSet<usize> =
                tie.iter().map(|place| unknowns.parameters[*place].0).collect();
            let mut ways = 1;
            groups.retain(|(others, count)| {
                let apart = others.is_disjoint(&quantities);
                if !apart {
                    quantities.extend(others);
                    ways += count;
                }
                apart
            });
            groups.push((quantities, ways));
        }
        let named = |(quantities, ways): (BTreeSet<usize>, usize)| Untold {
            names: quantities.iter().map(|q| robot.quantities[*q].name.clone()).collect(),
            ways,
        };
        let mut found: Vec<Untold> = groups.into_iter().map(named).collect();
        found.sort_by(|a, b| (a.names.len() == 1, &a.names).cmp(&(b.names.len() == 1, &b.names)));
        found
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    /// Two numbers felt only as a sum, one alone, and one not at all.
    #[test]
    fn what_is_felt_only_as_a_sum_is_tied() {
        let mut information = DMatrix::zeros(4, 4);
        for row in [[1.0, 2.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0]] {
            let row = DVector::from_row_slice(&row);
            information.ger(1.0, &row, &row, 1.0);
        }
        let told = Told::by(&information);
        assert_eq!(told.ties.len(), 2);
        assert!(told.ties.contains(&vec![0, 1]) && told.ties.contains(&vec![3]));
        assert!((told.deviation(2) - 1.0 / 3.0).abs() < 1e-12);
        // The sum itself is known: its variance is 1 whichever of the two is held.
        let sum = DVector::from_row_slice(&[1.0, 2.0, 0.0, 0.0]);
        assert!((sum.dot(&(&told.covariance * &sum)) - 1.0).abs() < 1e-12);
    }
}
