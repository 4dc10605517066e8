//! Turning a part to the axes of the world, as a machinist sets it up: its main plane lies in z = 0, and its main axis is one of the world.

use formats::scene::Placement;

use crate::error::{Error, Result};
use crate::geometry::{Point, Vector, plane_axes};
use crate::mesh::Mesh;
use crate::primitives::Primitive;

/// A surface of a part that may be a datum.
pub(super) struct Datum {
    pub surface: Primitive,
    /// +1 if the outside of the part is where the distance to the surface is positive, -1 otherwise.
    pub side: f64,
    /// The area of its triangles.
    pub area: f64,
}

/// Directions that are parallel or perpendicular to this sine are so. The datums of a part are exactly so, or far from it.
const SAME: f64 = 1e-3;

/// The most digits of a direction that are rounding errors.
const ROUNDING: f64 = 1e-12;

/// A direction and its opposite, with what has it.
struct DatumDirection<'a> {
    along: Vector,
    area: f64,
    /// The datums, the largest first.
    datums: Vec<&'a Datum>,
}

/// Where a part is turned to.
struct DatumFrame {
    x: Vector,
    z: Vector,
    /// The point that becomes the origin, but for what the datums do not tell.
    origin: Point,
}

/// The placement that puts a part onto its datums, in mm. `None` if it has no plane and no axis.
///
/// The main plane is the largest one of the direction in which planes have most area. It lies in z = 0, and the part is above it. The main
/// axis is that of the direction in which cylinders, cones and tori have most area. It becomes the z axis or the x axis if it is perpendicular
/// to the main plane or parallel to it. Otherwise the largest plane that is perpendicular to the main one lies in x = 0. Where no
/// datum tells the origin, it is the middle of the part.
fn placement(datums: &[Datum], mesh: &Mesh) -> Option<Placement> {
    let planes = directions(datums, |surface| match *surface {
        Primitive::Plane { normal, .. } => Some(normal),
        _ => None,
    });
    let axes = directions(datums, Primitive::axis);
    let middle = mesh.points.iter().map(|p| p.coords).sum::<Vector>();
    let middle = Point::from(middle / mesh.points.len().max(1) as f64);
    let frame = match (planes.first(), axes.first()) {
        (Some(main), axis) => on_plane(main, axis, &planes, middle),
        (None, Some(axis)) => {
            let along = upright(axis.along);
            let line = axis.datums[0].surface.origin();
            let origin = line + (middle - line).dot(&along) * along;
            DatumFrame { x: across(along), z: along, origin }
        }
        (None, None) => return None,
    };
    let DatumFrame { x, z, origin } = frame;
    let x = (x - x.dot(&z) * z).normalize();
    let rows = [x, z.cross(&x), z].map(tidy);
    let axes = [0, 1, 2].map(|k| rows.map(|row| row[k]));
    let translation = rows.map(|row| -row.dot(&origin.coords));
    Some(Placement { axes, translation })
}

/// The placement of the first component, which those after it share.
pub(super) fn common(
    known: &mut Option<Placement>,
    datums: &[Datum],
    mesh: &Mesh,
) -> Result<Placement> {
    let found = known.or_else(|| placement(datums, mesh));
    *known = found;
    found.ok_or_else(|| Error::Unaligned("it has no plane and no axis".into()))
}

/// The frame on a main plane.
fn on_plane(
    main: &DatumDirection,
    axis: Option<&DatumDirection>,
    planes: &[DatumDirection],
    middle: Point,
) -> DatumFrame {
    let base = main.datums[0];
    let z = -base.side * direction(base);
    let on_base = |p: Point| p - (p - base.surface.origin()).dot(&z) * z;
    let beside = |to: Vector| planes.iter().find(|of| of.along.dot(&to).abs() < SAME);
    // Moves a point along a direction onto the largest plane that is perpendicular to it.
    let onto = |p: Point, along: Vector| {
        let of = planes.iter().find(|of| of.along.cross(&along).norm() < SAME);
        let datum = of.map_or(p, |of| of.datums[0].surface.origin());
        p + (datum - p).dot(&along) * along
    };
    if let Some(axis) = axis {
        let line = axis.datums[0].surface.origin();
        if axis.along.cross(&z).norm() < SAME {
            let x = beside(z).map_or_else(|| across(z), |of| upright(of.along));
            return DatumFrame { x, z, origin: on_base(line) };
        }
        if axis.along.dot(&z).abs() < SAME {
            let x = upright(axis.along);
            let y = z.cross(&x);
            let on_line = middle + (line - middle).dot(&y) * y;
            return DatumFrame { x, z, origin: on_base(onto(on_line, x)) };
        }
    }
    let x = beside(z).map_or_else(|| across(z), |of| -of.datums[0].side * direction(of.datums[0]));
    let y = z.cross(&x);
    DatumFrame { x, z, origin: on_base(onto(onto(middle, x), y)) }
}

/// The normal of a plane.
fn direction(of: &Datum) -> Vector {
    match of.surface {
        Primitive::Plane { normal, .. } => normal,
        _ => of.surface.axis().unwrap_or_default(),
    }
}

/// The directions of some datums, that with most area first.
fn directions(
    datums: &[Datum],
    of: impl Fn(&Primitive) -> Option<Vector>,
) -> Vec<DatumDirection<'_>> {
    let mut found: Vec<DatumDirection> = Vec::new();
    for datum in datums {
        let Some(along) = of(&datum.surface) else { continue };
        let known = found.iter_mut().find(|of| of.along.cross(&along).norm() < SAME);
        match known {
            Some(known) => {
                known.area += datum.area;
                known.datums.push(datum);
            }
            None => found.push(DatumDirection { along, area: datum.area, datums: vec![datum] }),
        }
    }
    found.iter_mut().for_each(|of| of.datums.sort_by(|a, b| b.area.total_cmp(&a.area)));
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

