//! The shape of a fill. The front's points are extrapolated ring by ring, and
//! go astray in wide holes; here all are placed on the one surface that the
//! band of points around the hole makes likely.

use std::cell::RefCell;
use std::collections::HashMap;

use super::band::{self, Measured};
use super::develop::develop;
use super::front::{Fill, Hole, Lead, Surroundings};
use super::outlines::Outlines;
use super::sheet::Sheet;
use super::smoothing_spline::{Held, SmoothingSpline};
use crate::geometry::{LocalPlane, Point, Uv, Vector, VertexId};
use crate::mesh::remesh::Sizes;
use crate::mesh::{boundary, outline};

/// Cells of the spline across a hole's half width: enough for its bends …
const ACROSS_HOLE: f64 = 3.5;

/// … and across the band, from which it knows them.
const ACROSS_BAND: f64 = 3.0;

/// Nor are they narrower than this many edges, or distances between points.
const NARROWEST: f64 = 2.0;

/// The steepest slope, as the cosine of its angle, of a surface that is seen as
/// a height …
const STEEPEST: f64 = 0.4;

/// … and how many of the points around may be steeper.
const HIDDEN_SHARE: f64 = 0.02;

/// A developed fill changes its own chart; after so many rounds it has settled.
const ROUNDS: usize = 4;

/// How much of what is around a hole must be seen from one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// All but a few points.
    All,
    /// What is seen from there; the rest does not count.
    Part,
}

/// A hole and the points from which its fill takes its shape.
pub struct Shaper<'a> {
    hole: Hole<'a>,
    measured: &'a Measured<'a>,
    rim: Vec<VertexId>,
    /// The vertices around, all of them.
    band: Vec<VertexId>,
    /// Perpendicular to the hole as a whole.
    normal: Vector,
    perimeter: f64,
    width: f64,
    /// The mean distance between the points around: the side of the square that each
    /// has to itself.
    spacing: f64,
}

impl<'a> Shaper<'a> {
    /// `None` for a hole that has no side to it.
    pub fn new(hole: Hole<'a>, measured: &'a Measured<'a>) -> Option<Self> {
        let mesh = hole.around.mesh;
        let perimeter = hole.rims.iter().map(|r| boundary::length(mesh, r)).sum::<f64>();
        // The hole is to the right of its rims.
        let area: Vector = hole.rims.iter().map(|rim| -boundary::area(mesh, rim)).sum();
        let normal = area.try_normalize(0.0)?;
        let width = band::width(half_width(area.norm(), perimeter), hole.sizes.mean);
        let (rim, band) = (hole.rims.concat(), band::band(hole, width, |_| true));
        let spacing = spacing(hole.around, &band);
        Some(Shaper { hole, measured, rim, band, normal, perimeter, width, spacing })
    }

    /// How the hole looks from where it can be seen best. `None` if not all
    /// around it can be seen from there, unless only a part is `asked` for.
    pub fn view(&self, asked: Seen) -> Option<View> {
        let around = self.hole.around;
        let facing = |v: VertexId| around.cloud.normal(v.index()).dot(&self.normal) >= STEEPEST;
        let hidden = || self.band.iter().filter(|v| !facing(**v)).count() as f64;
        let band = match asked {
            Seen::All if hidden() > HIDDEN_SHARE * self.band.len() as f64 => return None,
            Seen::All => self.band.clone(),
            Seen::Part => band::band(self.hole, self.width, facing),
        };
        let centre = self.rim.iter().map(|&v| around.mesh.point(v).coords).sum::<Vector>();
        let plane = LocalPlane::new(Point::from(centre / self.rim.len() as f64), self.normal);
        let flat =
            |rim: &&[VertexId]| rim.iter().map(|&v| plane.flat(around.mesh.point(v))).collect();
        let outlines: Vec<Vec<Uv>> = self.hole.rims.iter().map(flat).collect();
        let height = |&v: &VertexId| {
            let p = self.measured.point(v, around.mesh.point(v));
            (plane.flat(p), [plane.height(p)])
        };
        let points: Vec<_> = band.iter().map(height).collect();
        let area = outlines.iter().map(|o| outline_area(o)).sum::<f64>().abs();
        let hole = Outlines::new(&outlines);
        let reach = |p: Uv, cell: f64| hole.reach(p, cell);
        let cell = self.cell(area);
        let spline = SmoothingSpline::fit(&points, reach, cell, self.narrowest(), Held::Both)?;
        Some(View { plane, spline, outlines })
    }

    /// The width of the spline's cells for a hole of some area.
    fn cell(&self, area: f64) -> f64 {
        let cell = half_width(area, self.perimeter) / ACROSS_HOLE;
        cell.min(self.width / ACROSS_BAND).max(self.narrowest())
    }

    /// Around slits and in gridded scans points can be nearer along the rim than
    /// across.
    fn narrowest(&self) -> f64 {
        NARROWEST * self.hole.sizes.mean.max(self.spacing)
    }

