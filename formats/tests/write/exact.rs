//! Solids that are built by hand from planes, cylinders, cones, spheres, tori, extrusions and
//! revolutions.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use formats::Brep;
use formats::brep::{
    BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, FaceId, Frame, PCurve, Shell, Solid, VertexId,
};
use formats::spline::SplineCurve;

use super::bodies::empty;

/// A solid of one shell that is being built.
pub struct ExactPart {
    brep: Brep,
    faces: Vec<FaceId>,
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// The frame at a height whose axes are those of the world.
fn level(z: f64) -> Frame {
    Frame::WORLD.at([0.0, 0.0, z])
}

impl ExactPart {
    pub fn new(name: &str) -> Self {
        ExactPart { brep: empty(name), faces: Vec::new() }
    }

    pub fn vertex(&mut self, at: [f64; 3]) -> VertexId {
        self.brep.add_vertex(at)
    }

    fn at(&self, vertex: VertexId) -> [f64; 3] {
        self.brep.vertices[vertex.0]
    }

    pub fn line(&mut self, from: VertexId, to: VertexId) -> EdgeId {
        let curve = BrepCurve::line(self.at(from), self.at(to)).unwrap();
        self.brep.add_edge(curve, [from, to])
    }

    /// A whole circle and the vertex at which it begins.
    pub fn circle(&mut self, frame: &Frame, radius: f64) -> (EdgeId, VertexId) {
        let vertex = self.vertex(frame.point([radius, 0.0, 0.0]));
        let curve = BrepCurve::circle(frame, radius).unwrap();
        (self.brep.add_edge(curve, [vertex; 2]), vertex)
    }

    pub fn arc(&mut self, frame: &Frame, radius: f64, angle: f64, ends: [VertexId; 2]) -> EdgeId {
        self.brep.add_edge(BrepCurve::arc(frame, radius, angle).unwrap(), ends)
    }

    pub fn edge(&mut self, curve: BrepCurve, ends: [VertexId; 2]) -> EdgeId {
        self.brep.add_edge(curve, ends)
    }

    /// A use of an edge whose pcurve is a line.
    pub fn on(&self, edge: EdgeId, forward: bool, from: [f64; 2], to: [f64; 2]) -> EdgeUse {
        let range = self.brep.edges[edge.0].curve.range();
        EdgeUse { edge, forward, pcurve: PCurve::line(from, to, range).unwrap() }
    }

    pub fn face(&mut self, surface: BrepSurface, forward: bool, loops: Vec<Vec<EdgeUse>>) {
        let surface = self.brep.add_surface(surface);
        self.faces.push(self.brep.add_face(Face { surface, forward, loops }));
    }

    /// A face on a plane. Its loops are in its own orientation.
    pub fn plane(&mut self, frame: Frame, forward: bool, loops: &[&[(EdgeId, bool)]]) {
        let of_edge = |&(edge, forward): &(EdgeId, bool)| {
            let curve = &self.brep.edges[edge.0].curve;
            EdgeUse { edge, forward, pcurve: PCurve::on_plane(&frame, curve).unwrap() }
        };
        let loops = loops.iter().map(|ring| ring.iter().map(of_edge).collect()).collect();
        self.face(BrepSurface::plane(frame), forward, loops);
    }

    /// A face once around a surface of revolution between two circles at v and w, with the
    /// seam edge between them.
    fn ring(
        &mut self,
        surface: BrepSurface,
        forward: bool,
        [(lower, v), (upper, w)]: [(EdgeId, f64); 2],
        seam: EdgeId,
    ) {
        let mut uses = vec![
            self.on(seam, false, [0.0, v], [0.0, w]),
            self.on(lower, true, [0.0, v], [TAU, v]),
            self.on(seam, true, [TAU, v], [TAU, w]),
            self.on(upper, false, [0.0, w], [TAU, w]),
        ];
        if !forward {
            uses.reverse();
            uses.iter_mut().for_each(|of_loop| of_loop.forward = !of_loop.forward);
        }
        self.face(surface, forward, vec![uses]);
    }

