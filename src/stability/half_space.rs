//! Reflection by a half space that scatters evenly `[Chandrasekhar1960]`.

/// Nodes of the quadrature.
const NODES: usize = 512;

/// The H-function: `1 / H(mu) = sqrt(1 - albedo) + albedo / 2 int_0^1 x H(x) / (x + mu) dx`.
///
/// Light of irradiance E that falls in at cosine m0 leaves at cosine m with radiance
/// `albedo E / (4 pi) m0 / (m + m0) H(m) H(m0)`.
pub(super) fn h(mu: f64, albedo: f64) -> f64 {
    let node = |i: usize| (i as f64 + 0.5) / NODES as f64;
    let mut h = vec![1.0; NODES];
    let at = |h: &[f64], mu: f64| {
        let terms = h
            .iter()
            .enumerate()
            .map(|(i, h)| h * node(i) / (mu + node(i)));
        let sum = terms.sum::<f64>() / NODES as f64;
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * sum)
    };
    for _ in 0..60 {
        // The geometric mean: where nothing is absorbed the plain iteration swings for ever.
        let next = |i: usize| (h[i] * at(&h, node(i))).sqrt();
        h = (0..NODES).map(next).collect();
    }
    at(&h, mu)
}

#[cfg(test)]
mod tests {
    use super::h;

    #[test]
    fn the_h_function_has_its_tabulated_values() {
        // [Chandrasekhar1960, table XI].
        for (albedo, mu, expected) in [(1.0, 1.0, 2.9078), (1.0, 0.5, 2.0128), (0.0, 0.7, 1.0)] {
            let found = h(mu, albedo);
            assert!((found - expected).abs() < 1e-3, "{albedo} {mu}: {found}");
        }
    }
}
