//! The triangulation of a ring by dynamic programming (Barequet & Sharir 1995, "Filling gaps in the boundary of a
//! polyhedron"): of all triangulations that with the least area off given surfaces, and of these the one with the least area.

/// Triangles, each with the surface that has it.
pub(super) type Triangulation<Corner> = Vec<([Corner; 3], Option<usize>)>;

/// The best triangulation of the part of a ring between two corners.
#[derive(Clone, Copy)]
struct RingPart {
    /// The area off the surfaces, and all of it.
    cost: [f64; 2],
    apex: usize,
    home: Option<usize>,
}

const IMPOSSIBLE: RingPart = RingPart { cost: [f64::INFINITY; 2], apex: 0, home: None };

fn is_less(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0] < b[0] || (a[0] == b[0] && a[1] < b[1])
}

/// Triangulates a ring of corners. `joined` says whether two corners have an edge already, `area` measures a triangle, and
/// `home` tells the surface that has it. Nothing is returned if there is no triangulation without such an edge.
pub(super) fn triangulated(
    corners: usize,
    joined: impl Fn(usize, usize) -> bool,
    area: impl Fn([usize; 3]) -> f64,
    home: impl Fn([usize; 3]) -> Option<usize>,
) -> Triangulation<usize> {
    let n = corners;
    let mut best = vec![IMPOSSIBLE; n * n];
    (1..n).for_each(|j| best[(j - 1) * n + j].cost = [0.0; 2]);
    for (i, j) in (2..n).flat_map(|gap| (0..n - gap).map(move |i| (i, i + gap))) {
        if (i, j) != (0, n - 1) && joined(i, j) {
            continue;
        }
        for k in i + 1..j {
            let (left, right) = (best[i * n + k].cost, best[k * n + j].cost);
            if left[0] + right[0] > best[i * n + j].cost[0] {
                continue;
            }
            let (own, home) = (area([i, k, j]), home([i, k, j]));
            let off = if home.is_none() { own } else { 0.0 };
            let cost = [left[0] + right[0] + off, left[1] + right[1] + own];
            if is_less(cost, best[i * n + j].cost) {
                best[i * n + j] = RingPart { cost, apex: k, home };
            }
        }
    }
    let mut made = Vec::with_capacity(n);
    let mut open = vec![(0, n - 1)];
    while let Some((i, j)) = open.pop() {
        if j - i < 2 {
            continue;
        }
        let RingPart { cost, apex, home } = best[i * n + j];
        if !cost[0].is_finite() {
            return Vec::new();
        }
        made.push(([i, apex, j], home));
        open.extend([(i, apex), (apex, j)]);
    }
    made
}
