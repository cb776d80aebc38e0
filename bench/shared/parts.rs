//! Bodies, shapes and joints in the scenes' own words. Metres, seconds, kg; quaternions are (x, y, z, w).

// An engine leaves unread what it cannot do.
#![allow(dead_code)]

use super::human::Hold;
use crate::world::{Body, Hull};

/// A point or a vector.
pub type V = [f32; 3];
/// A place and a turn in a body's frame; the turn is of unit length to six digits.
pub type Frame = (V, [f32; 4]);

/// Fixed step of every scene, in seconds.
pub const DT_S: f32 = 1.0 / 60.0;
/// Substeps per step of every scene.
pub const SUBSTEPS: u32 = 4;
/// How hard joints hold: hertz and damping ratio.
pub const JOINT_SOFTNESS: (f32, f32) = (60.0, 2.0);

/// How a body moves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Fixed,
    Kinematic,
    Dynamic,
}

/// A body before it has shapes.
#[derive(Clone, Copy)]
pub struct BodyOptions {
    pub kind: Kind,
    pub frame: Frame,
    /// m/s, of the centre of mass.
    pub velocity: V,
    /// rad/s
    pub spin: V,
    pub can_sleep: bool,
    /// Below this speed it may sleep, m/s.
    pub sleep_speed: f32,
}

impl BodyOptions {
    /// A body at rest and unturned.
    pub fn new(kind: Kind, x: f32, y: f32, z: f32) -> Self {
        BodyOptions {
            kind,
            frame: ([x, y, z], [0.0, 0.0, 0.0, 1.0]),
            velocity: [0.0; 3],
            spin: [0.0; 3],
            can_sleep: true,
            sleep_speed: 0.05,
        }
    }
}

/// What a shape is made of here.
pub enum Shape<'a> {
    /// Half extents, and the centre in the body's frame.
    Box { half: V, centre: V },
    /// Centred on the body.
    Sphere { radius: f32 },
    /// The centres of the caps and their radius.
    Capsule { a: V, b: V, radius: f32 },
    /// A hull shared between bodies.
    Hull(&'a Hull),
}

impl Shape<'_> {
    /// A box centred on its body.
    pub fn block(x: f32, y: f32, z: f32) -> Self {
        Shape::Box { half: [x, y, z], centre: [0.0; 3] }
    }
}

/// What a shape touches.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Meets {
    All,
    /// Nothing of its own kind.
    NotGhosts,
    /// All but shapes of the same group, counted from zero.
    NotGroup(u32),
}

/// Material, density and creation options of a shape.
#[derive(Clone, Copy)]
pub struct ShapeOptions {
    /// kg/m³
    pub density: f32,
    pub friction: f32,
    pub restitution: f32,
    /// Rolling resistance, of balls and capsules.
    pub rolling: f32,
    /// A fixed shape looks for contacts at creation.
    pub buffer_move: bool,
    pub meets: Meets,
}

impl Default for ShapeOptions {
    fn default() -> Self {
        ShapeOptions {
            density: 1000.0,
            friction: 0.6,
            restitution: 0.0,
            rolling: 0.0,
            buffer_move: false,
            meets: Meets::All,
        }
    }
}

/// A joint of a ragdoll. Its main axis is z of both frames.
pub struct Limb {
    pub a: Body,
    pub b: Body,
    pub frame_a: Frame,
    pub frame_b: Frame,
    pub hold: Hold,
    /// N m
    pub friction: f32,
}

/// How many bodies that stay, bodies that move and contacts to make room for.
#[derive(Clone, Copy, Default)]
pub struct Capacity {
    pub fixed: u32,
    pub moving: u32,
    pub contacts: u32,
}
