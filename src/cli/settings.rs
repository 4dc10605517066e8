//! What the user chose: as the library takes it, and as reports say it.

use clap::ValueEnum;
use scan2step::mesh::Outer;
use scan2step::{Cut, Options, fit, parameterize, smooth};
use serde_json::{Value, json};

use super::Failure;
use super::args::{Component, Convert, Fit, Map, Outline};
use super::cad::part_name;
use super::input::{Scan, stopped};
use super::places::{Corners, Place, Places};

/// What the pipeline takes.
pub fn options(args: &Convert, scan: &Scan) -> Result<Options, Failure> {
    let resolve = |places: &Places| scan.resolve(places);
    let corners = args.corners.as_ref().map(resolve).transpose()?;
    let corners = corners.map(|c| {
        <[_; 4]>::try_from(c)
            .map_err(|_| failure(args, "--corners: not four corners", "name exactly four"))
    });
    let corners = corners.transpose()?;
    // The loop that has the corners is the outer one, unless another is named.
    let outer = match (scan.outer(&args.piece)?, corners) {
        (Outer::Auto, Some([first, ..])) => Outer::Near(first),
        (outer, _) => outer,
    };
    let boundary_corners = match &args.how.boundary_corners {
        Corners::Auto => smooth::Corners::Auto,
        Corners::None => smooth::Corners::None,
        Corners::At(places) => smooth::Corners::At(resolve(places)?),
    };
    let cut = match (args.how.keep_fills, args.how.fill_only_holes_below) {
        (true, _) => Cut::None,
        (false, Some(length)) => Cut::FromLength(length),
        (false, None) => Cut::All,
    };
    let how = &args.how;
    let options = Options::builder()
        .name(part_name(&args.piece.scan))
        .unit(scan.unit)
        .outer(outer)
        .smooth(how.smooth)
        .boundary_corners(boundary_corners)
        .corners(corners)
        .outline(match how.outline {
            Outline::Auto => None,
            Outline::Sides => Some(parameterize::Outline::Sides),
            Outline::Trimmed => Some(parameterize::Outline::Free),
        })
        .map(match how.map {
            Map::LeastStretch => parameterize::MapMethod::LeastStretch,
            Map::MeanValue => parameterize::MapMethod::MeanValue,
        })
        .kappa(how.kappa)
        .depth(how.depth)
        .net(how.net)
        .max_net(how.max_net)
        .fit(match how.fit {
            Fit::Blend => fit::Method::Blend,
            Fit::Refined => fit::Method::Refined,
            Fit::Global => fit::Method::Global,
        })
        .tolerance(how.tolerance)
        .rim_tolerance(how.rim_tolerance)
        .outliers(how.outliers / 100.0)
        .cut(cut);
    options.build().map_err(|e| stopped(&args.piece.scan, &e))
}

fn failure(args: &Convert, what: &str, help: &str) -> Failure {
    Failure { error: format!("{}: {what}", args.piece.scan.display()), help: help.into() }
}

/// The same for reports, by the options' names. What is found on the scan is
/// `null`.
pub fn as_json(args: &Convert) -> Value {
    let places = |places: &Places| match places {
        Places::Vertices(v) => json!(v),
        Places::Points(p) => json!(p),
    };
    let place = |place: Place| match place {
        Place::Vertex(v) => json!([v]),
        Place::Point(p) => json!([p]),
    };
    json!({
        "units": args.piece.scale.units.map(name),
        "outer": args.piece.outer.map(place),
        "tolerance": args.how.tolerance,
        "rim_tolerance": args.how.rim_tolerance,
        "outliers": args.how.outliers,
        "corners": args.corners.as_ref().map(places),
        "outline": name(args.how.outline),
        "map": name(args.how.map),
        "boundary_corners": match &args.how.boundary_corners {
            Corners::Auto => json!("auto"),
            Corners::None => json!("none"),
            Corners::At(at) => places(at),
        },
        "smooth": match args.how.smooth {
            smooth::Support::Auto => json!("auto"),
            smooth::Support::Off => json!("off"),
            smooth::Support::Fixed(h) => json!(h),
        },
        "fit": name(args.how.fit),
        "kappa": args.how.kappa,
        "depth": args.how.depth,
        "net": args.how.net,
        "max_net": args.how.max_net,
        "fill_only_holes_below": args.how.fill_only_holes_below,
        "keep_fills": args.how.keep_fills,
        "component": match args.how.component {
            Component::Largest => json!("largest"),
            Component::All => json!("all"),
            Component::Number(n) => json!(n),
        },
        "schema": name(args.how.schema),
        "iges": name(args.how.iges),
    })
}

/// The name that a value has on the command line.
fn name(value: impl ValueEnum) -> Option<String> {
    value.to_possible_value().map(|v| v.get_name().to_owned())
}