    pub fn solid(mut self) -> Brep {
        let outer = self.brep.add_shell(Shell { faces: self.faces, closed: true });
        self.brep.solids.push(Solid { outer, voids: Vec::new() });
        self.brep
    }
}

/// The corners of a prism over a polygon in the plane of x and y, its edges, and its sides, top and
/// bottom except for the sides that `skipped` has. Returns the edges: below, above, upright.
fn prism(
    part: &mut ExactPart,
    outline: &[[f64; 2]],
    height: f64,
    skipped: &[usize],
) -> [Vec<EdgeId>; 3] {
    let n = outline.len();
    let mut corners = |z: f64| -> Vec<VertexId> {
        outline.iter().map(|[x, y]| part.vertex([*x, *y, z])).collect()
    };
    let (low, high) = (corners(0.0), corners(height));
    let upright: Vec<EdgeId> = (0..n).map(|k| part.line(low[k], high[k])).collect();
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for k in 0..n {
        let next = (k + 1) % n;
        if skipped.contains(&k) {
            // The caller replaces these edges.
            below.push(EdgeId(usize::MAX));
            above.push(EdgeId(usize::MAX));
            continue;
        }
        below.push(part.line(low[k], low[next]));
        above.push(part.line(high[k], high[next]));
        let along = [0, 1].map(|i| outline[next][i] - outline[k][i]);
        let out = [along[1], -along[0], 0.0];
        let frame = Frame::new([outline[k][0], outline[k][1], 0.0], out, Z).unwrap();
        part.plane(
            frame,
            true,
            &[&[(below[k], true), (upright[next], true), (above[k], false), (upright[k], false)]],
        );
    }
    [below, above, upright]
}

/// The top and the bottom of a prism, with further loops in them as seen from above.
fn lids(part: &mut ExactPart, [below, above]: [&[EdgeId]; 2], height: f64, holes: &[[EdgeId; 2]]) {
    let top: Vec<_> = above.iter().map(|e| (*e, true)).collect();
    let bottom: Vec<_> = below.iter().rev().map(|e| (*e, false)).collect();
    let inner: Vec<_> = holes.iter().map(|[b, t]| ([(*b, true)], [(*t, false)])).collect();
    let mut loops: Vec<&[(EdgeId, bool)]> = vec![&bottom];
    loops.extend(inner.iter().map(|(b, _)| b.as_slice()));
    part.plane(level(0.0), false, &loops);
    let mut loops: Vec<&[(EdgeId, bool)]> = vec![&top];
    loops.extend(inner.iter().map(|(_, t)| t.as_slice()));
    part.plane(level(height), true, &loops);
}

const PLATE: [[f64; 2]; 4] = [[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]];

pub fn exact_box() -> (Brep, f64) {
    let mut part = ExactPart::new("box");
    let [below, above, _] = prism(&mut part, &PLATE, 10.0, &[]);
    lids(&mut part, [&below, &above], 10.0, &[]);
    (part.solid(), 6000.0)
}

/// A plate with a round bore.
pub fn plate() -> (Brep, f64) {
    let mut part = ExactPart::new("plate");
    let [below, above, _] = prism(&mut part, &PLATE, 10.0, &[]);
    let frame = level(0.0).at([12.0, 9.0, 0.0]).turned(0.4);
    let (lower, a) = part.circle(&frame, 5.0);
    let (upper, b) = part.circle(&frame.at([12.0, 9.0, 10.0]), 5.0);
    let seam = part.line(a, b);
    part.ring(BrepSurface::cylinder(frame, 5.0), false, [(lower, 0.0), (upper, 10.0)], seam);
    lids(&mut part, [&below, &above], 10.0, &[[lower, upper]]);
    (part.solid(), 6000.0 - 250.0 * PI)
}

/// A plate with a round corner: a quarter of a cylinder that is tangent to two planes.
pub fn bracket() -> (Brep, f64) {
    let mut part = ExactPart::new("bracket");
    let radius = 6.0;
    // An L with a fillet in its inner corner, between corners 3 and 4.
    let outline = [
        [0.0, 0.0],
        [40.0, 0.0],
        [40.0, 8.0],
        [8.0 + radius, 8.0],
        [8.0, 8.0 + radius],
        [8.0, 30.0],
        [0.0, 30.0],
    ];
    let height = 12.0;
    let [mut below, mut above, upright] = prism(&mut part, &outline, height, &[3]);
    // The fillet is concave: seen from the solid, its axis is outside.
    let centre = [8.0 + radius, 8.0 + radius];
    let frame = Frame::new([centre[0], centre[1], 0.0], Z, [-1.0, 0.0, 0.0]).unwrap();
    let ends = |part: &ExactPart, k: usize| {
        [upright[k], upright[k + 1]].map(|e| part.brep.edges[e.0].ends)
    };
    let [[a, c], [b, d]] = ends(&part, 3);
    // The arc runs from corner 4 (at −x) to corner 3 (at −y).
    below[3] = part.arc(&frame, radius, FRAC_PI_2, [b, a]);
    above[3] = part.arc(&frame.at([centre[0], centre[1], height]), radius, FRAC_PI_2, [d, c]);
    let loops = vec![vec![
        part.on(below[3], false, [0.0, 0.0], [FRAC_PI_2, 0.0]),
        part.on(upright[4], true, [0.0, 0.0], [0.0, height]),
        part.on(above[3], true, [0.0, height], [FRAC_PI_2, height]),
        part.on(upright[3], false, [FRAC_PI_2, 0.0], [FRAC_PI_2, height]),
    ]];
    part.face(BrepSurface::cylinder(frame, radius), false, loops);
    let top: Vec<_> = above.iter().enumerate().map(|(k, e)| (*e, k != 3)).collect();
    let bottom: Vec<_> = below.iter().enumerate().rev().map(|(k, e)| (*e, k == 3)).collect();
    part.plane(level(0.0), false, &[&bottom]);
    part.plane(level(height), true, &[&top]);
    let area = 40.0 * 8.0 + 8.0 * 22.0 + radius * radius * (1.0 - PI / 4.0);
    (part.solid(), area * height)
}

/// A frame that is not along the axes.
fn askew() -> Frame {
    Frame::new([3.0, -4.0, 5.0], [1.0, 2.0, 2.0], X).unwrap()
}

fn raised(frame: &Frame, z: f64) -> Frame {
    frame.at(frame.point([0.0, 0.0, z]))
}

pub fn cylinder() -> (Brep, f64) {
    let mut part = ExactPart::new("cylinder");
    let frame = askew();
    let (lower, a) = part.circle(&frame, 5.0);
    let (upper, b) = part.circle(&raised(&frame, 12.0), 5.0);
    let seam = part.line(a, b);
    part.ring(BrepSurface::cylinder(frame, 5.0), true, [(lower, 0.0), (upper, 12.0)], seam);
    part.plane(frame, false, &[&[(lower, false)]]);
    part.plane(raised(&frame, 12.0), true, &[&[(upper, true)]]);
    (part.solid(), 300.0 * PI)
}

/// A cylinder whose wall has two faces on one surface.
pub fn halves() -> (Brep, f64) {
    let mut part = ExactPart::new("halves");
    let (frame, radius, height) = (askew(), 5.0, 12.0);
    let mut rings = Vec::new();
    for z in [0.0, height] {
        let level = raised(&frame, z);
        let ends = [radius, -radius].map(|x| part.vertex(level.point([x, 0.0, 0.0])));
        let front = part.arc(&level, radius, PI, ends);
        let back = part.arc(&level.turned(PI), radius, PI, [ends[1], ends[0]]);
        rings.push(([front, back], ends));
    }
    let upright = [0, 1].map(|k| part.line(rings[0].1[k], rings[1].1[k]));
    let mut halves = Vec::new();
    for k in 0..2 {
        let (u, w) = (k as f64 * PI, (k + 1) as f64 * PI);
        halves.push(vec![
            part.on(rings[0].0[k], true, [u, 0.0], [w, 0.0]),
            part.on(upright[1 - k], true, [w, 0.0], [w, height]),
            part.on(rings[1].0[k], false, [u, height], [w, height]),
            part.on(upright[k], false, [u, 0.0], [u, height]),
        ]);
    }
    let surface = part.brep.add_surface(BrepSurface::cylinder(frame, radius));
    for ring in halves {
        let face = Face { surface, forward: true, loops: vec![ring] };
        part.faces.push(part.brep.add_face(face));
    }
    let [lower, upper] = [0, 1].map(|k| rings[k].0);
    part.plane(frame, false, &[&[(lower[1], false), (lower[0], false)]]);
    part.plane(raised(&frame, height), true, &[&[(upper[0], true), (upper[1], true)]]);
    (part.solid(), 300.0 * PI)
}

pub fn truncated_cone() -> (Brep, f64) {
    let mut part = ExactPart::new("truncated_cone");
    let (frame, half_angle) = (askew(), 0.3_f64);
    let wide = 5.0 + 12.0 * half_angle.tan();
    let (lower, a) = part.circle(&frame, 5.0);
    let (upper, b) = part.circle(&raised(&frame, 12.0), wide);
    let seam = part.line(a, b);
    let surface = BrepSurface::cone(frame, 5.0, half_angle);
    part.ring(surface, true, [(lower, 0.0), (upper, 12.0)], seam);
    part.plane(frame, false, &[&[(lower, false)]]);
    part.plane(raised(&frame, 12.0), true, &[&[(upper, true)]]);
    (part.solid(), 4.0 * PI * (25.0 + 5.0 * wide + wide * wide))
}

/// A cone with its apex. The frame is at the base, and z points away from the apex.
pub fn cone() -> (Brep, f64) {
    let mut part = ExactPart::new("cone");
    let (frame, radius, height) = (askew(), 5.0_f64, 12.0);
    let half_angle = (radius / height).atan();
    let (base, a) = part.circle(&frame, radius);
    let apex = part.vertex(frame.point([0.0, 0.0, -height]));
    let seam = part.line(apex, a);
    let uses = vec![
        part.on(base, false, [0.0, 0.0], [TAU, 0.0]),
        part.on(seam, false, [0.0, -height], [0.0, 0.0]),
        part.on(seam, true, [TAU, -height], [TAU, 0.0]),
    ];
    part.face(BrepSurface::cone(frame, radius, half_angle), true, vec![uses]);
    part.plane(frame, true, &[&[(base, true)]]);
    (part.solid(), PI * radius * radius * height / 3.0)
}

/// The arc of a sphere's meridian at u = 0 from one latitude to another.
fn meridian(
    part: &mut ExactPart,
    frame: &Frame,
    radius: f64,
    [v, w]: [f64; 2],
) -> (EdgeId, [VertexId; 2]) {
    let out = frame.vector([v.cos(), 0.0, v.sin()]);
    let axis = frame.y().map(|e| -e);
    let plane = Frame::new(frame.origin(), axis, out).unwrap();
    let ends = [v, w].map(|v| frame.point([radius * v.cos(), 0.0, radius * v.sin()]));
    let ends = ends.map(|at| part.vertex(at));
    (part.arc(&plane, radius, w - v, ends), ends)
}

pub fn sphere() -> (Brep, f64) {
    let mut part = ExactPart::new("sphere");
    let (frame, radius) = (askew(), 7.0);
    let (seam, _) = meridian(&mut part, &frame, radius, [-FRAC_PI_2, FRAC_PI_2]);
    let uses = vec![
        part.on(seam, false, [0.0, -FRAC_PI_2], [0.0, FRAC_PI_2]),
        part.on(seam, true, [TAU, -FRAC_PI_2], [TAU, FRAC_PI_2]),
    ];
    part.face(BrepSurface::sphere(frame, radius), true, vec![uses]);
    (part.solid(), 4.0 / 3.0 * PI * 343.0)
}

/// A sphere from which a plane cuts a cap. The loop is above the pole that is left.
pub fn flat_sphere() -> (Brep, f64) {
    let mut part = ExactPart::new("flat_sphere");
    let (frame, radius, v) = (askew(), 7.0, 0.5_f64);
    let height = radius * v.sin();
    let (seam, ends) = meridian(&mut part, &frame, radius, [-FRAC_PI_2, v]);
    let top = raised(&frame, height);
    let rim = BrepCurve::circle(&top, radius * v.cos()).unwrap();
    let rim = part.edge(rim, [ends[1]; 2]);
    let uses = vec![
        part.on(rim, false, [0.0, v], [TAU, v]),
        part.on(seam, false, [0.0, -FRAC_PI_2], [0.0, v]),
        part.on(seam, true, [TAU, -FRAC_PI_2], [TAU, v]),
    ];
    part.face(BrepSurface::sphere(frame, radius), true, vec![uses]);
    part.plane(top, true, &[&[(rim, true)]]);
    let cap = radius - height;
    (part.solid(), 4.0 / 3.0 * PI * 343.0 - PI * cap * cap * (radius - cap / 3.0))
}

/// A round bar with a drilled hole whose bottom is a cone.
pub fn drilled() -> (Brep, f64) {
    let mut part = ExactPart::new("drilled");
    let (radius, bore, half_angle) = (8.0, 3.0, 1.03_f64);
    let (lower, a) = part.circle(&level(0.0), radius);
    let (upper, b) = part.circle(&level(20.0), radius);
    let seam = part.line(a, b);
    let wall = BrepSurface::cylinder(level(0.0), radius);
    part.ring(wall, true, [(lower, 0.0), (upper, 20.0)], seam);
    part.plane(level(0.0), false, &[&[(lower, false)]]);
    let (bottom, c) = part.circle(&level(10.0), bore);
    let (rim, d) = part.circle(&level(20.0), bore);
    let seam = part.line(c, d);
    part.plane(level(20.0), true, &[&[(upper, true)], &[(rim, false)]]);
    let wall = BrepSurface::cylinder(level(10.0), bore);
    part.ring(wall, false, [(bottom, 0.0), (rim, 10.0)], seam);
    let depth = bore / half_angle.tan();
    let apex = part.vertex([0.0, 0.0, 10.0 - depth]);
    let seam = part.line(c, apex);
    let uses = vec![
        part.on(bottom, true, [0.0, 0.0], [TAU, 0.0]),
        part.on(seam, true, [TAU, 0.0], [TAU, -depth]),
        part.on(seam, false, [0.0, 0.0], [0.0, -depth]),
    ];
    part.face(BrepSurface::cone(level(10.0), bore, half_angle), false, vec![uses]);
    let hole = bore * bore * (10.0 + depth / 3.0);
    (part.solid(), PI * (radius * radius * 20.0 - hole))
}

/// A cylinder with a dome. The dome's pole is above its rim in the frame of the sphere if `up`, and
/// below it otherwise.
pub fn dome(up: bool) -> (Brep, f64) {
    let mut part = ExactPart::new(if up { "dome" } else { "turned_dome" });
    let radius = 5.0;
    let (lower, a) = part.circle(&level(0.0), radius);
    let (upper, b) = part.circle(&level(8.0), radius);
    let seam = part.line(a, b);
    let wall = BrepSurface::cylinder(level(0.0), radius);
    part.ring(wall, true, [(lower, 0.0), (upper, 8.0)], seam);
    part.plane(level(0.0), false, &[&[(lower, false)]]);
    let pole = part.vertex([0.0, 0.0, 8.0 + radius]);
    let frame = level(8.0);
    if up {
        let axis = Frame::new(frame.origin(), [0.0, 1.0, 0.0], Z).unwrap();
        let seam = part.arc(&axis, radius, FRAC_PI_2, [pole, b]);
        let uses = vec![
            part.on(upper, true, [0.0, 0.0], [TAU, 0.0]),
            part.on(seam, false, [TAU, FRAC_PI_2], [TAU, 0.0]),
            part.on(seam, true, [0.0, FRAC_PI_2], [0.0, 0.0]),
        ];
        part.face(BrepSurface::sphere(frame, radius), true, vec![uses]);
    } else {
        let axis = Frame::new(frame.origin(), [0.0, 1.0, 0.0], Z).unwrap();
        let seam = part.arc(&axis, radius, FRAC_PI_2, [pole, b]);
        let uses = vec![
            part.on(upper, true, [TAU, 0.0], [0.0, 0.0]),
            part.on(seam, false, [0.0, -FRAC_PI_2], [0.0, 0.0]),
            part.on(seam, true, [TAU, -FRAC_PI_2], [TAU, 0.0]),
        ];
        part.face(BrepSurface::sphere(frame.flipped(), radius), true, vec![uses]);
    }
    (part.solid(), PI * radius * radius * (8.0 + 2.0 / 3.0 * radius))
}

/// The pcurve of an arc on a sphere as a spline.
fn on_sphere(frame: &Frame, radius: f64, arc: &BrepCurve) -> PCurve {
    let tip = frame.origin();
    let curve = hermite(arc.range(), 256, |t| {
        let [a, b, c] = frame.coordinates(arc.point(t));
        let speed = arc.speed(t);
        let [da, db, dc] = frame.coordinates([0, 1, 2].map(|k| tip[k] + speed[k]));
        let (square, v) = (a * a + b * b, (c / radius).asin());
        [[b.atan2(a), v], [(a * db - b * da) / square, dc / (radius * v.cos())]]
    });
    curve.into()
}

/// An eighth of a ball. If `polar`, a corner of its round face is the pole of the sphere.
pub fn octant(polar: bool) -> (Brep, f64) {
    let mut part = ExactPart::new("octant");
    let radius = 6.0;
    let axes = [X, [0.0, 1.0, 0.0], Z];
    let centre = part.vertex([0.0; 3]);
    let corners = axes.map(|axis| part.vertex(axis.map(|e| radius * e)));
    let lines = corners.map(|corner| part.line(centre, corner));
    let mut arcs = Vec::new();
    for k in 0..3 {
        let next = (k + 1) % 3;
        // The arc from corner k to the next one turns about the third axis.
        let frame = Frame::new([0.0; 3], axes[(k + 2) % 3], axes[k]).unwrap();
        let arc = part.arc(&frame, radius, FRAC_PI_2, [corners[k], corners[next]]);
        // The face looks against the axis.
        let ring = [(lines[next], true), (arc, false), (lines[k], false)];
        part.plane(frame, false, &[&ring]);
        arcs.push(arc);
    }
    let (frame, uses) = if polar {
        let quarter = FRAC_PI_2;
        let uses = vec![
            part.on(arcs[0], true, [0.0, 0.0], [quarter, 0.0]),
            part.on(arcs[1], true, [quarter, 0.0], [quarter, quarter]),
            part.on(arcs[2], true, [0.0, quarter], [0.0, 0.0]),
        ];
        (Frame::WORLD, uses)
    } else {
        // The poles are outside of the face.
        let frame = Frame::new([0.0; 3], [1.0, -1.0, 0.0], [1.0, 1.0, 1.0]).unwrap();
        let of_arc = |&edge: &EdgeId| {
            let pcurve = on_sphere(&frame, radius, &part.brep.edges[edge.0].curve);
            EdgeUse { edge, forward: true, pcurve }
        };
        (frame, arcs.iter().map(of_arc).collect())
    };
    part.face(BrepSurface::sphere(frame, radius), true, vec![uses]);
    (part.solid(), 4.0 / 3.0 * PI * radius.powi(3) / 8.0)
}

pub fn torus() -> (Brep, f64) {
    let mut part = ExactPart::new("torus");
    let (frame, [major, minor]) = (askew(), [10.0, 3.0]);
    let (around, vertex) = part.circle(&frame, major + minor);
    let centre = frame.point([major, 0.0, 0.0]);
    let tube = Frame::new(centre, frame.y().map(|e| -e), frame.x()).unwrap();
    let across = part.edge(BrepCurve::circle(&tube, minor).unwrap(), [vertex; 2]);
    let uses = vec![
        part.on(across, false, [0.0, 0.0], [0.0, TAU]),
        part.on(around, true, [0.0, 0.0], [TAU, 0.0]),
        part.on(across, true, [TAU, 0.0], [TAU, TAU]),
        part.on(around, false, [0.0, TAU], [TAU, TAU]),
    ];
    part.face(BrepSurface::torus(frame, major, minor), true, vec![uses]);
    (part.solid(), 2.0 * PI * PI * major * minor * minor)
}

/// A cubic spline in Hermite form through points with their derivatives, at even parameters.
fn hermite<const D: usize>(
    range: (f64, f64),
    spans: usize,
    at: impl Fn(f64) -> [[f64; D]; 2],
) -> SplineCurve<D> {
    let step = (range.1 - range.0) / spans as f64;
    let t = |i: usize| if i == spans { range.1 } else { range.0 + step * i as f64 };
    let mut knots = vec![range.0; 2];
    let mut poles = Vec::new();
    for i in 0..=spans {
        let [p, d] = at(t(i));
        knots.extend([t(i); 2]);
        let side = |s: f64| std::array::from_fn(|k| p[k] + s * step / 3.0 * d[k]);
        match i {
            0 => poles.extend([p, side(1.0)]),
            i if i == spans => poles.extend([side(-1.0), p]),
            _ => poles.extend([side(-1.0), side(1.0)]),
        }
    }
    knots.extend([range.1; 2]);
    SplineCurve::new(3, knots, poles, None).unwrap()
}

/// A cylinder with a thinner one that leaves it at right angles. They meet in a space curve.
pub fn crossed() -> (Brep, f64) {
    let mut part = ExactPart::new("crossed");
    let (wide, thin, long, height) = (10.0_f64, 5.0_f64, 18.0, 30.0);
    let frame = level(0.0).turned(PI); // the seam is on the other side of the branch
    let branch = Frame::new([0.0, 0.0, 15.0], X, Z).unwrap(); // x of the frame is up
    // The curve over the angle t about the branch: its y and z axes, and x from the wide cylinder.
    let shape = |t: f64| {
        let (up, side) = (thin * t.cos(), thin * t.sin());
        let (d_up, d_side) = (-thin * t.sin(), thin * t.cos());
        // The y axis of the branch's frame is z × x of it: −y of the world or y.
        let x = (wide * wide - side * side).sqrt();
        let dx = -side * d_side / x;
        (up, side, x, d_up, d_side, dx)
    };
    let spans = 512;
    let curve = hermite((0.0, TAU), spans, |t| {
        let (up, side, x, d_up, d_side, dx) = shape(t);
        let p = branch.point([up, side, x]);
        [p, branch.vector([d_up, d_side, dx])]
    });
    let start = part.vertex(curve.ends()[0]);
    let cut = part.edge(BrepCurve::Spline(curve), [start; 2]);
    // The branch.
    let (rim, b) = part.circle(&raised(&branch, long), thin);
    let seam = part.line(start, b);
    let on_thin = hermite((0.0, TAU), spans, |t| {
        let (_, _, x, _, _, dx) = shape(t);
        [[t, x], [1.0, dx]]
    });
    let uses = vec![
        part.on(seam, false, [0.0, wide], [0.0, long]),
        EdgeUse { edge: cut, forward: true, pcurve: on_thin.into() },
        part.on(seam, true, [TAU, wide], [TAU, long]),
        part.on(rim, false, [0.0, long], [TAU, long]),
    ];
    part.face(BrepSurface::cylinder(branch, thin), true, vec![uses]);
    part.plane(raised(&branch, long), true, &[&[(rim, true)]]);
    // The wide cylinder with a hole. Its angle is π where the branch is.
    let across = branch.y()[1];
    let on_wide = hermite((0.0, TAU), spans, |t| {
        let (up, side, x, d_up, d_side, _) = shape(t);
        let angle = PI + (across * side / wide).asin();
        [[angle, 15.0 + up], [across * d_side / x, d_up]]
    });
    let (lower, a) = part.circle(&frame, wide);
    let (upper, c) = part.circle(&raised(&frame, height), wide);
    let seam = part.line(a, c);
    let outer = vec![
        part.on(seam, false, [0.0, 0.0], [0.0, height]),
        part.on(lower, true, [0.0, 0.0], [TAU, 0.0]),
        part.on(seam, true, [TAU, 0.0], [TAU, height]),
        part.on(upper, false, [0.0, height], [TAU, height]),
    ];
    let hole = vec![EdgeUse { edge: cut, forward: false, pcurve: on_wide.into() }];
    part.face(BrepSurface::cylinder(frame, wide), true, vec![outer, hole]);
    part.plane(frame, false, &[&[(lower, false)]]);
    part.plane(raised(&frame, height), true, &[&[(upper, true)]]);
    // The branch's volume outside of the wide cylinder. The integrand is periodic, so the
    // trapezoidal rule is exact to rounding.
    let steps = 400;
    let inside: f64 = (0..steps)
        .map(|i| {
            let t = PI * f64::from(i) / f64::from(steps);
            2.0 * (thin * t.cos()).powi(2) * (wide * wide - (thin * t.sin()).powi(2)).sqrt()
        })
        .sum::<f64>()
        * PI
        / f64::from(steps);
    let volume = PI * wide * wide * height + PI * thin * thin * long - inside;
    (part.solid(), volume)
}

/// A profile in the plane of x and z, or of x and y.
fn profile(axes: [[f64; 3]; 2]) -> SplineCurve<3> {
    let poles = [[4.0, 0.0], [9.0, 3.0], [2.0, 6.0], [6.0, 11.0], [5.0, 14.0]];
    let at = |[a, b]: [f64; 2]| [0, 1, 2].map(|i| a * axes[0][i] + b * axes[1][i]);
    let knots = vec![0.0, 0.0, 0.0, 0.0, 2.5, 4.0, 4.0, 4.0, 4.0];
    SplineCurve::new(3, knots, poles.map(at).to_vec(), None).unwrap()
}

/// The integral of f(x, dz) over the profile.
fn over_profile(f: impl Fn(f64, f64) -> f64) -> f64 {
    let curve = profile([X, Z]);
    let nodes = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_35),
    ];
    let span = |a: f64, b: f64| {
        let (m, h) = (0.5 * (a + b), 0.5 * (b - a));
        let g = |t: f64| f(curve.point(t)[0], curve.speed(t)[2]);
        nodes.iter().map(|(x, w)| w * h * (g(m - h * x) + g(m + h * x))).sum::<f64>()
    };
    span(0.0, 2.5) + span(2.5, 4.0)
}

