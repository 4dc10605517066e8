//! What the functions of the library leave behind in the process that calls them: nothing.
//!
//! One test, since what it looks at belongs to the whole process.

mod common;

use common::face_of;
use common::fixture;
use formats::{Soup, cad, step};
use rayon::ThreadPoolBuilder;
use scan2step::mesh::{self, Choice, Components, Outer};
use scan2step::stages::parameterize::MapMethod;
use scan2step::{Builder, Options, check, inspect, measured, threads};

#[test]
fn nothing_is_set_for_the_whole_process() {
    // From here on faer panics where it looks up what is set for the whole process.
    faer::disable_global_parallelism();
    let scan = formats::read_scan(&fixture("relief.ply")).expect("a scan");
    let default = Options::builder();
    let mean_value = Options::builder().map(MapMethod::MeanValue);
    let expected = [&default, &mean_value].map(|options| face(&scan, options.clone()));
    for (options, expected) in [default.clone(), mean_value].into_iter().zip(&expected) {
        for threads in [1, 3] {
            let found = face(&scan, options.clone().threads(threads));
            assert!(found == *expected, "the bytes differ with {threads} threads");
        }
        let pool = ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
        let found = pool.install(|| face(&scan, options));
        assert!(found == *expected, "the bytes differ in a pool of the caller");
    }
    look_at(&scan, &expected[0]);
    #[cfg(unix)]
    assert!(forked(|| face(&scan, default) == expected[0]), "another face in a forked process");
    ThreadPoolBuilder::new().build_global().expect("nobody has started the pool of the process");
}

/// The bytes of the STEP file of a scan's face.
fn face(scan: &Soup, options: Builder) -> Vec<u8> {
    let options = options.build().expect("sound options");
    let conversion = face_of(scan, &options).expect("a face");
    let mut file = Vec::new();
    step::write(&conversion.brep, &step::Options::default(), &mut file).expect("it is written");
    file
}

/// Inspects a scan, and measures a file of its face against it.
fn look_at(scan: &Soup, file: &[u8]) {
    let components = || -> Components {
        let made = threads::run(None, || mesh::from_soup(scan, 1.0).map(Components::new));
        made.and_then(|made| made).expect("a mesh")
    };
    inspect(components(), Choice::Largest, Outer::Auto).expect("it is inspected");
    let of = measured(&components(), &[Choice::Largest], Outer::Auto).expect("its points");
    let folder = tempfile::tempdir().expect("a folder");
    let step = folder.path().join("face.step");
    std::fs::write(&step, file).expect("a file");
    let model = cad::read_cad(&step).expect("a face");
    let found = check::check(&model, &of.mesh, None).expect("it is measured");
    assert_eq!((found.faces, found.scan_to_face.distances.len()), (1, of.mesh.points.len()));
}

/// Whether `work` says so in a process that is a copy of this one. With rayon's own pool at
/// work in this process it would wait for ever.
#[cfg(unix)]
fn forked(work: impl FnOnce() -> bool) -> bool {
    use std::time::{Duration, Instant};

    let child = match fork::fork().expect("a second process") {
        fork::Fork::Child => std::process::exit(i32::from(!work())),
        fork::Fork::Parent(child) => child,
    };
    let begun = Instant::now();
    loop {
        if let Some(status) = fork::waitpid_nohang(child).expect("the second process") {
            return fork::WIFEXITED(status) && fork::WEXITSTATUS(status) == 0;
        }
        if begun.elapsed() > Duration::from_secs(300) {
            let kill = std::process::Command::new("kill").arg(child.to_string()).status();
            panic!("the second process hangs ({kill:?})");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
