//! Makes a PNG that shows a scan beside the CAD face that it becomes.
//!
//! `cargo run --release --example picture -- SCAN OUT.png [--size WxH]
//! [--mode MODE]`, with the modes of [`args::Mode`]

mod args;
mod bodies;
#[allow(dead_code)]
#[path = "../../tests/common/body.rs"]
mod body;
mod deviation;
mod face;
mod loops;
mod parameters;
mod scan;
mod scene;
mod stages;
mod trimmed;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Mode};
use bodies::Body;
use body::OneFace;
use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::image::Image;
use scene::Scene;

fn main() -> ExitCode {
    // This prints the usage and exits with 2 if the arguments are wrong.
    let args = Args::parse();
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<(), Box<dyn std::error::Error>> {
    let size = args.size();
    let scene = || Scene::of(&args.scan);
    let body = || Body::of(&args.scan);
    let picture = match args.mode {
        Mode::Layout => body()?.layout(size),
        Mode::Faces => body()?.faces(size),
        Mode::Pair => pair(&scene()?, size),
        Mode::Deviation => deviation::picture(&scene()?, size)?,
        Mode::Net => net(&scene()?, size),
        Mode::Uv => parameters::picture(&scene()?, size),
        Mode::Mesh => stages::mesh(&scene()?, size),
        Mode::Smooth => stages::smooth(&scene()?, size),
        Mode::Fill => stages::fill(&scene()?, size),
        Mode::Map => parameters::map(&scene()?, size),
        Mode::Trim => loops::picture(&scene()?, size),
    };
    picture.save(&args.out)?;
    Ok(())
}

/// The scan on the left and the face on the right.
fn pair(scene: &Scene, [width, height]: [usize; 2]) -> Image {
    // Both halves have the same size, so that they share one camera.
    let half = [width / 2, height];
    let camera = Camera::facing(&scene.measured.mesh, scene.extent(), half);
    let left = scan::canvas(&scene.measured.mesh, &camera, half).image();
    let right = face::picture(scene, &camera, half);
    left.beside(Image::blank([width % 2, height], scan2step::report::picture::colour::BACKGROUND))
        .beside(right)
}

/// The face with its control net.
fn net(scene: &Scene, size: [usize; 2]) -> Image {
    let net = scene.conversion.one().surface.net.iter().map(|&p| p.into());
    let camera = Camera::facing(&scene.measured.mesh, scene.extent().chain(net), size);
    face::picture_with_net(scene, &camera, size)
}
