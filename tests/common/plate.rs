//! A plate with a bore.

/// A plate of 60 × 40 × 8 with a bore through its middle, whose rim has 32 corners from the x axis on. The wall of the bore is
/// in the last 32 polygons.
pub fn plate(rim: &[[f64; 2]]) -> Vec<Vec<[f64; 3]>> {
    let corners = [[30.0, 20.0], [-30.0, 20.0], [-30.0, -20.0], [30.0, -20.0]];
    let mut all = Vec::new();
    let mut flat = |polygon: &[[f64; 2]]| {
        all.push(polygon.iter().map(|p| [p[0], p[1], 8.0]).collect());
        all.push(polygon.iter().rev().map(|p| [p[0], p[1], 0.0]).collect());
    };
    for k in 0..32 {
        flat(&[corners[k / 8], rim[(k + 1) % 32], rim[k]]);
        if k % 8 == 7 {
            flat(&[corners[k / 8], corners[(k / 8 + 1) % 4], rim[(k + 1) % 32]]);
        }
    }
    let mut wall = |p: [f64; 2], q: [f64; 2]| {
        all.push(vec![[p[0], p[1], 0.0], [q[0], q[1], 0.0], [q[0], q[1], 8.0], [p[0], p[1], 8.0]]);
    };
    (0..4).for_each(|k| wall(corners[k], corners[(k + 1) % 4]));
    (0..32).for_each(|k| wall(rim[(k + 1) % 32], rim[k]));
    all
}
