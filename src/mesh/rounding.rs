//! How exactly a file states its coordinates.

use formats::Soup;

use super::Build;
use crate::geometry::{NONE, Point, SAMPLE, Vector, bounds};
use crate::statistics::median;

/// What a modelling kernel itself leaves open, as a share of the diagonal of the part. Kernels work to 1e-7 mm on
/// parts of about 100 mm, whatever the unit of the file.
const KERNEL_SHARE: f64 = 1e-9;

/// A decimal lattice counts only if chance explains it less than once in so many parts.
const LATTICE_ODDS: f64 = 20.0;

/// The last digit of a rounded number is zero once in ten times. That of a number that a designer chose is zero at
/// least every second time.
const ROUNDED: f64 = 0.1;
const CHOSEN: f64 = 0.5;

/// Designers choose numbers of up to two decimals. Beyond, what they chose is zero, in rounded files too, or a fraction of an
/// inch, whose last digit is a five; that of other rounded numbers is one of nine.
const CHOSEN_PLACES: i32 = 2;
const ROUNDED_FIVES: f64 = 1.0 / 9.0;

/// Numbers are read from text to about this share.
const TEXT: f64 = 1e-12;

/// The finest decimal place that is looked for: those of float64 end there for parts of any size.
const MOST_DECIMALS: i32 = 12;

/// The steps in which the numbers of a file are written.
#[derive(Debug, Clone, PartialEq)]
pub struct FileRounding {
    /// Whether every number is one of 32 bits, or was one before it was written with its decimals.
    pub is_single: bool,
    /// Whether the decimals were cut off a multiple in 32 bits, as lib3mf does. Otherwise numbers were rounded.
    pub is_cut: bool,
    /// Decades (the exponent of the first digit) whose numbers lie on a decimal lattice, with its decimal places.
    pub decimals: Vec<(i32, i32)>,
}

/// How exactly the numbers of a file state the vertices of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct VertexErrors {
    /// The bound of the error of each vertex, in the mesh's unit.
    pub bounds: Vec<f64>,
    /// Whether every number is one of 32 bits, or was one.
    pub is_single: bool,
}

impl FileRounding {
    /// Finds the steps from the numbers of a file.
    pub fn of(points: &[[f64; 3]]) -> Self {
        let used = points.iter().filter(|p| p.iter().all(|x| x.is_finite()));
        let mut numbers: Vec<f64> = used.flatten().map(|x| x.abs()).filter(|&x| x > 0.0).collect();
        numbers.sort_unstable_by(f64::total_cmp);
        numbers.dedup();
        let is_single = numbers.iter().all(|&x| f64::from(x as f32) == x);
        let decade = |a: &f64, b: &f64| exponent(*a) == exponent(*b);
        // One number of decimals for all, or one for each decade if the digits are counted from the first one.
        let common = decimal_places(&numbers, is_single);
        let lattices = numbers.chunk_by(decade).filter_map(|same| {
            let places = common.or_else(|| decimal_places(same, is_single));
            places.map(|places| (exponent(same[0]), places))
        });
        let decimals: Vec<(i32, i32)> = lattices.collect();
        let of_single =
            |is_cut: &bool| common.is_some_and(|places| were_single(&numbers, places, *is_cut));
        let how = [false, true].into_iter().find(of_single).filter(|_| !is_single);
        FileRounding { is_single: is_single || how.is_some(), is_cut: how == Some(true), decimals }
    }

