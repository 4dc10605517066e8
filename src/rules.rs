//! What the numbers of options must be. Options, stages and the command line all
//! ask here, so that every rule is said once.

use std::f64::consts::PI;

use crate::geometry::Point;

/// What is wrong with the value of an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A length must be finite and above 0.
    #[error("not a length above 0")]
    Length,
    /// A length that may be 0 must be finite and not below.
    #[error("not a length of 0 or more")]
    Extent,
    /// A share must be 0 or more and below 1.
    #[error("not a share from 0 to below 1")]
    Share,
    /// An angle of the front must be between 0 and π.
    #[error("not an angle between 0 and π")]
    Angle,
    /// A point must have finite coordinates.
    #[error("not a point with finite coordinates")]
    Point,
    /// The domain is halved [`MOST_HALVINGS`] times at the most.
    #[error("not a number of halvings from 0 to {MOST_HALVINGS}")]
    Depth,
    /// A bicubic net has four control points a side at least.
    #[error("a bicubic net has at least 4x4 control points")]
    SmallNet,
    /// A net has more control points than it may have.
    #[error("a net of {} × {} control points exceeds the bound of {most}", net[0], net[1])]
    LargeNet {
        /// Control points along u and v.
        net: [usize; 2],
        /// The bound.
        most: usize,
    },
    /// The bound on a net must be from 16 to [`MOST_CONTROL_POINTS`].
    #[error("not a number of control points from {LEAST_CONTROL_POINTS} to {MOST_CONTROL_POINTS}")]
    MaxNet,
    /// There are 1 to [`MOST_THREADS`] threads.
    #[error("not a number of threads from 1 to {MOST_THREADS}")]
    Threads,
}

/// The result of a rule.
pub type Result<T> = std::result::Result<T, Fault>;

/// Spans are halved down to 2^−20 of the domain.
pub const MOST_HALVINGS: u32 = 20;

/// The largest net that may be asked for; its fit takes some 80 GB.
pub const MOST_CONTROL_POINTS: usize = 1 << 24;

/// The largest number of threads that may be asked for. Far more cores than this share no
/// memory, and each thread takes 8 MB of address space for its stack.
pub const MOST_THREADS: usize = 1024;

/// The shortest side of a bicubic net, and the smallest net.
const SIDE: usize = 4;
const LEAST_CONTROL_POINTS: usize = SIDE * SIDE;

fn must(holds: bool, fault: Fault) -> Result<()> {
    if holds { Ok(()) } else { Err(fault) }
}

/// A length above 0, in mm.
pub fn length(mm: f64) -> Result<()> {
    must(mm > 0.0 && mm.is_finite(), Fault::Length)
}

/// A length of 0 or more, in mm.
pub fn extent(mm: f64) -> Result<()> {
    must(mm >= 0.0 && mm.is_finite(), Fault::Extent)
}

/// A share of points.
pub fn share(share: f64) -> Result<()> {
    must((0.0..1.0).contains(&share), Fault::Share)
}

/// An angle of the front, in radians.
pub fn angle(radians: f64) -> Result<()> {
    must(radians > 0.0 && radians < PI, Fault::Angle)
}

/// Places in space.
pub fn points(points: &[Point]) -> Result<()> {
    must(points.iter().flat_map(|p| p.iter()).all(|x| x.is_finite()), Fault::Point)
}

/// Halvings of the domain.
pub fn depth(halvings: u32) -> Result<()> {
    must(halvings <= MOST_HALVINGS, Fault::Depth)
}

/// Control points of a net along u or v.
pub fn side(control_points: usize) -> Result<()> {
    must(control_points >= SIDE, Fault::SmallNet)
}

/// The bound on the control points of a net.
pub fn max_net(control_points: usize) -> Result<()> {
    let allowed = LEAST_CONTROL_POINTS..=MOST_CONTROL_POINTS;
    must(allowed.contains(&control_points), Fault::MaxNet)
}

/// Threads that share the work.
pub fn threads(count: usize) -> Result<()> {
    must((1..=MOST_THREADS).contains(&count), Fault::Threads)
}

/// A net of no more than `most` control points.
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
        assert!(max_net(usize::MAX).is_err());
    }
}
