//! Keys of a scene file against the schema: unknown ones, and where a key stands in the text.

use std::ops::Range;

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use super::error::Problem;

/// Finds the first key that the schema does not know, and names the nearest one it does.
pub(super) fn unknown(table: &toml::Table, schema: &Value) -> Option<Problem> {
    walk(table, schema, schema, &mut Vec::new())
}

fn walk(
    table: &toml::Table,
    schema: &Value,
    root: &Value,
    path: &mut Vec<String>,
) -> Option<Problem> {
    let known = properties(schema, root);
    if known.is_empty() {
        return None;
    }
    for (key, value) in table {
        path.push(key.clone());
        let Some((_, child)) = known.iter().find(|(name, _)| name == key) else {
            return Some(unknown_key(path, key, &known));
        };
        let found = match value {
            toml::Value::Table(inner) => walk(inner, child, root, path),
            toml::Value::Array(list) => list.iter().enumerate().find_map(|(i, item)| {
                path.push(i.to_string());
                let found = item
                    .as_table()
                    .and_then(|t| walk(t, items(child, root), root, path));
                path.pop();
                found
            }),
            _ => None,
        };
        if found.is_some() {
            return found;
        }
        path.pop();
    }
    None
}

fn unknown_key(path: &[String], key: &str, known: &[(String, &Value)]) -> Problem {
    let nearest = known
        .iter()
        .map(|(name, _)| (strsim::damerau_levenshtein(name, key), name))
        .min()
        .filter(|(distance, name)| *distance <= name.len().max(key.len()).div_ceil(2));
    let names: Vec<_> = known.iter().map(|(name, _)| name.as_str()).collect();
    let expected = format!("expected one of {}", names.join(", "));
    Problem {
        path: path.to_vec(),
        message: format!("unknown key `{key}`"),
        help: Some(nearest.map_or(expected, |(_, name)| format!("did you mean `{name}`?"))),
    }
}

/// The properties of an object schema, through references and alternatives.
fn properties<'a>(schema: &'a Value, root: &'a Value) -> Vec<(String, &'a Value)> {
    let schema = dereference(schema, root);
    let mut list: Vec<_> = schema["properties"]
        .as_object()
        .into_iter()
        .flatten()
        .map(|(name, value)| (name.clone(), value))
        .collect();
    for word in ["anyOf", "oneOf", "allOf"] {
        for alternative in schema[word].as_array().into_iter().flatten() {
            list.extend(properties(alternative, root));
        }
    }
    list
}

/// The schema of an array's items, through references and alternatives.
fn items<'a>(schema: &'a Value, root: &'a Value) -> &'a Value {
    let schema = dereference(schema, root);
    if !schema["items"].is_null() {
        return &schema["items"];
    }
    let alternatives = schema["anyOf"].as_array().into_iter().flatten();
    alternatives
        .map(|a| items(a, root))
        .find(|i| !i.is_null())
        .unwrap_or(&Value::Null)
}

fn dereference<'a>(schema: &'a Value, root: &'a Value) -> &'a Value {
    match schema["$ref"]
        .as_str()
        .and_then(|r| root.pointer(r.trim_start_matches('#')))
    {
        Some(target) => target,
        None => schema,
    }
}

/// Bytes of the key at `path`, or of the nearest table above it that exists.
pub(super) fn locate(text: &str, path: &[String]) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut span = None;
    let mut rest = path.iter();
    while let Some(key) = rest.next() {
        let Some((name, value)) = table
            .iter()
            .find(|(name, _)| name.get_ref().as_ref() == key)
        else {
            break;
        };
        span = Some(name.span());
        let mut value = value.get_ref();
        while let DeValue::Array(list) = value {
            let Some(item) = rest.next().and_then(|i| list.get(i.parse::<usize>().ok()?)) else {
                return span;
            };
            span = Some(item.span());
            value = item.get_ref();
        }
        match value {
            DeValue::Table(inner) => table = inner,
            _ => break,
        }
    }
    span
}
