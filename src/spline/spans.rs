//! The basis functions of a cubic knot vector as polynomials on each span. With them a sum of
//! powers over the samples of a span becomes a sum over B-splines.

use super::KnotVector;

/// The pairs (a, c), a ≤ c, of the four basis functions on a span, ordered by the difference `c −
/// a`.
pub(crate) const PAIRS: [(usize, usize); 10] =
    [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (1, 2), (2, 3), (0, 2), (1, 3), (0, 3)];

/// Coefficients of a cubic, of the powers 1 to s³.
pub(crate) type Cubic = [f64; 4];

/// Coefficients of a product of two cubics, of the powers 1 to s⁶, followed by a zero.
pub(crate) type Sextic = [f64; 8];

/// One knot span. Its local parameter `s` runs from −1 to 1.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    middle: f64,
    half: f64,
    /// The four basis functions on the span as polynomials in s.
    pub basis: [Cubic; 4],
    /// The products of [`PAIRS`] as polynomials in s.
    pub products: [Sextic; 10],
}

impl Span {
    /// Span `[tᵢ, tᵢ₊₁)` of a cubic knot vector, where i = `number` + 3.
    fn new(knots: &KnotVector, number: usize) -> Self {
        let (low, high) = (knots.knots()[number + 3], knots.knots()[number + 4]);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut span = Span { middle, half, basis: [[0.0; 4]; 4], products: [[0.0; 8]; 10] };
        if half > 0.0 {
            span.basis = span.pieces(knots, number);
            span.products = products(&span.basis);
        }
        span
    }

    /// The polynomials to which the basis functions are equal on span `number`, extrapolated to
    /// this span and expressed in its s.
    pub(crate) fn pieces(&self, knots: &KnotVector, number: usize) -> [Cubic; 4] {
        let h = self.half;
        let [value, slope, bend] = knots.basis_in(number + 3, self.middle).derivative;
        let further = knots.basis_in(number + 3, self.middle + h).derivative[2];
        std::array::from_fn(|a| {
            let third = (further[a] - bend[a]) * h * h / 6.0;
            [value[a], slope[a] * h, 0.5 * bend[a] * h * h, third]
        })
    }

    /// The local parameter of parameter `t`.
    pub(crate) fn local(&self, t: f64) -> f64 {
        (t - self.middle) / self.half
    }

    /// Half the length of the span.
    pub(crate) fn half(&self) -> f64 {
        self.half
    }
}

/// The products of [`PAIRS`].
pub(crate) fn products(basis: &[Cubic; 4]) -> [Sextic; 10] {
    PAIRS.map(|(a, c)| {
        let mut product = [0.0; 8];
        for (i, x) in basis[a].iter().enumerate() {
            for (j, y) in basis[c].iter().enumerate() {
                product[i + j] += x * y;
            }
        }
        product
    })
}

/// The spans of a cubic knot vector with single inner knots. The span of a parameter is found in
/// constant time.
#[derive(Debug, Clone)]
pub(crate) struct KnotSpans {
    /// The spans. There are three fewer than basis functions.
    pub all: Vec<Span>,
    ends: Vec<f64>,
    low: f64,
    scale: f64,
    /// For each bucket of parameters, a span near them.
    buckets: Vec<u32>,
}

impl KnotSpans {
    /// All spans of `knots`.
    pub(crate) fn new(knots: &KnotVector) -> Self {
        let all: Vec<Span> = (0..knots.functions() - 3).map(|n| Span::new(knots, n)).collect();
        let (low, high) = knots.range();
        let count = 2 * all.len();
        let at = |b: usize| low + (high - low) * b as f64 / count as f64;
        KnotSpans {
            ends: knots.knots()[3..=knots.functions()].to_vec(),
            low,
            scale: count as f64 / (high - low),
            buckets: (0..count).map(|b| (knots.span(at(b)) - 3) as u32).collect(),
            all,
        }
    }

    /// The number of the span that contains `t`, which is that of [`KnotVector::span`] minus 3.
    pub(crate) fn find(&self, t: f64) -> usize {
        let bucket = ((t - self.low) * self.scale).max(0.0) as usize;
        let mut n = self.buckets[bucket.min(self.buckets.len() - 1)] as usize;
        while n + 1 < self.all.len() && self.ends[n + 1] <= t {
            n += 1;
        }
        while n > 0 && (self.ends[n] > t || self.ends[n] == self.ends[n + 1]) {
            n -= 1;
        }
        n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven() -> KnotVector {
        KnotVector::clamped(3, &[0.0, 0.01, 0.012, 0.4, 0.45, 1.0], 1)
    }

    #[test]
    fn spans_are_found_as_by_bisection() {
        let knots = uneven();
        let spans = KnotSpans::new(&knots);
        for i in -20..=1020 {
            let t = f64::from(i) / 1000.0;
            assert_eq!(spans.find(t) + 3, knots.span(t), "{t}");
        }
    }

    #[test]
    fn pieces_are_the_basis_functions_also_beyond_their_span() {
        let knots = uneven();
        let spans = KnotSpans::new(&knots);
        for (home, of) in [(2, 2), (3, 2), (1, 2)] {
            let span = &spans.all[home];
            let pieces = span.pieces(&knots, of);
            for s in [-1.0, -0.3, 0.6, 1.0] {
                let t = span.middle + s * span.half;
                let exact = knots.basis_in(of + 3, t).derivative[0];
                for (piece, exact) in pieces.iter().zip(exact) {
                    let value = piece.iter().rev().fold(0.0, |sum, c| sum * s + c);
                    assert!((value - exact).abs() < 1e-9 * exact.abs().max(1.0));
                }
            }
        }
    }
}
