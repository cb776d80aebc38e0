//! Jounce: one deterministic world for everything that moves.
#![forbid(unsafe_code)]

mod command;
mod error;
mod event;
mod handle;
pub mod limits;
mod room;
mod settings;

pub use command::{Command, Output};
pub use error::{Error, Result};
pub use event::Event;
pub use handle::{BodyId, ShapeId};
pub use room::contacts::desc::{Combine, Filter, MassSpec, Material, ShapeDesc};
pub use room::rigid::desc::{AxisLocks, BodyDesc, BodyKind};
pub use settings::{Settings, WorldDesc};

pub use jounce_geometry as geometry;
pub use jounce_math as math;
pub use jounce_tasks as tasks;
