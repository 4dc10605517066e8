//! Reader of free-format parameters (IGES 5.3, clauses 2.2.2 and 2.2.3).

use std::ops::Range;

use super::deck::Deck;
use crate::Result;
use crate::token::excerpt;

/// The characters that separate parameters and end a record.
#[derive(Debug, Clone, Copy)]
pub(super) struct Delimiters {
    parameter: u8,
    record: u8,
    /// The number of bytes of the global section that define them.
    pub(super) length: usize,
}

impl Default for Delimiters {
    fn default() -> Self {
        Delimiters { parameter: b',', record: b';', length: 0 }
    }
}

impl Delimiters {
    /// Reads the first two parameters of the global section, which usually are `1H,,1H;,`. Both may
    /// be omitted.
    pub(super) fn of_global(global: &[u8]) -> Option<Self> {
        let mut found = Delimiters::default();
        match *global {
            [b'1', b'H', own, again, ..] if own == again => {
                (found.parameter, found.length) = (own, 4);
            }
            [b',', ..] => found.length = 1,
            _ => return None,
        }
        match global[found.length..] {
            [b'1', b'H', own, end, ..] if end == found.parameter => {
                (found.record, found.length) = (own, found.length + 4);
            }
            [end, ..] if end == found.parameter => found.length += 1,
            _ => return None,
        }
        (found.parameter != found.record).then_some(found)
    }
}

/// The remaining parameters of a record.
pub(super) struct Parameters<'d> {
    deck: &'d Deck<'d>,
    pointer: i64,
    text: Vec<u8>,
    /// The range of each parameter in the text.
    tokens: std::vec::IntoIter<Range<usize>>,
    position: usize,
}

impl<'d> Parameters<'d> {
    pub(super) fn new(
        deck: &'d Deck<'d>,
        pointer: i64,
        text: Vec<u8>,
        delimiters: Delimiters,
    ) -> Result<Self> {
        let tokens = tokens(&text, delimiters).map_err(|what| deck.error(pointer, what))?;
        Ok(Parameters { deck, pointer, text, tokens: tokens.into_iter(), position: 0 })
    }

    /// The next parameter. It is empty if it is omitted.
    fn next(&mut self) -> &[u8] {
        self.position += 1;
        let range = self.tokens.next().unwrap_or(0..0);
        &self.text[range]
    }

    fn wrong<T>(&self, what: &str) -> Result<T> {
        let at = self.position;
        Err(self.deck.error(self.pointer, format!("parameter {at} is no {what}")))
    }

    pub(super) fn skip(&mut self, count: usize) {
        for _ in 0..count {
            self.next();
        }
    }

    /// An integer or a pointer. It is 0 if it is omitted.
    pub(super) fn integer(&mut self) -> Result<i64> {
        let token = self.next();
        if token.is_empty() {
            return Ok(0);
        }
        let number = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
        number.map_or_else(|| self.wrong("whole number"), Ok)
    }

    /// A number of items.
    pub(super) fn count(&mut self) -> Result<usize> {
        let number = self.integer()?;
        usize::try_from(number).or_else(|_| self.wrong("count"))
    }

    /// A real number. It is 0 if it is omitted.
    pub(super) fn real(&mut self) -> Result<f64> {
        let token = self.next();
        if token.is_empty() {
            return Ok(0.0);
        }
        let text = String::from_utf8_lossy(token).replace(['D', 'd'], "E");
        let number = text.parse().ok().filter(|x: &f64| x.is_finite());
        number.map_or_else(|| self.wrong("number"), Ok)
    }

    pub(super) fn point(&mut self) -> Result<[f64; 3]> {
        Ok([self.real()?, self.real()?, self.real()?])
    }

    /// Reads `count` items, if the record is long enough.
    pub(super) fn several<T>(
        &mut self,
        count: usize,
        mut each: impl FnMut(&mut Self) -> Result<T>,
    ) -> Result<Vec<T>> {
        if count > self.tokens.len() {
            let left = self.tokens.len();
            let what = format!("names {count} parts, but has {left} more parameters");
            return Err(self.deck.error(self.pointer, what));
        }
        (0..count).map(|_| each(self)).collect()
    }

    /// A string.
    pub(super) fn string(&mut self) -> String {
        let token = self.next();
        let length = token.iter().take_while(|b| b.is_ascii_digit()).count();
        let text = token.get(length + 1..).unwrap_or_default();
        String::from_utf8_lossy(text).trim().to_owned()
    }
}

/// The ranges of the parameters up to the end of the record.
fn tokens(text: &[u8], delimiters: Delimiters) -> std::result::Result<Vec<Range<usize>>, String> {
    let mut tokens = Vec::new();
    let mut at = 0;
    loop {
        let blank = text[at..].iter().take_while(|b| **b == b' ').count();
        let begin = at + blank;
        let end = begin + length(&text[begin..], delimiters)?;
        let Some(delimiter) = text.get(end) else {
            return Err("has parameters without an end".into());
        };
        let content = text[begin..end].trim_ascii_end();
        tokens.push(begin..begin + content.len());
        at = end + 1;
        if *delimiter == delimiters.record {
            return Ok(tokens);
        }
    }
}

/// The length of the text up to the next delimiter. Delimiters within a string (`5Ha,b;c`) do not
/// count.
fn length(text: &[u8], delimiters: Delimiters) -> std::result::Result<usize, String> {
    let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
    let mut from = 0;
    if digits > 0 && text.get(digits) == Some(&b'H') {
        let count = std::str::from_utf8(&text[..digits]).ok().and_then(|n| n.parse().ok());
        let end = count.and_then(|count: usize| count.checked_add(digits + 1));
        from = end
            .filter(|end| *end <= text.len())
            .ok_or_else(|| format!("has a string that does not end: {}", excerpt(text)))?;
    }
    let is_end = |b: &u8| *b == delimiters.parameter || *b == delimiters.record;
    Ok(from + text[from..].iter().position(is_end).unwrap_or(text.len() - from))
}
