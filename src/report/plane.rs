//! A drawing of the parameter plane as SVG: knot lines and trim loops.

use std::fmt::Write;

use crate::convert::SurfaceFit;
use crate::geometry::Uv;

/// Units of the drawing for the longer side.
const SIDE: f64 = 1000.0;

/// The parameter plane of a face.
#[derive(Debug)]
pub(crate) struct PlaneDrawing {
    width: f64,
    height: f64,
    /// The knot lines as one path, and their number.
    knots: (String, usize),
    /// The boundary of the face as one path.
    cut: String,
    /// The path of each loop, with the number of its hole, and whether it is that of an island.
    loops: Vec<(String, Option<usize>, bool)>,
}

impl PlaneDrawing {
    /// The drawing of a surface. `outlines` are its loops as polygons.
    pub(super) fn of(c: &SurfaceFit, outlines: &[Vec<Uv>]) -> Self {
        let ((u0, u1), (v0, v1)) = (c.surface.u.range(), c.surface.v.range());
        // The proportion of the patch on the scan, but no narrower than 1 to 4.
        let aspect = c.parameterize.stretch.aspect;
        let aspect = if aspect.is_finite() { aspect.clamp(0.25, 4.0) } else { 1.0 };
        let (width, height) =
            if aspect > 1.0 { (SIDE, SIDE / aspect) } else { (SIDE * aspect, SIDE) };
        let x = |u: f64| (u - u0) / (u1 - u0) * width;
        let y = |v: f64| height - (v - v0) / (v1 - v0) * height;
        let (us, vs) = (c.surface.u.breaks(), c.surface.v.breaks());
        let mut lines = String::new();
        for &u in &us {
            let _ = write!(lines, "M{0:.1} 0V{height:.1}", x(u));
        }
        for &v in &vs {
            let _ = write!(lines, "M0 {:.1}H{width:.1}", y(v));
        }
        let sides = format!("M0 0H{width:.1}V{height:.1}H0Z");
        let drawn = |(ring, outline): (&crate::stages::trim::TrimLoop, &Vec<Uv>)| {
            (path(outline, x, y), ring.of.hole(), ring.of.island().is_some())
        };
        let loops: Vec<_> = c.loops.iter().zip(outlines).map(drawn).collect();
        let mut cut = c.outer.map_or(String::new(), |_| sides);
        loops.iter().for_each(|(path, ..)| cut += path);
        PlaneDrawing { width, height, knots: (lines, us.len() + vs.len()), cut, loops }
    }

    /// The drawing as SVG; `number` makes the names of its loops unique.
    pub(crate) fn svg(&self, number: usize) -> String {
        let PlaneDrawing { width, height, knots: (lines, count), cut, .. } = self;
        // Many lines are drawn fainter than few.
        let faint = (24.0 / *count as f64).clamp(0.15, 0.6);
        let mut loops = String::new();
        for (path, hole, is_island) in &self.loops {
            let island = if *is_island { " island" } else { "" };
            let hole = hole.map(|hole| format!(r#" data-hole="{number}-{hole}""#));
            let hole = hole.unwrap_or_default();
            let _ = write!(loops, r#"<path class="loop{island}"{hole} d="{path}"/>"#);
        }
        format!(
            r#"<svg class="plane" viewBox="-6 -6 {:.1} {:.1}" role="img" aria-label="The parameter plane with knot lines and trim loops"><path class="face" fill-rule="evenodd" d="{cut}"/><path class="knots" opacity="{faint:.2}" d="{lines}"/>{loops}<rect class="sides" width="{width:.1}" height="{height:.1}"/></svg>"#,
            width + 12.0,
            height + 12.0,
        )
    }
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
