//! The shape of a fill. The points of the front are extrapolated row by row, and in wide holes
//! they drift away from the surface. Here all points of a fill are placed on one smoothing
//! spline through the band of measured points around the hole.

use std::cell::RefCell;

use foldhash::HashMap;

use super::band::{self, MeasuredPoints};
use super::charted::ChartedFill;
use super::front::{Fill, Guide, OpenHole, Surroundings};
use super::numbering::Numbering;
use super::rigid_layout::lay_out;
use super::rim_outlines::RimOutlines;
use super::smoothing_spline::{Energies, SmoothingSpline};
use crate::geometry::{LocalPlane, Point, Uv, Vector, VertexId};
use crate::mesh::remesh::Sizes;
use crate::mesh::{boundary, outline};

/// The number of spline cells over half the width of a hole with which the fit begins. The grid
/// is refined until the energies smooth and not the cells, so more cells cost time and change
/// little. With far fewer, bends of the surface are lost.
const ACROSS_HOLE: f64 = 3.5;

/// The least number of spline cells across the band with which the fit begins: as many as a
/// curvature and its change need.
const ACROSS_BAND: f64 = 3.0;

/// The least width of a spline cell, in mean edge lengths or distances between points. A cell has
/// then about four points. Half of it lowers the rms over the
/// hole bench by 9 % but raises it by 60 % in a deep bay; twice as much doubles it.
const NARROWEST: f64 = 2.0;

/// The steepest slope of a height field, as the cosine of its angle: 66°. Steeper surfaces are
/// stretched by more than 2.5 in the plane, and cells that are right there are too wide in space.
/// With a larger cosine more holes need a layout, which takes ten times as long.
const STEEPEST: f64 = 0.4;

/// The share of the points of the band that may be steeper. A few points with bad normals, as at a
/// ragged rim, must not decide. A larger share bends the surface to points on its other side.
const HIDDEN_SHARE: f64 = 0.02;

/// The rounds of layout and fit. The shape of a fill depends on its layout, and the layout on the
/// shape. With 2 or 8 rounds a wide dome is 20 % or 12 % worse.
const ROUNDS: usize = 4;

/// A hole, and the measured points that give its fill its shape.
pub(crate) struct Shaper<'a> {
    hole: OpenHole<'a>,
    measured: &'a MeasuredPoints<'a>,
    numbering: Numbering<'a>,
    /// The vertices around the hole.
    band: Vec<VertexId>,
    /// The mean unit normal of the hole.
    normal: Vector,
    perimeter: f64,
    /// The width of the band.
    width: f64,
    /// The mean distance between the points of the band, as if they were on a square grid.
    spacing: f64,
    /// Whether all points of the band but a few are visible along the normal.
    is_visible: bool,
}

impl<'a> Shaper<'a> {
    /// `None` for a hole whose rims enclose no area.
    pub(super) fn new(hole: OpenHole<'a>, measured: &'a MeasuredPoints<'a>) -> Option<Self> {
        let mesh = hole.around.mesh;
        let perimeter = hole.rims.iter().map(|r| boundary::length(mesh, r)).sum::<f64>();
        // The hole is to the right of its rims.
        let area: Vector = hole.rims.iter().map(|rim| -boundary::area(mesh, rim)).sum();
        let normal = area.try_normalize(0.0)?;
        let width = band::width(half_width(area.norm(), perimeter), hole.sizes.mean);
        let band = band::band(hole, width, |_| true);
        let spacing = spacing(hole.around, &band);
        let numbering = Numbering::new(hole);
        let hidden = band.iter().filter(|v| !faces(hole, **v, normal)).count() as f64;
        let is_visible = hidden <= HIDDEN_SHARE * band.len() as f64;
        let shaper = Shaper {
            hole,
            measured,
            numbering,
            band,
            normal,
            perimeter,
            width,
            spacing,
            is_visible,
        };
        Some(shaper)
    }

    /// The surface over the hole as a height field along the mean normal. It goes through the
    /// points of the band that are visible from there and connected to the rim: the whole band
    /// if all but a few are visible.
    pub(crate) fn height_field(&self) -> Option<HeightField> {
        let around = self.hole.around;
        let visible = if self.is_visible {
            self.band.clone()
        } else {
            band::band(self.hole, self.width, |v| faces(self.hole, v, self.normal))
        };
        let rim = &self.numbering.rim;
        let centre = rim.iter().map(|&v| around.mesh.point(v).coords).sum::<Vector>();
        let plane = LocalPlane::new(Point::from(centre / rim.len() as f64), self.normal);
        let flat =
            |rim: &&[VertexId]| rim.iter().map(|&v| plane.flat(around.mesh.point(v))).collect();
        let outlines: Vec<Vec<Uv>> = self.hole.rims.iter().map(flat).collect();
        let height = |&v: &VertexId| {
            let p = self.measured.point(v, around.mesh.point(v));
            (plane.flat(p), [plane.height(p)])
        };
        let points: Vec<_> = visible.iter().map(height).collect();
        let area = outlines.iter().map(|o| outline_area(o)).sum::<f64>().abs();
        let hole = RimOutlines::new(&outlines);
        let reach = |p: Uv, cell: f64| hole.is_in_or_near(p, cell);
        let cell = self.cell(area);
        let spline = SmoothingSpline::fit(&points, reach, cell, self.narrowest(), Energies::Both)?;
        Some(HeightField { plane, spline, outlines })
    }