/// A prism with one side on a spline.
pub fn extrusion() -> (Brep, f64) {
    let mut part = ExactPart::new("extrusion");
    let y = [0.0, 1.0, 0.0];
    let (curve, height) = (profile([X, y]), 9.0);
    // Counter-clockwise from above: the base line, the profile upwards, the top line, the left side.
    let outline = [[0.0, 0.0], [4.0, 0.0], [5.0, 14.0], [0.0, 14.0]];
    let [mut below, mut above, upright] = prism(&mut part, &outline, height, &[1]);
    let ends = [upright[1], upright[2]].map(|e| part.brep.edges[e.0].ends);
    below[1] = part.edge(BrepCurve::Spline(curve.clone()), [ends[0][0], ends[1][0]]);
    let raised = curve.clone().mapped(|p| [p[0], p[1], p[2] + height]);
    above[1] = part.edge(BrepCurve::Spline(raised), [ends[0][1], ends[1][1]]);
    let loops = vec![vec![
        part.on(below[1], true, [0.0, 0.0], [4.0, 0.0]),
        part.on(upright[2], true, [4.0, 0.0], [4.0, height]),
        part.on(above[1], false, [0.0, height], [4.0, height]),
        part.on(upright[1], false, [0.0, 0.0], [0.0, height]),
    ]];
    part.face(BrepSurface::extrusion(curve, Z).unwrap(), true, loops);
    lids(&mut part, [&below, &above], height, &[]);
    (part.solid(), height * over_profile(|x, dz| x * dz))
}

