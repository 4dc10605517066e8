//! A still picture of the report, for documents and for people without a browser.

use std::io;

use nalgebra::Vector3;

use super::exact_view::{ExactView, KINDS};
use super::histogram::Histogram;
use super::scale::{Ends, short};
use super::view::{ReportView, ViewFigures};
use crate::deviation::Deviation;
use crate::geometry::{Point, box_of};
use crate::report::picture::canvas::Canvas;
use crate::report::picture::colour::{BACKGROUND, DOTS, INK, TINTS, encoded, linear, srgb};
use crate::report::picture::lines::{Lines, Pen};
use crate::report::picture::scale::{SIGNED, colour};
use crate::report::picture::text::{Style, Type};
use crate::report::picture::{Camera, Image, sheet};
use crate::words::{box_extents, grouped, mm, plural, separated};

/// Pixels of the picture.
pub(super) const SIZE: [usize; 2] = [1600, 1000];

/// Where things are, in pixels of a picture of the usual size.
pub(super) const MARGIN: usize = 40;
pub(super) const TOP: usize = 130;
pub(super) const COLUMN: usize = 1090;
const ASIDE: [usize; 2] = [225, 260];
const BARS: [usize; 2] = [470, 300];

pub(super) const MUTED: [u8; 3] = srgb(0x5f6b78);
const LINE: [u8; 3] = srgb(0xd5dae0);

pub(super) const TITLE: Style = Style { size: 40.0, bold: true, colour: INK };
pub(super) const TEXT: Style = Style { size: 24.0, bold: false, colour: INK };
pub(super) const SMALL: Style = Style { size: 20.0, bold: false, colour: MUTED };

/// The size of the dots at irregular vertices.
const DOT: Pen = Pen::solid(4.5);

/// The pens for seams of B-spline faces, and for edges of exact faces at which these turn or do not.
const SEAM: Pen = Pen::solid(0.7);
const SHARP_EDGE: Pen = Pen::solid(1.5);
const SMOOTH_EDGE: Pen = Pen { seen: 0.35, ..Pen::solid(0.7) };

/// Draws a picture of 1600 × 1000 pixels as PNG: the scan from three sides in the colours of its
/// deviation from the face, the histogram of the deviation, and the figures that matter most.
/// `name` stands above them.
///
/// # Errors
/// The font cannot be read, or the image cannot be encoded.
pub fn picture_png(name: &str, views: &[ReportView]) -> io::Result<Vec<u8>> {
    let mut page = Page::new()?;
    let end = Ends::of(views).measured;
    page.head(name, views);
    if let Some(first) = views.first() {
        let extent = || views.iter().flat_map(|view| view.scan.mesh.points.iter().copied());
        let size = [COLUMN - MARGIN, SIZE[1] - TOP - 10];
        let camera = match first.exact {
            Some(_) => Camera::isometric(extent(), size),
            None => Camera::facing(&first.scan.mesh, extent(), size),
        };
        page.image.lay(&side(views, &camera, size, end), [MARGIN / 2, TOP]);
        let extent: Vec<Point> = extent().collect();
        let asides = camera.asides(&first.scan.mesh, &extent, ASIDE);
        for (x, aside) in [COLUMN, COLUMN + ASIDE[0] + 20].into_iter().zip(asides) {
            page.image.lay(&side(views, &aside, ASIDE, end), [x, TOP]);
        }
    }
    let exact: Vec<&ExactView> = views.iter().filter_map(|view| view.exact.as_ref()).collect();
    let top = TOP + ASIDE[1] + 60;
    if exact.len() == views.len() && !views.is_empty() {
        page.kinds(&exact, [COLUMN, top]);
        let mut bytes = Vec::new();
        page.image.write(&mut bytes)?;
        return Ok(bytes);
    }
    let distances = views.iter().flat_map(|view| view.measured.iter().copied());
    let histogram = Histogram::of(distances, end);
    page.histogram(&histogram, views, [COLUMN, top]);
    page.figures(views, [COLUMN as f32, (top + BARS[1] + 130) as f32]);
    let mut bytes = Vec::new();
    page.image.write(&mut bytes)?;
    Ok(bytes)
}

/// The box around all components.
fn bounds(views: &[ReportView]) -> [[f64; 3]; 2] {
    let corners = views.iter().flat_map(|view| view.figures.bounds).map(Point::from);
    box_of(corners)
}

/// The tolerance, where all parts have the same.
fn tolerance(views: &[ReportView]) -> Option<f64> {
    let first = views.first()?.figures.tolerance;
    views.iter().all(|view| view.figures.tolerance == first).then_some(first)
}

/// Root mean square, 95th percentile and largest of the distances from all faces.
fn together(views: &[ReportView], of: fn(&ViewFigures) -> &Deviation) -> [f64; 3] {
    let figures = |d: &Deviation| [d.rms, d.p95, d.max];
    if let [only] = views {
        return figures(of(&only.figures));
    }
    let all: Vec<f64> =
        views.iter().flat_map(|view| &of(&view.figures).distances).copied().collect();
    // Where the farthest is, its ring shows.
    figures(&Deviation::of(&vec![Point::origin(); all.len()], all))
}

