#![no_main]

use libfuzzer_sys::fuzz_target;
use scan2step_formats_fuzz::check_points;

fuzz_target!(|content: &[u8]| check_points("scan.laz", content));
