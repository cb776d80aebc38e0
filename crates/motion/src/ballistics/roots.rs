//! Real roots of polynomials of low degree; brackets and minima.
//!
//! Between two neighbouring roots of p′ the polynomial p is monotonic, so a change of sign holds exactly one root, and
//! halving finds it. The roots of p′ come the same way, down to a constant. A root that p only touches is a root of p′
//! where p vanishes within rounding. Slower than a formula and without its cancellations.

use crate::error::Result;
use crate::limits::BISECTIONS_MAX;
use jounce_math::scalar::f64s::max;

/// Coefficients there is room for: degree 6.
const SIZE: usize = 7;

/// Real roots of Σ cᵢ xⁱ in [0, `end`], in rising order, each once.
pub(super) fn real_roots(coefficients: &[f64], end: f64) -> Vec<f64> {
    let mut c = [0.0; SIZE];
    for (to, from) in c.iter_mut().zip(coefficients) {
        *to = *from;
    }
    roots_of(&c, coefficients.len().min(SIZE), end)
}

fn roots_of(c: &[f64; SIZE], terms: usize, end: f64) -> Vec<f64> {
    if terms < 2 {
        return Vec::new();
    }
    let mut slope = [0.0; SIZE];
    for i in 1..terms {
        slope[i - 1] = c[i] * i as f64;
    }
    let mut bounds = vec![0.0];
    bounds.extend(roots_of(&slope, terms - 1, end));
    bounds.push(end);
    let mut roots: Vec<f64> = Vec::new();
    for pair in bounds.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (fa, fb) = (value(c, terms, a), value(c, terms, b));
        if touches(c, terms, a, fa) {
            add(&mut roots, a);
        } else if (fa < 0.0) != (fb < 0.0) && !touches(c, terms, b, fb) {
            add(&mut roots, bisect(a, b, fa < 0.0, |x| value(c, terms, x) < 0.0));
        }
    }
    let last = value(c, terms, end);
    if touches(c, terms, end, last) {
        add(&mut roots, end);
    }
    roots
}

fn add(roots: &mut Vec<f64>, x: f64) {
    let near = |y: &f64| (x - *y).abs() <= 1e-12 * max(x.abs(), y.abs());
    if !roots.last().is_some_and(near) {
        roots.push(x);
    }
}

/// The place between `a` and `b` where `below` turns from what it is at `a`.
pub(super) fn bisect(mut a: f64, mut b: f64, below_at_a: bool, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..BISECTIONS_MAX {
        let mid = 0.5 * (a + b);
        if mid <= a || mid >= b {
            break;
        }
        if below(mid) == below_at_a {
            a = mid;
        } else {
            b = mid;
        }
    }
    0.5 * (a + b)
}

/// Golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// The place between `a` and `b` where `f` is least, to about 1e-8 of the interval.
pub(super) fn golden(mut a: f64, mut b: f64, f: impl Fn(f64) -> Result<f64>) -> Result<f64> {
    let (mut x, mut y) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut fx, mut fy) = (f(x)?, f(y)?);
    for _ in 0..40 {
        if fx <= fy {
            (b, y, fy) = (y, x, fx);
            x = b - GOLDEN * (b - a);
            fx = f(x)?;
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + GOLDEN * (b - a);
            fy = f(y)?;
        }
    }
    Ok(if fx <= fy { x } else { y })
}

fn value(c: &[f64; SIZE], terms: usize, x: f64) -> f64 {
    c[..terms].iter().rev().fold(0.0, |s, c| s * x + c)
}

/// True where p(x) is zero within the rounding of its terms.
fn touches(c: &[f64; SIZE], terms: usize, x: f64, p: f64) -> bool {
    let size = c[..terms].iter().rev().fold(0.0, |s, c| s * x.abs() + c.abs());
    p.abs() <= 8.0 * f64::EPSILON * size
}

#[cfg(test)]
mod tests {
    use super::real_roots;

    fn close(got: &[f64], expected: &[f64]) {
        assert_eq!(got.len(), expected.len(), "{got:?} against {expected:?}");
        for (g, e) in got.iter().zip(expected) {
            assert!((g - e).abs() < 1e-7 * (1.0 + e), "{got:?} against {expected:?}");
        }
    }

    #[test]
    fn roots_simple_double_and_none() {
        // (x − 1)(x − 2)(x − 3)(x − 4)
        close(&real_roots(&[24.0, -50.0, 35.0, -10.0, 1.0], 10.0), &[1.0, 2.0, 3.0, 4.0]);
        // (x − 2)² (x² + 1)
        close(&real_roots(&[4.0, -4.0, 5.0, -4.0, 1.0], 10.0), &[2.0]);
        close(&real_roots(&[1.0, 0.0, 1.0], 10.0), &[]);
        close(&real_roots(&[-6.0, 2.0, 0.0, 0.0], 10.0), &[3.0]);
        close(&real_roots(&[5.0], 10.0), &[]);
        // Only within the range, its ends included.
        close(&real_roots(&[0.0, -10.0, 1.0], 10.0), &[0.0, 10.0]);
        // Far apart: (x − 1e-6)(x − 1e6).
        let far = real_roots(&[1.0, -1_000_000.000_001, 1.0], 1e9);
        assert!((far[0] * 1e6 - 1.0).abs() < 1e-9 && (far[1] / 1e6 - 1.0).abs() < 1e-9, "{far:?}");
    }
}