/// A turned part with a spline as its profile.
pub fn revolution() -> (Brep, f64) {
    let mut part = ExactPart::new("revolution");
    let curve = profile([X, Z]);
    let (lower, a) = part.circle(&level(0.0), 4.0);
    let (upper, b) = part.circle(&level(14.0), 5.0);
    let seam = part.edge(BrepCurve::Spline(curve.clone()), [a, b]);
    let surface = BrepSurface::revolution(curve, [0.0; 3], Z).unwrap();
    part.ring(surface, true, [(lower, 0.0), (upper, 4.0)], seam);
    part.plane(level(0.0), false, &[&[(lower, false)]]);
    part.plane(level(14.0), true, &[&[(upper, true)]]);
    (part.solid(), PI * over_profile(|x, dz| x * x * dz))
}

/// A box with a round empty space in it.
pub fn hollow_box() -> (Brep, f64) {
    let (mut outer, volume) = exact_box();
    let (mut part, radius) = (ExactPart::new(""), 4.0);
    let frame = Frame::new([15.0, 9.0, 5.0], [1.0, 1.0, 0.0], Z).unwrap();
    let (seam, _) = meridian(&mut part, &frame, radius, [-FRAC_PI_2, FRAC_PI_2]);
    let uses = vec![
        part.on(seam, false, [TAU, -FRAC_PI_2], [TAU, FRAC_PI_2]),
        part.on(seam, true, [0.0, -FRAC_PI_2], [0.0, FRAC_PI_2]),
    ];
    part.face(BrepSurface::sphere(frame, radius), false, vec![uses]);
    let mut void = part.solid();
    void.solids.clear();
    outer.append(void);
    outer.solids[0].voids.push(formats::brep::ShellId(1));
    outer.name = "hollow_box".into();
    (outer, volume - 4.0 / 3.0 * PI * radius.powi(3))
}

