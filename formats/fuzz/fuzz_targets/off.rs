#![no_main]

use libfuzzer_sys::fuzz_target;
use scan2step_formats_fuzz::check;

fuzz_target!(|content: &[u8]| check("scan.off", content));
