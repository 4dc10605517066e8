//! Tests of the program, each file about a part of it. They are one program themselves, since each would take seconds
//! to build.

#[path = "../common/mod.rs"]
mod common;

mod assemblies;
mod batch;
mod bodies;
mod brought;
mod cases;
mod check;
mod cli;
mod cloud_files;
mod crop;
mod inspect;
mod islands;
mod kinds;
mod open_parts;
mod operations;
mod part_reports;
mod parts;
mod progress;
mod random_parts;
mod real_scans;
mod reports;
mod roundtrip;
mod stopped;
mod streams;