/// A cylinder whose top is cut off by an oblique plane along an ellipse.
pub fn oblique() -> (Brep, f64) {
    let mut part = ExactPart::new("oblique");
    let (frame, radius, height, tilt) = (askew(), 5.0, 12.0, 0.5_f64);
    let (lower, a) = part.circle(&frame, radius);
    let rise = radius * tilt.tan();
    let top = Frame::new(
        frame.point([0.0, 0.0, height]),
        frame.vector([-tilt.sin(), 0.0, tilt.cos()]),
        frame.vector([tilt.cos(), 0.0, tilt.sin()]),
    )
    .unwrap();
    let b = part.vertex(frame.point([radius, 0.0, height + rise]));
    let cut = BrepCurve::ellipse(&top, [radius / tilt.cos(), radius], (0.0, TAU)).unwrap();
    let cut = part.edge(cut, [b; 2]);
    let seam = part.line(a, b);
    let wave = hermite((0.0, TAU), 256, |t| [[t, height + rise * t.cos()], [1.0, -rise * t.sin()]]);
    let uses = vec![
        part.on(seam, false, [0.0, 0.0], [0.0, height + rise]),
        part.on(lower, true, [0.0, 0.0], [TAU, 0.0]),
        part.on(seam, true, [TAU, 0.0], [TAU, height + rise]),
        EdgeUse { edge: cut, forward: false, pcurve: wave.into() },
    ];
    part.face(BrepSurface::cylinder(frame, radius), true, vec![uses]);
    part.plane(frame, false, &[&[(lower, false)]]);
    part.plane(top, true, &[&[(cut, true)]]);
    (part.solid(), PI * radius * radius * height)
}

