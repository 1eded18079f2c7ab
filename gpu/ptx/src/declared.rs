//! Declarations in the text of a module, and its brackets.

use crate::errors::ReadError;
use crate::function::Declared;
use crate::token::Token;

/// Name and bytes of a declaration such as `.param .align 16 .b8 name[8]`.
pub(crate) fn declared<'t>(tokens: &'t [Token<'t>]) -> Result<Declared<'t>, ReadError> {
    let line = tokens.first().map_or(0, |token| token.line);
    let wrong = |what: &str| ReadError { line, what: what.to_owned() };
    let mut each = None;
    let mut name = None;
    let mut count = 1;
    let mut words = tokens.iter().map(|token| token.text);
    while let Some(word) = words.next() {
        match word {
            ".align" => drop(words.next()),
            "[" => {
                let said = words.next().and_then(|count| count.parse::<usize>().ok());
                count = said.ok_or_else(|| wrong("no number of elements"))?;
            }
            "]" => {}
            "=" => break,
            _ if word.starts_with('.') => each = each.or(bytes_of(&word[1..])),
            _ => name = Some(word),
        }
    }
    match (name, each) {
        (Some(name), Some(each)) => Ok(Declared { name, bytes: each * count }),
        _ => Err(wrong("no name or no type")),
    }
}

pub(crate) fn bytes_of(kind: &str) -> Option<usize> {
    Some(match kind.trim_start_matches(['b', 'u', 's', 'f']) {
        "8" => 1,
        "16" => 2,
        "32" => 4,
        "64" => 8,
        _ => return None,
    })
}

/// The position of the bracket that closes the one at `at`.
pub(crate) fn matching(tokens: &[Token<'_>], at: usize) -> Result<usize, ReadError> {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(at) {
        match token.text {
            "(" | "{" => depth += 1,
            ")" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Ok(place);
        }
    }
    Err(ReadError { line: tokens[at].line, what: "a bracket that is not closed".into() })
}
