//! Options as a user may choose them.

use std::f64::consts::PI;

use proptest::prelude::*;
use scan2step::geometry::Point;
use scan2step::mesh::{Choice, Outer};
use scan2step::stages::fit;
use scan2step::stages::parameterize::Outline;
use scan2step::stages::smooth::{Corners, Support};
use scan2step::{Builder, Cut, Options, SurfaceChoice};

use crate::scan::Scan;

/// Options. Lengths are shares of the scan's size, and places are those of its parameter square.
#[derive(Debug, Clone)]
pub struct Choices {
    tolerance: Option<f64>,
    outliers: f64,
    smooth: Smooth,
    net: Option<[usize; 2]>,
    max_net: usize,
    kappa: Option<f64>,
    depth: Option<u32>,
    method: fit::Method,
    outline: Option<Outline>,
    cut: Cut,
    ear_angle: f64,
    component: Choice,
    places: Places,
}

#[derive(Debug, Clone, Copy)]
enum Smooth {
    Auto,
    Off,
    Fixed(f64),
}

#[derive(Debug, Clone)]
struct Places {
    corners: Option<[[f64; 2]; 4]>,
    kept: Option<Vec<[f64; 2]>>,
    outer: Option<[f64; 2]>,
}

/// A length from a millionth of the scan's size to ten times its size.
fn length() -> impl Strategy<Value = f64> {
    (-6.0..1.0).prop_map(|e| 10f64.powf(e))
}

fn maybe<S: Strategy>(often: f64, value: S) -> impl Strategy<Value = Option<S::Value>> {
    prop::option::weighted(often, value)
}

fn net() -> impl Strategy<Value = Option<[usize; 2]>> {
    maybe(0.4, prop_oneof![3 => [4..12_usize, 4..12], 1 => [4..80_usize, 4..80]])
}

fn places() -> impl Strategy<Value = Places> {
    let at = || [-0.1..1.1, -0.1..1.1];
    let corners = maybe(0.3, [at(), at(), at(), at()]);
    let kept = maybe(0.2, prop::collection::vec(at(), 0..9));
    (corners, kept, maybe(0.2, at())).prop_map(|(corners, kept, outer)| Places {
        corners,
        kept,
        outer,
    })
}

pub fn any() -> impl Strategy<Value = Choices> {
    use fit::Method::{Blend, Global, Refined};
    let smooth =
        prop_oneof![Just(Smooth::Auto), Just(Smooth::Off), length().prop_map(Smooth::Fixed)];
    let tolerance = maybe(0.5, length());
    let outliers = prop_oneof![Just(0.0), 0.0..0.999];
    let max_net = prop_oneof![3 => Just(900_usize), 1 => 16..900_usize];
    let method = prop_oneof![Just(Blend), Just(Global), Just(Refined)];
    let outline = maybe(0.5, prop_oneof![Just(Outline::Sides), Just(Outline::Free)]);
    let cut = prop_oneof![Just(Cut::All), Just(Cut::None), length().prop_map(Cut::FromLength)];
    let ear_angle = prop_oneof![3 => Just(5.0 * PI / 9.0), 1 => 0.01..3.13];
    let component =
        prop_oneof![5 => Just(Choice::Largest), 1 => (0..3_usize).prop_map(Choice::Number)];
    let sizes = (net(), max_net, maybe(0.2, length()), maybe(0.2, 0..=20_u32));
    let how = (tolerance, outliers, smooth, method, outline, cut, ear_angle, component);
    (sizes, how, places()).prop_map(|(sizes, how, places)| {
        let (net, max_net, kappa, depth) = sizes;
        let (tolerance, outliers, smooth, method, outline, cut, ear_angle, component) = how;
        Choices {
            tolerance,
            outliers,
            smooth,
            net,
            max_net,
            kappa,
            depth,
            method,
            outline,
            cut,
            ear_angle,
            component,
            places,
        }
    })
}

impl Choices {
    /// The options for a scan.
    pub fn options(&self, scan: &Scan) -> Options {
        let size = scan.place.scale;
        let at = |uv: [f64; 2]| Point::from(scan.place.of(scan.shape.at(uv)));
        let Places { corners, kept, outer } = &self.places;
        let kept = kept.as_ref().map(|kept| kept.iter().map(|&uv| at(uv)).collect());
        let cut = match self.cut {
            Cut::FromLength(share) => Cut::FromLength(size * share),
            other => other,
        };
        let smooth = match self.smooth {
            Smooth::Auto => Support::Auto,
            Smooth::Off => Support::Off,
            Smooth::Fixed(share) => Support::Fixed(size * share),
        };
        let options = splines()
            .tolerance(self.tolerance.map(|share| size * share))
            .outliers(self.outliers)
            .smooth(smooth)
            .net(self.net)
            .max_net(self.max_net.max(self.net.map_or(16, |[m, n]| m * n)))
            .kappa(self.kappa.map(|share| size * share))
            .depth(self.depth)
            .fit(self.method)
            .outline(self.outline)
            .cut(cut)
            .ear_angle(self.ear_angle)
            .component(self.component)
            .corners(corners.map(|corners| corners.map(at)))
            .boundary_corners(kept.map_or(Corners::Auto, Corners::At))
            .outer(outer.map_or(Outer::Auto, |uv| Outer::Near(at(uv))));
        options.build().expect("each can be chosen")
    }
}

/// Options for B-spline faces: what is not damaged is a clean mesh, and would get exact ones.
pub fn splines() -> Builder {
    Options::builder().surfaces(SurfaceChoice::Spline)
}
