#![no_main]

use libfuzzer_sys::fuzz_target;
use scan2step_formats_fuzz::check_model;

// The content is the model of a package.
fuzz_target!(|content: &[u8]| check_model(content));
