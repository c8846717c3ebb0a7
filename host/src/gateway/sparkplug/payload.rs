//! The payload of Sparkplug B as its protocol buffer has it (Sparkplug 3.0, section 6.4 and annex).
//!
//! Only the fields that an edge node needs; a decoder skips those that it does not know.

/// Type numbers of metrics (6.4.16).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum DataType {
    /// Signed, 32 bits.
    Int32 = 3,
    /// Signed, 64 bits.
    Int64 = 4,
    /// Unsigned, 32 bits.
    UInt32 = 7,
    /// IEEE 754, 64 bits.
    Double = 10,
    /// True or false.
    Boolean = 11,
    /// Text.
    String = 12,
}

/// A payload.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Payload {
    /// When it was sent, ms since 1970.
    #[prost(uint64, optional, tag = "1")]
    pub timestamp: Option<u64>,
    /// What it tells.
    #[prost(message, repeated, tag = "2")]
    pub metrics: Vec<Metric>,
    /// Its number, 0 to 255.
    #[prost(uint64, optional, tag = "3")]
    pub seq: Option<u64>,
}

/// A value with its name.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Metric {
    /// Its name.
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// A number instead of it.
    #[prost(uint64, optional, tag = "2")]
    pub alias: Option<u64>,
    /// When it was so, ms since 1970.
    #[prost(uint64, optional, tag = "3")]
    pub timestamp: Option<u64>,
    /// [`DataType`]
    #[prost(uint32, optional, tag = "4")]
    pub datatype: Option<u32>,
    /// It was so while nobody could be told.
    #[prost(bool, optional, tag = "5")]
    pub is_historical: Option<bool>,
    /// It has none.
    #[prost(bool, optional, tag = "7")]
    pub is_null: Option<bool>,
    /// More of it, told at its birth.
    #[prost(message, optional, tag = "9")]
    pub properties: Option<Properties>,
    /// The value.
    #[prost(oneof = "Value", tags = "10, 11, 12, 13, 14, 15")]
    pub value: Option<Value>,
}

/// A value.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum Value {
    /// 8 to 32 bits, signed ones in two's complement.
    #[prost(uint32, tag = "10")]
    Int(u32),
    /// 64 bits.
    #[prost(uint64, tag = "11")]
    Long(u64),
    /// IEEE 754, 32 bits.
    #[prost(float, tag = "12")]
    Float(f32),
    /// IEEE 754, 64 bits.
    #[prost(double, tag = "13")]
    Double(f64),
    /// [`DataType::Boolean`]
    #[prost(bool, tag = "14")]
    Boolean(bool),
    /// [`DataType::String`]
    #[prost(string, tag = "15")]
    Text(String),
}

/// Keys with their values, in the same order.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Properties {
    /// Keys.
    #[prost(string, repeated, tag = "1")]
    pub keys: Vec<String>,
    /// Values.
    #[prost(message, repeated, tag = "2")]
    pub values: Vec<Property>,
}

/// A property's value: all of ours are text.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Property {
    /// [`DataType`]
    #[prost(uint32, optional, tag = "1")]
    pub datatype: Option<u32>,
    /// The text.
    #[prost(string, optional, tag = "8")]
    pub text: Option<String>,
}

impl Metric {
    /// Says what one of the value is, by the key that hosts know (`engUnit`).
    pub fn with_unit(mut self, unit: &str) -> Metric {
        let value =
            Property { datatype: Some(DataType::String as u32), text: Some(unit.to_owned()) };
        self.properties = (!unit.is_empty())
            .then(|| Properties { keys: vec!["engUnit".to_owned()], values: vec![value] });
        self
    }

    /// A value with its name and type.
    pub fn new(name: &str, datatype: DataType, value: Value) -> Metric {
        Metric {
            name: Some(name.to_owned()),
            datatype: Some(datatype as u32),
            value: Some(value),
            ..Metric::default()
        }
    }

    /// A value that is not there now.
    pub fn null(name: &str, datatype: DataType) -> Metric {
        Metric {
            name: Some(name.to_owned()),
            datatype: Some(datatype as u32),
            is_null: Some(true),
            ..Metric::default()
        }
    }
}
