//! Every capacity and every bound of a loop.

/// Steps that an adaptive method takes within one call.
pub const STEPS_MAX: usize = 1_000_000;
/// Newton iterations of an implicit step.
pub const NEWTON_MAX: usize = 40;
/// Directions that GMRES keeps before it starts anew.
pub const KRYLOV_MAX: usize = 40;
/// Fresh starts of GMRES in one Newton iteration.
pub const KRYLOV_RESTARTS_MAX: usize = 25;
/// Parts that an implicit step is split into where it finds no answer.
pub const IMPLICIT_PARTS_MAX: u32 = 1024;
/// Halvings of a Newton step that makes things worse.
pub const BACKTRACKS_MAX: usize = 12;
/// Intervals that a quadrature splits its range into.
pub const INTERVALS_MAX: usize = 4096;
/// Halvings of a bracket: more than the bits of an `f64` can tell apart.
pub const BISECTIONS_MAX: usize = 200;
/// Points of a spring system, of a cloth or of a jelly.
pub const POINTS_MAX: usize = 1 << 24;
/// Depth of an octree: below it, bodies share a leaf.
pub const OCTREE_DEPTH_MAX: usize = 48;
/// Steps of a flight; one that is still up, or has drag too stiff to be followed, ends there.
pub const FLIGHT_STEPS_MAX: usize = 100_000;
/// Longest flight that is followed, s.
pub const FLIGHT_TIME_MAX_S: f64 = 100_000.0;
/// Steps along all paths that a search for a shot through air follows: about a second.
pub const SEARCH_STEPS_MAX: usize = 400_000;