/// The percentage of all smoothed points that keep their face's tolerance.
fn within(views: &[ReportView]) -> f64 {
    let sum = |of: fn(&ViewFigures) -> usize| {
        views.iter().map(|view| of(&view.figures)).sum::<usize>() as f64
    };
    100.0 - 100.0 * sum(|f| f.beyond) / sum(|f| f.smoothed.distances.len()).max(1.0)
}

/// The scan from one side.
fn side(views: &[ReportView], camera: &Camera, size: [usize; 2], end: f64) -> Image {
    let mut canvas = Canvas::new(size);
    for view in views {
        if let Some(exact) = &view.exact {
            sheet::draw_tinted(&mut canvas, &exact.mesh, camera, |t| exact.paint(t));
            continue;
        }
        let share = |v: crate::geometry::VertexId| {
            0.5 + 0.5 * f64::from(view.measured[view.scan.old[v.index()]]) / end
        };
        sheet::draw_coloured(&mut canvas, &view.scan.mesh, camera, &SIGNED, share);
    }
    for view in views {
        let lines = |edges: &[Vec<Point>], pen| {
            let mut lines = Lines::over(&canvas);
            for edge in edges {
                lines.polyline(&canvas, edge.iter().map(|p| camera.project(p)), pen);
            }
            lines
        };
        let smooth = lines(&view.smooth_edges, SMOOTH_EDGE);
        let sharp = if view.exact.is_some() { SHARP_EDGE } else { SEAM };
        let seams = lines(&view.seams, sharp);
        let mut dots = Lines::over(&canvas);
        view.irregular.iter().for_each(|p| dots.point(&canvas, camera.project(p), DOT));
        smooth.ink(&mut canvas, linear(INK));
        seams.ink(&mut canvas, linear(INK));
        dots.ink(&mut canvas, linear(DOTS));
        let rims = sheet::rims(&canvas, &view.scan.mesh, view.rims.iter(), camera, Pen::solid(1.4));
        rims.ink(&mut canvas, linear(INK));
        if view.exact.is_some() {
            continue;
        }
        let worst = ring(&canvas, camera, view.figures.measured.max_at.into());
        worst.ink(&mut canvas, linear(INK));
    }
    canvas.image()
}

/// A ring around the worst point, seen from everywhere.
fn ring(canvas: &Canvas, camera: &Camera, at: Point) -> Lines {
    let middle = camera.project(&at);
    let radius = 0.012 * SIZE[1] as f64;
    let corner = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::TAU / 48.0;
        middle + radius * Vector3::new(angle.cos(), angle.sin(), 0.0)
    };
    let mut lines = Lines::over(canvas);
    lines.polyline(canvas, (0..=48).map(corner), Pen::flat(2.2, 1.0));
    lines
}

/// A picture with text.
pub(super) struct Page {
    pub(super) image: Image,
    pub(super) letters: Type,
}

impl Page {
    pub(super) fn new() -> io::Result<Page> {
        let letters = Type::new().map_err(io::Error::other)?;
        Ok(Page { image: Image::blank(SIZE, BACKGROUND), letters })
    }

    /// A line under the head.
    pub(super) fn rule(&mut self) {
        self.image.fill([MARGIN, TOP - 8], [SIZE[0] - 2 * MARGIN, 2], LINE);
    }

    pub(super) fn write(&mut self, text: &str, at: [f32; 2], style: Style) {
        self.letters.write(&mut self.image, text, at, style);
    }

    fn centred(&mut self, text: &str, at: [f32; 2], style: Style) {
        let width = self.letters.width(text, style);
        // What would run over the page's edge ends there.
        let most = SIZE[0] as f32 - 8.0 - width;
        self.write(text, [(at[0] - 0.5 * width).min(most), at[1]], style);
    }

    /// As large as the style has it, or as there is room for up to the margin.
    pub(super) fn write_within(&mut self, text: &str, at: [f32; 2], style: Style) {
        let room = (SIZE[0] - MARGIN) as f32 - at[0];
        let share = (room / self.letters.width(text, style)).min(1.0);
        self.write(text, at, Style { size: style.size * share, ..style });
    }

    /// What was converted, and the result in a line.
    fn head(&mut self, name: &str, views: &[ReportView]) {
        let width = (SIZE[0] - 2 * MARGIN) as f32;
        let title = self.letters.fit(name, TITLE, width);
        self.write(&title, [MARGIN as f32, 62.0], TITLE);
        let vertices: usize = views.iter().map(|view| view.figures.vertices).sum();
        let triangles: usize = views.iter().map(|view| view.triangles).sum();
        let made = match views {
            [only] => only.figures.made.clone(),
            _ => plural(views.len(), "component"),
        };
        let [vertices, triangles] = [vertices, triangles].map(|n| separated(&n.to_string()));
        let size = box_extents(bounds(views));
        let line = format!("{vertices} points, {triangles} triangles  ·  {size}  ·  {made}");
        self.write_within(&line, [MARGIN as f32, 102.0], Style { colour: MUTED, ..TEXT });
        self.rule();
    }

