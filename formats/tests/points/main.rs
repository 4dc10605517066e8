//! The readers of clouds: every format in all its encodings, on small files made
//! here; damage of every kind; and the collected scans.

mod broken;
mod collected;
mod e57;
mod far;
mod grid;
mod las;
mod pcd;
mod ply;
mod ptx;
mod recognised;
mod seeds;
mod support;
mod text;