/// The one of two opposite directions whose largest coordinate is positive.
fn upright(along: Vector) -> Vector {
    if along[along.iamax()] < 0.0 { -along } else { along }
}

/// The direction across another one that is nearest to an axis of the world.
fn across(z: Vector) -> Vector {
    let part = |axis: Vector| axis - axis.dot(&z) * z;
    let all = [Vector::x(), Vector::y(), Vector::z()].map(part);
    let longest = all.into_iter().reduce(|a, b| if b.norm() > a.norm() + SAME { b } else { a });
    longest.unwrap_or_else(|| plane_axes(z).0)
}

/// A direction without coordinates that are rounding errors.
fn tidy(along: Vector) -> Vector {
    along.map(|x| if x.abs() < ROUNDING { 0.0 } else { x }).normalize()
}

/// A surface at its new place. Directions that are those of the world but for rounding become so.
pub(super) fn moved(surface: &Primitive, by: &Placement) -> Primitive {
    let place = |p: Point| moved_place(p, by);
    let turn = |v: Vector| tidy(Vector::from(by.turn(v.into())));
    match *surface {
        Primitive::Plane { origin, normal } => {
            Primitive::Plane { origin: place(origin), normal: turn(normal) }
        }
        Primitive::Cylinder { origin, axis, radius } => {
            Primitive::Cylinder { origin: place(origin), axis: turn(axis), radius }
        }
        Primitive::Cone { origin, axis, radius, angle } => {
            Primitive::Cone { origin: place(origin), axis: turn(axis), radius, angle }
        }
        Primitive::Sphere { centre, radius } => Primitive::Sphere { centre: place(centre), radius },
        Primitive::Torus { centre, axis, major, minor } => {
            Primitive::Torus { centre: place(centre), axis: turn(axis), major, minor }
        }
    }
}

/// A point at its new place.
pub(super) fn moved_place(p: Point, by: &Placement) -> Point {
    Point::from(by.apply(p.coords.into()))
}

/// A mesh at its new place.
pub(super) fn moved_mesh(mut mesh: Mesh, by: &Placement) -> Mesh {
    mesh.points.iter_mut().for_each(|p| *p = moved_place(*p, by));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexId;

    fn plane(at: [f64; 3], normal: [f64; 3], area: f64) -> Datum {
        let (origin, normal) = (Point::from(at), Vector::from(normal).normalize());
        Datum { surface: Primitive::Plane { origin, normal }, side: 1.0, area }
    }

    fn mesh() -> Mesh {
        let points =
            vec![Point::new(1.0, 2.0, 3.0), Point::new(3.0, 2.0, 3.0), Point::new(2.0, 5.0, 3.0)];
        Mesh { points, triangles: vec![[0, 1, 2].map(VertexId)] }
    }

    #[test]
    fn the_main_plane_lies_in_z_0_and_the_next_one_in_x_0() {
        let datums = [
            plane([7.0, 2.0, 0.0], [1.0, 0.0, 0.0], 50.0),
            plane([0.0, -4.0, 0.0], [0.0, -1.0, 0.0], 20.0),
            plane([0.0, 0.0, 9.0], [0.0, 0.0, 1.0], 5.0),
        ];
        let placed = placement(&datums, &mesh()).expect("a placement");
        let base = moved(&datums[0].surface, &placed);
        // The outside of the main plane is below.
        assert_eq!(direction_of(&base), Vector::new(0.0, 0.0, -1.0));
        assert!(base.origin().z.abs() < 1e-12);
        let side = moved(&datums[1].surface, &placed);
        assert_eq!(direction_of(&side), Vector::new(-1.0, 0.0, 0.0));
        assert!(side.origin().x.abs() < 1e-12);
        let third = moved(&datums[2].surface, &placed);
        assert!(third.origin().y.abs() < 1e-12);
        assert!(!placed.mirrors());
    }

    #[test]
    fn a_bore_through_the_main_plane_is_the_z_axis() {
        let tilt = Vector::new(0.3, -0.2, 0.9).normalize();
        let origin = Point::new(4.0, 5.0, 6.0);
        let bore = Primitive::Cylinder { origin: origin + 8.0 * tilt, axis: tilt, radius: 2.0 };
        let datums = [
            plane(origin.coords.into(), tilt.into(), 30.0),
            Datum { surface: bore, side: -1.0, area: 10.0 },
        ];
        let placed = placement(&datums, &mesh()).expect("a placement");
        let bore = moved(&bore, &placed);
        assert!(direction_of(&bore).xy().norm() == 0.0);
        assert!(bore.origin().coords.xy().norm() < 1e-12);
        assert!(moved(&datums[0].surface, &placed).origin().z.abs() < 1e-12);
    }

    #[test]
    fn without_planes_and_axes_there_is_none() {
        let ball = Primitive::Sphere { centre: Point::origin(), radius: 1.0 };
        assert!(placement(&[Datum { surface: ball, side: 1.0, area: 9.0 }], &mesh()).is_none());
    }

    fn direction_of(surface: &Primitive) -> Vector {
        match *surface {
            Primitive::Plane { normal, .. } => normal,
            _ => surface.axis().expect("an axis"),
        }
    }
}
