//! Gzip, with a bound on what comes out of how little.

use std::io::{self, BufRead, BufReader, Read};

use flate2::bufread::GzDecoder;

/// Scans shrink to a half or, as ascii STL of a regular grid, to a fiftieth;
/// bombs to a thousandth.
const MOST_GROWTH: u64 = 100;

/// So much may come out in any case.
const FREE: u64 = 4 << 20;

/// Unzips a stream of one or more gzip members and the zero bytes, if any,
/// that an archive or a tape put behind them, as gzip does.
pub(crate) struct Unzip<R> {
    /// The member being read; none once the stream is through.
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
