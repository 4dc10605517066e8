//! The named scans of benches and documents.

use crate::virtual_scan::{Star, Truth, VirtualScan, paper_scan, sheet};

/// The available scans: the name, the surface, the points along a side, the noise in mm, and the
/// holes. `grid250k` is for programs that need complete grids.
const SCANS: [(&str, Truth, usize, f64, &[Star]); 10] = [
    ("paper2500", sheet, 50, 0.0, &[]),
    ("roll40k", roll, 200, 0.05, &ROLL_HOLES),
    ("relief10k", relief, 100, 0.08, &RELIEF_HOLES),
    ("relief60k", relief, 250, 0.08, &RELIEF_HOLES),
    ("relief100k", relief, 316, 0.08, &RELIEF_HOLES),
    ("relief250k", relief, 500, 0.08, &RELIEF_HOLES),
    ("relief1m", relief, 1000, 0.08, &RELIEF_HOLES),
    ("relief4m", relief, 2000, 0.08, &RELIEF_HOLES),
    ("relief20m", relief, 4510, 0.08, &RELIEF_HOLES),
    ("grid250k", relief, 500, 0.08, &[]),
];

const ROLL_HOLES: [Star; 4] = [
    Star { centre: [0.3, 0.3], radius: 0.06, arms: 5.0 },
    Star { centre: [0.7, 0.65], radius: 0.09, arms: 3.0 },
    Star { centre: [0.45, 0.8], radius: 0.04, arms: 4.0 },
    Star { centre: [0.62, 0.22], radius: 0.03, arms: 6.0 },
];

const RELIEF_HOLES: [Star; 3] = [
    Star { centre: [0.5, 0.2], radius: 0.05, arms: 5.0 },
    Star { centre: [0.3, 0.63], radius: 0.04, arms: 3.0 },
    Star { centre: [0.72, 0.5], radius: 0.03, arms: 5.0 },
];

/// All names, for error messages.
pub fn names() -> String {
    let named = SCANS.iter().map(|scan| scan.0);
    named.chain(["paper8100"]).collect::<Vec<_>>().join(", ")
}

/// The scan with the given name. It is the same in every run.
pub fn scan(name: &str) -> Option<VirtualScan> {
    if name == "paper8100" {
        return Some(paper_scan());
    }
    let &(_, truth, side, noise, holes) = SCANS.iter().find(|scan| scan.0 == name)?;
    Some(VirtualScan::new(truth, [side, side], noise, holes.to_vec(), 1))
}

/// Three quarters of a rippled barrel with a thickness of 80 mm and a length of 120 mm. It
/// overhangs.
fn roll(u: f64, v: f64) -> [f64; 3] {
    let (angle, y) = (1.5 * std::f64::consts::PI * (u - 0.5), 120.0 * (v - 0.5));
    let ripples = 1.5 * (5.0 * angle).sin() * (y / 12.0).cos();
    let radius = 40.0 + 6.0 * (y / 25.0).cos() + ripples;
    [radius * angle.sin(), y, radius * angle.cos()]
}

/// A relief of 160 × 220 mm that resembles a face: a broad form, a steep nose, eyes, and fine
/// wrinkles in one quarter.
fn relief(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = (160.0 * (u - 0.5), 220.0 * (v - 0.5));
    let bump = |at: [f64; 2], size: [f64; 2]| {
        (-((x - at[0]) / size[0]).powi(2) - ((y - at[1]) / size[1]).powi(2)).exp()
    };
    let form = 60.0 * (1.7 - (x / 95.0).powi(2) - (y / 130.0).powi(2)).sqrt();
    let nose = 22.0 * bump([0.0, -5.0], [11.0, 28.0]);
    let eyes = 9.0 * (bump([32.0, 30.0], [14.0, 9.0]) + bump([-32.0, 30.0], [14.0, 9.0]));
    let wrinkles = 0.8 * (x / 1.8).sin() * bump([40.0, -60.0], [20.0, 25.0]);
    [x, y, form + nose - eyes + wrinkles]
}