    /// The width of the spline cells for a hole of some area.
    fn cell(&self, area: f64) -> f64 {
        let cell = half_width(area, self.perimeter) / ACROSS_HOLE;
        cell.min(self.width / ACROSS_BAND).max(self.narrowest())
    }

    /// Around slits and in scans by lines, points can be nearer along the rim than across it.
    fn narrowest(&self) -> f64 {
        NARROWEST * self.hole.sizes.mean.max(self.spacing)
    }

    /// Places a fill on the height field if the whole band is visible, and else on a surface over
    /// a layout.
    pub(crate) fn shaped(&self, fill: &Fill) -> Option<Fill> {
        match self.is_visible.then(|| self.height_field()).flatten() {
            Some(field) => self.over_plane(fill, &field),
            None => self.over_layout(fill, Energies::Both),
        }
    }

    /// Places a fill on a height field. `None` if its triangles overlap in the plane and cannot
    /// be replaced by others that do not.
    pub(crate) fn over_plane(&self, fill: &Fill, field: &HeightField) -> Option<Fill> {
        let mut charted = self.charted(fill);
        charted.uv = charted.points.iter().map(|&p| field.plane.flat(p)).collect();
        if charted.inverted() > 0 {
            field.triangulate(&mut charted)?;
        }
        self.place(&mut charted, |uv| field.at(uv));
        Some(self.numbering.fill(charted.points, &charted.triangles, fill))
    }

    /// Places a fill on a spline over the layout of fill and band in the plane, and repeats this
    /// with the layout of the result. `None` if triangles are inverted in the last layout.
    pub(crate) fn over_layout(&self, fill: &Fill, energies: Energies) -> Option<Fill> {
        let mut charted = self.charted(fill);
        let band =
            BandMesh::new(&self.numbering, self.hole.around, &self.band, charted.points.len());
        let mut start = None;
        for _ in 0..ROUNDS {
            let points = [charted.points.as_slice(), &band.points].concat();
            let triangles = [charted.triangles.as_slice(), &band.triangles].concat();
            let uv = lay_out(&points, &triangles, start)?;
            charted.uv = uv[..charted.points.len()].to_vec();
            let point = |(&v, &place): (&VertexId, &usize)| {
                let p = self.measured.point(v, self.hole.around.mesh.point(v));
                (uv[place], [p.x, p.y, p.z])
            };
            let known = self.band.iter().zip(&band.places);
            let points: Vec<_> = known.filter(|known| band.laid_out[*known.1]).map(point).collect();
            let cell = self.cell(charted.area());
            let covered = charted.covered(cell);
            let narrowest = self.narrowest();
            let spline =
                SmoothingSpline::fit(&points, |p, _| covered(p), cell, narrowest, energies)?;
            self.place(&mut charted, |uv| Some(Point::from(spline.at(uv)?)));
            let outer = &uv[uv.len() - band.points.len()..];
            start = Some([charted.uv.as_slice(), outer].concat());
        }
        let upright = charted.inverted() == 0;
        upright.then(|| self.numbering.fill(charted.points, &charted.triangles, fill))
    }

    /// A fill that has no chart yet.
    fn charted(&self, fill: &Fill) -> ChartedFill {
        let (points, triangles) = self.numbering.numbered(fill);
        ChartedFill { uv: Vec::new(), points, fixed: self.numbering.rim.len(), triangles }
    }

    /// Places a fill on a surface over its chart, and improves its triangles there.
    fn place(&self, charted: &mut ChartedFill, base: impl Fn(Uv) -> Option<Point>) {
        let offset = RimOffset::new(self.hole.sizes, charted, &base);
        let found = RefCell::new(Vec::new());
        let surface = |uv: Uv| {
            let p = base(uv)?;
            Some(p + offset.at(p, &mut found.borrow_mut()))
        };
        for v in charted.fixed..charted.points.len() {
            if let Some(p) = surface(charted.uv[v]) {
                charted.points[v] = p;
            }
        }
        charted.improve(surface, |i, j| self.numbering.joined(i, j));
    }
}

/// Whether the surface at a vertex faces a direction well enough for a height field.
fn faces(hole: OpenHole, v: VertexId, direction: Vector) -> bool {
    hole.around.cloud.normal(v.index()).dot(&direction) >= STEEPEST
}

/// The surface over a hole as a height field over a plane.
pub(crate) struct HeightField {
    plane: LocalPlane,
    spline: SmoothingSpline<1>,
    /// The rims in the plane.
    outlines: Vec<Vec<Uv>>,
}

