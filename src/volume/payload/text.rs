//! Voxels written as text: numbers between white space.

use std::io::{self, BufRead};

/// Longest number; anything longer is no number.
const TOKEN_LIMIT: usize = 512;

/// Why there is no further number.
pub(super) enum TextError {
    /// The text ended.
    End,
    /// This is not a number of the wanted type.
    NotANumber(String),
    /// The operating system refused.
    Io(io::Error),
}

/// The next white-space separated word, as a `T`. `token` is scratch space.
pub(super) fn next_number<T: std::str::FromStr>(
    reader: &mut impl BufRead,
    token: &mut Vec<u8>,
) -> Result<T, TextError> {
    token.clear();
    loop {
        let buf = reader.fill_buf().map_err(TextError::Io)?;
        if buf.is_empty() {
            break;
        }
        let skip = match token.is_empty() {
            true => buf.iter().take_while(|b| b.is_ascii_whitespace()).count(),
            false => 0,
        };
        let rest = &buf[skip..];
        let word = rest
            .iter()
            .take_while(|b| !b.is_ascii_whitespace())
            .take(TOKEN_LIMIT)
            .count();
        token.extend_from_slice(&rest[..word]);
        let ended = word < rest.len();
        reader.consume(skip + word);
        if token.len() >= TOKEN_LIMIT || (ended && !token.is_empty()) {
            break;
        }
    }
    if token.is_empty() {
        return Err(TextError::End);
    }
    let word = String::from_utf8_lossy(token);
    word.parse()
        .map_err(|_| TextError::NotANumber(word.into_owned()))
}
