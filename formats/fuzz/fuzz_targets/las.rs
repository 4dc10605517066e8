#![no_main]

use libfuzzer_sys::fuzz_target;
use scan2step_formats_fuzz::{check_points, let_laz_panic};

fuzz_target!(init: let_laz_panic(), |content: &[u8]| check_points("scan.las", content));
