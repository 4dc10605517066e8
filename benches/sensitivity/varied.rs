//! The values of named constants in a copy of the library that `benches/sensitivity` has rewritten.
//! The environment variable `VARIED` has the number of the constant to multiply, and `FACTOR` the
//! factor. The file that `CONSTANTS_READ` names gets the number of every constant that the run reads.

use std::env::var;
use std::fs::OpenOptions;
use std::io::Write;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

static READ: [AtomicBool; 1000] = [const { AtomicBool::new(false) }; 1000];

static VARIED: LazyLock<(usize, f64)> = LazyLock::new(|| {
    let number = var("VARIED").ok().and_then(|text| text.parse().ok());
    let factor = var("FACTOR").ok().and_then(|text| text.parse().ok());
    (number.unwrap_or(usize::MAX), factor.unwrap_or(1.0))
});

/// A value that can be multiplied. Whole numbers are rounded, and stay at least 1 from zero.
pub trait Scalable: Copy {
    fn times(self, factor: f64) -> Self;
}

impl Scalable for f64 {
    fn times(self, factor: f64) -> f64 {
        self * factor
    }
}

impl Scalable for f32 {
    fn times(self, factor: f64) -> f32 {
        self * factor as f32
    }
}

macro_rules! whole {
    ($($kind:ty),*) => {$(
        impl Scalable for $kind {
            fn times(self, factor: f64) -> $kind {
                let size = (self as f64).abs() * factor;
                (size.round().max(1.0) * (self as f64).signum()) as $kind
            }
        }
    )*};
}
whole!(usize, u32, u64, i32);

impl<T: Scalable, const N: usize> Scalable for [T; N] {
    fn times(self, factor: f64) -> Self {
        self.map(|x| x.times(factor))
    }
}

/// The value of the constant with this number in this run.
#[inline]
pub fn of<T: Scalable>(number: usize, value: T) -> T {
    if !READ[number].load(Relaxed) {
        note(number);
    }
    let (varied, factor) = *VARIED;
    if number == varied { value.times(factor) } else { value }
}

#[cold]
fn note(number: usize) {
    if READ[number].swap(true, Relaxed) {
        return;
    }
    let file =
        var("CONSTANTS_READ").map(|path| OpenOptions::new().append(true).create(true).open(path));
    if let Ok(Ok(mut file)) = file {
        let _ = file.write_all(format!("{number}\n").as_bytes());
    }
}
