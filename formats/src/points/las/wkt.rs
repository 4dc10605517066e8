//! Well-known text of coordinate systems, as far as their units need it.
//!
//! The input is text such as `PROJCS["name",…,UNIT["metre",1]]`. The output is its tree of
//! [`WktNode`]s. Quoted texts and words without brackets are skipped.

/// Brackets within brackets. Real systems have about eight. Thousands would overflow the
/// stack.
const DEEPEST: usize = 64;

/// A keyword with what is in its brackets.
#[derive(Debug, Default, PartialEq)]
pub(super) struct WktNode {
    pub(super) keyword: String,
    pub(super) numbers: Vec<f64>,
    pub(super) children: Vec<WktNode>,
}

impl WktNode {
    /// Whether the keyword is one of `names`, in any case of letters.
    pub(super) fn is(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.keyword.eq_ignore_ascii_case(name))
    }

    /// The first child with one of these keywords.
    pub(super) fn child(&self, names: &[&str]) -> Option<&WktNode> {
        self.children.iter().find(|child| child.is(names))
    }
}

/// The tree of the first keyword in `text`, if its brackets are closed.
pub(super) fn parse(text: &str) -> Option<WktNode> {
    let mut open: Vec<WktNode> = Vec::new();
    let mut word = String::new();
    let mut is_quoted = false;
    for letter in text.trim_end_matches('\0').chars() {
        match letter {
            // A doubled quote ends the text and begins it again.
            '"' => is_quoted = !is_quoted,
            _ if is_quoted => {}
            '[' | '(' if open.len() == DEEPEST => return None,
            '[' | '(' => open.push(WktNode { keyword: take(&mut word), ..WktNode::default() }),
            ',' => end_word(&mut open, &mut word),
            ']' | ')' => {
                end_word(&mut open, &mut word);
                let node = open.pop()?;
                match open.last_mut() {
                    Some(parent) => parent.children.push(node),
                    None => return Some(node),
                }
            }
            _ if letter.is_whitespace() => {}
            _ => word.push(letter),
        }
    }
    None
}

fn take(word: &mut String) -> String {
    std::mem::take(word)
}

/// Adds a word to the innermost node if it is a number.
fn end_word(open: &mut [WktNode], word: &mut String) {
    let number: Option<f64> = take(word).parse().ok();
    if let Some(node) = open.last_mut() {
        node.numbers.extend(number);
    }
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn brackets_make_a_tree() {
        let text = "PROJCS[\"a \"\"[b\"\"\",GEOGCS[\"c\", UNIT[\"degree\",0.017]],\n UNIT(\"m\", 1.0, ID[\"E\",9])]";
        let root = parse(text).expect("a tree");
        assert!(root.is(&["projcs"]));
        assert_eq!(root.children.len(), 2);
        let unit = root.child(&["UNIT"]).expect("a unit");
        assert_eq!(unit.numbers, [1.0]);
        assert_eq!(unit.children[0].numbers, [9.0]);
    }

    #[test]
    fn open_brackets_are_no_tree() {
        let deep = "A[".repeat(100_000) + &"]".repeat(100_000);
        for text in [&deep, "", "PROJCS", "PROJCS[UNIT[1]", "]", "\"[\"]"] {
            assert_eq!(parse(text), None, "{:.20}", text);
        }
    }
}