    /// The kinds of exact faces with their colours, and the bores and shafts.
    fn kinds(&mut self, views: &[&ExactView], [x, y]: [usize; 2]) {
        const ROW: usize = 34;
        self.write("Faces", [x as f32, y as f32 - 14.0], Style { bold: true, ..SMALL });
        let mut row = y + 8;
        let left = x as f32 + 34.0;
        for (kind, name) in KINDS.iter().enumerate() {
            let count: usize = views.iter().map(|view| view.counts[kind]).sum();
            if count == 0 {
                continue;
            }
            self.image.fill([x, row], [22, 22], srgb(TINTS[kind]));
            self.write(&plural(count, name), [left, row as f32 + 18.0], SMALL);
            row += ROW;
        }
        let rows: Vec<String> = views.iter().flat_map(|view| view.cylinders()).collect();
        if rows.is_empty() {
            return;
        }
        row += ROW;
        self.write("Cylinders", [x as f32, row as f32], Style { bold: true, ..SMALL });
        // Each component counts its own cylinders.
        let relations = match views {
            [only] => only.figures.relation_phrases(),
            _ => Vec::new(),
        };
        let room = ((SIZE[1] - MARGIN).saturating_sub(row) / ROW).saturating_sub(relations.len());
        let shown = if rows.len() > room { room.saturating_sub(1) } else { rows.len() };
        for text in &rows[..shown] {
            row += ROW;
            self.write_within(text, [x as f32, row as f32], SMALL);
        }
        if shown < rows.len() {
            let more = format!("and {} more in the report", rows.len() - shown);
            row += ROW;
            self.write(&more, [x as f32, row as f32], SMALL);
        }
        for text in &relations {
            row += ROW;
            self.write_within(text, [x as f32, row as f32], SMALL);
        }
    }

    /// Bars in the colours of the map, over their scale.
    fn histogram(&mut self, histogram: &Histogram, views: &[ReportView], [x, y]: [usize; 2]) {
        let [width, height] = BARS;
        let title = "Deviation of the scan from the face, mm";
        self.write(title, [x as f32, y as f32 - 14.0], Style { bold: true, ..SMALL });
        let most = histogram.counts.iter().copied().max().unwrap_or(0).max(1);
        let edge = |k: usize| x + k * width / histogram.counts.len();
        for (k, &count) in histogram.counts.iter().enumerate() {
            let share = (k as f64 + 0.5) / histogram.counts.len() as f64;
            let tall = (height * count).div_ceil(most);
            let paint = encoded(colour(&SIGNED, share));
            let size = edge(k + 1) - edge(k);
            self.image.fill([edge(k), y + height - tall], [size, tall], paint);
            self.image.fill([edge(k), y + height + 4], [size, 16], paint);
        }
        let at = |d: f64| x as f64 + (0.5 + 0.5 * d / histogram.end) * width as f64;
        let foot = (y + height + 44) as f32;
        for (d, sign) in [(-1.0_f64, "–"), (-0.5, "–"), (0.0, ""), (0.5, "+"), (1.0, "+")] {
            let text = format!("{sign}{}", short(d.abs() * histogram.end));
            self.centred(&text, [at(d * histogram.end) as f32, foot], SMALL);
        }
        let mut note = String::new();
        if let Some(tolerance) = tolerance(views).filter(|t| *t < histogram.end) {
            for d in [-tolerance, tolerance] {
                for dash in (0..height + 20).step_by(12) {
                    self.image.fill([at(d) as usize, y + dash], [2, 7], INK);
                }
            }
            note = format!("dashed: tolerance, ±{}  ·  ", short(tolerance));
        }
        if views.iter().any(|view| !view.irregular.is_empty()) {
            note += "dots: irregular vertices  ·  ";
        }
        note += if views.len() == 1 {
            "ring: the farthest point"
        } else {
            "rings: the farthest points"
        };
        self.write_within(&note, [x as f32, foot + 28.0], SMALL);
    }

    fn figures(&mut self, views: &[ReportView], [x, y]: [f32; 2]) {
        let line = |of| {
            let [rms, p95, max] = together(views, of).map(mm);
            format!("rms {rms}  ·  95 % {p95}  ·  max {max}")
        };
        let tolerance = tolerance(views).map_or("each face its own".into(), mm);
        let cut_off: usize = views.iter().map(|view| view.figures.cut_off).sum();
        let at_rims = match cut_off {
            0 => String::new(),
            cut_off => format!(", {} of them cut off at rims", grouped(cut_off)),
        };
        let rows = [
            ("as measured", line(|f| &f.measured)),
            ("smoothed", line(|f| &f.smoothed)),
            (
                "tolerance",
                format!("{tolerance}, which {:.2} % of the smoothed keep{at_rims}", within(views)),
            ),
        ];
        for (k, (label, text)) in rows.iter().enumerate() {
            let y = y + 30.0 * k as f32;
            let style = Style { size: 17.5, ..SMALL };
            self.write(label, [x, y], style);
            self.write_within(text, [x + 104.0, y], Style { colour: INK, ..style });
        }
    }
}