/// A quarter of a torus. Its seam runs along the bend.
pub fn elbow() -> (Brep, f64) {
    let mut part = ExactPart::new("elbow");
    let (frame, [major, minor]) = (askew(), [10.0, 3.0]);
    let mut tubes = Vec::new();
    for u in [0.0, FRAC_PI_2] {
        let turned = frame.turned(u);
        let centre = turned.point([major, 0.0, 0.0]);
        let tube = Frame::new(centre, turned.y().map(|e| -e), turned.x()).unwrap();
        let (circle, vertex) = part.circle(&tube, minor);
        tubes.push((tube, circle, vertex));
    }
    let ends = [tubes[0].2, tubes[1].2];
    let seam = part.arc(&frame, major + minor, FRAC_PI_2, ends);
    let uses = vec![
        part.on(seam, true, [0.0, 0.0], [FRAC_PI_2, 0.0]),
        part.on(tubes[1].1, true, [FRAC_PI_2, 0.0], [FRAC_PI_2, TAU]),
        part.on(seam, false, [0.0, TAU], [FRAC_PI_2, TAU]),
        part.on(tubes[0].1, false, [0.0, 0.0], [0.0, TAU]),
    ];
    part.face(BrepSurface::torus(frame, major, minor), true, vec![uses]);
    part.plane(tubes[0].0, true, &[&[(tubes[0].1, true)]]);
    part.plane(tubes[1].0, false, &[&[(tubes[1].1, false)]]);
    (part.solid(), PI * PI / 2.0 * major * minor * minor)
}

