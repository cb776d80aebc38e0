//! Every capacity and iteration bound of the engine. Reaching one is an error at the door, or degrades,
//! reports and continues inside a step.

/// Most bodies in a world.
pub const BODIES_MAX: usize = 1 << 22;
/// Most shapes in a world.
pub const SHAPES_MAX: usize = 1 << 23;
/// Most shapes on one body.
pub const SHAPES_PER_BODY_MAX: usize = 1 << 16;
/// Most shape pairs whose bounds overlap. A pair that touches takes about 1.5 KB with its solver row, so that all together take
/// 3 to 4 GB; pairs beyond are left out.
pub const CONTACTS_MAX: usize = 1 << 21;
/// Most new pairs that 32 shapes may find in one step where [`CONTACTS_MAX`] shared out among all that moved gives them less; the
/// rest of them is found in the steps after it.
pub const FOUND_PAIRS_MAX: usize = 1 << 12;
/// Farthest coordinate, metres; a body beyond it is quarantined.
pub const POSITION_MAX: f64 = 1e9;
/// Fastest speed accepted at the door, m/s (steps clamp to `Settings::linear_speed_max`).
pub const SPEED_MAX: f32 = 1e5;
/// Fastest spin accepted at the door, rad/s.
pub const SPIN_MAX: f32 = 1e5;
/// Largest mass, kg.
pub const MASS_MAX: f32 = 1e15;
/// Smallest mass of a dynamic body, kg.
pub const MASS_MIN: f32 = 1e-12;
/// Largest force (N), torque (N m) or impulse component.
pub const FORCE_MAX: f32 = 1e25;
/// Largest component of what a field accelerates by, m/s²: more would only meet the speed limit, and its square overflow.
pub const FIELD_ACCELERATION_MAX: f64 = 1e7;
/// Most substeps of a step.
pub const SUBSTEPS_MAX: u32 = 64;
/// Most steps of one [`crate::World::advance`].
pub const ADVANCE_STEPS_MAX: u32 = 8;
/// Most rounds of pairwise impacts before substep 1.
pub const IMPACT_ROUNDS_MAX: usize = 256;
/// Most joints in a world.
pub const JOINTS_MAX: usize = 1 << 22;
/// Most joints of one body.
pub const JOINTS_PER_BODY_MAX: usize = 1 << 16;
/// Most vehicles in a world.
pub const VEHICLES_MAX: usize = 1 << 16;
/// Most wheels of a vehicle.
pub const WHEELS_MAX: usize = 32;
/// Largest radius and largest width of a wheel, m: more than any that was built.
pub const WHEEL_SIZE_MAX: f32 = 10.0;
/// Least distance of two hubs of a vehicle, m.
pub const WHEELS_APART_MIN: f32 = 1e-3;
/// Largest part of a vehicle's mass that its wheels may have.
pub const UNSPRUNG_PART_MAX: f32 = 0.9;
/// Most points of an engine's torque curve.
pub const TORQUE_POINTS_MAX: usize = 32;
/// Most forward gears.
pub const GEARS_MAX: usize = 32;
/// Most characters in a world.
pub const CHARACTERS_MAX: usize = 1 << 14;
/// Most shapes near a character that a move looks at.
pub const CHARACTER_SHAPES_MAX: usize = 1 << 12;
/// Most of them that can move and are not large against the character; the nearest count.
pub const CHARACTER_MOVERS_MAX: usize = 32;
/// Most planes of what is near, of which those are chosen that a character is pushed out of; the deepest count.
pub const CHARACTER_PLANES_MAX: usize = 48;
/// Most hits that a move of a character tells.
pub const CHARACTER_HITS_MAX: usize = 16;
/// Farthest that a body may be grabbed from its centre of mass, m; a large body ten of its own radii
/// ([`crate::World::grab`]).
pub const GRAB_REACH_MAX: f64 = 10.0;
/// Most bones of a ragdoll.
pub const BONES_MAX: usize = 1 << 10;
/// Most fields in a world.
pub const FIELDS_MAX: usize = 1 << 12;
/// Most bodies that attract one another in one field.
pub const N_BODY_MAX: usize = 1 << 14;
/// Most emitters in a world.
pub const EMITTERS_MAX: usize = 1 << 14;
/// Most particles in a world.
pub const PARTICLES_MAX: usize = 1 << 22;
/// Most particles that an emitter bears by rate, 1/s.
pub const EMITTER_RATE_MAX: f64 = 1e7;
/// Largest mass of a particle, kg.
pub const PARTICLE_MASS_MAX: f32 = 1e6;
/// Most bursts of an emitter.
pub const BURSTS_MAX: usize = 16;
/// Most keys of a curve over a particle's life.
pub const CURVE_KEYS_MAX: usize = 8;
/// Most hits of one particle in one step.
pub const PARTICLE_BOUNCES_MAX: usize = 4;
/// Most shapes that a block of 64 particles looks at in one step.
pub const PARTICLE_OBSTACLES_MAX: usize = 64;
/// Most steps of Newton's method for one particle and shape.
pub const PARTICLE_SWEEP_ITERATIONS_MAX: usize = 16;
/// Most hits of particles that a step reports.
pub const PARTICLE_HIT_EVENTS_MAX: usize = 256;
/// Most passes of restitution at the end of a step.
pub const RESTITUTION_PASSES_MAX: usize = 64;
/// Most commands in the queue.
pub const COMMAND_QUEUE_MAX: usize = 1 << 20;
/// Most manifolds of one contact.
pub const MANIFOLDS_PER_CONTACT_MAX: usize = jounce_geometry::limits::MANIFOLDS_PER_PAIR_MAX;
/// Longest name, bytes.
pub const NAME_MAX: usize = 256;
/// Most results of one all-hits query.
pub const QUERY_HITS_MAX: usize = 1 << 20;
