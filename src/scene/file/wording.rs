//! Serde's messages in the words of scene files: what was found, what was expected.

use toml::Value;

/// Rewords `message`, which is about `value`; the second string is advice.
pub(super) fn reword(message: &str, value: Option<&Value>) -> (String, Option<String>) {
    if let Some(rest) = message.strip_prefix("unknown variant ") {
        return (format!("found {rest}"), nearest(rest));
    }
    if let Some(rest) = message.strip_prefix("missing field ") {
        return (format!("missing key {rest}"), None);
    }
    let kinds = ["invalid type: ", "invalid value: ", "invalid "];
    let Some(rest) = kinds.iter().find_map(|k| message.strip_prefix(k)) else {
        // A list of alternatives says only what was expected.
        let reworded = value.map(|v| format!("found {v}, expected {message}"));
        return (reworded.unwrap_or_else(|| message.to_owned()), None);
    };
    match rest.rsplit_once(", expected ") {
        Some((found, expected)) => {
            let (found, expected) = (found_words(found), expected_words(expected));
            (format!("found {found}, expected {expected}"), None)
        }
        None => (message.to_owned(), None),
    }
}

fn found_words(found: &str) -> String {
    match found.strip_prefix("length ") {
        Some(length) => format!("an array of length {length}"),
        None => match found {
            "map" => "a table".to_owned(),
            "sequence" => "an array".to_owned(),
            _ => found.trim_end_matches(" as i128").to_owned(),
        },
    }
}

fn expected_words(expected: &str) -> &str {
    match expected {
        "u32" => "an integer from 0 to 4294967295",
        "u64" => "an integer of at least 0",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        "a sequence" => "an array",
        "any valid TOML value" => "a number of at most 64 bits",
        _ if expected.starts_with("struct ") => "a table",
        _ => expected,
    }
}

/// The word nearest to the first of the words in backquotes.
fn nearest(words: &str) -> Option<String> {
    let mut words = words.split('`').skip(1).step_by(2);
    let found = words.next()?;
    let (distance, word) = words
        .map(|w| (strsim::damerau_levenshtein(w, found), w))
        .min()?;
    (distance <= word.len().div_ceil(2)).then(|| format!("did you mean `{word}`?"))
}
