//! The threads that share the loops of this library.
//!
//! rayon keeps a pool for the whole process, which begins with the first loop that runs on a
//! thread outside of any pool and never ends. A process that is forked after that inherits
//! the pool without its threads, and its first loop waits for them without end. So the
//! functions of this library that do a whole task ([`convert`](crate::convert),
//! [`inspect`](crate::convert::inspect), [`check`](crate::check::check) and their like) run their
//! loops by [`run`]. Whoever calls stages one by one, and wants the same, calls `run` too.

use crate::error::{Error, Result};

/// Bytes of the stack of each thread: as many as the main thread of a program has on Linux
/// and macOS, so that recursion may go as deep on every thread as on that one.
const STACK: usize = 8 << 20;

/// Calls `work` on one of the threads that share its loops, and returns what it returns.
///
/// `Some(n)` makes a pool of `n` threads. `None` takes the pool of the thread that calls,
/// which is how a caller hands in one of its own: `pool.install(|| convert(…))`. A thread
/// outside of any pool gets one with a thread for each core, or with as many as the variable
/// `RAYON_NUM_THREADS` says. A pool that is made here ends before the function returns.
///
/// # Errors
/// [`Error::Threads`]: the system starts no more threads.
pub fn run<R: Send>(threads: Option<usize>, work: impl FnOnce() -> R + Send) -> Result<R> {
    if threads.is_none() && rayon::current_thread_index().is_some() {
        return Ok(work());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).stack_size(STACK);
    pool.build_scoped(|thread| thread.run(), |pool| pool.install(work))
        .map_err(|why| Error::Threads(why.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_has_the_threads_that_were_asked_for() {
        let count = |threads| run(threads, rayon::current_num_threads).unwrap();
        assert_eq!([1, 3].map(|n| count(Some(n))), [1, 3]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        assert_eq!(pool.install(|| [count(None), count(Some(3)), count(None)]), [2, 3, 2]);
    }
}
