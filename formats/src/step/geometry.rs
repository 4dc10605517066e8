//! Writer of curves, and of B-spline surfaces (ISO 10303-42, clause 4).

use std::io;

use super::analytic;
use super::part21::{Id, IdRange, List, Part21, add, reals};
use crate::brep::{BrepCurve, PCurve};
use crate::number::{StepReal, distinct_knots};
use crate::spline::{SplineCurve, SplineKnots, SplineSurface};

pub(super) fn point(file: &mut Part21<'_>, [x, y, z]: [f64; 3]) -> io::Result<Id> {
    let [x, y, z] = [x, y, z].map(StepReal);
    add!(file, "CARTESIAN_POINT('',({x},{y},{z}))")
}

fn point2(file: &mut Part21<'_>, [u, v]: [f64; 2]) -> io::Result<Id> {
    add!(file, "CARTESIAN_POINT('',({},{}))", StepReal(u), StepReal(v))
}

/// Writes a curve in space.
pub(super) fn curve(file: &mut Part21<'_>, curve: &BrepCurve) -> io::Result<Id> {
    match curve {
        BrepCurve::Spline(spline) => spline_curve(file, spline),
        BrepCurve::Line(line) => analytic::line(file, line),
        BrepCurve::Ellipse(ellipse) => analytic::ellipse(file, ellipse),
    }
}

/// Writes a curve in a parameter plane.
pub(super) fn pcurve(file: &mut Part21<'_>, curve: &PCurve) -> io::Result<Id> {
    match curve {
        PCurve::Spline(spline) => {
            let poles = run(spline.poles(), |p| point2(file, *p))?;
            let closed = spline.poles().first() == spline.poles().last();
            knotted_curve(file, poles, (spline.knots(), spline.weights()), closed)
        }
        PCurve::Line(line) => analytic::line(file, line),
        PCurve::Ellipse(ellipse) => analytic::flat_ellipse(file, ellipse),
    }
}

/// Writes a `B_SPLINE_CURVE_WITH_KNOTS` in space.
pub(super) fn spline_curve(file: &mut Part21<'_>, spline: &SplineCurve<3>) -> io::Result<Id> {
    let poles = run(spline.poles(), |p| point(file, *p))?;
    let closed = spline.poles().first() == spline.poles().last();
    knotted_curve(file, poles, (spline.knots(), spline.weights()), closed)
}

/// Writes a curve. A rational one is a complex entity instance that consists of its supertypes and
/// `RATIONAL_B_SPLINE_CURVE` in alphabetical order.
fn knotted_curve(
    file: &mut Part21<'_>,
    poles: IdRange,
    (knots, weights): (&SplineKnots, Option<&[f64]>),
    closed: bool,
) -> io::Result<Id> {
    let degree = knots.degree();
    let (knots, counts) = distinct_knots(knots.knots());
    let (poles, closed) = (poles.list(), logical(closed));
    let (counts, knots) = (List(&counts), reals(&knots));
    match weights {
        None => add!(
            file,
            "B_SPLINE_CURVE_WITH_KNOTS('',{degree},{poles},.UNSPECIFIED.,{closed},.F.,\n\
             {counts},\n{knots},.UNSPECIFIED.)",
        ),
        Some(weights) => add!(
            file,
            "(BOUNDED_CURVE()\nB_SPLINE_CURVE({degree},{poles},.UNSPECIFIED.,{closed},.F.)\n\
             B_SPLINE_CURVE_WITH_KNOTS({counts},\n{knots},.UNSPECIFIED.)\nCURVE()\n\
             GEOMETRIC_REPRESENTATION_ITEM()\nRATIONAL_B_SPLINE_CURVE({})\n\
             REPRESENTATION_ITEM(''))",
            reals(weights),
        ),
    }
}

/// Writes a `B_SPLINE_SURFACE_WITH_KNOTS`. The first index of the net is that of u. A rational
/// surface is a complex entity instance, as for a curve.
pub(super) fn spline_surface(file: &mut Part21<'_>, spline: &SplineSurface) -> io::Result<Id> {
    let (rows, columns) = (spline.u().poles(), spline.v().poles());
    let net: Vec<&[[f64; 3]]> = spline.poles().chunks(columns).collect();
    let poles = run(spline.poles(), |p| point(file, *p))?;
    let list = List((0..rows).map(|i| poles.part(i, columns).list()));
    let u_closed = logical(net.first() == net.last());
    let v_closed = logical(net.iter().all(|row| row.first() == row.last()));
    let (u, u_counts) = distinct_knots(spline.u().knots());
    let (v, v_counts) = distinct_knots(spline.v().knots());
    let (u_degree, v_degree) = (spline.u().degree(), spline.v().degree());
    let (u, v, u_counts, v_counts) = (reals(&u), reals(&v), List(&u_counts), List(&v_counts));
    match spline.weights() {
        None => add!(
            file,
            "B_SPLINE_SURFACE_WITH_KNOTS('',{u_degree},{v_degree},{list},.UNSPECIFIED.,\
             {u_closed},{v_closed},.F.,\n{u_counts},\n{v_counts},\n{u},\n{v},\
             .UNSPECIFIED.)",
        ),
        Some(weights) => {
            let weights = List(weights.chunks(columns).map(reals));
            add!(
                file,
                "(BOUNDED_SURFACE()\nB_SPLINE_SURFACE({u_degree},{v_degree},{list},\
                 .UNSPECIFIED.,{u_closed},{v_closed},.F.)\n\
                 B_SPLINE_SURFACE_WITH_KNOTS({u_counts},\n{v_counts},\n{u},\n{v},\
                 .UNSPECIFIED.)\nGEOMETRIC_REPRESENTATION_ITEM()\n\
                 RATIONAL_B_SPLINE_SURFACE({weights})\nREPRESENTATION_ITEM('')\nSURFACE())",
            )
        }
    }
}

pub(super) fn logical(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}

/// Writes each of `items` as one entity instance.
fn run<T>(
    items: impl IntoIterator<Item = T>,
    mut write: impl FnMut(T) -> io::Result<Id>,
) -> io::Result<IdRange> {
    let mut items = items.into_iter();
    // A spline has at least one pole.
    let first = items.next().ok_or(io::ErrorKind::InvalidInput)?;
    let first = write(first)?;
    let mut count = 1;
    for item in items {
        write(item)?;
        count += 1;
    }
    Ok(IdRange { first, count })
}
