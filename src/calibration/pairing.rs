//! Who met whom, where several contacts were felt at once.

/// The assignment of `a` contacts to `b` others, as many as there are of the fewer, of least total cost: by shortest augmenting
/// paths (Jonker and Volgenant, "A Shortest Augmenting Path Algorithm for Dense and Sparse Linear Assignment Problems", 1987).
pub fn assigned(a: usize, b: usize, cost: &dyn Fn(usize, usize) -> f64) -> Vec<[usize; 2]> {
    if a > b {
        return assigned(b, a, &|j, i| cost(i, j)).into_iter().map(|[j, i]| [i, j]).collect();
    }
    // Prices of either side, and whom each of the others has: 0 is nobody, and the column where a path begins.
    let (mut of_rows, mut of_columns) = (vec![0.0; a + 1], vec![0.0; b + 1]);
    let mut row_of = vec![0; b + 1];
    for row in 1..=a {
        row_of[0] = row;
        let (mut least, mut before, mut reached) =
            (vec![f64::INFINITY; b + 1], vec![0; b + 1], vec![false; b + 1]);
        let mut at = 0;
        while row_of[at] != 0 {
            reached[at] = true;
            let (from, own) = (at, row_of[at]);
            let mut step = f64::INFINITY;
            for column in (1..=b).filter(|column| !reached[*column]) {
                let dear = cost(own - 1, column - 1) - of_rows[own] - of_columns[column];
                if dear < least[column] {
                    (least[column], before[column]) = (dear, from);
                }
                if least[column] < step || at == from {
                    (step, at) = (least[column], column);
                }
            }
            for column in 0..=b {
                if reached[column] {
                    of_rows[row_of[column]] += step;
                    of_columns[column] -= step;
                } else {
                    least[column] -= step;
                }
            }
        }
        while at != 0 {
            row_of[at] = row_of[before[at]];
            at = before[at];
        }
    }
    let mut pairs: Vec<[usize; 2]> = (1..=b)
        .filter(|column| row_of[*column] != 0)
        .map(|column| [row_of[column] - 1, column - 1])
        .collect();
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_total_is_found_where_the_closest_first_is_not() {
        // The closest pair of all, 0 and 0, leaves 1 a costly one.
        let costs = [[1.0, 2.0, 9.0], [1.5, 8.0, 9.0]];
        let cost = |i: usize, j: usize| costs[i][j];
        assert_eq!(assigned(2, 3, &cost), [[0, 1], [1, 0]]);
        assert_eq!(assigned(3, 2, &|j, i| cost(i, j)), [[1, 0], [0, 1]]);
        assert_eq!(assigned(1, 1, &|_, _| f64::INFINITY), [[0, 0]]);
    }
}
