//! What a character tells.

use super::desc::{CharacterDesc, CharacterGround, CharacterHit, CharacterInput};
use super::state::Character;
use crate::error::Result;
use crate::handle::{BodyId, CharacterId, ShapeId};
use crate::world::World;
use jounce_math::{DVec3, Vec3};

/// A character, to be read.
#[derive(Clone, Copy)]
pub struct CharacterRef<'a> {
    world: &'a World,
    character: &'a Character,
}

impl core::fmt::Debug for CharacterRef<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("CharacterRef").field("character", &self.character).finish_non_exhaustive()
    }
}

impl<'a> CharacterRef<'a> {
    /// Its description.
    pub fn desc(&self) -> &'a CharacterDesc {
        &self.character.desc
    }
    /// What it is asked to do.
    pub fn input(&self) -> &'a CharacterInput {
        &self.character.input
    }
    /// Its body; the body's origin is the foot.
    pub fn body(&self) -> BodyId {
        self.world.body_id(self.character.body)
    }
    /// Its capsule.
    pub fn shape(&self) -> ShapeId {
        self.character.shape
    }
    /// Where the foot is, world, m.
    pub fn position(&self) -> DVec3 {
        self.world.frames[self.character.body as usize].pose().p
    }
    /// Its turn about up, rad.
    pub fn heading(&self) -> f32 {
        self.character.heading
    }
    /// Velocity against the world in the last step, m/s.
    pub fn velocity(&self) -> Vec3 {
        let ground = self.character.ground.map_or(Vec3::ZERO, |g| g.velocity);
        self.character.velocity + ground
    }
    /// What it stands on.
    pub fn ground(&self) -> Option<&'a CharacterGround> {
        self.character.ground.as_ref()
    }
    /// Does it stand?
    pub fn is_grounded(&self) -> bool {
        self.character.ground.is_some()
    }
    /// Seconds since it last stood; 0 while it stands. Callers give late jumps by this (coyote time).
    pub fn air_time(&self) -> f32 {
        self.character.air_time
    }
    /// Is it crouched? It stays so while there is no headroom, whatever it is asked.
    pub fn is_crouched(&self) -> bool {
        self.character.crouched
    }
    /// Did it touch ground too steep to stand on in the last step?
    pub fn is_on_steep(&self) -> bool {
        self.character.on_steep
    }
    /// Did a ceiling end its way up in the last step?
    pub fn hit_ceiling(&self) -> bool {
        self.character.hit_ceiling
    }
    /// Had it no room left in the last step (between a lift and a ceiling)?
    pub fn is_squeezed(&self) -> bool {
        self.character.squeezed
    }
    /// How far it climbed a step in the last step of the world, m.
    pub fn stepped(&self) -> f32 {
        self.character.stepped
    }
    /// What it ran into in the last step, in order.
    pub fn hits(&self) -> &'a [CharacterHit] {
        &self.character.hits
    }
}

impl World {
    /// A character, to be read.
    ///
    /// # Errors
    /// A stale handle.
    pub fn character(&self, id: CharacterId) -> Result<CharacterRef<'_>> {
        let slot = self.character_slot(id)?;
        Ok(CharacterRef { world: self, character: &self.characters.table[slot] })
    }
    /// All characters, in slot order.
    pub fn characters(&self) -> impl Iterator<Item = CharacterId> + '_ {
        self.characters.table.iter().map(|(i, _)| self.character_id(i))
    }
}
