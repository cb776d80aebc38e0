//! The floating-point mode that the simulated bits depend on.
//!
//! Rounding to nearest, denormals kept, exceptions masked: what a thread has by default. Hosts change it, above all
//! audio libraries and game engines that flush denormals to zero, and then the same step gives other bits. A guard
//! sets the default and restores what was there.

use std::marker::PhantomData;

/// While it lives, the thread that made it has the default floating-point mode; dropping it restores the mode
/// found. Does nothing on targets without a mode register (wasm).
#[derive(Debug)]
#[must_use = "the caller's mode is restored when the guard drops"]
pub struct FloatEnv {
    /// The mode to restore; `None` where it was the default already.
    found: Option<Mode>,
    /// The register belongs to the thread: the guard must not move to another.
    thread: PhantomData<*const ()>,
}

impl FloatEnv {
    /// Sets the default mode on this thread.
    pub fn set_default() -> Self {
        let mode = imp::get();
        let found = (!imp::is_default(mode)).then(|| {
            imp::set(imp::DEFAULT);
            mode
        });
        Self { found, thread: PhantomData }
    }
}

impl Drop for FloatEnv {
    fn drop(&mut self) {
        if let Some(mode) = self.found {
            imp::set(mode);
        }
    }
}

#[cfg(target_arch = "x86_64")]
type Mode = u32;
#[cfg(not(target_arch = "x86_64"))]
type Mode = u64;

#[cfg(target_arch = "x86_64")]
mod imp {
    use std::arch::asm;

    /// MXCSR after reset: all exceptions masked, nearest, no flush-to-zero, no denormals-are-zero.
    pub const DEFAULT: u32 = 0x1f80;
    /// The six sticky exception flags are a record, not a mode.
    const FLAGS: u32 = 0x3f;

    pub fn is_default(mode: u32) -> bool {
        mode & !FLAGS == DEFAULT
    }

    pub fn get() -> u32 {
        let mut mode = 0u32;
        // SAFETY: stmxcsr writes four bytes to the address given, which is that of a live, aligned u32.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut mode, options(nostack, preserves_flags)) };
        mode
    }

    pub fn set(mode: u32) {
        // SAFETY: ldmxcsr reads four bytes from a live u32. The value was read from the register or is its reset
        // value, so no reserved bit is set (which would fault).
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const mode, options(nostack, preserves_flags)) };
    }

    /// Flush-to-zero, denormals-are-zero and rounding toward zero.
    #[cfg(test)]
    pub const UNUSUAL: u32 = DEFAULT | 0x8000 | 0x0040 | 0x6000;
}

#[cfg(target_arch = "aarch64")]
mod imp {
    use std::arch::asm;

    /// FPCR: nearest, no flush-to-zero, no default NaN, no traps.
    pub const DEFAULT: u64 = 0;

    pub fn is_default(mode: u64) -> bool {
        mode == DEFAULT
    }

    pub fn get() -> u64 {
        let mode: u64;
        // SAFETY: reading FPCR is allowed at every privilege level and has no other effect.
        unsafe { asm!("mrs {}, fpcr", out(reg) mode, options(nostack, preserves_flags)) };
        mode
    }

    pub fn set(mode: u64) {
        // SAFETY: writing FPCR is allowed at every privilege level; the value was read from it or is its default.
        unsafe { asm!("msr fpcr, {}", in(reg) mode, options(nostack, preserves_flags)) };
    }

    /// Flush-to-zero and rounding toward zero.
    #[cfg(test)]
    pub const UNUSUAL: u64 = (1 << 24) | (3 << 22);
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod imp {
    pub const DEFAULT: u64 = 0;

    pub fn is_default(_: u64) -> bool {
        true
    }

    pub fn get() -> u64 {
        DEFAULT
    }

    pub fn set(_: u64) {}
}

#[cfg(all(test, any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::{FloatEnv, imp};
    use crate::Tasks;
    use std::hint::black_box;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn half_of_smallest_normal() -> f32 {
        black_box(f32::MIN_POSITIVE) * black_box(0.5)
    }

    fn one_third() -> f32 {
        black_box(2.0f32) / black_box(3.0f32)
    }

    #[test]
    fn guard_sets_and_restores() {
        let usual = (half_of_smallest_normal(), one_third());
        assert!(usual.0 > 0.0);
        imp::set(imp::UNUSUAL);
        let before = (half_of_smallest_normal(), one_third());
        let inside = {
            let _env = FloatEnv::set_default();
            (half_of_smallest_normal(), one_third())
        };
        let after = (half_of_smallest_normal(), one_third());
        imp::set(imp::DEFAULT);
        assert_eq!(before.0, 0.0, "the caller's flush-to-zero is in force before");
        assert_ne!(before.1, usual.1, "the caller's rounding is in force before");
        assert_eq!(inside, usual);
        assert_eq!(after, before);
    }

    #[test]
    fn units_see_the_default_mode_whatever_the_caller_set() {
        for tasks in [Tasks::serial(), Tasks::pool(3), Tasks::chaos(1), Tasks::chaos_pool(3, 1)] {
            let kept = AtomicUsize::new(0);
            imp::set(imp::UNUSUAL);
            for units in [1, 64] {
                tasks.run(units, &|_| {
                    kept.fetch_add((half_of_smallest_normal() > 0.0) as usize, Ordering::Relaxed);
                });
            }
            let after = half_of_smallest_normal();
            imp::set(imp::DEFAULT);
            assert_eq!(kept.into_inner(), 65, "{tasks:?}");
            assert_eq!(after, 0.0, "the caller's mode is restored by {tasks:?}");
        }
    }
}
