//! The tokens of a text.

/// A word or a sign, and its line, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Token<'t> {
    pub(crate) text: &'t str,
    pub(crate) line: usize,
}

/// All tokens of a text, without comments.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut all = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let mut rest = text.split("//").next().unwrap_or_default().trim_start();
        while let Some(first) = rest.chars().next() {
            let end = if first == '"' {
                rest[1..].find('"').map_or(rest.len(), |quote| quote + 2)
            } else if is_of_word(first) {
                rest.find(|c| !is_of_word(c)).unwrap_or(rest.len())
            } else {
                first.len_utf8()
            };
            all.push(Token { text: &rest[..end], line });
            rest = rest[end..].trim_start();
        }
    }
    all
}

/// Whether a character belongs to a name, a number or a mnemonic, or to the signs before them.
fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || "_$%.@!-".contains(c)
}

#[cfg(test)]
mod tests {
    use super::tokens;

    #[test]
    fn words_and_signs() {
        let text = "// a comment\n\t@!%p1 bra $L__BB0_3; // another\n{ .reg .b32 tmp; mov.b64 {tmp, %r1}, -5; }\n.pragma \"no unroll\";";
        let all = tokens(text);
        let words: Vec<&str> = all.iter().map(|token| token.text).collect();
        assert_eq!(words[..4], ["@!%p1", "bra", "$L__BB0_3", ";"]);
        assert_eq!(
            words[4..20],
            ["{", ".reg", ".b32", "tmp", ";", "mov.b64", "{", "tmp", ",", "%r1", "}", ",", "-5", ";", "}", ".pragma"]
        );
        assert_eq!(words[20..], ["\"no unroll\"", ";"]);
        assert_eq!((all[0].line, all[4].line), (2, 3));
    }
}
