//! Which pairs of limbs can meet soon: a broad phase, for bodies of very many limbs.
//!
//! About each cluster lies a ball that grows as fast as any of its points can move. While two such balls are apart, so are
//! their clusters. Balls are swept along the axis on which they are spread most.

use super::sorted;
use crate::geometry::Ball;

/// Hands on every two balls that come within `margin` of each other, metres, when each grows by its `growth`; the
/// lesser number first, in any order.
pub(super) fn near_pairs(balls: &[Ball], growth: &[f64], margin: f64, mut found: impl FnMut([usize; 2])) {
    let grown = |k: usize| balls[k].radius + growth[k] + 0.5 * margin;
    let axis = widest_axis(balls);
    // The ends of each ball's shadow on the axis, and its number; in the order of the lower ends.
    let shadow = |(k, ball): (usize, &Ball)| {
        let (middle, half) = (ball.centre[axis], grown(k));
        (middle - half, middle + half, k)
    };
    let mut shadows: Vec<(f64, f64, usize)> = balls.iter().enumerate().map(shadow).collect();
    shadows.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    for (n, &(_, end, first)) in shadows.iter().enumerate() {
        for &(_, _, second) in shadows[n + 1..].iter().take_while(|(start, ..)| *start <= end) {
            let reach = grown(first) + grown(second);
            if (balls[first].centre - balls[second].centre).norm_squared() <= reach * reach {
                found(sorted([first, second]));
            }
        }
    }
}

/// The axis on which the centres are spread most.
fn widest_axis(balls: &[Ball]) -> usize {
    let count = balls.len().max(1) as f64;
    let mean = balls.iter().map(|ball| ball.centre).sum::<nalgebra::Vector3<f64>>() / count;
    let spread = balls.iter().map(|ball| (ball.centre - mean).map(|x| x * x)).sum::<nalgebra::Vector3<f64>>();
    spread.imax()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn sweeping_finds_what_looking_at_all_pairs_finds() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for count in [0, 1, 2, 40, 200] {
            let balls: Vec<Ball> = (0..count)
                .map(|_| Ball {
                    centre: Vector3::from_fn(|axis, _| rng.random_range(-1.0..1.0) * [0.3, 2.0, 1.0][axis]),
                    radius: rng.random_range(0.0..0.2),
                })
                .collect();
            let growth: Vec<f64> = (0..count).map(|_| rng.random_range(0.0..0.3)).collect();
            let margin = 0.05;
            let near = |i: usize, j: usize| {
                let apart = (balls[i].centre - balls[j].centre).norm() - balls[i].radius - balls[j].radius;
                apart <= growth[i] + growth[j] + margin
            };
            let all: Vec<[usize; 2]> = (0..count)
                .flat_map(|i| (i + 1..count).map(move |j| [i, j]))
                .filter(|&[i, j]| near(i, j))
                .collect();
            let mut found = Vec::new();
            near_pairs(&balls, &growth, margin, |pair| found.push(pair));
            found.sort_unstable();
            assert_eq!(found, all);
        }
    }
}
