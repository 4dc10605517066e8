#![no_main]

use libfuzzer_sys::fuzz_target;
use scan2step_formats_fuzz::check_points;
use scan2step_formats_fuzz::cloud_seeds::surveys::{with_checksums, without_checksums};

// With the checksums of the search nothing would be read.
fuzz_target!(|content: &[u8]| {
    check_points("scan.e57", &with_checksums(&without_checksums(content)));
});