/// A sector of a turned part with a spline as its profile.
pub fn sector() -> (Brep, f64) {
    let mut part = ExactPart::new("sector");
    let (curve, angles) = (profile([X, Z]), [0.3, 1.7]);
    let [low, high] = [0.0, 14.0].map(|z| part.vertex([0.0, 0.0, z]));
    let axis = part.line(low, high);
    let mut sides = Vec::new();
    for u in angles {
        let frame = Frame::WORLD.turned(u);
        let profile = profile([frame.x(), Z]);
        let [a, b] = profile.ends().map(|end| part.vertex(end));
        let profile = part.edge(BrepCurve::Spline(profile), [a, b]);
        let (bottom, top) = (part.line(low, a), part.line(high, b));
        sides.push((frame, profile, bottom, top, [a, b]));
    }
    let turn = angles[1] - angles[0];
    let arc = |part: &mut ExactPart, z: f64, radius: f64, k: usize| {
        let ends = [sides[0].4[k], sides[1].4[k]];
        part.arc(&level(z).turned(angles[0]), radius, turn, ends)
    };
    let (lower, upper) = (arc(&mut part, 0.0, 4.0, 0), arc(&mut part, 14.0, 5.0, 1));
    let [u, w] = angles;
    let uses = vec![
        part.on(lower, true, [u, 0.0], [w, 0.0]),
        part.on(sides[1].1, true, [w, 0.0], [w, 4.0]),
        part.on(upper, false, [u, 4.0], [w, 4.0]),
        part.on(sides[0].1, false, [u, 0.0], [u, 4.0]),
    ];
    part.face(BrepSurface::revolution(curve, [0.0; 3], Z).unwrap(), true, vec![uses]);
    for (k, (frame, profile, bottom, top, _)) in sides.iter().enumerate() {
        // Seen from −y of the frame, x and z are counter-clockwise.
        let out = frame.y().map(|e| -e);
        let plane = Frame::new([0.0; 3], out, frame.x()).unwrap();
        let ring = [(*bottom, true), (*profile, true), (*top, false), (axis, false)];
        let mut back: Vec<_> = ring.iter().rev().map(|(e, f)| (*e, !f)).collect();
        if k == 0 {
            back = ring.to_vec();
        }
        part.plane(plane, k == 0, &[&back]);
    }
    let [a, b] = [&sides[0], &sides[1]];
    let top = [(a.3, true), (upper, true), (b.3, false)];
    let bottom = [(b.2, true), (lower, false), (a.2, false)];
    part.plane(level(0.0), false, &[&bottom]);
    part.plane(level(14.0), true, &[&top]);
    (part.solid(), 0.5 * turn * over_profile(|x, dz| x * x * dz))
}

/// The models with their volumes.
pub fn all_exact() -> Vec<(Brep, f64)> {
    vec![
        exact_box(),
        plate(),
        bracket(),
        cylinder(),
        halves(),
        truncated_cone(),
        cone(),
        sphere(),
        flat_sphere(),
        drilled(),
        dome(true),
        dome(false),
        octant(false),
        torus(),
        hollow_box(),
        crossed(),
        oblique(),
        elbow(),
        extrusion(),
        revolution(),
        sector(),
    ]
}
