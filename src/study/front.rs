//! The Pareto front.

/// The points that no other beats, from the fastest to the most accurate.
///
/// A point is its time and its error. It is beaten by one that is no worse in either and better in one;
/// of equal points the first stays. Points that are not finite do not count.
#[must_use]
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let finite = |i: &usize| points[*i].0.is_finite() && points[*i].1.is_finite();
    let mut order: Vec<usize> = (0..points.len()).filter(finite).collect();
    // The sort is stable: equal points keep their order.
    order.sort_by(|a, b| {
        let ((time_a, error_a), (time_b, error_b)) = (points[*a], points[*b]);
        time_a.total_cmp(&time_b).then(error_a.total_cmp(&error_b))
    });
    let mut least = f64::INFINITY;
    order.retain(|i| {
        let better = points[*i].1 < least;
        least = least.min(points[*i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_no_other_beats() {
        let points = [(3.0, 0.1), (1.0, 0.5), (2.0, 0.6), (4.0, 0.1), (2.0, 0.3)];
        assert_eq!(front(&points), [1, 4, 0]);
    }

    #[test]
    fn equal_points_count_once_and_odd_ones_not_at_all() {
        let nan = f64::NAN;
        let points = [(nan, 0.0), (1.0, 0.2), (1.0, 0.2), (0.5, nan), (1.0, 0.1)];
        assert_eq!(front(&points), [4]);
        assert_eq!(front(&[(1.0, 0.2), (1.0, 0.2)]), [0]);
        assert_eq!(front(&[]), [0; 0]);
    }
}
