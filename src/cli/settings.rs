//! What the user chose: as the library takes it, and as reports say it.

use formats::Scene;
use scan2step::mesh::Choice;
use scan2step::report::{ScanSource, Settings};
use scan2step::stages::{fit, parameterize, smooth};
use scan2step::{Cut, Options, SurfaceChoice, TargetShape};

use super::Failure;
use super::args::{ComponentChoice, Convert, Fit, Map, OutlineChoice, ShapeChoice, SurfacesChoice};
use super::cad;
use super::input::{ReadScan, stopped};
use super::places::NamedCorners;

/// The options of the library.
pub(crate) fn options(args: &Convert) -> Result<Options, Failure> {
    let how = &args.how;
    let cut = match (how.keep_fills, how.fill_only_holes_below) {
        (true, _) => Cut::None,
        (false, Some(length)) => Cut::FromLength(length),
        (false, None) => Cut::All,
    };
    let boundary_corner_places = match &how.boundary_corners {
        NamedCorners::At(places) => Some(places.0.clone()),
        NamedCorners::Auto | NamedCorners::None => None,
    };
    let options = args.piece.cloud.options(&args.piece.scale, &args.piece.crop);
    let mut options = options
        .name(args.part_name())
        .outer_place(args.piece.outer.map(|place| place.0))
        .smooth(how.smooth)
        .boundary_corners(match how.boundary_corners {
            NamedCorners::None => smooth::Corners::None,
            NamedCorners::Auto | NamedCorners::At(_) => smooth::Corners::Auto,
        })
        .boundary_corner_places(boundary_corner_places)
        .corner_places(args.corners.clone().map(|places| places.0))
        .outline(match how.outline {
            OutlineChoice::Auto => None,
            OutlineChoice::Sides => Some(parameterize::Outline::Sides),
            OutlineChoice::Trimmed => Some(parameterize::Outline::Free),
        })
        .map(match how.map {
            Map::LeastStretch => parameterize::MapMethod::LeastStretch,
            Map::MeanValue => parameterize::MapMethod::MeanValue,
        })
        .kappa(how.kappa)
        .depth(how.depth)
        .net(how.net)
        .handles(how.handles)
        .shape(shape(how.shape))
        .surfaces(match how.surfaces {
            SurfacesChoice::Auto => SurfaceChoice::Auto,
            SurfacesChoice::Spline => SurfaceChoice::Spline,
        })
        .keep_polygons(how.keep_polygons)
        .regularize(how.regularize)
        .bias(how.bias)
        .align(how.align)
        .edges(how.edges)
        .faces(how.faces)
        .fit(match how.fit {
            Fit::Blend => fit::Method::Blend,
            Fit::Refined => fit::Method::Refined,
            Fit::Global => fit::Method::Global,
        })
        .tolerance(how.tolerance)
        .rim_tolerance(how.rim_tolerance)
        .outliers(how.outliers / 100.0)
        .cut(cut);
    if let Some(most) = how.max_net {
        options = options.max_net(most);
    }
    match how.component {
        ComponentChoice::Auto => {}
        ComponentChoice::Largest => options = options.component(Choice::Largest),
        ComponentChoice::Number(number) => options = options.component(Choice::Number(number)),
        ComponentChoice::All => options = options.all_components(true),
    }
    options.build().map_err(|e| stopped(&args.piece.scan.name, &e))
}

/// The same for reports.
pub(crate) fn settings(args: &Convert, options: &Options, scan: &ReadScan) -> Settings {
    let mut settings = Settings::of(options, &scan.source)
        .of_files(cad::schema(args.how.schema), cad::form(args.how.iges))
        .of_scene(parts(args), args.how.strict, args.piece.scale.up.word());
    // As the user wrote it: a share times 100 may differ in its last digit.
    settings.outliers = args.how.outliers;
    settings
}

/// The same for the report of an assembly.
pub(crate) fn of_files(args: &Convert, options: &Options, scene: &Scene) -> Settings {
    // Settings take the unit of the scan from any of its meshes.
    let soup = scene.meshes().first().map(|mesh| mesh.soup.clone()).unwrap_or_default();
    let source = ScanSource::of(args.piece.scan.name.display().to_string(), &soup, options);
    let mut settings = Settings::of(options, &source)
        .of_files(cad::schema(args.how.schema), cad::form(args.how.iges))
        .of_scene(parts(args), args.how.strict, args.piece.scale.up.word());
    settings.outliers = args.how.outliers;
    settings
}

/// What the user chose of the parts of a file.
fn parts(args: &Convert) -> Option<String> {
    args.how.parts.as_ref().map(ToString::to_string)
}

/// The shape that the user named.
fn shape(choice: ShapeChoice) -> Option<TargetShape> {
    match choice {
        ShapeChoice::Auto => None,
        ShapeChoice::Face => Some(TargetShape::Face),
        ShapeChoice::Shell => Some(TargetShape::Shell),
        ShapeChoice::Solid => Some(TargetShape::Solid),
    }
}