    /// The step between the largest numbers of the corners of a soup, as far as its digits tell: that of its decimals,
    /// whose number is fixed or counted from the first digit, or that of numbers of 32 bits. 0 if neither shows.
    pub(crate) fn largest_step(soup: &Soup) -> f64 {
        let corners = || soup.polygons.iter().flatten();
        let at = |&corner: &u32| soup.points.get(corner as usize);
        let used = corners().filter_map(at).flatten().map(|x| x.abs()).filter(|x| x.is_finite());
        let (largest, is_single) = used.fold((0.0f64, true), |(largest, is_single), x| {
            (largest.max(x), is_single && f64::from(x as f32) == x)
        });
        let single = if is_single { 2.0 * half_ulp(largest, true) } else { 0.0 };
        let mut sample: Vec<u32> =
            corners().step_by((3 * corners().count()).div_ceil(SAMPLE).max(1)).copied().collect();
        sample.sort_unstable();
        sample.dedup();
        let drawn = sample.iter().filter_map(at).flatten().map(|x| x.abs());
        // Powers of ten that scale smaller numbers are infinite.
        let numbers: Vec<f64> = drawn.filter(|x| x.is_normal()).collect();
        let places = |mut numbers: Vec<f64>| {
            numbers.sort_unstable_by(f64::total_cmp);
            numbers.dedup();
            // Heights on a grid are one number of three, and hardly repeated. A design repeats most of its numbers.
            let is_measured = numbers.len() >= sample.len();
            let (places, digits) = lattice(&numbers, is_single).filter(|_| is_measured)?;
            // Many last digits are zero if a designer chose the numbers, or if places are counted from the other end.
            (odds(&digits, CHOSEN_PLACES) > LATTICE_ODDS.ln()).then_some(places)
        };
        let from_first = || numbers.iter().map(|x| x / 10f64.powi(exponent(*x))).collect();
        let counted = || Some(places(from_first())? - exponent(largest));
        let decimals = places(numbers.clone()).or_else(counted);
        decimals.map_or(single, |places| single.max(10f64.powi(-places)))
    }

    /// The median side of the polygons of a soup, if the largest numbers are in coarser steps (`step`), so that
    /// neighbours change places. Heights may be in such steps along the axis that most of the area faces.
    pub(crate) fn lost_side(soup: &Soup, step: f64) -> Option<f64> {
        let every = soup.polygons.len().div_ceil(SAMPLE).max(1);
        let (mut sides, mut area, mut farthest) = (Vec::new(), Vector::zeros(), Vector::zeros());
        for corners in soup.polygons.iter().step_by(every) {
            let Some(&[a, b, c]) = corners.first_chunk() else { continue };
            let at = |v: u32| soup.points.get(v as usize).map(|p| Point::from(*p));
            let (Some(a), Some(b), Some(c)) = (at(a), at(b), at(c)) else { continue };
            sides.extend([(b - a).norm(), (c - b).norm()].iter().filter(|&&side| side > 0.0));
            area += (b - a).cross(&(c - a)).abs();
            farthest = farthest.sup(&a.coords.abs());
        }
        let side = median(&mut sides)?;
        (side < step && area.imax() != farthest.imax()).then_some(side)
    }

    /// The bound of the error of one number.
    fn error_of(&self, x: f64) -> f64 {
        let binary = half_ulp(x, self.is_single);
        let first = exponent(x.abs().max(f64::MIN_POSITIVE));
        let nearest = self.decimals.iter().min_by_key(|(decade, _)| (decade - first).abs());
        nearest.map_or(binary, |&(_, places)| {
            let step = 10f64.powi(-places);
            if self.is_cut { 2.0 * binary + step } else { binary + 0.5 * step }
        })
    }

    /// The bound of the error of a point of the file, for a part with this diagonal.
    pub(crate) fn error(&self, p: [f64; 3], diagonal: f64) -> f64 {
        let [x, y, z] = p.map(|x| self.error_of(x));
        Point::new(x, y, z).coords.norm() + KERNEL_SHARE * diagonal
    }

    /// The errors of the vertices of a mesh that was built of a soup, in the mesh's unit. `factor` is the length of
    /// the soup's unit in that of the mesh.
    pub fn errors(&self, soup: &Soup, build: &Build, factor: f64) -> Vec<f64> {
        let diagonal = build.mesh.diagonal() / factor;
        let mut by_place = vec![0.0f64; soup.points.len() + 1];
        for (point, &place) in soup.points.iter().zip(&build.vertices) {
            if place != NONE {
                by_place[place as usize] = factor * self.error(*point, diagonal);
            }
        }
        build.place.iter().map(|&place| by_place[place as usize]).collect()
    }

