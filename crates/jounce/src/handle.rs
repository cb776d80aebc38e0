//! Typed handles: an index and a generation, 64 bits, stable across clone and restore.

macro_rules! handle {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(C)]
        pub struct $name {
            pub(crate) index: u32,
            pub(crate) generation: u32,
        }

        impl $name {
            /// Both halves in one number: generation in the upper 32 bits, index in the lower.
            pub const fn to_bits(self) -> u64 {
                ((self.generation as u64) << 32) | self.index as u64
            }
            /// The inverse of [`Self::to_bits`]. Any number is accepted; one that names nothing is stale.
            pub const fn from_bits(bits: u64) -> Self {
                Self { index: bits as u32, generation: (bits >> 32) as u32 }
            }
            /// Slot index; reused after removal, so it is not an identity by itself.
            pub const fn index(self) -> u32 {
                self.index
            }
        }
    };
}

handle! {
    /// Names a body of a [`crate::World`].
    BodyId
}
handle! {
    /// Names a shape on a body of a [`crate::World`].
    ShapeId
}
handle! {
    /// Names an emitter of particles of a [`crate::World`].
    EmitterId
}
handle! {
    /// Names a joint of a [`crate::World`].
    JointId
}
handle! {
    /// Names a vehicle of a [`crate::World`].
    VehicleId
}
handle! {
    /// Names a field of a [`crate::World`].
    FieldId
}
handle! {
    /// Names a character of a [`crate::World`].
    CharacterId
}
