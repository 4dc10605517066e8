//! The readers: every feature and every error with small files that are made here, the collected
//! scans, and random damage.

mod corpus;
mod damage;
mod general;
mod gltf;
mod mutations;
mod obj;
mod obj_odd;
mod off;
mod ply;
mod recognised;
mod scene;
mod seeds;
mod stl;
mod stream;
mod support;
mod threemf;