    /// The errors of the vertices of a mesh whose numbers are those of its file times `unit`.
    pub(crate) fn errors_of(points: &[Point], unit: f64) -> VertexErrors {
        let numbers: Vec<[f64; 3]> = points.iter().map(|p| (p / unit).into()).collect();
        let [low, high] = bounds(points.iter().copied());
        let (rounding, diagonal) = (FileRounding::of(&numbers), (high - low).norm() / unit);
        let bounds = numbers.into_iter().map(|p| unit * rounding.error(p, diagonal)).collect();
        VertexErrors { bounds, is_single: rounding.is_single }
    }

    /// In words, for reports.
    pub fn name(&self) -> String {
        let bits = if self.is_single { "float32" } else { "float64" };
        let places = self.decimals.iter().map(|&(_, places)| places).max();
        places.map_or_else(|| bits.into(), |places| format!("{places} decimals"))
    }
}

/// The exponent of the first decimal digit. The tiny number keeps exact powers of ten in their own decade.
fn exponent(x: f64) -> i32 {
    (x.log10() + 1e-12).floor() as i32
}

/// Half the step between neighbouring binary numbers.
fn half_ulp(x: f64, is_single: bool) -> f64 {
    let epsilon = if is_single { f64::from(f32::EPSILON) } else { f64::EPSILON };
    let least = f64::from(f32::MIN_POSITIVE);
    0.5 * epsilon * 2f64.powf(x.abs().max(least).log2().floor())
}

/// The decimal places of a lattice that holds all numbers, which ascend, if they use it as roundings do.
fn decimal_places(numbers: &[f64], is_single: bool) -> Option<i32> {
    let (places, digits) = lattice(numbers, is_single)?;
    (odds(&digits, places) > LATTICE_ODDS.ln()).then_some(places)
}

/// The decimal places of a lattice that holds all numbers, which ascend, and how often each last digit is there.
fn lattice(numbers: &[f64], is_single: bool) -> Option<(i32, [f64; 10])> {
    // A number of 32 bits is the nearest to its decimal one, or next to it.
    let slack = |x: f64| if is_single { 2.02 * half_ulp(x, true) } else { TEXT * x };
    let on_lattice = |places: i32| {
        let step = 10f64.powi(-places);
        numbers.iter().all(|&x| (x - (x / step).round() * step).abs() <= slack(x))
    };
    let first = exponent(*numbers.last()?);
    let places = (-first - 1..MOST_DECIMALS).find(|&places| on_lattice(places))?;
    let step = 10f64.powi(-places);
    let widest = numbers.iter().map(|&x| slack(x)).fold(0.0, f64::max);
    if step <= 4.0 * widest {
        return None;
    }
    let mut digits = [0.0; 10];
    numbers.iter().for_each(|x| digits[((x / step).round() % 10.0) as usize] += 1.0);
    Some((places, digits))
}

/// Whether numbers with so many decimals were written from numbers of 32 bits. If their decimals were cut off, each is a whole
/// number of 32 bits times the last place. Otherwise it is next to a number of 32 bits. Few decimal numbers are either.
fn were_single(numbers: &[f64], places: i32, is_cut: bool) -> bool {
    let step = 10f64.powi(-places);
    let is_one = |&x: &f64| {
        if is_cut {
            let whole = (x / step).round();
            f64::from(whole as f32) == whole
        } else {
            (x - f64::from(x as f32)).abs() <= 0.5 * step + TEXT * x
        }
    };
    let rarity = |&x: &f64| {
        let apart = if is_cut { half_ulp(x / step, true) } else { half_ulp(x, true) / step };
        (2.0 * apart).max(1.0).ln()
    };
    numbers.iter().all(is_one) && numbers.iter().map(rarity).sum::<f64>() > LATTICE_ODDS.ln()
}