impl HeightField {
    fn at(&self, uv: Uv) -> Option<Point> {
        Some(self.plane.lift(uv, self.spline.at(uv)?[0]))
    }

    /// The guide of a front.
    pub(crate) fn guide<'a>(
        &self,
        surface: &'a (dyn Fn(Point) -> Option<(Point, Vector)> + Sync),
    ) -> Guide<'a> {
        Guide { plane: self.plane, surface }
    }

    /// The point above or below `p` and the unit normal there, by differences over `step`.
    pub(crate) fn foot(&self, p: Point, step: f64) -> Option<(Point, Vector)> {
        let uv = self.plane.flat(p);
        let [x, y] = [Uv::new(uv.x + step, uv.y), Uv::new(uv.x, uv.y + step)];
        let at = self.at(uv)?;
        let normal = (self.at(x)? - at).cross(&(self.at(y)? - at));
        Some((at, normal.try_normalize(0.0)?))
    }

    /// Replaces the triangles of a fill by others that do not overlap in the plane.
    fn triangulate(&self, charted: &mut ChartedFill) -> Option<()> {
        let outlines: Vec<&[Uv]> = self.outlines.iter().map(Vec::as_slice).collect();
        let triangles = outline::triangulate(&outlines, &charted.uv[charted.fixed..])?;
        // The triangulation takes parity for inside, which can be wrong where rims cross. Then
        // the number of triangles differs.
        (triangles.len() == charted.triangles.len()).then_some(())?;
        charted.triangles = triangles;
        (charted.inverted() == 0).then_some(())
    }
}

fn outline_area(outline: &[Uv]) -> f64 {
    let at = |i: usize| outline[i % outline.len()] - outline[0];
    0.5 * (1..outline.len()).map(|i| at(i).perp(&at(i + 1))).sum::<f64>()
}

/// Half the width of a hole: the radius of a round one, the width of a slit.
fn half_width(area: f64, perimeter: f64) -> f64 {
    2.0 * area / perimeter
}

/// The mean distance between vertices, as the root of the area of each.
fn spacing(around: &Surroundings, band: &[VertexId]) -> f64 {
    let triangles = band.iter().flat_map(|&v| around.rings.triangles(v));
    let area = |&t: &u32| 0.5 * around.mesh.area_vector(around.mesh.triangles[t as usize]).norm();
    let (sum, count) = triangles.map(area).fold((0.0, 0), |(sum, n), x| (sum + x, n + 1));
    // A mesh has about twice as many triangles as vertices.
    (2.0 * sum / f64::from(count.max(1))).sqrt()
}

/// The triangles of the band. The numbers of its points follow those of the fill, but for the
/// rim.
struct BandMesh {
    points: Vec<Point>,
    triangles: Vec<[usize; 3]>,
    /// The number of each vertex of the band.
    places: Vec<usize>,
    /// Whether each number occurs in a triangle, and so has a place in the layout.
    laid_out: Vec<bool>,
}

impl BandMesh {
    fn new(numbering: &Numbering, around: &Surroundings, band: &[VertexId], first: usize) -> Self {
        let mut number: HashMap<VertexId, usize> =
            numbering.rim.iter().enumerate().map(|(i, &v)| (v, i)).collect();
        let mut points = Vec::new();
        let mut places = Vec::new();
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
        BandMesh { points, triangles, places, laid_out }
    }
}

/// The offset of the rim from the surface. It decays into the hole, so that the fill meets the
/// rim smoothly.
struct RimOffset<'a> {
    sizes: &'a Sizes,
    rim: Vec<Vector>,
}

/// The decay length of the offset of the rim, in mean edge lengths. Half and twice as much change
/// the rms over the hole bench by 1 %; a noisy rim is better with less, a ragged one with more.
const FADE: f64 = 2.0;

impl<'a> RimOffset<'a> {
    fn new(sizes: &'a Sizes, charted: &ChartedFill, base: impl Fn(Uv) -> Option<Point>) -> Self {
        let offset =
            |v: usize| base(charted.uv[v]).map_or(Vector::zeros(), |p| charted.points[v] - p);
        RimOffset { sizes, rim: (0..charted.fixed).map(offset).collect() }
    }

    /// The offset at a point of the surface.
    fn at(&self, p: Point, found: &mut Vec<u32>) -> Vector {
        let reach = FADE * self.sizes.mean;
        let (mut sum, mut total, mut nearest) = (Vector::zeros(), f64::MIN_POSITIVE, f64::MAX);
        for (i, distance) in self.sizes.rim_within(p, 2.5 * reach, found) {
            let weight = (-(distance / reach).powi(2)).exp();
            sum += weight * self.rim[i];
            total += weight;
            nearest = nearest.min(distance);
        }
        sum / total * (-(nearest / reach).powi(2)).exp()
    }
}
