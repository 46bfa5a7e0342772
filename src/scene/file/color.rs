//! Colours in scene files: a number for grey, or three.

use std::fmt;

use glam::Vec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};

/// Linear RGB, written as `0.5` or `[1.0, 0.8, 0.6]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgb(pub Vec3);

impl<'de> Deserialize<'de> for Rgb {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Parts;
        impl<'de> Visitor<'de> for Parts {
            type Value = Rgb;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number (grey) or [r, g, b]")
            }
            fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<Rgb, E> {
                Ok(Rgb(Vec3::splat(v as f32)))
            }
            fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<Rgb, E> {
                self.visit_f64(v as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Rgb, A::Error> {
                let mut parts = Vec::new();
                while let Some(v) = seq.next_element::<f32>()? {
                    parts.push(v);
                }
                match parts[..] {
                    [r, g, b] => Ok(Rgb(Vec3::new(r, g, b))),
                    _ => Err(serde::de::Error::invalid_length(parts.len(), &self)),
                }
            }
        }
        deserializer.deserialize_any(Parts)
    }
}

impl JsonSchema for Rgb {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Rgb".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Linear RGB (sRGB primaries): a number for grey, or [r, g, b].",
            "anyOf": [
                { "type": "number", "minimum": 0 },
                { "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 3, "maxItems": 3 }
            ]
        })
    }
}