    /// Shapes a fill as a height over the view's plane. `None` if it cannot be
    /// seen from there without triangles that overlap.
    pub fn over_plane(&self, fill: &Fill, view: &View) -> Option<Fill> {
        let mut sheet = self.sheet(fill);
        sheet.uv = sheet.points.iter().map(|&p| view.plane.flat(p)).collect();
        if sheet.turned() > 0 {
            view.rebuild(&mut sheet)?;
        }
        self.settle(&mut sheet, |uv| view.surface(uv));
        Some(self.fill(sheet, fill))
    }

    /// Shapes a fill over its own layout in the plane, by turns. Where the surface
    /// around the hole bends much, one that goes on with its curvature can swing
    /// out and fold; one `held` flat does not.
    pub fn developed(&self, fill: &Fill, held: Held) -> Option<Fill> {
        let mut sheet = self.sheet(fill);
        let outside = Outside::new(self.hole.around, &self.rim, &self.band, sheet.points.len());
        let mut start = None;
        for _ in 0..ROUNDS {
            let points = [sheet.points.as_slice(), &outside.points].concat();
            let triangles = [sheet.triangles.as_slice(), &outside.triangles].concat();
            let uv = develop(&points, &triangles, start)?;
            sheet.uv = uv[..sheet.points.len()].to_vec();
            let point = |(&v, &place): (&VertexId, &usize)| {
                let p = self.measured.point(v, self.hole.around.mesh.point(v));
                (uv[place], [p.x, p.y, p.z])
            };
            let known = self.band.iter().zip(&outside.places);
            let points: Vec<_> =
                known.filter(|known| outside.is_laid_out(*known.1)).map(point).collect();
            let cell = self.cell(sheet.area());
            let covered = sheet.covered(cell);
            let narrowest = self.narrowest();
            let spline = SmoothingSpline::fit(&points, |p, _| covered(p), cell, narrowest, held)?;
            self.settle(&mut sheet, |uv| Some(Point::from(spline.at(uv)?)));
            let outer = &uv[uv.len() - outside.points.len()..];
            start = Some([sheet.uv.as_slice(), outer].concat());
        }
        (sheet.turned() == 0).then(|| self.fill(sheet, fill))
    }

    fn sheet(&self, fill: &Fill) -> Sheet {
        let mesh = self.hole.around.mesh;
        let place: HashMap<VertexId, usize> =
            self.rim.iter().enumerate().map(|(i, &v)| (v, i)).collect();
        let local = |v: VertexId| match v.index().checked_sub(mesh.points.len()) {
            None => place[&v],
            Some(new) => self.rim.len() + new,
        };
        let of_rim = self.rim.iter().map(|&v| mesh.point(v));
        Sheet {
            uv: Vec::new(),
            points: of_rim.chain(fill.points.iter().copied()).collect(),
            fixed: self.rim.len(),
            triangles: fill.triangles.iter().map(|t| t.map(local)).collect(),
        }
    }

    fn fill(&self, mut sheet: Sheet, from: &Fill) -> Fill {
        let first = self.hole.around.mesh.points.len();
        let global = |v: usize| match v.checked_sub(self.rim.len()) {
            None => self.rim[v],
            Some(new) => VertexId::from(first + new),
        };
        Fill {
            points: sheet.points.split_off(self.rim.len()),
            triangles: sheet.triangles.into_iter().map(|t| t.map(global)).collect(),
            wide_ears: from.wide_ears,
            spanned: from.spanned,
        }
    }

    fn joined(&self, v: usize, w: usize) -> bool {
        v.max(w) < self.rim.len() && self.hole.around.joined(self.rim[v], self.rim[w])
    }

    /// Places the fill on a surface over its chart, and improves it there.
    fn settle(&self, sheet: &mut Sheet, base: impl Fn(Uv) -> Option<Point>) {
        let rest = Rest::new(self.hole.sizes, sheet, &base);
        let found = RefCell::new(Vec::new());
        let surface = |uv: Uv| {
            let p = base(uv)?;
            Some(p + rest.at(p, &mut found.borrow_mut()))
        };
        for v in sheet.fixed..sheet.points.len() {
            if let Some(p) = surface(sheet.uv[v]) {
                sheet.points[v] = p;
            }
        }
        sheet.improve(surface, |v, w| self.joined(v, w));
    }
}

/// A hole seen whole from one side: its surface as a height over a plane.
pub struct View {
    plane: LocalPlane,
    spline: SmoothingSpline<1>,
    /// The rims in the plane.
    outlines: Vec<Vec<Uv>>,
}

impl View {
    fn surface(&self, uv: Uv) -> Option<Point> {
        Some(self.plane.lift(uv, self.spline.at(uv)?[0]))
    }

