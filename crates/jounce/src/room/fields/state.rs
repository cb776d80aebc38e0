//! The table of fields.

use super::desc::FieldDesc;
use crate::table::Table;

/// A field with what it remembers.
#[derive(Clone, Debug)]
pub(crate) struct FieldRecord {
    pub desc: FieldDesc,
    /// Step at which it was added: turning frames speed up from there.
    pub since: u64,
}

/// All fields, and the time they are asked at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fields {
    pub table: Table<FieldRecord>,
    /// Simulated time of the substep, s.
    pub time: f64,
}
