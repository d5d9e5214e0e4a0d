//! Who met whom, where several contacts were felt at once.

/// So many contacts of a side are assigned exactly; of more, the closest first.
const EXACTLY: usize = 8;

/// The assignment of `a` contacts to `b` others, as many as there are of the fewer, of least total cost.
pub fn assigned(a: usize, b: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<[usize; 2]> {
    if a > b {
        return fewer_first(b, a, |j, i| cost(i, j)).into_iter().map(|[j, i]| [i, j]).collect();
    }
    fewer_first(a, b, cost)
}

fn fewer_first(a: usize, b: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<[usize; 2]> {
    if b <= EXACTLY { exactly(a, b, cost) } else { closest_first(a, b, cost) }
}

/// By the least costs of the first contacts for every set of others that they may be assigned to.
fn exactly(a: usize, b: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<[usize; 2]> {
    let sets = 1usize << b;
    let mut least = vec![f64::INFINITY; sets];
    let mut last = vec![vec![usize::MAX; sets]; a];
    least[0] = 0.0;
    for (i, last) in last.iter_mut().enumerate() {
        let mut next = vec![f64::INFINITY; sets];
        for set in (0..sets).filter(|set| set.count_ones() as usize == i) {
            for j in (0..b).filter(|j| set & (1 << j) == 0) {
                let (with, sum) = (set | 1 << j, least[set] + cost(i, j));
                if sum < next[with] {
                    next[with] = sum;
                    last[with] = j;
                }
            }
        }
        least = next;
    }
    let mut set = (0..sets).min_by(|x, y| least[*x].total_cmp(&least[*y])).unwrap_or(0);
    let mut pairs = Vec::with_capacity(a);
    for i in (0..a).rev() {
        let j = last[i][set];
        if j == usize::MAX {
            return closest_first(a, b, cost);
        }
        pairs.push([i, j]);
        set &= !(1 << j);
    }
    pairs.reverse();
    pairs
}

fn closest_first(a: usize, b: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<[usize; 2]> {
    let mut all: Vec<(f64, usize, usize)> =
        (0..a).flat_map(|i| (0..b).map(move |j| (i, j))).map(|(i, j)| (cost(i, j), i, j)).collect();
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    let (mut used_a, mut used_b) = (vec![false; a], vec![false; b]);
    let mut pairs = Vec::new();
    for (_, i, j) in all {
        if !used_a[i] && !used_b[j] {
            (used_a[i], used_b[j]) = (true, true);
            pairs.push([i, j]);
        }
    }
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
        assert_eq!(assigned(2, 3, cost), [[0, 1], [1, 0]]);
        assert_eq!(assigned(3, 2, |j, i| cost(i, j)), [[1, 0], [0, 1]]);
        assert_eq!(closest_first(2, 3, cost), [[0, 0], [1, 1]]);
    }
}
