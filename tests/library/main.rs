//! Tests of the library, each file about a part of it. One program has them all, since each program would take
//! seconds to build.

#[path = "../common/mod.rs"]
mod common;

mod border;
mod clean_meshes;
mod clouds;
mod components;
mod exact;
mod file;
mod filling;
mod fitting;
mod handles;
mod index;
mod nearest;
mod network;
mod outline;
mod parameterization;
mod random_bodies;
mod rims;
mod scanned;
mod smoothing;
mod solids;
mod stages;
mod thinning;
mod units;
mod vertices;
