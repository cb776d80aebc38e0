//! Records of characters.

use super::around::{Ahead, MoveScratch};
use super::desc::{CharacterDesc, CharacterGround, CharacterHit, CharacterInput};
use crate::handle::ShapeId;
use crate::hash::StateHasher;
use crate::table::Table;
use jounce_math::{DVec3, Vec3};

/// A character of the world.
#[derive(Clone, Debug)]
pub(crate) struct Character {
    pub desc: CharacterDesc,
    /// Slot of its body, and its capsule.
    pub body: u32,
    pub shape: ShapeId,
    pub input: CharacterInput,
    /// Where the foot was put last; a body that is elsewhere was moved by someone else.
    pub foot: DVec3,
    pub heading: f32,
    /// Own velocity, m/s: against the ground while it stands, against the world in the air.
    pub velocity: Vec3,
    pub ground: Option<CharacterGround>,
    /// Force of a walker on what it stands on, N.
    pub load: f32,
    pub crouched: bool,
    /// Seconds since it last stood.
    pub air_time: f32,
    /// A one-way platform it lets itself fall through.
    pub passing: Option<ShapeId>,
    pub on_steep: bool,
    pub hit_ceiling: bool,
    pub squeezed: bool,
    pub stepped: f32,
    pub hits: Vec<CharacterHit>,
}

/// All characters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Characters {
    pub table: Table<Character>,
    /// Memory of the stage.
    pub ahead: Vec<Ahead>,
    pub scratch: MoveScratch,
}

impl Character {
    pub fn height(&self) -> f32 {
        if self.crouched { self.desc.crouch_height } else { self.desc.mover.height }
    }
}

impl Characters {
    pub fn is_empty(&self) -> bool {
        self.table.len() == 0
    }
    pub fn hash(&self, h: &mut StateHasher) {
        if self.table.slots() == 0 {
            return;
        }
        for w in self.table.allocator_words() {
            h.pair(w, 9);
        }
        for (i, c) in self.table.iter() {
            h.pair(i, c.body);
            h.word(c.shape.to_bits());
            let flags =
                [c.crouched, c.on_steep, c.hit_ceiling, c.squeezed, c.input.crouch, c.input.drop_through];
            h.pair(flags.iter().fold(0, |x, &f| (x << 1) | u32::from(f)), c.hits.len() as u32);
            h.vec3(c.input.walk);
            h.floats(c.input.jump.unwrap_or(-1.0), c.input.heading.unwrap_or(f32::MAX));
            h.dvec3(c.foot);
            h.vec3(c.velocity);
            h.floats(c.heading, c.air_time);
            h.floats(c.stepped, c.load);
            h.word(c.passing.map_or(0, ShapeId::to_bits));
            if let Some(g) = &c.ground {
                h.word(g.shape.to_bits());
                h.dvec3(g.point);
                h.vec3(g.normal);
                h.vec3(g.velocity);
            }
            for hit in &c.hits {
                h.word(hit.shape.to_bits());
                h.dvec3(hit.point);
                h.vec3(hit.normal);
            }
        }
    }
}
