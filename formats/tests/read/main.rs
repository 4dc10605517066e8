//! The readers: every feature and every refusal, on small files made here;
//! the collected scans; and random damage.

mod corpus;
mod general;
mod gltf;
mod mutations;
mod obj;
mod ply;
mod stl;
mod support;
