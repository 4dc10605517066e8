//! Parser of records and their parameters (ISO 10303-21, clauses 6 and 9).

use super::names;
use crate::token::excerpt;

/// The largest depth of nested lists and typed parameters. No schema has a depth of more than
/// three.
const MAX_DEPTH: usize = 16;

/// A simple record: `KEYWORD(parameters)`.
#[derive(Debug)]
pub(super) struct SimpleRecord<'a> {
    pub(super) name: &'a str,
    pub(super) values: Vec<Value<'a>>,
}

/// A parameter.
#[derive(Debug, PartialEq)]
pub(super) enum Value<'a> {
    Reference(u64),
    Integer(i64),
    Real(f64),
    /// The text of a string between its apostrophes, with escapes.
    Text(&'a [u8]),
    /// The name of an enumeration value `.NAME.` without its points.
    Enumeration(&'a str),
    /// `$`, `*` or binary data, which are not used.
    Nothing,
    List(Vec<Value<'a>>),
    /// The value of a typed parameter `KEYWORD(value)`.
    Typed(Box<Value<'a>>),
}

/// A position in the text.
pub(super) struct Cursor<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

/// The result of a parser, or a description of the error.
type Parsed<T> = Result<T, String>;

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mark = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Cursor { bytes, at: mark }
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(0)
    }

    /// Skips `text` if it is next.
    pub(super) fn take(&mut self, text: &[u8]) -> bool {
        let is_next = self.rest().starts_with(text);
        self.at += if is_next { text.len() } else { 0 };
        is_next
    }

    /// Skips white space and comments.
    pub(super) fn skip_blank(&mut self) {
        loop {
            let blank = self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
            self.at += blank;
            if !self.rest().starts_with(b"/*") {
                return;
            }
            self.skip_comment();
        }
    }

    fn skip_comment(&mut self) {
        let end = self.rest().windows(2).skip(2).position(|w| w == b"*/");
        self.at = end.map_or(self.bytes.len(), |i| self.at + i + 4);
    }

    /// Skips everything up to and including the next semicolon outside of strings and comments.
    /// Returns `false` if there is none.
    pub(super) fn skip_statement(&mut self) -> bool {
        loop {
            let telling = |b: &u8| matches!(b, b';' | b'\'' | b'/');
            let Some(i) = self.rest().iter().position(telling) else { return false };
            self.at += i;
            match self.peek() {
                b';' => {
                    self.at += 1;
                    return true;
                }
                b'\'' => match self.rest()[1..].iter().position(|b| *b == b'\'') {
                    Some(i) => self.at += i + 2,
                    None => return false,
                },
                _ if self.rest().starts_with(b"/*") => self.skip_comment(),
                _ => self.at += 1,
            }
        }
    }

    pub(super) fn digits(&mut self) -> Option<u64> {
        let count = self.rest().iter().take_while(|b| b.is_ascii_digit()).count();
        let text = std::str::from_utf8(&self.rest()[..count]).ok()?;
        self.at += count;
        text.parse().ok()
    }

    /// The next keyword. It is empty if there is none.
    pub(super) fn word(&mut self) -> &'a str {
        let is_letter = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'!' | b'-');
        let count = self.rest().iter().take_while(|b| is_letter(b)).count();
        let text = std::str::from_utf8(&self.rest()[..count]).unwrap_or_default();
        self.at += count;
        text
    }

    /// Whether an entity instance has a keyword that is `wanted`.
    pub(super) fn has_keyword(&mut self, wanted: &dyn Fn(&str) -> bool) -> bool {
        if !self.take(b"(") {
            return wanted(names::long(self.word()));
        }
        loop {
            self.skip_blank();
            let word = self.word();
            if word.is_empty() || wanted(names::long(word)) {
                return !word.is_empty();
            }
            self.skip_blank();
            self.skip_list();
        }
    }

    /// Skips a list in parentheses, if there is one.
    fn skip_list(&mut self) {
        let mut depth = 0;
        loop {
            let telling = |b: &u8| matches!(b, b'(' | b')' | b'\'' | b';');
            let Some(i) = self.rest().iter().position(telling) else {
                self.at = self.bytes.len();
                return;
            };
            self.at += i;
            match self.peek() {
                b'(' => depth += 1,
                b')' => depth -= 1,
                b';' => return,
                _ => match self.rest()[1..].iter().position(|b| *b == b'\'') {
                    Some(i) => self.at += i + 1,
                    None => self.at = self.bytes.len() - 1,
                },
            }
            self.at += 1;
            if depth <= 0 {
                return;
            }
        }
    }

    /// The records of an entity instance, up to its semicolon.
    pub(super) fn instance(&mut self) -> Parsed<Vec<SimpleRecord<'a>>> {
        let mut records = Vec::new();
        if self.take(b"(") {
            loop {
                self.skip_blank();
                if self.take(b")") {
                    break;
                }
                records.push(self.record()?);
            }
        } else {
            records.push(self.record()?);
        }
        self.skip_blank();
        if self.take(b";") { Ok(records) } else { Err(self.unexpected("a semicolon")) }
    }

    fn record(&mut self) -> Parsed<SimpleRecord<'a>> {
        let name = names::long(self.word());
        self.skip_blank();
        if name.is_empty() || !self.take(b"(") {
            return Err(self.unexpected("an entity's name and ("));
        }
        Ok(SimpleRecord { name, values: self.list(0)? })
    }

    /// The rest of a list after its opening parenthesis.
    fn list(&mut self, depth: usize) -> Parsed<Vec<Value<'a>>> {
        if depth > MAX_DEPTH {
            return Err("lists that are nested too deeply".into());
        }
        let mut values = Vec::new();
        self.skip_blank();
        if self.take(b")") {
            return Ok(values);
        }
        loop {
            values.push(self.value(depth)?);
            self.skip_blank();
            if self.take(b")") {
                return Ok(values);
            }
            if !self.take(b",") {
                return Err(self.unexpected("a comma or )"));
            }
        }
    }

    fn value(&mut self, depth: usize) -> Parsed<Value<'a>> {
        self.skip_blank();
        match self.peek() {
            b'#' => {
                self.at += 1;
                let id = self.digits();
                id.map(Value::Reference).ok_or_else(|| self.unexpected("a number after #"))
            }
            b'\'' => self.text(),
            b'.' if !self.rest().get(1).is_some_and(u8::is_ascii_digit) => {
                self.at += 1;
                let name = self.word();
                if self.take(b".") {
                    Ok(Value::Enumeration(name))
                } else {
                    Err(self.unexpected("the end of an enumeration"))
                }
            }
            b'(' => {
                self.at += 1;
                self.list(depth + 1).map(Value::List)
            }
            b'$' | b'*' => {
                self.at += 1;
                Ok(Value::Nothing)
            }
            b'"' => {
                let end = self.rest()[1..].iter().position(|b| *b == b'"');
                self.at += end.ok_or("binary data without an end")? + 2;
                Ok(Value::Nothing)
            }
            b'+' | b'-' | b'.' | b'0'..=b'9' => self.number(),
            _ => self.typed(depth),
        }
    }

    fn typed(&mut self, depth: usize) -> Parsed<Value<'a>> {
        let name = self.word();
        self.skip_blank();
        if name.is_empty() || !self.take(b"(") {
            return Err(self.unexpected("a parameter"));
        }
        let mut values = self.list(depth + 1)?;
        match (values.pop(), values.is_empty()) {
            (Some(value), true) => Ok(Value::Typed(Box::new(value))),
            _ => Err(format!("{name} does not have exactly one parameter")),
        }
    }

    fn text(&mut self) -> Parsed<Value<'a>> {
        let begin = self.at + 1;
        self.at = begin;
        loop {
            let end = self.rest().iter().position(|b| *b == b'\'');
            self.at += end.ok_or("a string without an end")? + 1;
            // Two apostrophes stand for one apostrophe.
            if !self.take(b"'") {
                return Ok(Value::Text(&self.bytes[begin..self.at - 1]));
            }
        }
    }

    fn number(&mut self) -> Parsed<Value<'a>> {
        let is_part = |b: &u8| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'E' | b'e');
        let count = self.rest().iter().take_while(|b| is_part(b)).count();
        let digits = &self.rest()[..count];
        let text = std::str::from_utf8(digits).unwrap_or_default();
        let whole = digits.iter().all(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-'));
        let value = if whole {
            text.parse().ok().map(Value::Integer)
        } else {
            text.parse().ok().filter(|x: &f64| x.is_finite()).map(Value::Real)
        };
        let value = value.ok_or_else(|| format!("{} is not a number", excerpt(digits)))?;
        self.at += count;
        Ok(value)
    }

    fn unexpected(&self, wanted: &str) -> String {
        let here = self.rest().split(|b| *b == b'\n').next().unwrap_or_default();
        match excerpt(here).as_str() {
            "" => format!("{wanted} was expected where the line ends"),
            found => format!("{wanted} was expected instead of {found}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_parsed() {
        let text = b"( A( ) /* ; */B($,(1,-2.E1,.5),.T.,LENGTH(2.5),'x;''y' , #12,\"0F\"));";
        let records = Cursor::new(text).instance().unwrap();
        assert_eq!((records[0].name, records[1].name), ("A", "B"));
        let list = vec![Value::Integer(1), Value::Real(-20.0), Value::Real(0.5)];
        let expected = [
            Value::Nothing,
            Value::List(list),
            Value::Enumeration("T"),
            Value::Typed(Box::new(Value::Real(2.5))),
            Value::Text(b"x;''y"),
            Value::Reference(12),
            Value::Nothing,
        ];
        assert_eq!(records[1].values, expected);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let fault = |text: &str| Cursor::new(text.as_bytes()).instance().unwrap_err();
        assert_eq!(fault("A(1"), "a comma or ) was expected where the line ends");
        assert_eq!(fault("A(1 2);"), "a comma or ) was expected instead of 2);");
        assert_eq!(fault("A(1.2.3);"), "1.2.3 is not a number");
        assert_eq!(fault("A('x);"), "a string without an end");
        assert_eq!(fault("A(1e999);"), "1e999 is not a number");
        assert!(fault(&format!("A({}", "(".repeat(99_999))).contains("nested too deeply"));
    }
}
