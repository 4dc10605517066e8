//! The parameters of single kinds of entities (IGES 5.3, chapter 4).

use std::io;

use super::entity::{LoopUse, Pointer};
use super::parameters::Parameters;
use crate::spline::{SplineCurve, SplineSurface};

/// Writes entity 100, or 104 with the equation b² x² + a² y² = a² b².
pub(super) fn arc(
    p: &mut Parameters<'_>,
    centre: [f64; 2],
    [a, b]: [f64; 2],
    ends: &[[f64; 2]; 2],
) -> io::Result<()> {
    if a == b {
        p.real(0.0)?;
        p.reals(&centre)?;
    } else {
        p.reals(&[b * b, 0.0, a * a, 0.0, 0.0, -(a * b).powi(2), 0.0])?;
    }
    ends.iter().try_for_each(|end| p.reals(end))
}

pub(super) fn counted(p: &mut Parameters<'_>, parts: &[Pointer]) -> io::Result<()> {
    p.add(parts.len())?;
    parts.iter().try_for_each(|part| p.add(part))
}

pub(super) fn points(p: &mut Parameters<'_>, points: &[[f64; 3]]) -> io::Result<()> {
    points.iter().try_for_each(|point| p.reals(point))
}

/// Writes the weights of poles. They are all 1 for a polynomial.
pub(super) fn weights(
    p: &mut Parameters<'_>,
    weights: Option<&[f64]>,
    poles: usize,
) -> io::Result<()> {
    match weights {
        Some(weights) => p.reals(weights),
        None => (0..poles).try_for_each(|_| p.real(1.0)),
    }
}

/// Writes entity 126 up to its poles.
pub(super) fn curve<const D: usize>(
    p: &mut Parameters<'_>,
    c: &SplineCurve<D>,
    planar: bool,
) -> io::Result<()> {
    let poles = c.poles();
    p.add(poles.len() - 1)?;
    p.add(c.knots().degree())?;
    let closed = poles.first() == poles.last();
    // The flags are planar, closed, polynomial, periodic.
    for flag in [planar, closed, c.weights().is_none(), false] {
        p.add(u8::from(flag))?;
    }
    p.reals(c.knots().knots())?;
    weights(p, c.weights(), poles.len())
}

/// Writes entity 126 after its poles: the range and the normal of a planar curve.
pub(super) fn curve_end<const D: usize>(
    p: &mut Parameters<'_>,
    c: &SplineCurve<D>,
    normal_z: f64,
) -> io::Result<()> {
    let (start, end) = c.knots().range();
    p.reals(&[start, end, 0.0, 0.0, normal_z])
}

/// Writes entity 128. The first index of the net, which is that of u, changes fastest.
pub(super) fn surface(p: &mut Parameters<'_>, s: &SplineSurface) -> io::Result<()> {
    let (rows, columns) = (s.u().poles(), s.v().poles());
    for number in [rows - 1, columns - 1, s.u().degree(), s.v().degree()] {
        p.add(number)?;
    }
    let net: Vec<&[[f64; 3]]> = s.poles().chunks(columns).collect();
    let u_closed = net.first() == net.last();
    let v_closed = net.iter().all(|row| row.first() == row.last());
    // The flags are closed in u and v, polynomial, periodic in u and v.
    for flag in [u_closed, v_closed, s.weights().is_none(), false, false] {
        p.add(u8::from(flag))?;
    }
    p.reals(s.u().knots())?;
    p.reals(s.v().knots())?;
    let u_first = || (0..rows * columns).map(|k| (k % rows) * columns + k / rows);
    let turned: Option<Vec<f64>> = s.weights().map(|w| u_first().map(|at| w[at]).collect());
    weights(p, turned.as_deref(), rows * columns)?;
    u_first().try_for_each(|at| p.reals(&s.poles()[at]))?;
    let (u, v) = (s.u().range(), s.v().range());
    p.reals(&[u.0, u.1, v.0, v.1])
}

/// Writes entity 186: each shell with a flag that its normals point out of the material.
pub(super) fn solid(p: &mut Parameters<'_>, outer: Pointer, voids: &[Pointer]) -> io::Result<()> {
    p.add(outer)?;
    p.add(1)?;
    p.add(voids.len())?;
    for void in voids {
        p.add(void)?;
        p.add(1)?;
    }
    Ok(())
}

pub(super) fn on_surface(p: &mut Parameters<'_>, parts: [&Pointer; 3]) -> io::Result<()> {
    p.add(0)?; // nothing said about how the curve came about
    parts.into_iter().try_for_each(|part| p.add(part))?;
    p.add(3) // both curves are equally good
}

/// Writes entity 144 with an explicit outer loop (N1 = 1).
pub(super) fn trimmed(
    p: &mut Parameters<'_>,
    surface: Pointer,
    loops: &[Pointer],
) -> io::Result<()> {
    p.add(surface)?;
    p.add(1)?;
    p.add(loops.len() - 1)?;
    loops.iter().try_for_each(|l| p.add(l))
}

pub(super) fn edge_list(
    p: &mut Parameters<'_>,
    vertices: Pointer,
    edges: &[(Pointer, [usize; 2])],
) -> io::Result<()> {
    p.add(edges.len())?;
    for (curve, ends) in edges {
        p.add(curve)?;
        for end in ends {
            p.add(vertices)?;
            p.add(end + 1)?;
        }
    }
    Ok(())
}

pub(super) fn edge_loop(p: &mut Parameters<'_>, uses: &[LoopUse]) -> io::Result<()> {
    p.add(uses.len())?;
    for LoopUse { list, is_vertex, number, forward, pcurve } in uses {
        p.add(u8::from(*is_vertex))?;
        p.add(list)?;
        p.add(number + 1)?;
        p.add(u8::from(*forward))?;
        p.add(1)?; // one pcurve
        p.add(0)?; // not claimed to be an iso-curve
        p.add(pcurve)?;
    }
    Ok(())
}

pub(super) fn shell(p: &mut Parameters<'_>, faces: &[(Pointer, bool)]) -> io::Result<()> {
    p.add(faces.len())?;
    for (face, forward) in faces {
        p.add(face)?;
        p.add(u8::from(*forward))?;
    }
    Ok(())
}
