//! Values of several forms, read without untagged enums so that errors keep their place.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// A JSON object with free keys, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Map<T>(pub Vec<(String, T)>);

impl<T> Default for Map<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Map<T> {
    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&T> {
        self.0.iter().find(|(k, _)| k == key).map(|(_, v)| v)
    }
    /// The keys, in the order of the file.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(k, _)| k.as_str())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Map<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for V<T> {
            type Value = Map<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Map<T>, A::Error> {
                let mut all = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    all.push(entry);
                }
                Ok(Map(all))
            }
        }
        d.deserialize_map(V(PhantomData))
    }
}

impl<T: JsonSchema> JsonSchema for Map<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("Map_of_{}", T::schema_name()).into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(g: &mut SchemaGenerator) -> Schema {
        let value = g.subschema_for::<T>();
        json_schema!({"type": "object", "additionalProperties": value})
    }
}

/// Defines a value that is a number or an array of `$n` numbers.
macro_rules! one_or_several {
    ($(#[$doc:meta])* $name:ident, $t:ty, $n:literal, $expecting:literal, $kind:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum $name {
            /// One number.
            One($t),
            /// One for each axis.
            Each([$t; $n]),
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                struct V;
                impl<'de> Visitor<'de> for V {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str($expecting)
                    }
                    fn visit_u64<E: de::Error>(self, v: u64) -> Result<$name, E> {
                        <$t>::deserialize(de::value::U64Deserializer::new(v)).map($name::One)
                    }
                    fn visit_i64<E: de::Error>(self, v: i64) -> Result<$name, E> {
                        <$t>::deserialize(de::value::I64Deserializer::new(v)).map($name::One)
                    }
                    fn visit_f64<E: de::Error>(self, v: f64) -> Result<$name, E> {
                        <$t>::deserialize(de::value::F64Deserializer::new(v)).map($name::One)
                    }
                    fn visit_seq<A: SeqAccess<'de>>(self, a: A) -> Result<$name, A::Error> {
                        <[$t; $n]>::deserialize(de::value::SeqAccessDeserializer::new(a)).map($name::Each)
                    }
                }
                d.deserialize_any(V)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }
            fn inline_schema() -> bool {
                true
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({"anyOf": [
                    {"type": $kind},
                    {"type": "array", "items": {"type": $kind}, "minItems": $n, "maxItems": $n}
                ]})
            }
        }
    };
}

one_or_several!(
    /// A factor for all axes, or one for each.
    Scale, f32, 3, "a number or an array of three numbers", "number"
);
one_or_several!(
    /// A distance in x and z, or one for each.
    Spacing, f32, 2, "a number or an array of two numbers", "number"
);
one_or_several!(
    /// A number of copies along x, or along x, y and z.
    Count, u64, 3, "a whole number or an array of three whole numbers", "integer"
);

impl Scale {
    /// Factor of each axis.
    pub fn each(self) -> [f32; 3] {
        match self {
            Self::One(s) => [s; 3],
            Self::Each(e) => e,
        }
    }
}

impl Spacing {
    /// Distance in x and z.
    pub fn each(self) -> [f32; 2] {
        match self {
            Self::One(s) => [s; 2],
            Self::Each(e) => e,
        }
    }
}

impl Count {
    /// How far copy (i, j, k) is moved: a single number makes a row along the whole of `step`.
    pub fn shift(self, cell: [f64; 3], step: [f64; 3]) -> [f64; 3] {
        let [i, j, k] = match self {
            Self::One(_) => [cell[0]; 3],
            Self::Each(_) => cell,
        };
        [i * step[0], j * step[1], k * step[2]]
    }
    /// Number along each axis.
    pub fn each(self) -> [u64; 3] {
        match self {
            Self::One(n) => [n, 1, 1],
            Self::Each(e) => e,
        }
    }
}

/// A set of layers: a bit set as a whole number, or a list of layer numbers 0…31.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers(pub u32);

impl<'de> Deserialize<'de> for Layers {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Layers;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a bit set (0 to 4294967295) or a list of layer numbers (0 to 31)")
            }
            fn visit_u64<E: de::Error>(self, v: u64) -> Result<Layers, E> {
                let wrong = |_| E::invalid_value(de::Unexpected::Unsigned(v), &self);
                u32::try_from(v).map(Layers).map_err(wrong)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut a: A) -> Result<Layers, A::Error> {
                let mut bits = 0;
                while let Some(n) = a.next_element::<u64>()? {
                    if n > 31 {
                        return Err(de::Error::invalid_value(de::Unexpected::Unsigned(n), &self));
                    }
                    bits |= 1u32 << n;
                }
                Ok(Layers(bits))
            }
        }
        d.deserialize_any(V)
    }
}

impl JsonSchema for Layers {
    fn schema_name() -> Cow<'static, str> {
        "Layers".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [
            {"type": "integer", "minimum": 0, "maximum": u32::MAX},
            {"type": "array", "items": {"type": "integer", "minimum": 0, "maximum": 31}}
        ]})
    }
}