/// The logarithm of the odds that numbers with these last digits were rounded.
fn odds(digits: &[f64; 10], places: i32) -> f64 {
    let used: f64 = digits[1..].iter().sum();
    let odds = |usual: f64, rare: f64, share: f64| {
        usual * ((1.0 - share) / (1.0 - CHOSEN)).ln() + rare * (share / CHOSEN).ln()
    };
    if places <= CHOSEN_PLACES {
        odds(used, digits[0], ROUNDED)
    } else {
        odds(used - digits[5], digits[5], ROUNDED_FIVES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates of a designer's part, with digits that are all used.
    fn points() -> Vec<[f64; 3]> {
        let turn = |k: usize| 0.37 * k as f64;
        (0..60).map(|k| [40.0 * turn(k).cos(), 40.0 * turn(k).sin(), 0.1 * turn(k)]).collect()
    }

    #[test]
    fn numbers_of_32_bits_are_told_from_their_decimals() {
        let rounded = |x: f64| format!("{x:.6}").parse().expect("a number");
        let cut = |x: f64| f64::from((x as f32 * 1e6).trunc()) / 1e6;
        let single = |x: f64| f64::from(x as f32);
        type Written<'a> = &'a dyn Fn(f64) -> f64;
        let files: [(Written, bool, bool); 3] =
            [(&|x| rounded(single(x)), true, false), (&cut, true, true), (&rounded, false, false)];
        for (written, is_single, is_cut) in files {
            let of: Vec<[f64; 3]> = points().iter().map(|p| p.map(written)).collect();
            let rounding = FileRounding::of(&of);
            assert_eq!([rounding.is_single, rounding.is_cut], [is_single, is_cut]);
            assert!(rounding.decimals.iter().all(|&(_, places)| places == 6), "{rounding:?}");
            let off = of.iter().flatten().zip(points().into_iter().flatten());
            let share = off.map(|(x, y)| (x - y).abs() / rounding.error_of(y)).fold(0.0, f64::max);
            assert!(share > 0.5 && share < 1.0 + 1e-6, "{share} of the bound");
        }
    }

    /// The step of a soup of these numbers, as they are written.
    fn step_as(numbers: &[[f64; 3]], written: &dyn Fn(f64) -> f64) -> f64 {
        let points = numbers.iter().map(|p| p.map(written)).collect();
        let mut soup = Soup { points, ..Soup::default() };
        soup.polygons.push(0..numbers.len() as u32);
        // What no polygon uses has no say.
        soup.points.push([f64::MAX; 3]);
        FileRounding::largest_step(&soup)
    }

    #[test]
    fn the_step_of_a_file_is_that_of_its_last_digits() {
        let is_near = |x: f64, y: f64| (x / y - 1.0).abs() < 1e-9;
        let fixed = |x: f64| format!("{x:.2}").parse::<f64>().expect("a number");
        let counted = |x: f64| format!("{x:.3e}").parse::<f64>().expect("a number");
        let single = |x: f64| f64::from(x as f32);
        assert!(is_near(step_as(&points(), &fixed), 1e-2));
        assert!(is_near(step_as(&points(), &|x| single(fixed(x))), 1e-2));
        assert!(is_near(step_as(&points(), &counted), 1e-2));
        // Numbers of 32 bits far from zero, numbers of 64 bits, and numbers that a designer chose.
        let far: Vec<_> = points().iter().map(|p| p.map(|x| x + 5e6)).collect();
        assert!((0.5..0.7).contains(&step_as(&far, &single)));
        assert_eq!(step_as(&points(), &|x| x), 0.0);
        assert_eq!(step_as(&[[-2.9e-309, 0.0, 0.0]], &|x| x), 0.0);
        let chosen = |x: f64| (x / 4.0).round() * 3.0;
        assert!(step_as(&points(), &chosen) < 1e-4);
    }
}
