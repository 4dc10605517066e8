//! Decompression of gzip with a bound on the ratio of output to input.

use std::io::{self, BufRead, BufReader, Read};

use flate2::bufread::GzDecoder;

/// The largest ratio of decompressed to compressed size. Scans are compressed to a half, or to a
/// fiftieth for an ASCII STL of a regular grid. Gzip bombs are compressed to a thousandth.
const MOST_GROWTH: u64 = 100;

/// The number of decompressed bytes that are always allowed.
const FREE: u64 = 4 << 20;

/// Decompresses a stream of one or more gzip members. Like gzip, it accepts zero bytes after them,
/// which archives and tapes append.
pub(crate) struct Unzip<R> {
    /// The current member. `None` at the end of the stream.
    member: Option<GzDecoder<Zipped<R>>>,
    unzipped: u64,
}

type Zipped<R> = BufReader<Counted<R>>;

impl<R: Read> Unzip<R> {
    pub(crate) fn new(zipped: R) -> Self {
        let zipped = BufReader::new(Counted { inner: zipped, bytes: 0 });
        Unzip { member: Some(GzDecoder::new(zipped)), unzipped: 0 }
    }
}

impl<R: Read> Read for Unzip<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let n = member.read(into)?;
            if n > 0 || into.is_empty() {
                self.unzipped += n as u64;
                if self.unzipped > FREE.max(MOST_GROWTH * member.get_ref().get_ref().bytes) {
                    return Err(io::Error::other("it unzips to more than 100 times its size"));
                }
                return Ok(n);
            }
            let zipped = member.get_mut();
            skip_zeros(zipped)?;
            let is_end = zipped.fill_buf()?.is_empty();
            let rest = self.member.take().filter(|_| !is_end);
            self.member = rest.map(|member| GzDecoder::new(member.into_inner()));
        }
        Ok(0)
    }
}

fn skip_zeros(zipped: &mut impl BufRead) -> io::Result<()> {
    loop {
        let buffer = zipped.fill_buf()?;
        let zeros = buffer.iter().take_while(|&&byte| byte == 0).count();
        if zeros == 0 {
            return Ok(());
        }
        zipped.consume(zeros);
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
