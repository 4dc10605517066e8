//! A drawing of the parameter plane as SVG: knot lines and trim loops.

use std::fmt::Write;

use crate::Conversion;
use crate::geometry::Uv;

use super::FaceView;

/// Units of the drawing for the longer side.
const SIDE: f64 = 1000.0;

/// The drawing of one part; `number` makes its loops' names unique.
pub fn svg(number: usize, c: &Conversion, shown: &FaceView) -> String {
    let ((u0, u1), (v0, v1)) = (c.surface.u.range(), c.surface.v.range());
    // The proportion of the patch on the scan, but no narrower than 1 to 4.
    let aspect = c.parameterize.stretch.aspect;
    let aspect = if aspect.is_finite() { aspect.clamp(0.25, 4.0) } else { 1.0 };
    let (width, height) = if aspect > 1.0 { (SIDE, SIDE / aspect) } else { (SIDE * aspect, SIDE) };
    let x = |u: f64| (u - u0) / (u1 - u0) * width;
    let y = |v: f64| height - (v - v0) / (v1 - v0) * height;
    let mut lines = String::new();
    for u in c.surface.u.breaks() {
        let _ = write!(lines, "M{0:.1} 0V{height:.1}", x(u));
    }
    for v in c.surface.v.breaks() {
        let _ = write!(lines, "M0 {:.1}H{width:.1}", y(v));
    }
    // Many lines are drawn fainter than few.
    let faint = (24.0 / lines.matches('M').count() as f64).clamp(0.15, 0.6);
    let mut loops = String::new();
    let sides = format!("M0 0H{width:.1}V{height:.1}H0Z");
    let mut cut = c.outer.map_or(String::new(), |_| sides);
    for (ring, outline) in c.loops.iter().zip(&shown.outlines) {
        let path = path(outline, x, y);
        let island = if ring.of.island().is_some() { " island" } else { "" };
        let hole = ring.of.hole().map(|hole| format!(r#" data-hole="{number}-{hole}""#));
        let hole = hole.unwrap_or_default();
        let _ = write!(loops, r#"<path class="loop{island}"{hole} d="{path}"/>"#);
        cut += &path;
    }
    format!(
        r#"<svg class="plane" viewBox="-6 -6 {:.1} {:.1}" role="img" aria-label="The parameter plane with knot lines and trim loops"><path class="face" fill-rule="evenodd" d="{cut}"/><path class="knots" opacity="{faint:.2}" d="{lines}"/>{loops}<rect class="sides" width="{width:.1}" height="{height:.1}"/></svg>"#,
        width + 12.0,
        height + 12.0,
    )
}

fn path(outline: &[Uv], x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64) -> String {
    let mut path = String::new();
    let mut last = String::new();
    for (k, p) in outline.iter().enumerate() {
        let at = format!("{:.1} {:.1}", x(p.x), y(p.y));
        if at != last {
            path += if k == 0 { "M" } else { "L" };
            path += &at;
            last = at;
        }
    }
    path + "Z"
}
