//! B-spline curves and surfaces (ISO 10303-42, clause 4).

use std::io;

use truck_modeling::{BSplineCurve, BSplineSurface, Point2, Point3};

use super::part21::{Id, List, Part21, Run, add, reals};
use crate::number::{StepReal, distinct_knots};

pub(super) fn point(file: &mut Part21<'_>, p: Point3) -> io::Result<Id> {
    let [x, y, z] = [p.x, p.y, p.z].map(StepReal);
    add!(file, "CARTESIAN_POINT('',({x},{y},{z}))")
}

fn point2(file: &mut Part21<'_>, p: Point2) -> io::Result<Id> {
    add!(file, "CARTESIAN_POINT('',({},{}))", StepReal(p.x), StepReal(p.y))
}

/// `B_SPLINE_CURVE_WITH_KNOTS` in space.
pub(super) fn curve(file: &mut Part21<'_>, curve: &BSplineCurve<Point3>) -> io::Result<Id> {
    let poles = run(curve.control_points(), |p| point(file, *p))?;
    let closed = curve.control_points().first() == curve.control_points().last();
    knotted_curve(file, poles, curve.knot_vec(), closed)
}

/// `B_SPLINE_CURVE_WITH_KNOTS` in a parameter plane.
pub(super) fn pcurve(file: &mut Part21<'_>, curve: &BSplineCurve<Point2>) -> io::Result<Id> {
    let poles = run(curve.control_points(), |p| point2(file, *p))?;
    let closed = curve.control_points().first() == curve.control_points().last();
    knotted_curve(file, poles, curve.knot_vec(), closed)
}

fn knotted_curve(file: &mut Part21<'_>, poles: Run, knots: &[f64], closed: bool) -> io::Result<Id> {
    let degree = knots.len() - poles.count - 1;
    let (knots, counts) = distinct_knots(knots);
    add!(
        file,
        "B_SPLINE_CURVE_WITH_KNOTS('',{degree},{},.UNSPECIFIED.,{},.F.,\n{},\n{},.UNSPECIFIED.)",
        poles.list(),
        logical(closed),
        List(&counts),
        reals(&knots),
    )
}

/// `B_SPLINE_SURFACE_WITH_KNOTS`; the first index of the net is u.
pub(super) fn surface(file: &mut Part21<'_>, surface: &BSplineSurface<Point3>) -> io::Result<Id> {
    let net = surface.control_points();
    let poles = run(net.iter().flatten(), |p| point(file, *p))?;
    let rows = (0..net.len()).map(|i| poles.part(i, net[0].len()).list());
    let u_closed = net.first() == net.last();
    let v_closed = net.iter().all(|row| row.first() == row.last());
    let (u, u_counts) = distinct_knots(surface.uknot_vec());
    let (v, v_counts) = distinct_knots(surface.vknot_vec());
    add!(
        file,
        "B_SPLINE_SURFACE_WITH_KNOTS('',{},{},{},.UNSPECIFIED.,{},{},.F.,\n{},\n{},\n{},\n{},\
         .UNSPECIFIED.)",
        surface.udegree(),
        surface.vdegree(),
        List(rows),
        logical(u_closed),
        logical(v_closed),
        List(&u_counts),
        List(&v_counts),
        reals(&u),
        reals(&v),
    )
}

pub(super) fn logical(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}

/// Writes each of `items` as one entity.
fn run<T>(
    items: impl IntoIterator<Item = T>,
    mut write: impl FnMut(T) -> io::Result<Id>,
) -> io::Result<Run> {
    let mut items = items.into_iter();
    // The topology index has refused everything without poles.
    let first = items.next().ok_or(io::ErrorKind::InvalidInput)?;
    let first = write(first)?;
    let mut count = 1;
    for item in items {
        write(item)?;
        count += 1;
    }
    Ok(Run { first, count })
}
