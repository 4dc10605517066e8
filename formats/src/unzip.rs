//! Gzip, with a bound on what comes out of how little.

use std::io::{self, Read};

use flate2::read::MultiGzDecoder;

/// Scans shrink to a half or, as ascii STL of a regular grid, to a fiftieth;
/// bombs to a thousandth.
const MOST_GROWTH: u64 = 100;

/// So much may come out in any case.
const FREE: u64 = 4 << 20;

/// Unzips a stream of one or more gzip members.
pub(crate) struct Unzip<R> {
    zip: MultiGzDecoder<Counted<R>>,
    unzipped: u64,
}

impl<R: Read> Unzip<R> {
    pub(crate) fn new(zipped: R) -> Self {
        let zip = MultiGzDecoder::new(Counted { inner: zipped, bytes: 0 });
        Unzip { zip, unzipped: 0 }
    }
}

impl<R: Read> Read for Unzip<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.zip.read(into)?;
        self.unzipped += n as u64;
        if self.unzipped > FREE.max(MOST_GROWTH * self.zip.get_ref().bytes) {
            return Err(io::Error::other("it unzips to more than 100 times its size"));
        }
        Ok(n)
    }
}

struct Counted<R> {
    inner: R,
    bytes: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(into)?;
        self.bytes += n as u64;
        Ok(n)
    }
}
