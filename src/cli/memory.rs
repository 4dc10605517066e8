//! `--max-memory`: what a run will need, told from counts once the scan is read.

use bytesize::ByteSize;

use super::Failure;
use super::args::{Convert, How};
use super::input::Scan;

/// The program itself.
const PROGRAM: u64 = 25_000_000;

/// Bytes a triangle and a vertex of the file, through all stages but the fit. The
/// most that was measured, on scans from 4,000 to a million vertices, is 800 a
/// triangle, where many holes are filled; clean ones take 300. How much fills add,
/// counts do not tell.
const TRIANGLE: u64 = 1_000;
const VERTEX: u64 = 200;

/// The same for reports that show the scan, and what their picture takes of any scan;
/// measured: 153 MB.
const PICTURED_TRIANGLE: u64 = 300;
const PICTURE: u64 = 170_000_000;

/// Bytes a control point while the largest net is fitted; measured: 4,250 for a uniform
/// net, 5,500 where a tolerance that cannot be met takes all that there may be, 14,000
/// where folds are taken out all over the net.
const CONTROL_POINT: u64 = 16_000;

/// Refuses a run that may need more than the user allows.
pub fn check(args: &Convert, scan: &Scan) -> Result<(), Failure> {
    let Some(allowed) = args.manner.max_memory else { return Ok(()) };
    let needed = needed(args, scan.counts);
    if needed <= allowed.as_u64() {
        return Ok(());
    }
    let [vertices, triangles] = scan.counts;
    let needed = ByteSize::b(needed).display().si();
    Err(Failure {
        error: format!(
            "{}: may need {needed} for {vertices} vertices, {triangles} triangles and up to {} control points; --max-memory allows {}",
            scan.path.display(),
            largest_net(&args.how, vertices),
            allowed.display().si()
        ),
        help: "allow more, bound the net with a smaller --max-net, or thin the scan".into(),
    })
}

/// Bytes that a run with such counts of vertices and triangles may need.
fn needed(args: &Convert, [vertices, triangles]: [usize; 2]) -> u64 {
    let pictured = args.report.iter().any(|file| file.kind.is_picture());
    let (picture, shown) = if pictured { (PICTURE, PICTURED_TRIANGLE) } else { (0, 0) };
    let each = |count: usize, bytes: u64| (count as u64).saturating_mul(bytes);
    let parts = [picture, each(triangles, TRIANGLE + shown), each(vertices, VERTEX)];
    let net = each(largest_net(&args.how, vertices), CONTROL_POINT);
    parts.into_iter().fold(PROGRAM.saturating_add(net), u64::saturating_add)
}

/// Control points at the most: as many as the user asks for or, where neither a tolerance
/// nor knots are named, as the points bear. Knots by a κ or a depth of the user's may
/// be as many as `--max-net` allows, whatever the scan.
fn largest_net(how: &How, vertices: usize) -> usize {
    let is_named = how.tolerance.is_some() || how.kappa.is_some() || how.depth.is_some();
    match how.net {
        Some([m, n]) => m.saturating_mul(n),
        None if is_named => how.max_net,
        None => how.max_net.min(vertices / 2),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::args::{Cli, Command};

    fn largest(options: &[&str]) -> usize {
        let words = ["scan2step", "convert", "a.ply", "a.step", "--max-net", "5000"];
        let cli = Cli::try_parse_from(words.iter().chain(options)).unwrap();
        let Command::Convert(args) = cli.command else { panic!("it converts") };
        largest_net(&args.how, 1000)
    }

    #[test]
    fn knots_that_are_named_may_make_the_largest_net() {
        assert_eq!(largest(&[]), 500);
        assert_eq!(largest(&["--net", "20x30"]), 600);
        for named in [["--tolerance", "0.1"], ["--kappa", "0.1"], ["--depth", "6"]] {
            assert_eq!(largest(&named), 5000, "{named:?}");
        }
    }
}
