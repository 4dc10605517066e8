//! The rules for the values of options. The option builders, the stages and the command line all
//! check values here, so that every rule exists once.

use std::f64::consts::PI;

use crate::geometry::Point;

/// A violation of a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A length must be finite and above 0.
    #[error("not a length above 0")]
    Length,
    /// A length that may be 0 must be finite and not negative.
    #[error("not a length of 0 or more")]
    Extent,
    /// A share must be at least 0 and below 1.
    #[error("not a share from 0 to below 1")]
    Share,
    /// An angle of the advancing front must be between 0 and π.
    #[error("not an angle between 0 and π")]
    Angle,
    /// An edge must be sharp from an angle between 0° and 180° on.
    #[error("not an angle between 0° and 180°")]
    Degrees,
    /// A point must have finite coordinates.
    #[error("not a point with finite coordinates")]
    Point,
    /// The domain may be halved at most [`MOST_HALVINGS`] times.
    #[error("not a number of halvings from 0 to {MOST_HALVINGS}")]
    Depth,
    /// A bicubic net must have at least four control points in each direction.
    #[error("a bicubic net has at least 4x4 control points")]
    SmallNet,
    /// A net has more control points than allowed.
    #[error("a net of {} × {} control points exceeds the bound of {most}", net[0], net[1])]
    LargeNet {
        /// The numbers of control points in u and in v.
        net: [usize; 2],
        /// The largest allowed number of control points.
        most: usize,
    },
    /// The faces of a body have more control points than allowed.
    #[error("{faces} faces have at least {least} control points, and {most} are allowed")]
    LargeLayout {
        /// The number of faces of the layout.
        faces: usize,
        /// The least number of control points of them all.
        least: usize,
        /// The largest allowed number of control points.
        most: usize,
    },
    /// The limit on the size of a net must be between 16 and [`MOST_CONTROL_POINTS`].
    #[error("not a number of control points from {LEAST_CONTROL_POINTS} to {MOST_CONTROL_POINTS}")]
    MaxNet,
    /// A solid has [`LEAST_FACES`] to [`MOST_FACES`] faces.
    #[error("not a number of faces from {LEAST_FACES} to {MOST_FACES}")]
    Faces,
    /// A component becomes a void only in a solid around it.
    #[error("a void needs a solid around it")]
    Void,
    /// A cloud has at least [`LEAST_POINTS`] points.
    #[error("not a number of points from {LEAST_POINTS} on")]
    MaxPoints,
    /// There are 1 to [`MOST_THREADS`] threads.
    #[error("not a number of threads from 1 to {MOST_THREADS}")]
    Threads,
}

/// The result of a check.
pub type Result<T> = std::result::Result<T, Fault>;

/// The largest number of halvings. Spans are then 2^−20 of the domain.
pub const MOST_HALVINGS: u32 = 20;

/// The largest net that may be requested. Its fit takes about 80 GB of memory.
pub const MOST_CONTROL_POINTS: usize = 1 << 24;

/// The largest number of threads that may be asked for. Far more cores than this share no
/// memory, and each thread takes 8 MB of address space for its stack.
pub const MOST_THREADS: usize = 1024;

/// The smallest number of points of a cloud. Fewer do not tell a surface from its noise.
pub const LEAST_POINTS: usize = 100;

/// The numbers of faces of a solid that may be asked for. Four four-sided faces close a torus, and a ball
/// has six. CAD systems take minutes to open a solid with more faces.
pub const LEAST_FACES: usize = 4;
/// See [`LEAST_FACES`].
pub const MOST_FACES: usize = 100_000;

/// The smallest number of control points of a bicubic net in one direction, and in total.
const SIDE: usize = 4;
const LEAST_CONTROL_POINTS: usize = SIDE * SIDE;

fn must(holds: bool, fault: Fault) -> Result<()> {
    if holds { Ok(()) } else { Err(fault) }
}

/// Checks that a length in mm is above 0.
pub fn length(mm: f64) -> Result<()> {
    must(mm > 0.0 && mm.is_finite(), Fault::Length)
}

/// Checks that a length in mm is 0 or more.
pub fn extent(mm: f64) -> Result<()> {
    must(mm >= 0.0 && mm.is_finite(), Fault::Extent)
}

/// Checks a bound on the points of a cloud.
pub fn max_points(count: usize) -> Result<()> {
    must(count >= LEAST_POINTS, Fault::MaxPoints)
}

/// Checks a share of points.
pub fn share(share: f64) -> Result<()> {
    must((0.0..1.0).contains(&share), Fault::Share)
}

/// Checks an angle of the advancing front, in radians.
pub fn angle(radians: f64) -> Result<()> {
    must(radians > 0.0 && radians < PI, Fault::Angle)
}

/// Checks an angle from which on an edge is sharp, in degrees.
pub fn degrees(degrees: f64) -> Result<()> {
    must(degrees > 0.0 && degrees.to_radians() < PI, Fault::Degrees)
}

/// Checks that points are finite.
pub fn finite(x: f64) -> Result<()> {
    must(x.is_finite(), Fault::Point)
}

/// See [`Fault::Point`].
pub fn points(points: &[Point]) -> Result<()> {
    must(points.iter().flat_map(|p| p.iter()).all(|x| x.is_finite()), Fault::Point)
}

/// Checks a number of halvings of the domain.
pub fn depth(halvings: u32) -> Result<()> {
    must(halvings <= MOST_HALVINGS, Fault::Depth)
}

/// Checks the number of control points of a net in u or in v.
pub fn side(control_points: usize) -> Result<()> {
    must(control_points >= SIDE, Fault::SmallNet)
}

/// Checks the limit on the number of control points of a net.
pub fn max_net(control_points: usize) -> Result<()> {
    let allowed = LEAST_CONTROL_POINTS..=MOST_CONTROL_POINTS;
    must(allowed.contains(&control_points), Fault::MaxNet)
}

/// Checks a number of faces of a solid.
pub fn faces(count: usize) -> Result<()> {
    must((LEAST_FACES..=MOST_FACES).contains(&count), Fault::Faces)
}

/// Threads that share the work.
pub fn threads(count: usize) -> Result<()> {
    must((1..=MOST_THREADS).contains(&count), Fault::Threads)
}

/// Checks that a net has at least 4 × 4 and in total at most `most` control points.
pub fn net(net: [usize; 2], most: usize) -> Result<()> {
    net.into_iter().try_for_each(side)?;
    must(net[0].saturating_mul(net[1]) <= most, Fault::LargeNet { net, most })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_breaks_every_rule() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            assert!(length(x).is_err() && extent(x).is_err(), "{x}");
            assert!(share(x).is_err() && angle(x).is_err(), "{x}");
        }
        assert_eq!((length(0.0), extent(0.0)), (Err(Fault::Length), Ok(())));
        assert_eq!((share(0.0), share(1.0)), (Ok(()), Err(Fault::Share)));
    }

    #[test]
    fn nets_have_bounds_that_do_not_overflow() {
        assert_eq!(net([4, 4], 16), Ok(()));
        assert_eq!(net([3, 9], 100), Err(Fault::SmallNet));
        let net_of = [usize::MAX; 2];
        assert_eq!(net(net_of, 100), Err(Fault::LargeNet { net: net_of, most: 100 }));
        assert_eq!((max_net(15), max_net(16)), (Err(Fault::MaxNet), Ok(())));
        assert_eq!((faces(3), faces(4)), (Err(Fault::Faces), Ok(())));
        assert!(max_net(usize::MAX).is_err());
    }
}
