//! Measures each stage and the whole conversion on virtual scans with three holes.
//!
//! cargo bench                                      10⁴ and 10⁵ points, in some minutes
//! cargo bench -- smooth                            stages with this in their name
//! SCAN2STEP_BENCH=large cargo bench -- relief4m   10⁶ and 4·10⁶ points, too
//!
//! Times are CPU seconds of all threads. The throughput is in measured points.

#[allow(dead_code)]
#[path = "../../tests/common/body.rs"]
mod body;
mod cpu;
#[path = "../../examples/virtual_scan/named.rs"]
#[allow(dead_code)]
mod named;
mod prepared;
mod tasks;
#[path = "../../tests/common/virtual_scan.rs"]
#[allow(dead_code)]
mod virtual_scan;

use std::cell::OnceCell;
use std::time::Duration;

use criterion::{
    BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};

use cpu::CpuTime;
use prepared::Prepared;
use tasks::{TASKS, ended};

/// The number of points of the complete grids, and the names of the scans.
const SIZES: [(u64, &str); 2] = [(10_000, "relief10k"), (100_000, "relief100k")];
const LARGE: [(u64, &str); 2] = [(1_000_000, "relief1m"), (4_000_000, "relief4m")];

fn stages(criterion: &mut Criterion<CpuTime>) {
    let large = std::env::var("SCAN2STEP_BENCH").is_ok_and(|size| size == "large");
    let more = if large { &LARGE[..] } else { &[] };
    for &(points, name) in SIZES.iter().chain(more) {
        // The input is prepared when the first bench that passes the filter runs.
        let prepared = OnceCell::new();
        for (stage, task) in TASKS {
            let mut group = criterion.benchmark_group(stage);
            group.sample_size(10).sampling_mode(SamplingMode::Flat);
            group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(3));
            group.throughput(Throughput::Elements(points));
            group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
                task(bencher, prepared.get_or_init(|| ended(Prepared::new(name))));
            });
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = stages
}
criterion_main!(benches);
