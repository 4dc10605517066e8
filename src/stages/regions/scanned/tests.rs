//! Tests on made meshes.