    /// To lead a front by.
    pub fn lead<'a>(
        &self,
        surface: &'a (dyn Fn(Point) -> Option<(Point, Vector)> + Sync),
    ) -> Lead<'a> {
        Lead { plane: self.plane, surface }
    }

    /// The point above or below a place, and the unit normal there.
    pub fn under(&self, p: Point, step: f64) -> Option<(Point, Vector)> {
        let uv = self.plane.flat(p);
        let [x, y] = [Uv::new(uv.x + step, uv.y), Uv::new(uv.x, uv.y + step)];
        let at = self.surface(uv)?;
        let normal = (self.surface(x)? - at).cross(&(self.surface(y)? - at));
        Some((at, normal.try_normalize(0.0)?))
    }

    /// Triangulates a fill anew in the plane.
    fn rebuild(&self, sheet: &mut Sheet) -> Option<()> {
        let outlines: Vec<&[Uv]> = self.outlines.iter().map(Vec::as_slice).collect();
        let triangles = outline::triangulate(&outlines, &sheet.uv[sheet.fixed..])?;
        // Parity alone does not tell in from out; the number of triangles does.
        (triangles.len() == sheet.triangles.len()).then_some(())?;
        sheet.triangles = triangles;
        (sheet.turned() == 0).then_some(())
    }
}

fn outline_area(outline: &[Uv]) -> f64 {
    let at = |i: usize| outline[i % outline.len()] - outline[0];
    0.5 * (1..outline.len()).map(|i| at(i).perp(&at(i + 1))).sum::<f64>()
}

/// Half the width of a hole: of a round one the radius, of a slit its width.
fn half_width(area: f64, perimeter: f64) -> f64 {
    2.0 * area / perimeter
}

/// The side of the square that each of the vertices has to itself, in the mean.
fn spacing(around: &Surroundings, band: &[VertexId]) -> f64 {
    let triangles = band.iter().flat_map(|&v| around.rings.triangles(v));
    let area = |&t: &u32| 0.5 * around.mesh.area_vector(around.mesh.triangles[t as usize]).norm();
    let (sum, count) = triangles.map(area).fold((0.0, 0), |(sum, n), x| (sum + x, n + 1));
    // In a closed mesh, twice as many triangles as vertices.
    (2.0 * sum / f64::from(count.max(1))).sqrt()
}

/// The band's triangles, numbered after the sheet's vertices but for the rim.
struct Outside {
    points: Vec<Point>,
    triangles: Vec<[usize; 3]>,
    /// Of each of the band's vertices.
    places: Vec<usize>,
    /// Places that have triangles.
    laid_out: Vec<bool>,
}

impl Outside {
    fn new(around: &Surroundings, rim: &[VertexId], band: &[VertexId], first: usize) -> Self {
        let mut number = HashMap::new();
        let mut points = Vec::new();
        let mut places = Vec::new();
        for (i, &v) in rim.iter().enumerate() {
            number.insert(v, i);
        }
        for &v in band {
            let next = first + points.len();
            let place = *number.entry(v).or_insert_with(|| {
                points.push(around.mesh.point(v));
                next
            });
            places.push(place);
        }
        let mut numbers: Vec<u32> =
            band.iter().flat_map(|&v| around.rings.triangles(v).iter().copied()).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let triangles: Vec<[usize; 3]> = numbers
            .into_iter()
            .filter_map(|t| {
                let [a, b, c] = around.mesh.triangles[t as usize].map(|v| number.get(&v).copied());
                Some([a?, b?, c?])
            })
            .collect();
        let mut laid_out = vec![false; first + points.len()];
        triangles.iter().flatten().for_each(|&v| laid_out[v] = true);
        Outside { points, triangles, places, laid_out }
    }

    /// Whether a place has triangles by which it has been laid out.
    fn is_laid_out(&self, place: usize) -> bool {
        self.laid_out[place]
    }
}

/// What the rim is off the surface; it fades out into the hole, so that the
/// fill leaves the rim as smoothly as it may.
struct Rest<'a> {
    sizes: &'a Sizes,
    rim: Vec<Vector>,
}

/// How far the rim's own way reaches into the hole, in edges.
const FADE: f64 = 2.0;

impl<'a> Rest<'a> {
    fn new(sizes: &'a Sizes, sheet: &Sheet, base: impl Fn(Uv) -> Option<Point>) -> Self {
        let rest = |v: usize| base(sheet.uv[v]).map_or(Vector::zeros(), |p| sheet.points[v] - p);
        Rest { sizes, rim: (0..sheet.fixed).map(rest).collect() }
    }

    /// The rest near a point of the surface.
    fn at(&self, p: Point, found: &mut Vec<u32>) -> Vector {
        let reach = FADE * self.sizes.mean;
        let (mut sum, mut total, mut nearest) = (Vector::zeros(), 1e-300, f64::MAX);
        for (i, distance) in self.sizes.rim_within(p, 2.5 * reach, found) {
            let weight = (-(distance / reach).powi(2)).exp();
            sum += weight * self.rim[i];
            total += weight;
            nearest = nearest.min(distance);
        }
        sum / total * (-(nearest / reach).powi(2)).exp()
    }
}
